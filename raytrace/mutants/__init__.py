"""A mutation study: which mistakes do certified bounds find, and which do metrics with a threshold?"""

from raytrace.mutants.mutations import MUTATIONS, Mutation
from raytrace.mutants.study import DETECTORS, SCENES, Study, study

__all__ = ["DETECTORS", "MUTATIONS", "SCENES", "Mutation", "Study", "study"]
