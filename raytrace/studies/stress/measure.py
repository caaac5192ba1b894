"""How wrong an answer is: decisions taken wrongly, and errors in units in the last place."""

from typing import Any, NamedTuple

import numpy as np

from raytrace.arithmetic.exact import Exact

__all__ = ["INPUT", "Measurement", "at_one", "summary", "ulps"]

#: Who errs where the numbers of a problem are rounded before anybody computes with them.
INPUT = "rounding the input"


class Measurement(NamedTuple):
    """One measurement: who, how hard the problem was, and how wrong the answers were.

    axis, x: which figure, and where in it. who: the arithmetic and formula, or "rounding the input" for the error that
    the formula is not charged with. n: how many cases.
    wrong: share of decisions (hit or miss, tile, shadow) that are not the exact ones; ``None`` where none is taken.
    ulp: the largest error in units in the last place of the exact result, of those whose decision is right; ``None``
    where there is none. ulp_median: the median.
    conditioned: the largest error in such units over the problem's condition number, where one is stated.
    """

    axis: str
    x: float
    who: str
    n: int
    wrong: float | None = None
    ulp: float | None = None
    ulp_median: float | None = None
    conditioned: float | None = None


def ulps(found: np.ndarray, exact: Any, dtype: Any) -> np.ndarray:
    """The errors of numbers in units in the last place of `dtype` at the exact number, float64, infinite for NaN.

    Where the exact number is subnormal or 0 the unit is that of the smallest normal number.
    """
    limits = np.finfo(dtype)
    size = np.clip(np.abs(exact.floats()), float(limits.smallest_normal), float(limits.max))
    with np.errstate(all="ignore"):
        unit = np.spacing(np.minimum(size, limits.max / 2).astype(dtype)).astype(np.float64)
        error = np.abs((Exact.of(found) - exact).floats()) / unit
    same_infinity = found == exact.floats()
    return np.where(same_infinity, 0, np.where(np.isfinite(error), error, np.inf))


def at_one(found: Any, exact: Any, dtype: Any) -> np.ndarray:
    """The errors of vectors' components, (3, n), in units in the last place just below 1; infinite for NaN."""
    unit = float(np.spacing(dtype(0.75)))
    errors = np.stack([np.abs((Exact.of(f) - e).floats()) / unit for f, e in zip(found, exact, strict=True)])
    return np.where(np.isfinite(errors), errors, np.inf)


def summary(errors: np.ndarray, condition: np.ndarray | None = None) -> dict[str, float]:
    """The fields of a `Measurement` that errors in units in the last place fill."""
    if not errors.size:
        return {}
    fields = {"ulp": float(errors.max()), "ulp_median": float(np.median(errors))}
    if condition is not None:
        fields["conditioned"] = float((errors / condition).max())
    return fields
