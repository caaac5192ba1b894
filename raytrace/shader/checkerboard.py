"""The ground's pattern (assignment, 'Procedural Pattern')."""

from raytrace.shader.control import each, step
from raytrace.shader.coverage import half_plane_coverage, interval_coverage
from raytrace.shader.glsl import Vec2, Vec3, floor, isfinite, maximum, minimum, mix, mod, select
from raytrace.shader.jet import Jet
from raytrace.shader.namespace import constant, namespace
from raytrace.shader.types import Float

__all__ = ["checkerboard", "checkerboard_mean"]

#: A pixel is cut into so many strips across the longer side of what it sees of the ground.
STRIPS = 4


@step
def checkerboard(point: Vec3, tile_size: Float, even: Vec3, odd: Vec3, line: Vec3) -> Vec3:
    """The colour of the checkerboard in the plane of world x and z, with a middle line on each axis.

    The pattern looks at x and z whatever the plane's normal is, as printed.
    """
    t = floor(point.xz / tile_size + 0.5)
    # Floats are even from 2**24 (float32) on, so is a coordinate too large for the arithmetic.
    tile = t.x + t.y
    parity = select(isfinite(tile), mod(tile, 2), 0)
    middle_line = (t.x == 0) | (t.y == 0)
    return select(middle_line, line, mix(even, odd, parity))


@step
def checkerboard_mean(point: Vec3, tile_size: Float, even: Vec3, odd: Vec3, line: Vec3) -> Vec3:
    """The mean colour of the checkerboard over a pixel in which `point` is seen, a jet.

    The pattern is made of products of a function of x and one of z, whose means are taken one by one, in strips of the
    pixel, as to look along the ground is to see long strips of it.
    """
    p = point.xz / tile_size
    known = isfinite(p.x.value + p.y.value + p.x.spread + p.y.spread)
    p = Vec2(*(select(known, x, 0) for x in p))
    lengthwise = abs(p.x.dy) + abs(p.y.dy) >= abs(p.x.dx) + abs(p.y.dx)
    length, width = (Vec2(*(select(choice, x.dy, x.dx) for x in p)) for choice in (lengthwise, ~lengthwise))

    def add(means, k, place, p, length, width):
        sides = zip(p, length, width, strict=True)
        strip = (Jet(x.value + place * along, across, along / STRIPS) for x, along, across in sides)
        (line_x, wave_x), (line_z, wave_z) = ((interval_coverage(x, -0.5, 0.5), _square_wave_mean(x)) for x in strip)
        off_lines, stripes = means
        off_lines = off_lines + (1 - line_x) * (1 - line_z) / STRIPS
        return off_lines, stripes + (wave_x - line_x) * (wave_z - line_z) / STRIPS

    zero = constant(0, p.x.value)
    places = namespace(zero).asarray([(k + 0.5) / STRIPS - 0.5 for k in range(STRIPS)], dtype=zero.dtype)
    off_lines, stripes = each(places, add, (zero, zero), p, length, width, unroll=False)
    return line * (1 - off_lines) + (even + odd) * (0.5 * off_lines) + (even - odd) * (0.5 * stripes)


def _square_wave_mean(x: Jet) -> Float:
    """The mean of 1 on even tiles and -1 on odd ones over a pixel."""
    # A pixel that is narrower than a tile sees one edge at most.
    left = floor(x.value)
    edge = (1 - 2 * mod(left, 2)) * (1 - 2 * half_plane_coverage(x - (left + 0.5)))
    # Others: x is distributed as the sum of two uniform numbers, whose widths are these, so that the mean is a second
    # difference of the wave's second integral.
    one, other = abs(x.dx), abs(x.dy)
    wide = maximum(maximum(one, other), 0.5)
    narrow = maximum(minimum(one, other), wide / 16)
    far, near = (wide + narrow) / 2, (wide - narrow) / 2
    ends = _second_integral(x.value + far) + _second_integral(x.value - far)
    corners = _second_integral(x.value + near) + _second_integral(x.value - near)
    return select(x.spread <= 1, edge, (ends - corners) / (wide * narrow))


def _second_integral(x: Float) -> Float:
    """The periodic function whose second derivative is the square wave."""
    tile = floor(x + 0.5)
    within = x - tile
    return (1 - 2 * mod(tile, 2)) * (0.5 * within * within - 0.125)
