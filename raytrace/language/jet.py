"""Jets: planes that know how they change from one pixel to the next.

A jet is an array for the shader's text like any other. Its derivatives follow the rules of calculus, but for the square
root (`_Namespace.root`). Comparisons compare the values.
"""

from collections.abc import Callable
from functools import wraps
from typing import Any, NamedTuple

from raytrace.language.namespace import lift, namespace
from raytrace.language.types import Array, Bool

__all__ = ["Edge", "Jet", "jet", "value", "values"]

#: The least that a jet changes along one axis of a pixel, as a part of that along the other.
LEAST = 2.0**-10
#: A jet is far from 0 if it is so many times what it changes by from the middle of a pixel to its farthest corner.
FAR = 4.0


def _beside_vectors(operation: Callable) -> Callable:
    """A method that leaves vectors to their own, as arrays do, and has literals in the planes' arithmetic."""

    @wraps(operation)
    def method(self, other):
        if isinstance(other, tuple) and not isinstance(other, Jet):
            return NotImplemented
        return operation(self, other if isinstance(other, Jet) else lift(other, self.value))

    return method


class Jet(NamedTuple):
    """A plane, and its derivatives by the column and by the row: how much it changes over a pixel's width and height.

    A tuple, so that whatever walks structures of planes finds three of them. Whatever is no jet is constant.
    """

    value: Array
    dx: Array
    dy: Array

    # NumPy's operators then leave the operation to this class.
    __array_ufunc__ = None
    __hash__ = None  # pyright: ignore[reportAssignmentType]

    def __array_namespace__(self, api_version: str | None = None) -> Any:
        return _Namespace(namespace(self.value))

    @property
    def dtype(self) -> Any:
        return self.value.dtype

    @property
    def shape(self) -> tuple[int, ...]:
        return self.value.shape

    @property
    def spread(self) -> Array:
        """By how much it changes over a pixel, at most: |dx| + |dy|."""
        return abs(self.dx) + abs(self.dy)

    @property
    def edge(self) -> "Edge":
        """Where it changes its sign."""
        xp, one = namespace(self.value), lift(1, self.value)
        x, y = abs(self.dx), abs(self.dy)
        # As small as may be divided by: a quotient's derivative has it squared.
        smallest = 2 * xp.sqrt(xp.finfo(self.dtype).smallest_normal * one)
        steep = xp.maximum(xp.maximum(x, y), smallest)
        flat = xp.maximum(xp.minimum(x, y) / steep, LEAST * one)
        return Edge(steep, flat, xp.minimum(xp.maximum(self.value, -steep), steep) / steep)

    @property
    def share(self) -> Array:
        """The share of a pixel where it is positive, exact where it is linear.

        Over the pixel it is distributed as the sum of two uniform numbers, a trapezoid, whose integral this is.
        """
        xp, edge = namespace(self.value), self.edge
        cut_off = xp.minimum(edge.corner * edge.corner / (2 * edge.flat), lift(1, edge.flat))
        beside = xp.where(edge.distance > 0, 1 - cut_off, cut_off)
        return xp.where(edge.crosses, 0.5 + edge.distance, beside)

    def __neg__(self) -> "Jet":
        return Jet(-self.value, -self.dx, -self.dy)

    def __abs__(self) -> "Jet":
        return _Namespace(namespace(self.value)).where(self.value < 0, -self, self)

    @_beside_vectors
    def __add__(self, other: Any) -> "Jet":
        if isinstance(other, Jet):
            return Jet(self.value + other.value, self.dx + other.dx, self.dy + other.dy)
        return Jet(self.value + other, self.dx, self.dy)

    @_beside_vectors
    def __mul__(self, other: Any) -> "Jet":
        if isinstance(other, Jet):
            a, b = self.value, other.value
            return Jet(a * b, self.dx * b + a * other.dx, self.dy * b + a * other.dy)
        return Jet(self.value * other, self.dx * other, self.dy * other)

    @_beside_vectors
    def __truediv__(self, other: Any) -> "Jet":
        if isinstance(other, Jet):
            quotient, b = self.value / other.value, other.value
            return Jet(quotient, (self.dx - quotient * other.dx) / b, (self.dy - quotient * other.dy) / b)
        return Jet(self.value / other, self.dx / other, self.dy / other)

    @_beside_vectors
    def __rtruediv__(self, other: Any) -> "Jet":
        quotient = other / self.value
        return Jet(quotient, -quotient * self.dx / self.value, -quotient * self.dy / self.value)

    @_beside_vectors
    def __sub__(self, other: Any) -> "Jet":
        return self + -other

    @_beside_vectors
    def __rsub__(self, other: Any) -> "Jet":
        return -self + other

    __radd__, __rmul__ = __add__, __mul__

    def __lt__(self, other: Any) -> Bool:
        return self.value < value(other)

    def __le__(self, other: Any) -> Bool:
        return self.value <= value(other)

    def __gt__(self, other: Any) -> Bool:
        return self.value > value(other)

    def __ge__(self, other: Any) -> Bool:
        return self.value >= value(other)

    def __eq__(self, other: Any) -> Bool:
        return self.value == value(other)

    def __ne__(self, other: Any) -> Bool:
        return self.value != value(other)


