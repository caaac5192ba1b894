"""Spheres: one ray against one of them, and against all (assignment, 'Ray-Sphere Intersection', 'Shadow')."""

from math import inf
from typing import NamedTuple

from raytrace.language.control import each, step
from raytrace.language.glsl import Vec3, clamp, dot, select, smallest_divisor, sqrt
from raytrace.language.namespace import constant
from raytrace.language.types import Bool, Float, Int
from raytrace.shader.hit import Hit
from raytrace.shader.uniforms import Sphere

__all__ = [
    "INTERSECTIONS",
    "any_sphere_intersect",
    "closest_approach",
    "closest_sphere_intersect",
    "sphere_intersect",
    "sphere_reach",
]


class Roots(NamedTuple):
    """Where a ray's line meets a sphere: nowhere if the discriminant is negative, else at t1 <= t2."""

    discriminant: Float
    t1: Float
    t2: Float


def textbook_roots(ro: Vec3, rd: Vec3, radius: Float) -> Roots:
    """The roots as the assignment has them, for a sphere around the origin.

    ``b*b - c`` cancels where the sphere is small against its distance.
    """
    b = dot(ro, rd)
    c = dot(ro, ro) - radius * radius
    d = b * b - c
    root = sqrt(d)
    return Roots(d, -b - root, -b + root)


def closest_approach(ro: Vec3, rd: Vec3) -> tuple[Float, Vec3]:
    """b, so that the ray's line is nearest to the origin at t = -b, and that point."""
    b = dot(ro, rd)
    return b, ro - b * rd


def robust_roots(ro: Vec3, rd: Vec3, radius: Float) -> Roots:
    """The same roots without cancellation.

    The discriminant compares the radius with the distance from the centre to the line, and the root that would
    cancel is had from the product of both, c. Near the surface c itself cancels. Its error must not make that root the
    larger one, so c is kept within the larger root's square; where both roots are 0 it is 0.

    Source: Haines, Guenther, Akenine-Moeller, 'Precision Improvements for Ray/Sphere Intersection',
    Ray Tracing Gems (2019), chapter 7.
    """
    b, nearest = closest_approach(ro, rd)
    d = radius * radius - dot(nearest, nearest)
    root = sqrt(d)
    c = dot(ro, ro) - radius * radius
    ahead = b < 0
    larger = select(ahead, root - b, root + b)
    most = larger * larger
    q = select(ahead, larger, -larger)
    # A ray that starts on the sphere and touches it there has both roots at 0, or too near to it to be divided by.
    other = clamp(c, -most, most) / select(larger <= smallest_divisor(larger), 1, q)
    return Roots(d, select(ahead, other, q), select(ahead, q, other))


INTERSECTIONS = {"textbook": textbook_roots, "robust": robust_roots}


def sphere_intersect(ro: Vec3, rd: Vec3, s: Sphere, intersection: str = "textbook") -> Float:
    """The t at which the ray ro + t * rd (`rd` of unit length) meets the sphere `s`; negative: not at all.

    The nearer root, or the farther one where the nearer is behind the origin, as it is inside the sphere.
    `intersection` is "textbook" (the assignment's formula) or "robust".
    """
    d, t1, t2 = INTERSECTIONS[intersection](ro - s.center, rd, s.radius)
    # `d >= 0` and not `d < 0`: where the discriminant has overflowed to NaN there is no intersection either.
    return select(d >= 0, select(t1 < 0, t2, t1), -1)


def sphere_reach(ro: Vec3, rd: Vec3, s: Sphere, intersection: str = "textbook") -> Float:
    """The same t, but where the ray's line passes the sphere by, that of the point nearest to it."""
    _, t1, t2 = INTERSECTIONS[intersection](ro - s.center, rd, s.radius)
    return select(t1 < 0, t2, t1)


@step
def closest_sphere_intersect(
    ro: Vec3, rd: Vec3, spheres: Sphere | None, intersection: str = "textbook"
) -> tuple[Float, Int]:
    """The smallest t >= 0 at which the ray meets a sphere, and the sphere's index; (-1, -1) if it meets none.

    Of spheres at equal t the last one wins: ``t > closestHit`` goes on, equality does not.
    """

    def body(closest, i, sphere, ro, rd):
        t = sphere_intersect(ro, rd, sphere, intersection)
        passed_over = (t < 0) | (t > closest.t)
        return select(passed_over, closest, Hit(t, constant(i, closest.index)))

    nothing = Hit(constant(inf, rd.x), constant(-1, rd.x, "int32"))
    closest = each(spheres, body, nothing, ro, rd)
    # The assignment's bestT: it follows closestHit but starts at -1.
    return select(closest.index < 0, -1, closest.t), closest.index


@step
def any_sphere_intersect(
    ro: Vec3, rd: Vec3, spheres: Sphere | None, intersection: str = "textbook", but: Int | None = None
) -> Bool:
    """Whether the ray meets any sphere at t >= 0: ``closestSphereIntersect(...) >= 0``, which needs no order.

    `but`: the index of a sphere that is left out; ``None`` for none.
    """

    def body(blocked, i, sphere, ro, rd, *but):
        meets = sphere_intersect(ro, rd, sphere, intersection) >= 0
        for index in but:
            meets = meets & (index != i)
        return blocked | meets

    left_out = () if but is None else (but,)
    return each(spheres, body, constant(False, rd.x, "bool"), ro, rd, *left_out)
