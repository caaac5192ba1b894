"""A square of a pixel as the mean over it: what is seen of the surfaces in it, and of the sky behind them.

Where an edge runs through a square, its colour is that of either side, each by its share. A share changes as the edge
moves, so that such an image has the derivatives of edges that move; at one point nothing is to be seen of them.
"""

from typing import Any, NamedTuple

from raytrace.edges.occlusion import darkness, inserted, none_yet, sphere_share, stacked
from raytrace.edges.shading import SQUARE
from raytrace.language.control import at, branch, count, detach, each, step
from raytrace.language.glsl import Vec2, Vec3, clamp, dot, maximum, minimum, select, smallest_divisor, sqrt
from raytrace.language.jet import Jet, jet, value, values
from raytrace.language.namespace import constant
from raytrace.language.tree import array_map, tree_map
from raytrace.language.types import Bool, Float, Int
from raytrace.shader.camera import orthographic_ray, primary_ray
from raytrace.shader.hit import Hit, Nearest
from raytrace.shader.main import shade
from raytrace.shader.sky import background_color
from raytrace.shader.sphere import sphere_reach
from raytrace.shader.uniforms import Plane, Program, Sphere, Uniforms

__all__ = ["camera_ray", "mean_color"]

#: So many surfaces are seen in a square; the last of them stands for those behind it.
LAYERS = 3
#: A plane is seen at least so much of a square away from its horizon, where it would be infinitely far.
HORIZON = 2.0**-10


class Layer(NamedTuple):
    """What a square sees of one surface, were it alone: its share of the square, and t there, a jet."""

    share: Float
    t: Jet


class Part(NamedTuple):
    """What a square sees of a surface: its number, its share of the square, t, and the way to the share's middle."""

    index: Int
    share: Float
    t: Jet
    middle: Vec2


def camera_ray(uniforms: Uniforms, program: Program, ndc: Vec2) -> tuple[Vec3, Vec3]:
    """Return origin and direction of the camera's ray, of jets."""
    ray = orthographic_ray if program.orthographic else primary_ray
    return array_map(jet, ray(uniforms.camera, ndc))


def mean_color(uniforms: Uniforms, program: Program, ndc: Vec2) -> Vec3:
    """Return the mean of the linear image over the squares around `ndc`, of jets."""
    ro, rd = camera_ray(uniforms, program, ndc)
    zero = 0 * ndc.x.value
    black = Vec3(zero, zero, zero)
    if uniforms.spheres is None and uniforms.planes is None:
        return black + sky_color(uniforms, rd, (), (), 1 + zero)

    def seen(ro, rd, index):
        return layer(ro, rd, index, uniforms, program)

    def unseen(ro, rd, index):
        zero = constant(0, rd.x.value)
        return Layer(zero, Jet(zero, zero, zero))

    def see(layers, _, index, ro, rd):
        return (*layers[1:], branch(index >= 0, seen, unseen, ro, rd, index))

    def shaded(ro, rd, part):
        ro, rd, t = array_map(lambda x: aside(x, part.middle), (ro, rd, part.t))
        hit = Hit(t, part.index)
        return part.share * values(shade(ro, rd, hit, uniforms, program, **SQUARE).linear)

    def dark(ro, rd, part):
        zero = constant(0, part.share)
        return Vec3(zero, zero, zero)

    def add(color, _, part, ro, rd):
        return color + branch(part.share > 0, shaded, dark, ro, rd, part)

    *indices, behind = nearest_surfaces(*tree_map(detach, (ro, rd, uniforms)))
    nothing = Layer(zero, Jet(zero, zero, zero))
    layers = each(stacked(indices, zero), see, (nothing,) * LAYERS, ro, rd, unroll=False)
    parts, uncovered = visible_parts(indices, layers, behind >= 0)
    color = sky_color(uniforms, rd, parts, layers, uncovered)
    return each(tree_map(lambda *both: stacked(both, zero), *parts), add, color + black, ro, rd, unroll=False)


@step
def nearest_surfaces(ro: Vec3, rd: Vec3, uniforms: Uniforms) -> tuple[Int, ...]:
    """Return the numbers of the nearest surfaces that may be seen in the square, nearest first; -1 for no more.

    Spheres are counted first, then planes.
    """

    def sphere(nearest, i, sphere, ro, rd):
        approach = sphere_approach(ro, rd, sphere)
        return inserted(nearest, approach, constant(i, nearest.index[0]), approach > 0)

    def plane(nearest, i, plane, ro, rd):
        approach = plane_approach(ro, rd, plane)
        number = constant(i, nearest.index[0]) + count(uniforms.spheres)
        seen = approach.share > 0
        # At the horizon it may be seen only beside the square's middle.
        far = smallest_divisor(approach.value)
        return inserted(nearest, maximum(approach.value, far), number, seen, last_wins=False)

    nearest = each(uniforms.spheres, sphere, none_yet(Nearest, LAYERS + 1, value(rd.x)), ro, rd)
    return each(uniforms.planes, plane, nearest, ro, rd).index


@step
def sphere_approach(ro: Vec3, rd: Vec3, sphere: Sphere) -> Float:
    """Return 1 / t of a sphere in the middle of a square, and 0 where the square sees nothing of it."""
    t = sphere_reach(values(ro), values(rd), sphere)
    return select((darkness(ro, rd, sphere) > 0) & (t >= 0), 1 / maximum(t, smallest_divisor(t)), 0)


