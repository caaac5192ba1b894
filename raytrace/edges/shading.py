"""What differs in the assignment's steps where a surface is seen by all of a pixel, and not at one point of it."""

from raytrace.edges.coverage import positive_mean
from raytrace.edges.occlusion import lit_share, lit_share_of_planes
from raytrace.edges.pattern import checkerboard_mean
from raytrace.language.control import step
from raytrace.language.glsl import Vec3
from raytrace.language.jet import Jet, jet, values
from raytrace.language.tree import array_map
from raytrace.language.types import Float, Int
from raytrace.shader.light import Footprint
from raytrace.shader.shadows import place_of_plane, shadow_along
from raytrace.shader.uniforms import Plane, Program, Uniforms

__all__ = ["PIXEL", "plane_surface"]


@step
def shadow_ray(ro: Vec3, rd: Vec3, uniforms: Uniforms, program: Program, but: Int | None) -> Float:
    """Return the share of a pixel's rays, jets, that nothing stops; `but`: as in `raytrace.shader.shadows`."""
    by_spheres = lit_share(ro, rd, uniforms.spheres, but)
    plane = None if uniforms.shadow_planes is None else place_of_plane(but, uniforms, program)
    return by_spheres * lit_share_of_planes(ro, rd, uniforms.shadow_planes, plane)


#: Light over a pixel, of jets.
PIXEL = Footprint(positive=positive_mean, centre=values, shadow=shadow_along(shadow_ray))


def plane_surface(point: Vec3, t: Jet, plane: Plane, program: Program) -> tuple[Vec3, Vec3]:
    """Return the unit normal, as jets, and the mean colour of a plane over a pixel in which it is seen at `point`."""
    normal = array_map(jet, plane.normal)
    if not program.patterned:
        return normal, plane.even
    pattern = plane.tile_size, plane.even, plane.odd, plane.line
    return normal, checkerboard_mean(point, t, not program.orthographic, *pattern)