class Edge(NamedTuple):
    """An edge in a pixel, in widths of the pixel along the axis that it crosses more steeply.

    steep: how much the jet changes over that width. flat: the other axis's change as a share of it. distance: from the
    edge to the pixel's centre; beyond 1 there is no edge in the pixel.
    """

    steep: Array
    flat: Array
    distance: Array

    @property
    def corner(self) -> Array:
        """How far the edge is from the far corner of the pixel; 0 where it is beyond."""
        left = (1 + self.flat) / 2 - abs(self.distance)
        return namespace(left).maximum(left, lift(0, left))

    @property
    def crosses(self) -> Bool:
        """Whether it runs from side to side, and cuts off no corner."""
        return abs(self.distance) <= (1 - self.flat) / 2


def jet(x: Any) -> Jet:
    """A plane as a jet that does not change; a jet as it is."""
    return x if isinstance(x, Jet) else Jet(x, *(lift(0, x),) * 2)


def value(x: Any) -> Any:
    """The plane of a jet; anything else as it is."""
    return x.value if isinstance(x, Jet) else x


def values(structure: Any) -> Any:
    """`structure` with planes in the place of its jets."""
    if isinstance(structure, Jet) or not isinstance(structure, tuple):
        return value(structure)
    parts = [values(part) for part in structure]
    return type(structure)(*parts) if hasattr(structure, "_fields") else tuple(parts)


class _Namespace:
    """The functions of the array API standard that the shader uses on its way to a surface, for jets over `base`."""

    def __init__(self, base: Any):
        self.base = base

    @property
    def built_ins(self) -> "_Namespace":
        return self

    def finfo(self, dtype: Any) -> Any:
        return self.base.finfo(dtype)

    def asarray(self, value: Any, dtype: Any) -> Array:
        return self.base.asarray(value, dtype=dtype)

    def isfinite(self, x: Jet) -> Bool:
        return self.base.isfinite(x.value)

    def where(self, condition: Bool, a: Any, b: Any) -> Jet:
        """`a` where `condition` holds, else `b`; one of them at least is a jet."""
        like = a.value if isinstance(a, Jet) else b.value
        a, b = (x if isinstance(x, Jet) else jet(lift(x, like)) for x in (a, b))
        return Jet(*(self.base.where(condition, *parts) for parts in zip(a, b, strict=True)))

    def maximum(self, a: Jet, b: Any) -> Jet:
        return self._extreme(self.base.maximum, a, b)

    def minimum(self, a: Jet, b: Any) -> Jet:
        return self._extreme(self.base.minimum, a, b)

    def _extreme(self, of: Callable, a: Jet, b: Any) -> Jet:
        either = self.where(a.value == of(a.value, value(b)), a, b)
        return Jet(of(a.value, value(b)), either.dx, either.dy)

    def root(self, x: Jet) -> Jet:
        """Return the mean of the root over that part of the pixel where `x` is positive, exact where it is linear.

        So it has a derivative where `x` is 0 in the pixel, as at a sphere's silhouette. The integral of the root is a
        second difference of that of 4/15 x^(5/2), as `x` is distributed as the sum of two uniform numbers. Its slopes
        are the tangent's, but none is steeper than that half a pixel from 0.
        """
        base, edge, share = self.base, x.edge, x.share
        one = lift(1, share)
        far, near = (1 + edge.flat) / 2, (1 - edge.flat) / 2
        place = base.minimum(base.maximum(x.value / edge.steep, -far), FAR * far)
        ends = [place + far, place - far, place + near, place - near]
        a, b, c, d = (end * end * self._root(end) for end in ends)
        close = (a + b - c - d) * 4 / (15 * edge.flat * base.where(share > 0, share, one))
        # Far from 0 the root is nearly even: its mean is the root's, less by the variance.
        positive = base.where(place < FAR * far, edge.steep, x.value)
        ratio = edge.steep / positive
        apart = self._root(positive) * (1 - (1 + edge.flat * edge.flat) * ratio * ratio / 96)
        within = close * self._root(edge.steep)
        mean = base.where(place < FAR * far, within, apart)
        slope = 2 * base.maximum(mean, self._root(x.spread / 2))
        slope = base.where(slope > 0, slope, one)
        return Jet(mean, x.dx / slope, x.dy / slope)

    def _root(self, x: Array) -> Array:
        positive = x > 0
        return self.base.where(positive, self.base.sqrt(self.base.where(positive, x, lift(1, x))), lift(0, x))
