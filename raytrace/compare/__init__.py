"""Two images of the same thing: how far they are apart, where, and by which of the usual mistakes."""

from raytrace.compare.checks import BOUNDS, failures
from raytrace.compare.comparison import Comparison, compare
from raytrace.compare.diff import write_diff
from raytrace.compare.inputs import NotFinite
from raytrace.compare.matrix import Matrix, matrix

__all__ = ["BOUNDS", "Comparison", "Matrix", "NotFinite", "compare", "failures", "matrix", "write_diff"]
