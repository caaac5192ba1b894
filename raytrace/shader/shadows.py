"""Extensions of the assignment's shadows: planes that cast them, and shadow rays that start on the surface."""

from collections.abc import Callable

from raytrace.language.control import count, step
from raytrace.language.glsl import Vec3, select
from raytrace.language.namespace import constant
from raytrace.language.types import Float, Int
from raytrace.shader.light import POINT, SHADOW_OFFSET, Footprint
from raytrace.shader.plane import any_plane_intersect
from raytrace.shader.sphere import any_sphere_intersect
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["SHADOW_STARTS", "footprint_of", "place_of_plane", "shadow_along"]

#: Where a shadow ray starts: at the assignment's offset, whatever the scene's scale; or on the surface itself, which
#: then is left out of what can block the ray, so that a scene's shadows do not depend on its unit of length.
SHADOW_STARTS = ("offset", "surface")

#: How much light comes along a ray (ro, rd, uniforms, program), which the surface of a number does not block.
ShadowRay = Callable[[Vec3, Vec3, Uniforms, Program, Int | None], Float]


def footprint_of(uniforms: Uniforms, program: Program) -> Footprint:
    """Return the assignment's point, or one with these extensions where the scene or the program has any."""
    return POINT if uniforms.shadow_planes is None and program.shadow_start == "offset" else EXTENDED


def shadow_along(shadow_ray: ShadowRay) -> Callable:
    """Return the shadow at a point (`Footprint.shadow`) by that ray, which starts where the program says."""

    def shadow(point: Vec3, N: Vec3, L: Vec3, index: Int, uniforms: Uniforms, program: Program) -> Float:
        if program.shadow_start == "surface":
            return shadow_ray(point, L, uniforms, program, index)
        return shadow_ray(point + SHADOW_OFFSET * N, L, uniforms, program, None)

    return shadow


@step
def shadow_ray(ro: Vec3, rd: Vec3, uniforms: Uniforms, program: Program, but: Int | None) -> Float:
    """Return how much light comes along the ray: 0 where a sphere, or a plane that casts a shadow, stands at t >= 0.

    but: the index of a surface that does not block, spheres counted first, then planes; ``None`` for none.
    """
    blocked = any_sphere_intersect(ro, rd, uniforms.spheres, program.intersection, but)
    if uniforms.shadow_planes is not None:
        blocked = blocked | any_plane_intersect(ro, rd, uniforms.shadow_planes, place_of_plane(but, uniforms, program))
    return select(blocked, constant(0, rd.x), 1)


def place_of_plane(index: Int | None, uniforms: Uniforms, program: Program) -> Int | None:
    """Return where surface number `index` stands among the planes that cast shadows; -1 where it is none of them."""
    if index is None:
        return None
    number = index - count(uniforms.spheres)
    place = constant(-1, number)
    for i, known in enumerate(program.casting):
        place = select(number == known, i, place)
    return place


EXTENDED = POINT._replace(shadow=shadow_along(shadow_ray))
