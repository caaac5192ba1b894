"""How much of a pixel's rays a sphere stops, and how much of a pixel the sun reaches: visibility between 0 and 1."""

from raytrace.edges.coverage import disc_coverage, half_plane_coverage
from raytrace.language.control import at, branch, count, each
from raytrace.language.glsl import Vec3, dot, select
from raytrace.language.jet import values
from raytrace.language.namespace import constant
from raytrace.language.types import Bool, Float, Int
from raytrace.shader.hit import Darkest, Nearest
from raytrace.shader.sphere import closest_approach
from raytrace.shader.uniforms import Plane, Sphere

__all__ = ["inserted", "lit_share", "lit_share_of_planes", "none_yet", "sphere_share"]

#: So many spheres may share the edges of shadow in one pixel.
SHADOWS = 2


def sphere_share(ro: Vec3, rd: Vec3, s: Sphere) -> Float:
    """The share of a pixel whose rays, jets, meet the sphere at t >= 0."""
    ro = ro - s.center
    b, nearest = closest_approach(ro, rd)
    inside = dot(ro, ro) < s.radius * s.radius
    return select(inside, 1, select(b < 0, disc_coverage(nearest, s.radius), 0))


def lit_share(ro: Vec3, rd: Vec3, spheres: Sphere | None, but: Int | None = None) -> Float:
    """The share of a pixel whose rays, jets, meet no sphere but number `but`.

    Of the spheres those two count that stop most. Where both stop only some, what they stop is independent.
    """

    def body(darkest, i, sphere, ro, rd, *but):
        share = sphere_share(ro, rd, sphere)
        for index in but:
            share = select(index == i, constant(0, share), share)
        return inserted(darkest, share, constant(i, darkest.index[0]), share > 0)

    left_out = () if but is None else (but,)
    darkest = each(spheres, body, none_yet(Darkest, SHADOWS, values(rd.x)), ro, rd, *left_out)

    def stopped(ro, rd, index):
        return sphere_share(ro, rd, at(spheres, index))

    def none(ro, rd, index):
        return constant(0, values(rd.x))

    lit = constant(1, values(rd.x))
    if count(spheres):
        for index in darkest.index:
            lit = lit * (1 - branch(index >= 0, stopped, none, ro, rd, index))
    return lit


def lit_share_of_planes(ro: Vec3, rd: Vec3, planes: Plane | None, but: Int | None = None) -> Float:
    """The share of a pixel whose rays, from jets along one direction, meet none of the planes but number `but`."""

    def body(lit, i, plane, ro, *but):
        distance, approach = dot(plane.point - ro, plane.normal), dot(rd, plane.normal)
        hidden = half_plane_coverage(select(approach > 0, distance, -distance))
        for index in but:
            hidden = select(index == i, 0, hidden)
        return lit * (1 - select(approach == 0, 0, hidden))

    left_out = () if but is None else (but,)
    return each(planes, body, constant(1, values(ro.x)), ro, *left_out)


def none_yet(kind: type, number: int, like: Float) -> Nearest | Darkest:
    """The state of a search for the best `number` before it has begun."""
    return kind((constant(0, like),) * number, (constant(-1, like, "int32"),) * number)


def inserted(
    best: Nearest | Darkest, merit: Float, index: Int, able: Bool, last_wins: bool = True
) -> Nearest | Darkest:
    """The best few of those and one more, if it is `able`; of equal ones the last, or else the first, comes first."""
    merits, indices = [], []
    merit, index = select(able, merit, 0), select(able, index, -1)
    for other, its in zip(*best, strict=True):
        better = merit > other
        if last_wins:
            better = better | ((merit == other) & (index > its))
        merits.append(select(better, merit, other))
        indices.append(select(better, index, its))
        merit, index = select(better, other, merit), select(better, its, index)
    return type(best)(tuple(merits), tuple(indices))
