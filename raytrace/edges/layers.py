"""A pixel as the mean over its square: what is seen of each surface in it, and of the sky behind them.

Where an edge runs through a pixel, the pixel's colour is that of either side, each by its share. A share changes as the
edge moves, so that such an image has the derivatives of edges that move; at one point of a pixel nothing is to be seen
of them.
"""

from typing import Any, NamedTuple

from raytrace.edges.coverage import half_plane_coverage
from raytrace.edges.occlusion import inserted, none_yet, sphere_share
from raytrace.edges.shading import PIXEL, plane_surface
from raytrace.language.control import at, branch, count, each, rarely, step
from raytrace.language.glsl import Vec2, Vec3, clamp, dot, maximum, minimum, select, smallest_divisor
from raytrace.language.jet import Jet, jet, value, values
from raytrace.language.namespace import constant, namespace
from raytrace.language.tree import array_map, tree_map
from raytrace.language.types import Float, Int
from raytrace.shader.camera import orthographic_ray, primary_ray
from raytrace.shader.hit import Hit, Nearest
from raytrace.shader.main import shade
from raytrace.shader.sampling import sample_grid
from raytrace.shader.sky import background_color
from raytrace.shader.sphere import sphere_reach
from raytrace.shader.uniforms import Plane, Program, Uniforms

__all__ = ["mean_color"]

#: So many surfaces are told apart in one pixel.
LAYERS = 3
#: A pixel that an edge of shadow runs through is cut into so many squares along either side: the pattern and the edge's
#: own curve go with it there.
FINER = 4
#: A plane is seen at least so much of a pixel away from its horizon, where it would be infinitely far.
HORIZON = 2.0**-10


class Layer(NamedTuple):
    """What a pixel sees of one surface, were it alone.

    share: of the pixel. approach: 1 / t, a jet. shift: from the pixel's centre to that of the share, in pixels.
    """

    share: Float
    approach: Jet
    shift: Vec2


def mean_color(uniforms: Uniforms, program: Program, pixel_ndc: Vec2) -> Vec3:
    """The mean of the linear image over the pixels whose centres are at `pixel_ndc`, of jets."""

    def ray(pixel_ndc):
        ray = orthographic_ray if program.orthographic else primary_ray
        return array_map(jet, ray(uniforms.camera, pixel_ndc))

    ro, rd = ray(pixel_ndc)
    indices = nearest_surfaces(ro, rd, uniforms)

    def seen(ro, rd, index):
        return layer(ro, rd, index, uniforms)

    def nothing(ro, rd, index):
        zero = constant(0, rd.x.value)
        return Layer(zero, jet(zero), Vec2(zero, zero))

    layers = [branch(index >= 0, seen, nothing, ro, rd, index) for index in indices]
    visible, uncovered = visible_shares(layers, constant(1, rd.x.value))

    def shaded(pixel_ndc, index):
        ro, rd = ray(pixel_ndc)
        t = reach(ro, rd, index, uniforms, program)
        steps = shade(ro, rd, Hit(t, index), uniforms, program, False, plane_surface, PIXEL)
        return values((steps.linear, steps.shadow))

    def finer(pixel_ndc, index, color):
        def add(total, _, place, pixel_ndc, index):
            square = Vec2(*(Jet(x.value, x.dx / FINER, x.dy / FINER) for x in shifted(pixel_ndc, place)))
            return total + shaded(square, index)[0] / FINER**2

        zero = constant(0, color.x)
        grid = sample_grid(FINER, color.x) / FINER - 0.5
        return each(grid, add, Vec3(zero, zero, zero), pixel_ndc, index, unroll=False)

    def coarse(pixel_ndc, index, color):
        return color

    def colored(pixel_ndc, index, shift):
        pixel_ndc = shifted(pixel_ndc, shift)
        color, lit = shaded(pixel_ndc, index)
        if program.lighting != "shadow" or (uniforms.spheres is None and uniforms.shadow_planes is None):
            return color
        return rarely((lit > 0) & (lit < 1), finer, coarse, pixel_ndc, index, color)

    def black(pixel_ndc, index, shift):
        zero = constant(0, pixel_ndc.x.value)
        return Vec3(zero, zero, zero)

    def add(color, _, surface, pixel_ndc):
        index, share, shift = surface
        return color + share * branch(share > 0, colored, black, pixel_ndc, index, shift)

    color = sky_color(uniforms, ray, pixel_ndc, rd, uncovered, layers, indices)
    surfaces = [(index, seen.share, seen.shift) for index, seen in zip(indices, visible, strict=True)]
    return each(stacked(surfaces, pixel_ndc.x.value), add, color, pixel_ndc, unroll=False) if surfaces else color


