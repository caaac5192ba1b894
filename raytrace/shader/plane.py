"""Planes: one ray against one of them, and against all (assignment, 'Ground Plane')."""

from math import inf

from raytrace.language.control import detach, each, step
from raytrace.language.glsl import Vec3, dot, select, smallest_normal
from raytrace.language.namespace import constant
from raytrace.language.types import Bool, Float, Int
from raytrace.shader.hit import Hit
from raytrace.shader.uniforms import Plane

__all__ = ["any_plane_intersect", "closest_plane_intersect", "plane_intersect"]


def plane_intersect(ro: Vec3, rd: Vec3, n: Vec3, p: Vec3) -> Float:
    """The t at which the ray ro + t * rd meets the plane through `p` with normal `n`; of any sign.

    IEEE's infinity or NaN where the ray is parallel to the plane.
    """
    distance, approach = dot(p - ro, n), dot(rd, n)
    # The quotient's derivative holds 1 / approach**2. Where that overflows the value is kept, without derivative.
    steep = approach * approach >= smallest_normal(approach)
    return select(steep, distance / select(steep, approach, 1), detach(distance / approach))


@step
def closest_plane_intersect(ro: Vec3, rd: Vec3, planes: Plane | None, but: Int | None = None) -> tuple[Float, Int]:
    """The smallest t at which the ray meets a plane and the plane's index; (infinity, -1) if it meets none.

    A plane is met where t is positive and finite. Of planes at equal t the first one wins. `but`: the index of a plane
    that is left out; ``None`` for none.
    """

    def body(closest, i, plane, ro, rd, *but):
        t = plane_intersect(ro, rd, plane.normal, plane.point)
        # Nearer than something is finite; NaN is neither.
        nearer = (t > 0) & (t < closest.t)
        for index in but:
            nearer = nearer & (index != i)
        return select(nearer, Hit(t, constant(i, closest.index)), closest)

    nothing = Hit(constant(inf, rd.x), constant(-1, rd.x, "int32"))
    left_out = () if but is None else (but,)
    return tuple(each(planes, body, nothing, ro, rd, *left_out))


@step
def any_plane_intersect(ro: Vec3, rd: Vec3, planes: Plane | None, but: Int | None = None) -> Bool:
    """Whether the ray meets any of the planes, `but` one, at a positive, finite t."""
    _, index = closest_plane_intersect(ro, rd, planes, but)
    return index >= 0
