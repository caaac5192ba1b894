"""What differs in the assignment's steps where a surface is seen by all of a square, and not at one point of it."""

from raytrace.edges.coverage import positive_mean
from raytrace.edges.occlusion import lit_share, lit_share_of_planes
from raytrace.edges.pattern import checkerboard_mean
from raytrace.language.control import step
from raytrace.language.glsl import Vec3
from raytrace.language.jet import Jet, jet, values
from raytrace.language.tree import array_map
from raytrace.language.types import Float, Int
from raytrace.shader.light import SHADOW_OFFSET, Footprint
from raytrace.shader.shadows import place_of_plane
from raytrace.shader.uniforms import Plane, Program, Uniforms

__all__ = ["SQUARE"]


@step
def shadow_ray(ro: Vec3, rd: Vec3, uniforms: Uniforms, program: Program, but: Int) -> Float:
    """Return the share of a square's rays, jets, that nothing but surface number `but` stops."""
    by_spheres = lit_share(ro, rd, uniforms.spheres, but)
    plane = None if uniforms.shadow_planes is None else place_of_plane(but, uniforms, program)
    return by_spheres * lit_share_of_planes(ro, rd, uniforms.shadow_planes, plane)


def shadow(point: Vec3, N: Vec3, L: Vec3, index: Int, uniforms: Uniforms, program: Program) -> Float:
    """Return the share of a square, seen at `point`, that the sun reaches, were it to face it.

    The surface never hides the sun from itself where it faces it; the mean of a sphere's points is within the sphere.
    """
    start = point if program.shadow_start == "surface" else point + SHADOW_OFFSET * N
    return shadow_ray(start, L, uniforms, program, index)


def plane_surface(point: Vec3, t: Jet, plane: Plane, program: Program) -> tuple[Vec3, Vec3]:
    """Return the unit normal and the mean colour of a plane over a square in which it is seen at `point`, of jets."""
    normal = array_map(jet, plane.normal)
    if not program.patterned:
        return normal, plane.even
    pattern = plane.tile_size, plane.even, plane.odd, plane.line
    return normal, checkerboard_mean(point, t, not program.orthographic, *pattern)


#: What `shade` does otherwise where a square sees a surface.
SQUARE = {
    "plane_surface": plane_surface,
    "footprint": Footprint(positive=positive_mean, centre=values, shadow=shadow),
}
