"""How much of a pixel lies on one side of an edge: the box filter, where an edge is straight and a disc is round.

An edge is where a clearance changes its sign, a jet: so it is known where the edge runs, to first order.
"""

from math import pi
from typing import NamedTuple

from raytrace.language.glsl import Vec3, clamp, cross, dot, maximum, minimum, mix, select, smallest_divisor, sqrt
from raytrace.language.jet import Jet
from raytrace.language.types import Bool, Float

__all__ = ["disc_coverage", "half_plane_coverage", "interval_coverage", "positive_mean"]

#: A clearance that changes along one of the pixel's axes only is taken to change so much along the other.
LEAST = 2.0**-10
#: Pixels that are so many discs wide, or so many discs away, might as well be infinitely so.
MOST = 2.0**10


class _Edge(NamedTuple):
    """An edge in a pixel, in widths of the pixel along the axis that it crosses more steeply.

    steep: how much the clearance changes over that width. flat: the other axis's change as a share of it. distance:
    from the edge to the pixel's centre; beyond 1 there is no edge in the pixel.
    """

    steep: Float
    flat: Float
    distance: Float

    @classmethod
    def of(cls, clearance: Jet) -> "_Edge":
        x, y = abs(clearance.dx), abs(clearance.dy)
        steep = maximum(maximum(x, y), smallest_divisor(x))
        flat = maximum(minimum(x, y) / steep, LEAST)
        return cls(steep, flat, clamp(clearance.value, -steep, steep) / steep)

    @property
    def corner(self) -> Float:
        """How far the edge is from the far corner of the pixel; 0 where it is beyond."""
        return maximum((1 + self.flat) / 2 - abs(self.distance), 0)

    @property
    def crosses(self) -> Bool:
        """Whether it runs from side to side, and cuts off no corner."""
        return abs(self.distance) <= (1 - self.flat) / 2


def half_plane_coverage(clearance: Jet) -> Float:
    """The share of a pixel where the clearance is positive, exact where it is linear.

    The clearance over the pixel is distributed as the sum of two uniform numbers, a trapezoid, whose integral this is.
    """
    edge = _Edge.of(clearance)
    cut_off = minimum(edge.corner * edge.corner / (2 * edge.flat), 1)
    return select(edge.crosses, 0.5 + edge.distance, select(edge.distance > 0, 1 - cut_off, cut_off))


def positive_mean(x: Jet) -> Float:
    """The mean of max(x, 0) over a pixel, exact where x is linear: the integral of the coverage.

    It is half of x and of the mean of |x|.
    """
    edge = _Edge.of(x)
    flat, corner = edge.flat, edge.corner
    crossing = edge.distance * edge.distance + flat * flat / 12 + 0.25
    size = select(edge.crosses, crossing, abs(edge.distance) + corner * corner * corner / (3 * flat))
    return select(abs(x) < edge.steep, 0.5 * edge.steep * (edge.distance + size), maximum(x.value, 0))


def interval_coverage(x: Jet, low: float, high: float) -> Float:
    """The share of a pixel where x is between `low` and `high`."""
    return half_plane_coverage(x - low) - half_plane_coverage(x - high)


def disc_coverage(offset: Vec3, radius: Float) -> Float:
    """The share of a pixel where the vector `offset`, of jets, is not longer than `radius`.

    Both edges across its direction are taken to be straight. A disc smaller than a pixel is an upright rectangle as
    large as the disc.
    """
    offset = offset / radius
    distance = sqrt(dot(offset, offset))
    strip = half_plane_coverage(1 - distance) + half_plane_coverage(1 + distance) - 1
    here, x, y = (Vec3(*(clamp(getattr(component, name), -MOST, MOST) for component in offset)) for name in Jet._fields)
    xx, xy, yy, across = dot(x, x), dot(x, y), dot(y, y), cross(x, y)
    # The disc's pixels are pi / per_area; with so many it is no rectangle.
    squared = maximum(dot(across, across), 0.01)
    per_area = sqrt(squared)
    area = pi / per_area
    # Pixels from here to the disc's middle, and how far the disc reaches from there, along either axis.
    on_x, on_y = dot(here, x), dot(here, y)
    middle_x, middle_y = (xy * on_y - yy * on_x) / squared, (xy * on_x - xx * on_y) / squared
    reach_x, reach_y = (maximum(sqrt(square) / per_area, 1 / MOST) for square in (yy, xx))
    scale = sqrt(area / (4 * reach_x * reach_y))
    rectangle = _overlap(middle_x, reach_x * scale) * _overlap(middle_y, reach_y * scale)
    return mix(rectangle, strip, clamp((area - 1) / 3, 0, 1))


def _overlap(middle: Float, half: Float) -> Float:
    """How much of the pixel's side, from -1/2 to 1/2, is within `half` of `middle`."""
    return clamp(middle + half, -0.5, 0.5) - clamp(middle - half, -0.5, 0.5)
