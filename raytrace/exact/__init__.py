"""Exact arithmetic: arrays of arbitrary precision that the shader's own text runs on."""

from raytrace.exact.arrays import BITS, Exact, Undecided, precision

__all__ = ["BITS", "Exact", "Undecided", "precision"]
