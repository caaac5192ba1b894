"""How much of a square's rays a sphere stops, and how much of it the sun reaches: visibility between 0 and 1."""

from typing import Any

from raytrace.edges.coverage import disc_coverage
from raytrace.language.control import at, branch, each, step
from raytrace.language.glsl import Vec3, clamp, dot, maximum, select, smallest_divisor, sqrt
from raytrace.language.jet import jet, values
from raytrace.language.namespace import constant, namespace
from raytrace.language.types import Bool, Float, Int
from raytrace.shader.hit import Darkest
from raytrace.shader.sphere import closest_approach
from raytrace.shader.uniforms import Plane, Sphere

__all__ = ["darkness", "inserted", "lit_share", "lit_share_of_planes", "none_yet", "sphere_share", "stacked"]

#: So many spheres may share the edges of shadow in one square.
SHADOWS = 2


@step
def sphere_share(ro: Vec3, rd: Vec3, s: Sphere) -> Float:
    """Return the share of a square whose rays, jets, meet the sphere at t >= 0."""
    ro = ro - s.center
    b, nearest = closest_approach(ro, rd)
    inside = dot(ro, ro) < s.radius * s.radius
    return select(inside, 1, select(b < 0, disc_coverage(nearest, s.radius), 0))


@step
def darkness(ro: Vec3, rd: Vec3, s: Sphere) -> Float:
    """Return about what share of a square's rays, jets, meet the sphere: 0 where none does, 1 only where all do."""
    ro = ro - s.center
    b, nearest = closest_approach(ro, rd)
    clearance = s.radius - jet(sqrt(dot(nearest, nearest)))
    reach = maximum(clearance.spread, smallest_divisor(clearance.value))
    share = clamp(0.5 + clearance.value / reach, 0, 1)
    return select(dot(ro, ro) < s.radius * s.radius, 1, select(b < 0, share, 0))


def lit_share(ro: Vec3, rd: Vec3, spheres: Sphere | None, but: Int | None = None) -> Float:
    """Return the share of a square whose rays, jets, meet no sphere but number `but`.

    Of the spheres those two count that stop most. Where both stop only some, what they stop is taken to be independent.
    """
    like = values(rd.x) + 0 * values(ro.x)
    if spheres is None:
        return constant(1, like)

    def search(darkest, i, sphere, ro, rd, *but):
        share = darkness(ro, rd, sphere)
        for index in but:
            share = select(index == i, 0, share)
        return inserted(darkest, share, constant(i, darkest.index[0]), share > 0)

    left_out = () if but is None else (but,)
    darkest = each(spheres, search, none_yet(Darkest, SHADOWS, like), ro, rd, *left_out)

    def add(lit, _, index, ro, rd):
        return lit * branch(index >= 0, left, whole, ro, rd, index)

    def left(ro, rd, index):
        return 1 - sphere_share(ro, rd, at(spheres, index))

    def whole(ro, rd, index):
        return constant(1, like)

    return each(stacked(darkest.index, like), add, constant(1, like), ro, rd, unroll=False)


def lit_share_of_planes(ro: Vec3, rd: Vec3, planes: Plane | None, but: Int | None = None) -> Float:
    """Return the share of a square whose rays, from jets along one direction, meet no plane but number `but`."""

    def body(lit, i, plane, ro, *but):
        distance, approach = dot(plane.point - ro, plane.normal), dot(rd, plane.normal)
        hidden = select(approach > 0, distance, -distance).share
        for index in but:
            hidden = select(index == i, 0, hidden)
        return lit * (1 - select(approach == 0, 0, hidden))

    left_out = () if but is None else (but,)
    return each(planes, body, constant(1, values(ro.x)), ro, *left_out)


def none_yet(kind: type, number: int, like: Float) -> Any:
    """Return the state of a search for the best `number` before it has begun."""
    return kind((constant(0, like),) * number, (constant(-1, like, "int32"),) * number)


def inserted(best: Any, merit: Float, index: Int, able: Bool, last_wins: bool = True) -> Any:
    """Return the best few of those and one more, if it is `able`; of equal ones the last, or else the first, leads."""
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


def stacked(planes: Any, like: Float) -> Any:
    """Return planes as one array whose first axis numbers them: items for `each`."""
    xp = namespace(like)
    return xp.stack([xp.broadcast_to(plane, like.shape) for plane in planes])
