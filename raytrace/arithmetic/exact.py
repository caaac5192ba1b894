"""Arrays of `arb`, real numbers of any precision with a bound of their error (python-flint; F. Johansson, 'Arb:
Efficient Arbitrary-Precision Midpoint-Radius Interval Arithmetic', 2017).

They are citizens of the array namespace protocol, so the shader's own text runs on them. Floats enter as the numbers
that they are. Sums and products of floats are exact, as long as `precision` has room for all their digits; what is not
exact carries its bound, and a comparison that the bound leaves open raises `Undecided` rather than guess.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from flint import arb, ctx

from raytrace.language.namespace import Unlimited

__all__ = ["BITS", "Exact", "Undecided", "precision"]

#: Digits for sums of products of four float64 numbers of any size that a scene may have.
BITS = 1200


class Undecided(ArithmeticError):
    """The bound of a number's error is too wide for a comparison or `floor`: more precision is needed."""


@contextmanager
def precision(bits: int = BITS) -> Iterator[None]:
    """Within this context numbers have so many binary digits."""
    before, ctx.prec = ctx.prec, bits
    try:
        yield
    finally:
        ctx.prec = before


#: What an array's numbers are.
REAL, BOOL, INT = "float-exact", "bool", "int32"


class Exact:
    """An array of real numbers, of answers, or of indices.

    value: a NumPy array of `arb`, bool or int32.
    """

    __array_ufunc__ = None
    __slots__ = ("value",)

    def __init__(self, value: Any):
        self.value = np.asarray(value)

    @classmethod
    def of(cls, floats: Any) -> "Exact":
        """NumPy's numbers (float32, float64, longdouble; also bool and integers) as what they are."""
        floats = np.asarray(floats)
        if floats.dtype.kind != "f":
            return cls(floats if floats.dtype.kind == "b" else floats.astype(np.int32))
        high = floats.astype(np.float64)
        numbers = _number(high)
        low = np.subtract(floats, high, out=np.zeros_like(floats), where=np.isfinite(floats)).astype(np.float64)
        return cls(numbers if not low.any() else numbers + _number(low))

    def floats(self, dtype: Any = np.float64) -> np.ndarray:
        """The nearest float64, about; other kinds of arrays as they are."""
        return self.value if self.dtype != REAL else np.asarray(_nearest(self.value)).astype(dtype)

    @property
    def dtype(self) -> str:
        return {"b": BOOL, "i": INT}.get(self.value.dtype.kind, REAL)

    @property
    def shape(self) -> tuple[int, ...]:
        return self.value.shape

    @property
    def ndim(self) -> int:
        return self.value.ndim

    def __array_namespace__(self, api_version: str | None = None) -> Any:
        return ExactNamespace

    def __bool__(self) -> bool:
        raise TypeError("an array has no truth of its own")

    def __getitem__(self, key: Any) -> "Exact":
        return Exact(self.value[key])

    def __neg__(self) -> "Exact":
        return Exact(-self.value)

    def __abs__(self) -> "Exact":
        return Exact(abs(self.value))

    def __invert__(self) -> "Exact":
        return Exact(~self.value)

    def __and__(self, other: Any) -> "Exact":
        return Exact(self.value & other.value)

    def __or__(self, other: Any) -> "Exact":
        return Exact(self.value | other.value)


def _operator(name: str, wrapped: Any, swapped: bool = False) -> None:
    def operator(self: Exact, other: Any) -> Any:
        if not isinstance(other, Exact | int | float):
            return NotImplemented
        if not isinstance(other, Exact):
            other = Exact.of(np.asarray(other, np.int32 if self.dtype == INT else np.float64))
        return Exact(wrapped(other.value, self.value) if swapped else wrapped(self.value, other.value))

    setattr(Exact, name, operator)


def _quotient(a: Any, b: Any) -> Any:
    """IEEE's answer to a division by zero; `arb` has none."""
    if b.is_zero():
        return arb.nan() if a.is_zero() or a.is_nan() else (arb.pos_inf() if a > 0 else arb.neg_inf())
    return a / b


