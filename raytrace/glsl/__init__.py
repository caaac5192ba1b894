"""The assignment's program as GLSL, emitted from a scene: the one other text of its formulas, for GPUs."""

from raytrace.glsl.dialects import vertex_shader
from raytrace.glsl.shader import fragment_shader
from raytrace.glsl.values import flat_values, values_of

__all__ = ["flat_values", "fragment_shader", "values_of", "vertex_shader"]
