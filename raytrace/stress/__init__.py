"""Stress tests: each formula of the shader, on every arithmetic, against exact arithmetic."""

from raytrace.stress.axes import AXES
from raytrace.stress.bounds import BOUNDS, Verdict, verdicts
from raytrace.stress.effort import FULL, QUICK, Effort
from raytrace.stress.measure import Point
from raytrace.stress.running import stress

__all__ = ["AXES", "BOUNDS", "FULL", "QUICK", "Effort", "Point", "Verdict", "stress", "verdicts"]
