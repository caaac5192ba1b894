"""Real engines on random scenes: each image lies within the bounds that hold for every conforming program."""

from raytrace.studies.conformance.scenes import STRUCTURES, Structure, random_scene
from raytrace.studies.conformance.study import ENGINES, Result, study

__all__ = ["ENGINES", "STRUCTURES", "Result", "Structure", "random_scene", "study"]
