"""Stress tests: each formula of the shader, on every arithmetic, against exact arithmetic."""

from raytrace.studies.stress.axes import AXES
from raytrace.studies.stress.effort import FULL, QUICK, Effort
from raytrace.studies.stress.limits import BOUNDS, Verdict, verdicts
from raytrace.studies.stress.measure import Measurement
from raytrace.studies.stress.running import stress

__all__ = ["AXES", "BOUNDS", "FULL", "QUICK", "Effort", "Measurement", "Verdict", "stress", "verdicts"]
