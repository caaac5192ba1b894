"""Outward: from a result that float64 has rounded to a bound that holds.

Each function takes lower or upper ends as arrays of float64 and gives new ones.
"""

import numpy as np

from raytrace.intervals.errors import TINY32, TINY64, ULP64, ErrorModel

__all__ = ["exact_sum", "lower", "upper", "widened"]

#: The digits of a float64 that a float32 does not have.
_EXTRA = np.int64((1 << 29) - 1)
_LARGEST32 = float(np.finfo(np.float32).max)


def exact_sum(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rounded sum, and what it lacks to the exact one (D. E. Knuth's TwoSum); NaN where it overflows."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def lower(ends: np.ndarray, missing: np.ndarray | None, model: ErrorModel) -> np.ndarray:
    """A lower bound of what the arithmetic makes of numbers from `ends` on.

    missing: the exact ends less these, or ``None`` where nothing is missing: then what the arithmetic holds stays exact.
    """
    if missing is not None:
        ends = np.where(missing < 0, ends - (np.abs(ends) * ULP64 + TINY64), ends)
    return _down32(ends) if model.float32 else ends


def upper(ends: np.ndarray, missing: np.ndarray | None, model: ErrorModel) -> np.ndarray:
    """An upper bound; see `lower`."""
    if missing is not None:
        ends = np.where(missing > 0, ends + (np.abs(ends) * ULP64 + TINY64), ends)
    return _up32(ends) if model.float32 else ends


def widened(low: np.ndarray, high: np.ndarray, ulps: float, model: ErrorModel) -> tuple[np.ndarray, np.ndarray]:
    """Ends that float64 has rounded by up to a unit and that the arithmetic may miss by `ulps` units of float32."""
    relative = 2 * ULP64 + ulps * 2.0**-23 * (1 + 2.0**-20)
    low = low - (np.abs(low) * relative + TINY64)
    high = high + (np.abs(high) * relative + TINY64)
    return (_down32(low), _up32(high)) if model.float32 else (low, high)


def _down32(x: np.ndarray) -> np.ndarray:
    """The largest float32 up to `x`; a number that may be flushed is 0, too."""
    bits = x.view(np.int64)
    negative = (bits >> 63) & _EXTRA
    rounded = np.where(np.isfinite(x), (bits + negative) & ~_EXTRA, bits).view(np.float64)
    # A subnormal number may be flushed to 0, and what float32 does not hold is infinite.
    rounded = np.where((rounded > 0) & (rounded < TINY32), 0, rounded)
    return np.where(rounded < -_LARGEST32, -np.inf, rounded)


def _up32(x: np.ndarray) -> np.ndarray:
    return -_down32(-x)
