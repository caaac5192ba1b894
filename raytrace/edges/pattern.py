"""The mean colour of the ground's pattern over a square."""

from raytrace.edges.coverage import interval_coverage
from raytrace.language.control import each, step
from raytrace.language.glsl import Vec2, Vec3, clamp, floor, isfinite, maximum, minimum, mod, select
from raytrace.language.jet import Jet
from raytrace.language.namespace import namespace
from raytrace.language.types import Float

__all__ = ["STRIPS", "checkerboard_mean"]

#: A square is cut into so many strips across the longer side of what it sees of the ground.
STRIPS = 4
#: Near its horizon the ground is taken to be no farther than so much of the distance in the middle of the square.
NEAREST = 2.0**-6


@step
def checkerboard_mean(
    point: Vec3, t: Jet, converging: bool, tile_size: Float, even: Vec3, odd: Vec3, line: Vec3
) -> Vec3:
    """Return the mean colour of the checkerboard over a square in which `point` is seen at `t`, both jets.

    The pattern is made of products of a function of x and one of z, whose means are taken one by one, in strips of the
    square, as to look along the ground is to see long strips of it. Where rays are `converging` it is 1 / t and not t
    that is linear in the square, and a point of the ground is a quotient by it.
    """
    p = point.xz / tile_size
    known = isfinite(p.x.value + p.y.value + p.x.spread + p.y.spread)
    p = Vec2(*(select(known, x, 0) for x in p))
    lengthwise = abs(p.x.dy) + abs(p.y.dy) >= abs(p.x.dx) + abs(p.y.dx)
    length, width = (Vec2(*(select(choice, x.dy, x.dx) for x in p)) for choice in (lengthwise, ~lengthwise))

    nearing = select(lengthwise, t.dy, t.dx) / t.value if converging else 0 * p.x.value

    def add(means, k, place, p, length, width, nearing):
        low, high = (end / maximum(1 - end * nearing, NEAREST) for end in (place - 0.5 / STRIPS, place + 0.5 / STRIPS))
        near = 1 / maximum(1 - place * nearing, NEAREST)
        # From end to end, so that strips meet: what enters one leaves the next.
        sides = zip(p, length, width, strict=True)
        x, z = (
            Jet(x.value + (low + high) / 2 * along, across * near, along * (high - low)) for x, along, across in sides
        )
        # Of a strip as long as a tile it is not known how x and z go together: it is grey.
        contrast = clamp(2 - 2 * maximum(abs(x.dy), abs(z.dy)), 0, 1)
        line_x, line_z = (interval_coverage(x, -0.5, 0.5) for x in (x, z))
        plain, stripes = means
        waves = contrast * (_square_wave_mean(x) - line_x) * (_square_wave_mean(z) - line_z)
        return plain + (1 - line_x) * (1 - line_z) / STRIPS, stripes + waves / STRIPS

    zero = 0 * p.x.value
    places = namespace(zero).asarray([(k + 0.5) / STRIPS - 0.5 for k in range(STRIPS)], dtype=zero.dtype)
    plain, stripes = each(places, add, (zero, zero), p, length, width, nearing, unroll=False)
    stripes = clamp(stripes, -plain, plain)
    return line * (1 - plain) + 0.5 * (even * (plain + stripes) + odd * (plain - stripes))


def _square_wave_mean(x: Jet) -> Float:
    """The mean of 1 on even tiles and -1 on odd ones over a pixel."""
    # A pixel that is narrower than a tile sees one edge at most.
    left = floor(x.value)
    edge = (1 - 2 * mod(left, 2)) * (1 - 2 * (x - (left + 0.5)).share)
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
