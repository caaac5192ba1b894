"""The array type: intervals of numbers and of indices, and answers that may be undecided.

An `Interval` holds every number that the arithmetic of its error model may have computed at that place, by the model of
each operation. Bounds are float64 and err outward only. Where a bound says nothing, as for a quotient by an interval
that holds 0, the interval is everything from -infinity to infinity, and stands for what is not a number as well. A
`Condition` says for each place whether it may hold and whether it may fail.
"""

from collections.abc import Callable
from math import frexp
from typing import Any

import numpy as np

from raytrace.arithmetic.intervals.error_models import ErrorModel
from raytrace.arithmetic.intervals.rounding import exact_product, exact_sum, outward, outward_sum, widened

__all__ = ["BOOL", "INT", "Condition", "Interval", "bounded", "is_power_of_two"]


FLOAT, INT, BOOL = "float-interval", "int32", "bool"


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
        return bounded(*outward_sum(low, high, self.model), self.xp)

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
        scale = other if is_power_of_two(other) else self if is_power_of_two(self) else None
        if scale is not None:
            x = self if scale is other else other
            ends = x.low * scale.low, x.high * scale.low
            low, high = (ends[1], ends[0]) if scale.low < 0 else ends
            return bounded(*outward(low, high, self.model), self.xp)
        with np.errstate(all="ignore"):
            products = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        low, high = _extremes(products)
        return self._rounded_products(low, high)

    __rmul__ = __mul__

    def _squared(self) -> "Interval":
        a, b = self.low * self.low, self.high * self.high
        low, high = np.where((self.low < 0) & (self.high > 0), 0, np.minimum(a, b)), np.maximum(a, b)
        square = self._rounded_products(low, high)
        return Interval(np.maximum(square.low, 0), square.high, self.xp)

    def _rounded_products(self, low: Any, high: Any) -> "Interval":
        if self.model.float32:
            # Ends are float32, and the product of two of these is a float64.
            return bounded(*outward(low, high, self.model), self.xp)
        return bounded(*widened(low, high, 0.0, self.model), self.xp)

    def __truediv__(self, other: Any) -> "Interval":
        other = self._other(other)
        if other is NotImplemented:
            return other
        if is_power_of_two(other):
            return self * Interval(1 / other.low, 1 / other.low, self.xp)
        if other.ndim == 0 and not self.model.float32:
            return self._by_one_number(other)
        with np.errstate(all="ignore"):
            quotients = [a / b for a in (self.low, self.high) for b in (other.low, other.high)]
        low, high = widened(*_extremes(quotients), self.model.divide, self.model)
        if self.model.float32:
            huge = np.maximum(-other.low, other.high) > self.model.largest_divisor
            if huge.any():
                low, high = np.where(huge, np.minimum(low, 0), low), np.where(huge, np.maximum(high, 0), high)
        unbounded = (other.low <= 0) & (other.high >= 0)
        low, high = np.where(unbounded, -np.inf, low), np.where(unbounded, np.inf, high)
        return bounded(*self._by_zero(other, low, high), self.xp)

    def _by_one_number(self, other: "Interval") -> "Interval":
        """Quotients by the same number for all: those that are exact stay exact, as a pixel's coordinates do."""
        with np.errstate(all="ignore"):
            ends = [a / b for a, b in ((self.low, other.low), (self.high, other.high))]
        point = (self.low == self.high) & (other.low == other.high)
        exact = point & (np.abs(other.low) > 0) & exact_product(ends[0], other.low, self.low)
        quotient = self / Interval(np.broadcast_to(other.low, (1,)), np.broadcast_to(other.high, (1,)), self.xp)
        low, high = (end.reshape(self.shape) for end in (quotient.low, quotient.high))
        return Interval(np.where(exact, ends[0], low), np.where(exact, ends[0], high), self.xp)

    def _by_zero(self, other: "Interval", low: Any, high: Any) -> tuple[Any, Any]:
        """A quotient by 0 itself is infinite, with a sign that is not known: where that is decided both are tried."""
        if self.xp.decide is None:
            return low, high
        zero = (other.low == 0) & (other.high == 0) & ((self.low > 0) | (self.high < 0))
        # It is asked at every quotient, as it counts the questions that it is asked.
        positive = self.xp.decide(Condition(np.True_, zero, self.xp))
        if not zero.any():
            return low, high
        infinite = np.where(positive, np.inf, -np.inf)
        infinite = np.where(self.low > 0, infinite, -infinite)
        return np.where(zero, infinite, low), np.where(zero, infinite, high)

    def __rtruediv__(self, other: Any) -> "Interval":
        other = self._other(other)
        return other if other is NotImplemented else other / self

    def __lt__(self, other: Any) -> "Condition":
        return self._compared(other, lambda a, b: a.low < b.high, lambda a, b: a.high >= b.low)

    def __le__(self, other: Any) -> "Condition":
        return self._compared(other, lambda a, b: a.low <= b.high, lambda a, b: a.high > b.low)

    def __gt__(self, other: Any) -> "Condition":
        return self._compared(other, lambda a, b: a.high > b.low, lambda a, b: a.low <= b.high)

    def __ge__(self, other: Any) -> "Condition":
        return self._compared(other, lambda a, b: a.high >= b.low, lambda a, b: a.low < b.high)

    def __eq__(self, other: Any) -> "Condition":
        return self._compared(other, _overlap, lambda a, b: ~_same_points(a, b))

    def __ne__(self, other: Any) -> "Condition":
        return ~(self == other)

    __hash__ = None  # pyright: ignore[reportAssignmentType]

    def _compared(self, other: Any, may_hold: Callable, may_fail: Callable) -> Any:
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


def bounded(low: Any, high: Any, xp: Any) -> Interval:
    """The interval; where an end is not a number, as 0 times infinity is none, everything."""
    wrong = np.isnan(low) | np.isnan(high)
    if wrong.any():
        low, high = np.where(wrong, -np.inf, low), np.where(wrong, np.inf, high)
    return Interval(low, high, xp)


class Condition:
    """For each place whether something `may_hold` and whether it `may_fail`; never neither."""

    __array_ufunc__ = None
    __slots__ = ("decision", "may_fail", "may_hold", "xp")

    def __init__(self, may_hold: Any, may_fail: Any, xp: Any):
        self.may_hold, self.may_fail, self.xp = np.asarray(may_hold), np.asarray(may_fail), xp
        #: How an engine has decided what was undecided; for as long as the condition is used.
        self.decision: np.ndarray | None = None

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


def _extremes(numbers: list) -> tuple[Any, Any]:
    """The smallest and the largest, NaN where one is."""
    a, b, c, d = numbers
    return np.minimum(np.minimum(a, b), np.minimum(c, d)), np.maximum(np.maximum(a, b), np.maximum(c, d))


def is_power_of_two(x: Interval) -> bool:
    """Whether this is one number, +-2**k with a moderate k: products with it are exact."""
    if x.low.size != 1 or x.dtype == INT or x.low.ndim:
        return False
    value = float(x.low)
    return value == float(x.high) and abs(frexp(value)[0]) == 0.5 and 2.0**-60 < abs(value) < 2.0**60


def _anything(x: Interval) -> Any:
    return (x.low == -np.inf) & (x.high == np.inf) if x.dtype == FLOAT else False


def _overlap(a: Interval, b: Interval) -> Any:
    return (a.low <= b.high) & (a.high >= b.low)


def _same_points(a: Interval, b: Interval) -> Any:
    return (a.low == a.high) & (b.low == b.high) & (a.low == b.low)
