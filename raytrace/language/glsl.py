"""GLSL's vocabulary, for planes of any arithmetic.

A vector is a named tuple of component planes, not an array with a trailing axis: shader code then reads as it
does in GLSL (``rd.y < 0``, ``dot(N, L)``, ``point.xz / tile_size``) and every operation runs over contiguous
memory. A component may also be of shape (), a uniform; operations broadcast.

Source: The OpenGL ES Shading Language 3.00, chapters 5 (operators) and 8 (built-in functions).
"""

import operator
from collections import namedtuple
from collections.abc import Callable
from typing import Any

import numpy as np

from raytrace.language.engine import engine
from raytrace.language.jet import value
from raytrace.language.literal import Literal
from raytrace.language.namespace import constant, namespace
from raytrace.language.selection import maximum, minimum, select
from raytrace.language.tree import array_map
from raytrace.language.types import Array

__all__ = [
    "Mat3",
    "Mat4",
    "Vec2",
    "Vec3",
    "Vec4",
    "clamp",
    "cross",
    "dot",
    "exp2",
    "floor",
    "isfinite",
    "log2",
    "maximum",
    "minimum",
    "mix",
    "mod",
    "normalize",
    "pow",
    "select",
    "smallest_divisor",
    "smallest_normal",
    "sqrt",
]


class _Componentwise:
    """Operators of GLSL's vectors: component by component, scalars are broadcast."""

    # Without this, `ndarray * Vec3` would build an array of shape (3, height, width).
    __array_ufunc__ = None
    __slots__ = ()

    def _with(self: Any, operation, other: Any):
        others = other if _is_vector(other) else (other,) * len(self)
        return type(self)(*map(operation, self, others))

    def __add__(self, other):
        return self._with(operator.add, other)

    def __sub__(self, other):
        return self._with(operator.sub, other)

    def __mul__(self, other):
        return self._with(operator.mul, other)

    def __truediv__(self, other):
        return self._with(operator.truediv, other)

    def __radd__(self, other):
        return self._with(lambda a, b: b + a, other)

    def __rsub__(self, other):
        return self._with(lambda a, b: b - a, other)

    def __rmul__(self, other):
        return self._with(lambda a, b: b * a, other)

    def __rtruediv__(self, other):
        return self._with(lambda a, b: b / a, other)

    def __neg__(self: Any):
        return type(self)(*map(operator.neg, self))


class Vec2(_Componentwise, namedtuple("Vec2", "x y")):
    """GLSL's ``vec2``: two planes."""

    __slots__ = ()


class Vec3(_Componentwise, namedtuple("Vec3", "x y z")):
    """GLSL's ``vec3``: three planes."""

    __slots__ = ()

    @property
    def xz(self) -> Vec2:
        return Vec2(self.x, self.z)


class Vec4(_Componentwise, namedtuple("Vec4", "x y z w")):
    """GLSL's ``vec4``: four planes."""

    __slots__ = ()

    @property
    def xyz(self) -> Vec3:
        return Vec3(self.x, self.y, self.z)


class _Matrix:
    """A matrix as the tuple of its columns, as GLSL stores it."""

    __array_ufunc__ = None
    __slots__ = ()

    def __mul__(self: Any, vector):
        own = _own("dot", *vector, *self.x)
        if own is not None:
            return type(self.x)(*(own(row, vector) for row in zip(*self, strict=True)))
        first, *rest = (column * component for column, component in zip(self, vector, strict=True))
        return sum(rest, first)


class Mat3(_Matrix, namedtuple("Mat3", "x y z")):
    """GLSL's ``mat3``: three columns, each a `Vec3`."""

    __slots__ = ()


class Mat4(_Matrix, namedtuple("Mat4", "x y z w")):
    """GLSL's ``mat4``: four columns, each a `Vec4`."""

    __slots__ = ()

    @property
    def mat3(self) -> Mat3:
        """The upper left part, ``mat3(m)``."""
        return Mat3(self.x.xyz, self.y.xyz, self.z.xyz)


def _own(name: str, *operands: Any) -> Callable | None:
    """The built-in of that name of the operands' arithmetic, or ``None``.

    An arithmetic that stands for other people's programs has built-ins of its own (`built_ins` of its namespace): GLSL
    leaves the order of operations inside a built-in to the implementation.
    """
    array = next((operand for operand in operands if hasattr(operand, "__array_namespace__")), None)
    return None if array is None else getattr(getattr(namespace(array), "built_ins", None), name, None)


def dot(a: Any, b: Any) -> Array:
    """The scalar product of two vectors, summed from x on."""
    own = _own("dot", *a, *b)
    if own is not None:
        return own(a, b)
    first, *rest = (a * b for a, b in zip(a, b, strict=True))
    return sum(rest, first)


def cross(a: Vec3, b: Vec3) -> Vec3:
    """The vector product."""
    return Vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


def normalize(v: Vec3) -> Vec3:
    """`v` divided by its length, whatever that is; the zero vector, which GLSL leaves undefined, stays zero."""
    v = _of_moderate_length(v)
    squared = dot(v, v)
    return v / select(squared > 0, sqrt(squared), 1)