def stacked(structures: list, like: Float) -> Any:
    """Structures of planes as one of arrays whose first axis numbers them: items for `each`."""
    xp = namespace(like)
    return tree_map(lambda *planes: xp.stack([xp.broadcast_to(plane, like.shape) for plane in planes]), *structures)


@step
def nearest_surfaces(ro: Vec3, rd: Vec3, uniforms: Uniforms) -> tuple[Int, ...]:
    """The numbers of the nearest surfaces of which the pixel sees anything, nearest first; -1 where there are no more.

    Spheres are counted first, then planes.
    """

    def sphere(nearest, i, sphere, ro, rd):
        t = value(sphere_reach(ro, rd, sphere))
        approach = 1 / maximum(t, smallest_divisor(t))
        return inserted(nearest, approach, constant(i, nearest.index[0]), (sphere_share(ro, rd, sphere) > 0) & (t >= 0))

    def plane(nearest, i, plane, ro, rd):
        approach = plane_approach(ro, rd, plane)
        number = constant(i, nearest.index[0]) + count(uniforms.spheres)
        seen = half_plane_coverage(approach) > 0
        # At the horizon it may be seen only beside the pixel's centre.
        far = smallest_divisor(approach.value)
        return inserted(nearest, maximum(approach.value, far), number, seen, last_wins=False)

    nearest = none_yet(Nearest, min(LAYERS, count(uniforms.spheres) + count(uniforms.planes)), value(rd.x))
    nearest = each(uniforms.spheres, sphere, nearest, ro, rd)
    return each(uniforms.planes, plane, nearest, ro, rd).index


def plane_approach(ro: Vec3, rd: Vec3, plane: Plane) -> Jet:
    """1 / t of a plane: positive where it is seen and, without any jump, negative beyond its horizon."""
    distance = dot(plane.point - ro, plane.normal)
    # Rays from a plane's own points do not meet it, as t = 0 is not seen.
    apart = abs(distance) >= smallest_divisor(distance)
    return select(apart, dot(rd, plane.normal) / select(apart, distance, 1), jet(constant(0, rd.x.value)))


def layer(ro: Vec3, rd: Vec3, index: Int, uniforms: Uniforms) -> Layer:
    """What the pixel sees of surface number `index`."""
    spheres, planes = uniforms.spheres, uniforms.planes

    def on_sphere(ro, rd, index):
        sphere = at(spheres, index)
        t = sphere_reach(ro, rd, sphere)
        share = sphere_share(ro, rd, sphere)
        clearance = dot(sphere.center - ro, rd)
        offset = ro - sphere.center + clearance * rd
        # Towards the sphere's middle the distance from it falls.
        return Layer(share, 1 / maximum(t, smallest_divisor(t.value)), centre_shift(-dot(offset, offset), share))

    def on_plane(ro, rd, index):
        approach = plane_approach(ro, rd, at(planes, index - count(spheres)))
        share = half_plane_coverage(approach)
        return Layer(share, approach, centre_shift(approach, share))

    if planes is None:
        return on_sphere(ro, rd, index)
    if spheres is None:
        return on_plane(ro, rd, index)
    return branch(index < count(spheres), on_sphere, on_plane, ro, rd, index)


def centre_shift(clearance: Jet, share: Float) -> Vec2:
    """From the pixel's centre to that of the part where the clearance is positive, in pixels."""
    steepness = maximum(clearance.spread, smallest_divisor(clearance.value))
    length = (1 - share) / 2
    return Vec2(clearance.dx / steepness * length, clearance.dy / steepness * length)


def shifted(pixel_ndc: Vec2, shift: Vec2) -> Vec2:
    """Coordinates of points `shift` away, in pixels, from `pixel_ndc`."""
    return Vec2(*(x + (x.dx * shift.x + x.dy * shift.y) for x in pixel_ndc))