def plane_approach(ro: Vec3, rd: Vec3, plane: Plane) -> Jet:
    """Return 1 / t of a plane: positive where it is seen and, without any jump, negative beyond its horizon."""
    distance = dot(plane.point - ro, plane.normal)
    # Rays from a plane's own points do not meet it, as t = 0 is not seen.
    apart = abs(distance) >= smallest_divisor(distance)
    return select(apart, dot(rd, plane.normal) / select(apart, distance, 1), jet(constant(0, rd.x.value)))


def layer(ro: Vec3, rd: Vec3, index: Int, uniforms: Uniforms, program: Program) -> Layer:
    """Return what the square sees of surface number `index`."""
    spheres, planes = uniforms.spheres, uniforms.planes

    def on_sphere(ro, rd, index):
        sphere = at(spheres, index)
        return sphere_share(ro, rd, sphere), sphere_reach(ro, rd, sphere, program.intersection)

    def on_plane(ro, rd, index):
        approach = plane_approach(ro, rd, at(planes, index - count(spheres)))
        least = maximum(approach.spread * HORIZON, smallest_divisor(approach.value))
        t = 1 / select(approach > least, approach, Jet(least, approach.dx, approach.dy))
        return approach.share, t

    if planes is None:
        share, t = on_sphere(ro, rd, index)
    elif spheres is None:
        share, t = on_plane(ro, rd, index)
    else:
        share, t = branch(index < count(spheres), on_sphere, on_plane, ro, rd, index)
    return Layer(share, t)


def centre_shift(clearance: Jet) -> Vec2:
    """Return the way from the square's middle to that of the part where the clearance is positive, in squares."""
    x, y = clearance.dx, clearance.dy
    steep = maximum(sqrt(x * x + y * y), smallest_divisor(x))
    x, y = x / steep, y / steep
    half = (abs(x) + abs(y)) / 2
    length = (half - clamp(clearance.value / steep, -half, half)) / 2
    return Vec2(x * length, y * length)


def aside(x: Jet, shift: Vec2) -> Jet:
    """Return a jet as it is `shift` away, in squares."""
    return Jet(x.value + (x.dx * shift.x + x.dy * shift.y), x.dx, x.dy)


@step
def visible_parts(indices: Any, layers: Any, behind: Bool) -> tuple[tuple[Part, ...], Float]:
    """Return what a square sees of surfaces, the nearer ones first, and what share of it sees none.

    behind: whether there are more surfaces, for which the last one stands. Where several have edges in a square, their
    shares are taken to be independent. Where two surfaces meet, each is seen in the middle of what is in front of the
    other: beyond that line it may be inside a sphere, in its shadow.
    """
    uncovered = select(behind, 0, 1 + 0 * layers[0].share)
    for layer in layers:
        uncovered = uncovered * (1 - layer.share)
    zero = 0 * uncovered
    shares = [layer.share for layer in layers]
    middles = [Vec2(zero, zero) for _ in layers]
    for i, front in enumerate(layers):
        for j, back in enumerate(layers[i + 1 :], i + 1):
            ahead = _approach(front.t) - _approach(back.t)
            # Equal surfaces do not take turns.
            apart = (ahead.spread > 0) | (ahead != 0)
            nearer = select(apart, (-ahead).share, 0)
            meet = (nearer > 0) & (nearer < 1) & (front.share > 0) & (back.share > 0)
            shares[i] = shares[i] * (1 - back.share * nearer)
            shares[j] = shares[j] * (1 - front.share * (1 - nearer))
            for one, clearance in ((i, ahead), (j, -ahead)):
                middles[one] = select(meet, centre_shift(clearance), middles[one])
    total = sum(shares[1:], shares[0])
    scale = (1 - uncovered) / maximum(total, smallest_divisor(total))
    parts = zip(indices, shares, layers, middles, strict=True)
    return tuple(Part(index, share * scale, layer.t, middle) for index, share, layer, middle in parts), uncovered


def _approach(t: Jet) -> Jet:
    return 1 / maximum(t, smallest_divisor(t.value))


def sky_color(uniforms: Uniforms, rd: Vec3, parts: Any, layers: Any, uncovered: Float) -> Vec3:
    """Return the background's part of a square, of which it is seen in the share that is `uncovered`."""
    first_plane = count(uniforms.spheres)
    # What no plane hides, where each ends at its horizon.
    open_ = 1 + 0 * uncovered
    for part, layer in zip(parts, layers, strict=True):
        open_ = open_ * (1 - select(part.index >= first_plane, layer.share, 0))

    def sky(rd, open_, uncovered):
        # It is what lies below the horizon that a plane hides.
        share = minimum(rd.y.share, open_) / maximum(open_, smallest_divisor(open_))
        rd = values(rd)
        color = background_color(rd._replace(y=maximum(rd.y, 0)), uniforms.sky, uniforms.sun)
        return uncovered * (share * color + (1 - share) * uniforms.sky.void)

    def none(rd, open_, uncovered):
        zero = 0 * uncovered
        return Vec3(zero, zero, zero)

    return branch(uncovered > 0, sky, none, rd, open_, uncovered)
