"""Two images of the same thing: how far they are apart, where, and by which of the usual mistakes."""

from raytrace.comparison.checks import BOUNDS, failures, requirements
from raytrace.comparison.diff import write_diff
from raytrace.comparison.inputs import NotFinite
from raytrace.comparison.matrix import Matrix, matrix
from raytrace.comparison.result import Comparison, compare

__all__ = ["BOUNDS", "Comparison", "Matrix", "NotFinite", "compare", "failures", "matrix", "requirements", "write_diff"]