def visible_shares(layers: list[Layer], whole: Float) -> tuple[list[Layer], Float]:
    """The layers, nearest first, with that of their shares which is seen, and what is left of the whole pixel.

    Where several have edges in a pixel their shares are taken to be independent. Where two meet, so that either is in
    front in a part of the pixel, they hide each other there, and are seen in the middle of what is left to them.
    """
    uncovered = whole
    for surface in layers:
        uncovered = uncovered * (1 - surface.share)

    before = [surface.share for surface in layers]
    meeting = [whole] * len(layers)
    shifts = [surface.shift for surface in layers]

    def hide(i, j, ahead, behind):
        """Layer j hides the part `behind` of layer i, where layer i is not `ahead` of it."""
        meets = (behind > 0) & (behind < 1)
        left = 1 - layers[j].share * behind
        before[i] = before[i] * select(meets, 1, left)
        meeting[i] = minimum(meeting[i], select(meets, left, 1))
        weight = select(meets, (1 - behind) / select(meets, left, 1), 0)
        shifts[i] = shifts[i] + weight * centre_shift(ahead, 1 - behind)

    for i, front in enumerate(layers):
        for j, back in enumerate(layers[i + 1 :], i + 1):
            ahead = front.approach - back.approach
            # Equal surfaces do not take turns.
            apart = (ahead.spread > 0) | (ahead != 0)
            behind = select(apart, half_plane_coverage(-ahead), 0)
            hide(i, j, ahead, behind)
            hide(j, i, -ahead, 1 - behind)

    visible = [
        Layer(share * left, surface.approach, clamp(shift, -0.5, 0.5))
        for share, left, surface, shift in zip(before, meeting, layers, shifts, strict=True)
    ]
    total = sum((surface.share for surface in visible), 0 * whole)
    scale = (1 - uncovered) / maximum(total, smallest_divisor(total))
    return [surface._replace(share=surface.share * scale) for surface in visible], uncovered


def reach(ro: Vec3, rd: Vec3, index: Int, uniforms: Uniforms, program: Program) -> Jet:
    """t of surface number `index`, where the pixel sees something of it."""
    spheres, planes = uniforms.spheres, uniforms.planes

    def on_sphere(ro, rd, index):
        return sphere_reach(ro, rd, at(spheres, index), program.intersection)

    def on_plane(ro, rd, index):
        approach = plane_approach(ro, rd, at(planes, index - count(spheres)))
        least = maximum(approach.spread * HORIZON, smallest_divisor(approach.value))
        return 1 / select(approach > least, approach, Jet(least, approach.dx, approach.dy))

    if planes is None:
        return on_sphere(ro, rd, index)
    if spheres is None:
        return on_plane(ro, rd, index)
    return branch(index < count(spheres), on_sphere, on_plane, ro, rd, index)


def sky_color(uniforms, ray, pixel_ndc, rd, uncovered, layers, indices) -> Vec3:
    """The background's part of the pixel: its colour above the horizon and below it, each by its visible share."""
    first_plane = count(uniforms.spheres)
    by_planes, by_spheres = 1, 1
    for surface, index in zip(layers, indices, strict=True):
        plane = index >= first_plane
        by_planes = by_planes * (1 - select(plane, surface.share, 0))
        by_spheres = by_spheres * (1 - select(plane, 0, surface.share))
    above = half_plane_coverage(rd.y)
    # Where a plane ends at the horizon it is what lies below that it hides.
    below = maximum(by_planes - above, 0)
    shares = by_spheres * (by_planes - below), by_spheres * below

    def sky(pixel_ndc, share, up):
        # At the horizon itself the sky is steep.
        _, rd = ray(shifted(pixel_ndc, centre_shift(up, share)))
        rd = values(rd)
        return background_color(rd._replace(y=maximum(rd.y, 0)), uniforms.sky, uniforms.sun)

    def none(pixel_ndc, share, up):
        zero = constant(0, pixel_ndc.x.value)
        return Vec3(zero, zero, zero)

    part = branch(shares[0] > 0, sky, none, pixel_ndc, above, rd.y)
    return shares[0] * part + shares[1] * uniforms.sky.void
