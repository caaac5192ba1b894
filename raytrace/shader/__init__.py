"""The assignment's shader, one file a step.

The functions take planes (arrays of one number a pixel, of any array library with ``__array_namespace__``) and
scalars, and give planes. See `raytrace.language.glsl` for the vocabulary and `raytrace.language.control` for how an
engine runs it.
"""

from raytrace.shader.camera import orthographic_ray, pixel_to_ndc, primary_ray
from raytrace.shader.checkerboard import checkerboard
from raytrace.shader.film import develop, tonemap_and_gamma_correct
from raytrace.shader.light import light_at_point, shadow_ray
from raytrace.shader.main import Steps, main
from raytrace.shader.pixel import Frame, pixels
from raytrace.shader.plane import closest_plane_intersect, plane_intersect
from raytrace.shader.sky import background_color
from raytrace.shader.sphere import closest_sphere_intersect, sphere_intersect

__all__ = [
    "Frame",
    "Steps",
    "background_color",
    "checkerboard",
    "closest_plane_intersect",
    "closest_sphere_intersect",
    "develop",
    "light_at_point",
    "main",
    "orthographic_ray",
    "pixel_to_ndc",
    "pixels",
    "plane_intersect",
    "primary_ray",
    "shadow_ray",
    "sphere_intersect",
    "tonemap_and_gamma_correct",
]
