"""The array type: intervals of numbers and of indices, and answers that may be undecided.

An `Interval` holds every number that the arithmetic of its error model may have computed at that place, by the model of
each operation. Bounds are float64 and err outward only. Where a bound says nothing, as for a quotient by an interval that
holds 0, the interval is everything from -infinity to infinity, and stands for what is not a number as well. A `Condition`
says for each place whether it may hold and whether it may fail.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from raytrace.intervals.errors import ErrorModel
from raytrace.intervals.rounding import exact_sum, lower, upper, widened

__all__ = ["Condition", "Interval"]


class _Dtype(str):
    __slots__ = ()


FLOAT, INT, BOOL = _Dtype("float-interval"), _Dtype("int32"), _Dtype("bool")


class Interval:
    """Bounds of numbers, or of indices: arrays `low` and `high` of one shape, float64 or int32."""

    __array_ufunc__ = None
    __slots__ = ("high", "low", "xp")

    def __init__(self, low: Any, high: Any, xp: Any):
        self.low, self.high, self.xp = np.asarray(low), np.asarray(high), xp

    @property
    def dtype(self) -> str:
        return INT if self.low.dtype.kind == "i" else FLOAT

    @property
    def shape(self) -> tuple[int, ...]:
        return self.low.shape

    @property
    def ndim(self) -> int:
        return self.low.ndim

    @property
    def model(self) -> ErrorModel:
        return self.xp.model

    def __array_namespace__(self, api_version: str | None = None) -> Any:
        return self.xp

    def __bool__(self) -> bool:
        raise TypeError("an interval has no truth of its own")

    def __getitem__(self, key: Any) -> "Interval":
        return Interval(self.low[key], self.high[key], self.xp)

    def __neg__(self) -> "Interval":
        return Interval(-self.high, -self.low, self.xp)

    def __add__(self, other: Any) -> "Interval":
        other = self._other(other)
        if other is NotImplemented:
            return other
        if self.dtype == INT:
            return Interval(self.low + other.low, self.high + other.high, self.xp)
        low, high = exact_sum(self.low, other.low), exact_sum(self.high, other.high)
        return self._made(lower(*low, self.model), upper(*high, self.model))

    __radd__ = __add__

    def __sub__(self, other: Any) -> "Interval":
        other = self._other(other)
        return other if other is NotImplemented else self + (-other)

    def __rsub__(self, other: Any) -> "Interval":
        other = self._other(other)
        return other if other is NotImplemented else other + (-self)

    def __mul__(self, other: Any) -> "Interval":
        if other is self:
            return self._squared()
        other = self._other(other)
        if other is NotImplemented:
            return other
        scale = other if _is_power_of_two(other) else self if _is_power_of_two(self) else None
        if scale is not None:
            # Exact, but for what is subnormal.
            x = self if scale is other else other
            ends = x.low * scale.low, x.high * scale.low
            low, high = (ends[1], ends[0]) if scale.low < 0 else ends
            return self._made(lower(low, None, self.model), upper(high, None, self.model))
        products = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        low, high = _extremes(products)
        return self._rounded_products(low, high)

    __rmul__ = __mul__

    def _squared(self) -> "Interval":
        a, b = self.low * self.low, self.high * self.high
        low, high = np.where((self.low < 0) & (self.high > 0), 0, np.minimum(a, b)), np.maximum(a, b)
        square = self._rounded_products(low, high)
        return Interval(np.maximum(square.low, 0), square.high, self.xp)

    def _rounded_products(self, low: np.ndarray, high: np.ndarray) -> "Interval":
        if self.model.float32 and not _may_underflow(low, high):
            # The product of two float32 is a float64; ends are float32.
            return self._made(lower(low, None, self.model), upper(high, None, self.model))
        return self._made(*widened(low, high, 1 if self.model.float32 else 0, self.model))

    def __truediv__(self, other: Any) -> "Interval":
        other = self._other(other)
        if other is NotImplemented:
            return other
        if _is_power_of_two(other):
            return self * Interval(1 / other.low, 1 / other.low, self.xp)
        with np.errstate(all="ignore"):
            quotients = [a / b for a in (self.low, self.high) for b in (other.low, other.high)]
        low, high = widened(*_extremes(quotients), self.model.divide, self.model)
        unbounded = (other.low <= 0) & (other.high >= 0)
        return self._made(np.where(unbounded, -np.inf, low), np.where(unbounded, np.inf, high))

    def __rtruediv__(self, other: Any) -> "Interval":
        other = self._other(other)
        return other if other is NotImplemented else other / self

    def __lt__(self, other: Any) -> "Condition":
        return self._compared(other, np.less, lambda a, b: a.low < b.high, lambda a, b: a.high >= b.low)

    def __le__(self, other: Any) -> "Condition":
        return self._compared(other, np.less_equal, lambda a, b: a.low <= b.high, lambda a, b: a.high > b.low)

    def __gt__(self, other: Any) -> "Condition":
        return self._compared(other, np.greater, lambda a, b: a.high > b.low, lambda a, b: a.low <= b.high)

    def __ge__(self, other: Any) -> "Condition":
        return self._compared(other, np.greater_equal, lambda a, b: a.high >= b.low, lambda a, b: a.low < b.high)

    def __eq__(self, other: Any) -> "Condition":
        return self._compared(other, np.equal, _overlap, lambda a, b: ~_same_points(a, b))

    def __ne__(self, other: Any) -> "Condition":
        return ~(self == other)

    __hash__ = None

    def _compared(self, other: Any, _: Any, may_hold: Callable, may_fail: Callable) -> Any:
        other = self._other(other)
        if other is NotImplemented:
            return other
        # What is not a number answers no: an interval that may stand for it may always fail.
        anything = _anything(self) | _anything(other)
        return Condition(may_hold(self, other), may_fail(self, other) | anything, self.xp)

    def _other(self, other: Any) -> Any:
        """`other` as an interval of this kind, if it can be."""
        if isinstance(other, Interval):
            return other
        if isinstance(other, int | float) and not isinstance(other, bool):
            value = np.asarray(other, np.int32 if self.dtype == INT else np.float64)
            return Interval(value, value, self.xp)
        return NotImplemented

    def _made(self, low: np.ndarray, high: np.ndarray) -> "Interval":
        # What is not a number, such as 0 times infinity, may be anything.
        wrong = np.isnan(low) | np.isnan(high)
        if wrong.any():
            low, high = np.where(wrong, -np.inf, low), np.where(wrong, np.inf, high)
        return Interval(low, high, self.xp)


class Condition:
    """For each place whether something `may_hold` and whether it `may_fail`; never neither."""

    __array_ufunc__ = None
    __slots__ = ("decision", "may_fail", "may_hold", "xp")

    def __init__(self, may_hold: Any, may_fail: Any, xp: Any):
        self.may_hold, self.may_fail, self.xp = np.asarray(may_hold), np.asarray(may_fail), xp
        #: How an engine has decided what was undecided; for as long as the condition is used.
        self.decision = None

    @property
    def shape(self) -> tuple[int, ...]:
        return np.broadcast_shapes(self.may_hold.shape, self.may_fail.shape)

    @property
    def dtype(self) -> str:
        return BOOL

    @property
    def ndim(self) -> int:
        return len(self.shape)

    def __array_namespace__(self, api_version: str | None = None) -> Any:
        return self.xp

    def __bool__(self) -> bool:
        raise TypeError("a condition may be undecided")

    def __getitem__(self, key: Any) -> "Condition":
        return Condition(
            np.broadcast_to(self.may_hold, self.shape)[key], np.broadcast_to(self.may_fail, self.shape)[key], self.xp
        )

    def __and__(self, other: "Condition") -> "Condition":
        return Condition(self.may_hold & other.may_hold, self.may_fail | other.may_fail, self.xp)

    def __or__(self, other: "Condition") -> "Condition":
        return Condition(self.may_hold | other.may_hold, self.may_fail & other.may_fail, self.xp)

    def __invert__(self) -> "Condition":
        return Condition(self.may_fail, self.may_hold, self.xp)


def _extremes(numbers: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and the largest, NaN where one is."""
    a, b, c, d = numbers
    return np.minimum(np.minimum(a, b), np.minimum(c, d)), np.maximum(np.maximum(a, b), np.maximum(c, d))


def _is_power_of_two(x: Interval) -> bool:
    """Whether this is one number, +-2**k with a moderate k: products with it are exact."""
    if x.low.size != 1 or x.dtype == INT or x.low.ndim:
        return False
    value = float(x.low)
    return value == float(x.high) and abs(np.frexp(value)[0]) == 0.5 and 2.0**-60 < abs(value) < 2.0**60


def _may_underflow(low: np.ndarray, high: np.ndarray) -> bool:
    """Whether a product of two float32 among these ends may not be a float64; their smallest is 2**-298."""
    return False


def _anything(x: Interval) -> Any:
    return (x.low == -np.inf) & (x.high == np.inf) if x.dtype == FLOAT else False


def _overlap(a: Interval, b: Interval) -> np.ndarray:
    return (a.low <= b.high) & (a.high >= b.low)


def _same_points(a: Interval, b: Interval) -> np.ndarray:
    return (a.low == a.high) & (b.low == b.high) & (a.low == b.low)