def _decided(compare: Any, opposite: Any) -> Any:
    def answer(a: Any, b: Any) -> bool:
        if compare(a, b):
            return True
        # What is not a number is not smaller, nor larger, nor equal, as in IEEE 754.
        if opposite(a, b) or a.is_nan() or b.is_nan():
            return False
        raise Undecided(f"{a} and {b} cannot be told apart with {ctx.prec} bits")

    elementwise = np.frompyfunc(answer, 2, 1)

    def compared(a: np.ndarray, b: np.ndarray) -> Any:
        if a.dtype.kind == "i":
            return compare(a, b)
        return np.asarray(elementwise(a, b)).astype(bool)

    return compared


_number = np.frompyfunc(lambda x: arb(float(x)), 1, 1)
_nearest = np.frompyfunc(lambda x: float(x.mid()) if x.is_finite() else float(x), 1, 1)
_finite = np.frompyfunc(lambda x: x.is_finite(), 1, 1)

for _name, _function in (("add", np.add), ("sub", np.subtract), ("mul", np.multiply)):
    _operator(f"__{_name}__", _function)
    _operator(f"__r{_name}__", _function, swapped=True)
_operator("__truediv__", np.frompyfunc(_quotient, 2, 1))
_operator("__rtruediv__", np.frompyfunc(_quotient, 2, 1), swapped=True)
for _name, _compare, _opposite in (
    ("__lt__", lambda a, b: a < b, lambda a, b: a >= b),
    ("__le__", lambda a, b: a <= b, lambda a, b: a > b),
    ("__gt__", lambda a, b: a > b, lambda a, b: a <= b),
    ("__ge__", lambda a, b: a >= b, lambda a, b: a < b),
    ("__eq__", lambda a, b: a == b, lambda a, b: a != b),
    ("__ne__", lambda a, b: a != b, lambda a, b: a == b),
):
    _operator(_name, _decided(_compare, _opposite))


def _floor(x: Any) -> Any:
    floor = x.floor()
    if x.is_finite() and not floor.is_exact():
        raise Undecided(f"the floor of {x} is not known with {ctx.prec} bits")
    return floor


def _log2(x: Any) -> Any:
    return arb.neg_inf() if x.is_zero() else x.log() / arb.const_log2()


def _exp2(x: Any) -> Any:
    return arb(0) if not x.is_finite() and x < 0 else arb(2) ** x


def _elementwise(function: Any) -> Any:
    vectorized = np.frompyfunc(function, 1, 1)
    return staticmethod(lambda x: Exact(vectorized(x.value)))


class ExactNamespace:
    """The functions of the array API standard that the shader uses."""

    bool, int32 = BOOL, INT
    floor = _elementwise(_floor)
    sqrt = _elementwise(lambda x: x.sqrt())
    exp2 = _elementwise(_exp2)
    log2 = _elementwise(_log2)

    @staticmethod
    def finfo(dtype: Any) -> type[Unlimited]:
        return Unlimited

    @staticmethod
    def asarray(value: Any, dtype: Any) -> Exact:
        kinds = {BOOL: np.bool, INT: np.int32}
        return Exact.of(np.asarray(value, kinds.get(dtype, np.float64)))

    @staticmethod
    def where(condition: Exact, a: Exact, b: Exact) -> Exact:
        return Exact(np.where(condition.value, a.value, b.value))

    @staticmethod
    def minimum(a: Any, b: Any) -> Exact:
        return ExactNamespace.where(b < a, b, a)

    @staticmethod
    def maximum(a: Any, b: Any) -> Exact:
        return ExactNamespace.where(b > a, b, a)

    @staticmethod
    def isfinite(x: Exact) -> Exact:
        return Exact(np.asarray(_finite(x.value)).astype(bool))

    @staticmethod
    def reshape(x: Exact, shape: tuple[int, ...]) -> Exact:
        return Exact(x.value.reshape(shape))

    @staticmethod
    def take(x: Exact, index: Exact, axis: int) -> Exact:
        return Exact(np.take(x.value, index.value, axis=axis))
