"""Outward: from results that float64 has rounded to ends that hold.

Every end is 0 or of at least the model's smallest size, so that no product or quotient of two ends underflows in
float64, and a result is 0 only where it is exactly that. In a float32 model every end is a float32, so that products
are exact.
"""

import numpy as np

from raytrace.arithmetic.intervals.error_models import ULP32, ULP64, ErrorModel
from raytrace.language.types import Array

__all__ = ["exact_product", "exact_sum", "outward", "outward_sum", "widened"]

#: The digits of a float64 that a float32 does not have.
_EXTRA = np.int64((1 << 29) - 1)
_LARGEST32, _LARGEST64 = float(np.finfo(np.float32).max), float(np.finfo(np.float64).max)

Ends = tuple[Array, Array]


def exact_sum(a: Array, b: Array) -> Ends:
    """The rounded sum, and what it lacks to the exact one (D. E. Knuth's TwoSum); NaN where it overflows."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def exact_product(a: Array, b: Array, product: Array) -> Array:
    """Whether a * b is `product`, exactly (T. J. Dekker's product, G. W. Veltkamp's splitting); no for huge ones."""

    def split(x: Array) -> Ends:
        shifted = 134217729.0 * x
        high = shifted - (shifted - x)
        return high, x - high

    with np.errstate(all="ignore"):
        total = a * b
        (a_high, a_low), (b_high, b_low) = split(a), split(b)
        lacks = ((a_high * b_high - total) + a_high * b_low + a_low * b_high) + a_low * b_low
        return (total == product) & (lacks == 0)


def outward_sum(low: Ends, high: Ends, model: ErrorModel) -> Ends:
    """Ends of a sum from what `exact_sum` gives for the lower and for the upper ones. Exact sums stay exact."""
    (least, least_lacks), (most, most_lacks) = low, high
    least = np.where(least_lacks < 0, least - np.abs(least) * ULP64, least)
    most = np.where(most_lacks > 0, most + np.abs(most) * ULP64, most)
    return outward(least, most, model)


def widened(low: Array, high: Array, ulps: float, model: ErrorModel) -> Ends:
    """Ends that float64 has rounded by up to a unit and that the arithmetic may miss by `ulps` units of float32."""
    relative = 2 * ULP64 + ulps * ULP32 * (1 + 2.0**-20)
    # An infinite end on the wrong side may be a finite number that float64 does not hold.
    low, high = np.minimum(low, _LARGEST64), np.maximum(high, -_LARGEST64)
    return outward(low - np.abs(low) * relative, high + np.abs(high) * relative, model)


def outward(low: Array, high: Array, model: ErrorModel) -> Ends:
    """Ends that the model's arithmetic holds: in float32 the neighbours below and above of what is none."""
    if model.float32:
        low, high = _down32(low), -_down32(-high)
    return _down_to_size(low, model.smallest), -_down_to_size(-high, model.smallest)


def _down32(x: Array) -> Array:
    """The largest float32 up to `x`."""
    bits = np.array(x).view(np.int64)
    # Towards 0 a number loses its last digits; a negative one is first made larger by all but one of their last.
    # Infinities, and what is not a number, stay.
    bits += (bits >> 63) & _EXTRA
    bits &= ~_EXTRA
    rounded = bits.view(np.float64)
    beyond = np.abs(rounded) > _LARGEST32
    if beyond.any():
        rounded = np.where(rounded < -_LARGEST32, -np.inf, rounded)
        rounded = np.where((rounded > _LARGEST32) & (rounded < np.inf), _LARGEST32, rounded)
    return rounded


def _down_to_size(x: Array, smallest: float) -> Array:
    """At most `x`, and not smaller than that but 0: such numbers may be flushed to 0, too."""
    small = np.abs(x) < smallest
    return np.where(small, np.where(x < 0, -smallest, 0), x) if small.any() else x
