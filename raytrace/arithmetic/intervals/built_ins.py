"""GLSL's built-ins on intervals of float32: bounds of every form that an implementation may give them.

`raytrace.arithmetic.intervals.error_models.BUILT_INS` is the table of these forms. A fused multiply-add needs no form
of its own: the interval of a product holds the exact product as well as both of its roundings, so a sum with it holds
all three sums.
"""

from collections.abc import Iterable
from functools import reduce
from itertools import combinations
from typing import Any

import numpy as np

from raytrace.arithmetic.intervals.arrays import Interval, is_power_of_two
from raytrace.arithmetic.intervals.rounding import outward

__all__ = ["dot", "either", "mix", "mod", "power"]

#: What float64 rounds in the few operations of a sum of products, relative to the largest number in it.
_ROUNDED64 = 2.0**-49


def either(*forms: Interval) -> Interval:
    """Return the hull of what several forms of a built-in give."""
    low, high = (reduce(extreme, (getattr(form, end) for form in forms)) for extreme, end in _ENDS)
    return Interval(low, high, forms[0].xp)


_ENDS = ((np.minimum, "low"), (np.maximum, "high"))


def dot(x: Iterable[Any], y: Iterable[Any]) -> Interval:
    """Bound the sum of the products of two vectors' components, added in any order and grouping."""
    terms = [a * b for a, b in zip(x, y, strict=True)]
    # A term that is 0 for all pixels, as of a matrix, leaves every sum as it is.
    terms = [term for term in terms if term.ndim or term.low != 0 or term.high != 0] or terms[:1]
    numbers = range(len(terms))
    sums: dict[tuple[int, ...], Any] = {(i,): term for i, term in enumerate(terms)}
    # Any grouping adds, last, the sums of some of the terms and of the others.
    for size in numbers[1:]:
        for some in combinations(numbers, size + 1):
            first, *rest = some
            groups = [(first, *more) for k in range(size) for more in combinations(rest, k)]
            sums[some] = either(*(sums[group] + sums[tuple(i for i in some if i not in group)] for group in groups))
    return sums[tuple(numbers)]


def mix(x: Interval, y: Interval, a: Interval) -> Interval:
    """Bound the blend from `x` to `y` in each of its three forms.

    Interval arithmetic of a form forgets that `a` occurs in it twice. So the hull of the forms is met with the hull of
    the exact blend, which is linear in x, in y and in a and so has its extremes at their ends, widened by the most that
    any form's roundings amount to. The first is exact where the forms are, the second is narrow where `a` is wide.
    """
    change = 1 - a
    forms = either(x * change + y * a, x + (y - x) * a, (x - x * a) + y * a)
    with np.errstate(all="ignore"):
        ends = [
            start + (end - start) * share
            for start in (x.low, x.high)
            for end in (y.low, y.high)
            for share in (a.low, a.high)
        ]
        start, end, share, rest = (np.maximum(np.abs(z.low), np.abs(z.high)) for z in (x, y, a, change))
        difference = np.maximum(np.abs(y.high - x.low), np.abs(y.low - x.high))
        # The sizes of what each form rounds before its last sum; 1 - a and y - x are rounded, and their products again.
        rounded = np.maximum(
            np.maximum(2 * start * rest + end * share, 2 * difference * share),
            start * share + start * rest + end * share,
        )
        model = forms.model
        error = rounded * (2.0**-23 + 2.0**-43) + (start + end + 4) * model.smallest
        error = error + (start + difference * share) * _ROUNDED64
        low, high = outward(reduce(np.minimum, ends) - error, reduce(np.maximum, ends) + error, model)
    # NaN, as of infinite ends, bounds nothing.
    return Interval(np.fmax(forms.low, low), np.fmin(forms.high, high), forms.xp)


def mod(x: Interval, y: Any) -> Interval:
    """Bound the remainder in both of its forms."""
    xp = x.xp
    y = y if isinstance(y, Interval) else xp.asarray(y, dtype=x.dtype)
    quotient = x / y
    whole = xp.floor(quotient)
    found = either(x - y * whole, y * (quotient - whole))
    if is_power_of_two(y) and y.low > 0:
        # The quotient is exact, so the exact remainder is at least 0 and less than y, and so are its neighbours.
        return Interval(np.clip(found.low, 0, y.low), np.clip(found.high, 0, y.low), xp)
    return found


def power(x: Interval, y: Any) -> Interval:
    """Bound ``exp2(y * log2(x))`` for y > 0, where x is not negative; the shader never raises a negative number.

    GLSL leaves the logarithm of 0 open. SwiftShader takes 0 for 2**-127, so numbers below the smallest normal one are
    taken for any of these.
    """
    xp, smallest = x.xp, np.asarray(x.model.smallest)
    found = xp.exp2(y * xp.log2(xp.maximum(x, Interval(smallest, smallest, xp))))
    return Interval(np.where(x.low < smallest, 0, found.low), found.high, xp)
