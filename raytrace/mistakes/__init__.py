"""Mistakes that shaders have, each stated once."""

from raytrace.mistakes.mutations import MUTATIONS, Mutation

__all__ = ["MUTATIONS", "Mutation"]
