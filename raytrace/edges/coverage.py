"""How much of a pixel lies on one side of an edge: the box filter, where an edge is straight and a disc is round.

An edge is where a clearance changes its sign, a jet: so it is known where the edge runs, to first order.
"""

from raytrace.language.glsl import Vec3, clamp, cross, dot, maximum, select, sqrt
from raytrace.language.jet import Jet
from raytrace.language.types import Float

__all__ = ["disc_coverage", "interval_coverage", "positive_mean"]

#: An ellipse is small where its half axes' inverses, squared, are together larger than this: less than 8 squares.
BENT = 1 / 32
#: Chords are added up along so many lines: their places between the first and the last, and their weights, by Gauss and
#: Legendre. The lines crowd where a chord may begin: t -> 3 t^2 - 2 t^3 takes the root's steepness away there.
NODES = [(0.0694318442029737, 0.1739274225687269), (0.3300094782075719, 0.3260725774312731)]
NODES += [(1 - node, weight) for node, weight in NODES]
LINES = [(t * t * (3 - 2 * t), 6 * t * (1 - t) * weight) for t, weight in NODES]
#: A disc that changes less than so much along a square's side, squared, is seen edge on.
LEAST_SQUARED = 2.0**-20
#: Pixels that are so many discs wide, or so many discs away, might as well be infinitely so.
MOST = 2.0**10


def positive_mean(x: Jet) -> Float:
    """Return the mean of max(x, 0) over a square, exact where x is linear: the integral of the share.

    It is half of x and of the mean of |x|.
    """
    edge = x.edge
    flat, corner = edge.flat, edge.corner
    crossing = edge.distance * edge.distance + flat * flat / 12 + 0.25
    size = select(edge.crosses, crossing, abs(edge.distance) + corner * corner * corner / (3 * flat))
    return select(abs(x) < edge.steep, 0.5 * edge.steep * (edge.distance + size), maximum(x.value, 0))


def interval_coverage(x: Jet, low: float, high: float) -> Float:
    """Return the share of a square where x is between `low` and `high`."""
    return maximum((x - low).share - (x - high).share, 0)


def disc_coverage(offset: Vec3, radius: Float) -> Float:
    """Return the share of a square where the vector `offset`, of jets, is not longer than `radius`.

    Seen in the square, the disc is an ellipse. Where that is large its edge is straight, but for what bends away of it;
    else its chords are added up along so many lines.
    """
    offset = offset / radius
    here, x, y = (Vec3(*(clamp(getattr(component, name), -MOST, MOST) for component in offset)) for name in Jet._fields)
    xx, xy, yy, across = maximum(dot(x, x), LEAST_SQUARED), dot(x, y), dot(y, y), cross(x, y)
    squared = maximum(dot(across, across), LEAST_SQUARED * xx)
    # From the square's middle to the ellipse's, how far that reaches down, and half of its longest chord.
    on_x, on_y = dot(here, x), dot(here, y)
    middle_x, middle_y = (xy * on_y - yy * on_x) / squared, (xy * on_x - xx * on_y) / squared
    reach, half = sqrt(xx / squared), 1 / sqrt(xx)
    low, high = (clamp((side - middle_y) / reach, -1, 1) for side in (-0.5, 0.5))
    chords = 0 * on_x
    for place, weight in LINES:
        line = low + (high - low) * place
        chord, middle = half * sqrt(1 - line * line), middle_x - xy / xx * (reach * line)
        chords = chords + weight * _overlap(middle, chord)
    # What bends away of a straight edge is the mean of a parabola over it.
    straight = (1 - (xx + yy) / 48 - sqrt(dot(offset, offset))).share
    return clamp(select(xx + yy > BENT, chords * (high - low) * reach, straight), 0, 1)


def _overlap(middle: Float, half: Float) -> Float:
    """How much of the square's side, from -1/2 to 1/2, is within `half` of `middle`."""
    return clamp(middle + half, -0.5, 0.5) - clamp(middle - half, -0.5, 0.5)
