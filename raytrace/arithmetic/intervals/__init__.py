"""Intervals: arrays that hold every number that a program may compute, for the shader's own text."""

from raytrace.arithmetic.intervals.arrays import Condition, Interval
from raytrace.arithmetic.intervals.error_models import BUILT_INS, GLSL_HIGHP, REAL, ErrorModel
from raytrace.arithmetic.intervals.namespace import IntervalNamespace

__all__ = ["BUILT_INS", "GLSL_HIGHP", "REAL", "Condition", "ErrorModel", "Interval", "IntervalNamespace"]
