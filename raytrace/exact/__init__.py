"""Exact arithmetic: arrays of arbitrary precision that the shader's own text runs on."""

from raytrace.exact.arrays import BITS, Exact, Undecided, precision
from raytrace.exact.image import exact_steps

__all__ = ["BITS", "Exact", "Undecided", "exact_steps", "precision"]
