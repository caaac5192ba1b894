"""Mistakes in how an image's values were stored: cut off instead of rounded, or counted to another white."""

import numpy as np

from raytrace.comparison.diagnosis import Diagnosis
from raytrace.comparison.metrics import pixels_over, rmse
from raytrace.image.depth import Depth

__all__ = ["WHITES", "storage_mistake"]

#: What stands for white in files of other habits than 0 to 1.
WHITES = (255, 65535, 1023, 100)
#: Values that must lie between black and white, for a statement about them.
_LEAST = 300
#: Of those values: how many may disagree, as where engines decide an edge otherwise; and how many are cut by a whole
#: step, which is half of them on average, among the dark ones and among the bright ones.
_OTHERS = 0.01
_CUT = (0.3, 0.7)


def storage_mistake(a: np.ndarray, b: np.ndarray, depth: Depth | None) -> Diagnosis | None:
    """Return the mistake in how `b` was stored, if there is one; display values both, (height, width, 3).

    depth: what they were rounded to, ``None`` for floats.
    """
    return _other_white(a, b) or (None if depth is None or depth.floating else _cut_off(a, b, depth))


def _other_white(a: np.ndarray, b: np.ndarray) -> Diagnosis | None:
    """Values from 0 to 255, say: a 255th of them is the image."""
    for white in WHITES:
        if 0.5 * white < b.max() <= white * 1.01 and a.max() <= 2 and a.max() > 0.5:
            before, after = rmse(a, b), rmse(a, b / white)
            over = int(pixels_over(a, b).sum()), int(pixels_over(a, b / white).sum())
            if after < 0.1 * before and over[1] < 0.5 * over[0]:
                explained = 1 - (after / before) ** 2
                name = f"stored with {white} for white, where 1 is meant"
                return Diagnosis(name, explained, (before, after), over)
    return None


def _cut_off(a: np.ndarray, b: np.ndarray, depth: Depth) -> Diagnosis | None:
    """Each value is the next step below, where it should be the nearest one."""
    between = (a > 0) & (a < 1)
    if np.count_nonzero(between) < _LEAST:
        return None
    steps, values = np.rint((a - b)[between] / depth.unit), a[between]
    cut = steps == 1
    bright = values > np.median(values)
    shares = [part.mean() for part in (cut[bright], cut[~bright]) if part.size >= _LEAST / 3]
    if np.mean(~np.isin(steps, (0, 1))) > _OTHERS or not all(_CUT[0] <= share <= _CUT[1] for share in shares):
        return None
    after = np.where(steps == 1, 0, steps) * depth.unit
    before, left = rmse(a, b), float(np.sqrt(np.sum(np.square(after)) / a.size))
    over = int(pixels_over(a, b).sum())
    return Diagnosis(
        f"cut off to {depth}, where each value is to be rounded to the nearest: {depth.rounding}",
        1 - (left / before) ** 2,
        (before, left),
        (over, over),
    )
