"""The functions of the array API standard that the shader uses, for intervals of one error model."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

from raytrace.arithmetic.intervals import built_ins
from raytrace.arithmetic.intervals.arrays import BOOL, INT, Condition, Interval, bounded
from raytrace.arithmetic.intervals.error_models import LIBM, ULP32, ULP64, ErrorModel
from raytrace.arithmetic.intervals.rounding import outward, widened
from raytrace.language.namespace import Unlimited

__all__ = ["IntervalNamespace"]


class IntervalNamespace:
    """An array namespace (`__array_namespace__`) with an error model.

    decide: gives what holds of a condition that may hold and may fail; without, it stays undecided.
    """

    bool, int32 = BOOL, INT

    def __init__(self, model: ErrorModel, decide: Callable[[Condition], np.ndarray] | None = None):
        self.model, self.decide = model, decide
        #: Of real numbers all forms of a built-in are one.
        self.built_ins = built_ins if model.float32 else None

    def finfo(self, dtype: Any) -> type[Unlimited]:
        """What becomes of small numbers is the error model's."""
        return Unlimited

    def asarray(self, value: Any, dtype: Any) -> Any:
        if dtype == BOOL:
            value = np.asarray(value, np.bool)
            return Condition(value, ~value, self)
        value = np.asarray(value, np.int32 if dtype == INT else np.float64)
        return Interval(value, value, self)

    def given(self, numbers: Any) -> Interval:
        """The numbers that the program is given: as they are, or 0 where it may take them for that."""
        numbers = np.asarray(numbers, np.float64)
        return Interval(*outward(numbers, numbers, self.model), self)

    def rational(self, value: Fraction) -> Interval:
        """A literal: the number itself in real arithmetic; in float32 what a compiler may make of its text."""
        nearest = np.asarray(float(value))
        if Fraction(float(value)) == value and (not self.model.float32 or np.float32(nearest) == nearest):
            return Interval(nearest, nearest, self)
        if not self.model.float32:
            return Interval(*widened(nearest, nearest, 0.0, self.model), self)
        # A decimal's neighbours; a number that has no finite decimal expansion is a quotient of two.
        denominator = value.denominator
        for factor in (2, 5):
            while denominator % factor == 0:
                denominator //= factor
        if denominator == 1:
            low, high = _neighbours(value)
            return Interval(np.asarray(low), np.asarray(high), self)
        return Interval(*widened(nearest, nearest, self.model.quotient_literals, self.model), self)

    def where(self, condition: Condition, a: Any, b: Any) -> Any:
        """`a` or `b`; where that is undecided both, unless one decision is taken after the other."""
        may_hold, may_fail = condition.may_hold, condition.may_fail
        if self.decide is not None:
            may_hold = self.decide(condition)
            may_fail = ~may_hold
        if isinstance(a, Condition):
            return Condition(
                (may_hold & a.may_hold) | (may_fail & b.may_hold),
                (may_hold & a.may_fail) | (may_fail & b.may_fail),
                self,
            )
        if self.decide is not None:
            return Interval(np.where(may_hold, a.low, b.low), np.where(may_hold, a.high, b.high), self)
        low = np.where(may_hold, np.where(may_fail, np.minimum(a.low, b.low), a.low), b.low)
        high = np.where(may_hold, np.where(may_fail, np.maximum(a.high, b.high), a.high), b.high)
        return Interval(low, high, self)

    def minimum(self, a: Interval, b: Interval) -> Interval:
        return Interval(np.minimum(a.low, b.low), np.minimum(a.high, b.high), self)

    def maximum(self, a: Interval, b: Interval) -> Interval:
        return Interval(np.maximum(a.low, b.low), np.maximum(a.high, b.high), self)

    def floor(self, x: Interval) -> Interval:
        return Interval(np.floor(x.low), np.floor(x.high), self)

    def sqrt(self, x: Interval) -> Interval:
        """Of what of it is not negative; the text takes no root of anything else."""
        low, high = np.sqrt(np.maximum(x.low, 0)), np.sqrt(np.maximum(x.high, 0))
        low, high = widened(low, high, self.model.root, self.model)
        return Interval(np.maximum(low, 0), high, self)

    def exp2(self, x: Interval) -> Interval:
        model = self.model
        with np.errstate(all="ignore"):
            low, high = np.exp2(x.low), np.exp2(x.high)
            low = low - low * self._relative(model.exp2 + model.exp2_slope * np.abs(x.low))
            high = high + high * self._relative(model.exp2 + model.exp2_slope * np.abs(x.high)) + 2.0**-1000
        low = np.where(x.low == -np.inf, 0, np.where(np.isnan(low), np.finfo(np.float64).max, low))
        high = np.where(x.high == -np.inf, 0, np.where(np.isnan(high), np.inf, high))
        low, high = widened(low, high, 0.0, model)
        return bounded(np.maximum(low, 0), high, self)

    def log2(self, x: Interval) -> Interval:
        """Of what of it is not negative; -infinity of 0."""
        with np.errstate(all="ignore"):
            low, high = np.log2(np.maximum(x.low, 0)), np.log2(np.maximum(x.high, 0))
            low_error, high_error = (
                np.maximum(np.abs(end) * self._relative(self.model.log2), self.model.log2_absolute)
                for end in (low, high)
            )
            low, high = low - low_error, high + high_error
        low = np.where(np.isnan(low), -np.inf, low)
        high = np.where(np.isnan(high), np.where(x.high <= 0, -np.inf, np.inf), high)
        return bounded(*widened(low, high, 0.0, self.model), self)

    def isfinite(self, x: Interval) -> Condition:
        finite = np.isfinite(x.low) & np.isfinite(x.high)
        never = x.low > np.finfo(np.float64).max
        return Condition(~never, ~finite, self)

    def reshape(self, x: Interval, shape: tuple[int, ...]) -> Interval:
        return Interval(x.low.reshape(shape), x.high.reshape(shape), self)

    def take(self, x: Interval, index: Interval, axis: int) -> Interval:
        """The item of each index; of several possible ones the hull."""
        low, high = (np.take(end, index.low, axis=axis) for end in (x.low, x.high))
        for i in range(x.shape[0]):
            among = (index.low < i) & (i <= index.high)
            if among.any():
                low = np.where(among, np.minimum(low, x.low[i]), low)
                high = np.where(among, np.maximum(high, x.high[i]), high)
        return Interval(low, high, self)

    def _relative(self, units: Any) -> Any:
        return units * ULP32 * (1 + 2.0**-20) + (LIBM + 2) * ULP64


def _neighbours(value: Fraction) -> tuple[float, float]:
    """The float32 on either side of a number that is none."""
    nearest = np.float32(float(value))
    if Fraction(float(nearest)) > value:
        return float(np.nextafter(nearest, np.float32(-np.inf))), float(nearest)
    return float(nearest), float(np.nextafter(nearest, np.float32(np.inf)))