def _of_moderate_length(v: Vec3) -> Vec3:
    """`v`, times a power of two where its squared length would overflow or underflow. Such a product is exact."""
    limits = namespace(v.x).finfo(v.x.dtype)
    if not limits.smallest_normal:
        return v  # an arithmetic without limits
    # The limits are those of float64 in what is wider, as a Python number writes the powers.
    exponents = int(min(-np.frexp(limits.smallest_normal)[1], 1022))
    digits = int(-np.frexp(limits.eps)[1])
    # Up to there a square that underflows is no digit of the largest one.
    far = (exponents - digits) // 2 - 1
    up, down = exponents * 7 // 10, exponents * 11 // 20
    largest = maximum(maximum(maximum(v.x, -v.x), maximum(v.y, -v.y)), maximum(v.z, -v.z))
    scale = select(largest < 2.0**-far, 2.0**up, select(largest > 2.0**far, 2.0**-down, constant(1, largest)))
    return v * scale


def clamp(x: Any, low: Any, high: Any) -> Any:
    """`x` limited to the range from `low` to `high`; of a vector, each component."""
    return array_map(lambda x: minimum(maximum(x, low), high), x)


def mix(a: Any, b: Any, share: Any) -> Any:
    """The linear blend ``a * (1 - share) + b * share``."""
    own = _own("mix", *_components(a), *_components(b), *_components(share))
    if own is None:
        return a * (1 - share) + b * share
    vector: Any = next((type(x) for x in (a, b, share) if isinstance(x, _Componentwise)), None)
    if vector is None:
        return own(a, b, share)
    n = len(vector._fields)
    return vector(*map(own, *(_components(x) if isinstance(x, _Componentwise) else (x,) * n for x in (a, b, share))))


def _components(x: Any) -> tuple:
    return tuple(x) if _is_vector(x) else (x,)


def _is_vector(x: Any) -> bool:
    return isinstance(x, _Componentwise)


def floor(x: Any) -> Any:
    """The largest whole number not above `x`; of a vector, each component."""
    return array_map(lambda x: namespace(x).floor(x), x)


def mod(x: Array, y: Any) -> Array:
    """``x - y * floor(x / y)``: the remainder with the sign of `y`."""
    own = _own("mod", x)
    return x - y * floor(x / y) if own is None else own(x, y)


def isfinite(x: Array) -> Array:
    """False where `x` is infinite or not a number."""
    return namespace(x).isfinite(x)


def smallest_normal(x: Array, times: int = 1) -> Array:
    """The smallest positive normal number of the arithmetic of `x`, of shape (), or so many times that."""
    return constant(times * namespace(x).finfo(x.dtype).smallest_normal, x)


def smallest_divisor(x: Array) -> Array:
    """A positive number, of shape (), as small as may be divided by: a quotient's derivative has it squared."""
    return 2 * sqrt(smallest_normal(value(x)))


def sqrt(x: Array) -> Array:
    """The square root; 0 for x <= 0.

    The derivative at 0 is infinite and is defined as 0 here: the root is taken of a number that is never below
    the smallest normal one, so no derivative is infinite and none is lost where `x` is positive and normal.
    """
    own = _own("root", x)
    if own is not None:
        return own(x)
    if not namespace(x).finfo(x.dtype).smallest_normal:
        return namespace(x).sqrt(maximum(x, 0))  # an arithmetic without limits; it has no derivatives
    tiny = smallest_normal(x)
    return select(x > 0, namespace(x).sqrt(maximum(x, tiny)), 0)


def exp2(x: Array) -> Array:
    """Two to the power `x`, as the engine computes it."""
    return engine().exp2(x)


def log2(x: Array) -> Array:
    """The logarithm to base 2 of a positive number, as the engine computes it."""
    return engine().log2(x)


def pow(x: Any, y: Any) -> Any:
    """`x` to the power `y`, for x >= 0 and y > 0; of a vector, each component.

    As GLSL defines its precision: ``exp2(y * log2(x))``. Where `y` is a literal 1/2, 1/4, 1/8, ... it is the
    same number by square roots, which are faster and correctly rounded. An arithmetic that stands for other people's
    programs takes either.
    0 for x <= 0, with derivative 0 (the true one is infinite at 0 for y < 1).
    """
    roots = _square_roots(y)

    def leaf(x):
        either = _own("either", x)
        if not roots:
            return by_logarithm(x)
        return by_roots(x) if either is None else either(by_logarithm(x), by_roots(x))

    def by_roots(x):
        for _ in range(roots):
            x = sqrt(x)
        return x

    def by_logarithm(x):
        own = _own("power", x)
        if own is not None:
            return own(x, y)
        # Not the smallest normal number itself: the derivative divides by it and by ln 2, which a compiler may
        # take for one division by a product, and that would underflow.
        positive = maximum(x, smallest_normal(x, times=4))
        return select(x > 0, exp2(y * log2(positive)), 0)

    return array_map(leaf, x)


def _square_roots(exponent: Any) -> int:
    """k for a literal exponent of 1 / 2**k, otherwise 0."""
    if not isinstance(exponent, Literal):
        return 0
    numerator, denominator = exponent.value.as_integer_ratio()
    power_of_two = denominator & (denominator - 1) == 0
    return denominator.bit_length() - 1 if numerator == 1 and power_of_two else 0
