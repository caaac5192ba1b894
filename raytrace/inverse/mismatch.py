"""Whether a model explains a picture: what is left over is held against the noise in the picture."""

import math
from dataclasses import dataclass

import numpy as np

from raytrace.inverse.blocks import SIDE
from raytrace.inverse.likelihood import LEAST_NOISE, OUTLIER

__all__ = ["Mismatch"]

#: A pixel is far off where it differs by more than so many standard deviations of the noise, beside the rounding.
FAR = 5.0
#: The largest share of such pixels in a picture that is explained: correct engines reach 0.3 % where a level camera
#: puts pixels' centres on edges of the pattern.
FAR_SHARE = 0.01
#: The largest share of blocks most of whose pixels are far off, where the model is right but, maybe, at edges.
WHOLE_SHARE = 0.02
#: The largest mean square of blocks' means over what noise gives, which is 1; and so many standard errors beside.
UNEVEN, ERRORS = 1.35, 5.0
#: A model that explains less than this share of a picture's variance explains nothing, unless what is left over is as
#: small as the noise of a photograph: then the picture has little to explain.
EXPLAINED, SMALL = 0.3, 0.05


@dataclass(frozen=True)
class Mismatch:
    """What of a picture its model leaves over.

    noise: the standard deviation of neighbours' differences, in display values: the picture's own noise. far: the share
    of pixels that are far off. whole: the share of blocks in which most pixels are, so that it is no edge. uneven: the
    mean square of the means over blocks, relative to that of noise. limit: the largest such that noise gives.
    explained: the share of the picture's variance.
    """

    noise: float
    far: float
    whole: float
    uneven: float
    limit: float
    explained: float

    @classmethod
    def of(cls, target: np.ndarray, values: np.ndarray, inside: np.ndarray, half: float) -> "Mismatch":
        """Return what is left over of `target`, arrays (blocks, SIDE * SIDE, 3) where `inside` is True.

        half: half of the step between two values that the picture can store.
        """
        difference = target - values
        noise = _noise(difference, values, inside)
        sigma = math.sqrt(noise**2 + LEAST_NOISE**2)
        difference = target - _clipped_mean(values, sigma)
        away = np.abs(difference).max(-1)
        is_far = inside & (away > FAR * sigma + half)
        trusted = (inside & ~is_far)[..., None]
        count = np.maximum(trusted.sum(1), 1)
        means = np.where(trusted, difference, 0).sum(1) / count
        # Equal values are rounded equally, unless the noise is larger than the step.
        step = 2 * half
        rounding = step / math.sqrt(12) * math.exp(-2 * (math.pi * sigma / step) ** 2) if half else 0.0
        expected = sigma**2 / count + rounding**2 + LEAST_NOISE**2
        left_out = is_far.sum(1) > inside.sum(1) / 2
        squares = (means**2 / expected)[(trusted.sum(1)[:, 0] >= SIDE * SIDE // 4) & ~left_out]
        known = target[inside]
        variance = float(np.var(known, axis=0).sum())
        left = float(np.mean(difference[inside] ** 2, axis=0).sum())
        return cls(
            noise=noise,
            far=float(is_far[inside].mean()),
            whole=float(left_out.mean()),
            uneven=float(squares.mean()) if squares.size else 1.0,
            limit=UNEVEN + ERRORS * math.sqrt(2 / max(squares.size, 1)),
            explained=1 - left / variance if left > difference.shape[-1] * SMALL**2 else 1.0,
        )

    @property
    def smooth(self) -> bool:
        """Whether the model is right but, maybe, at edges: there it matters how the picture was sampled."""
        return self.uneven <= self.limit and self.explained >= EXPLAINED and self.whole <= WHOLE_SHARE

    @property
    def fits(self) -> bool:
        """Whether the model explains the picture."""
        return self.smooth and self.far <= FAR_SHARE

    @property
    def hopeless(self) -> bool:
        """Whether no sun close by explains the picture either: such suns differ in some pixels at edges of shadows."""
        return not self.smooth or self.far > 3 * FAR_SHARE

    def __str__(self) -> str:
        if self.explained < EXPLAINED:
            return f"it explains {max(0.0, 100 * self.explained):.0f} % of the picture's variance"
        parts = []
        if self.far > FAR_SHARE:
            parts.append(f"{100 * self.far:.1f} % of the pixels are off by more than {FAR:.0f} times the noise")
        if self.uneven > self.limit:
            parts.append(
                f"means over {SIDE}x{SIDE} pixels are off by {math.sqrt(self.uneven):.1f} times what noise gives"
            )
        return " and ".join(parts) or "it explains the picture"


def _noise(difference: np.ndarray, values: np.ndarray, inside: np.ndarray) -> float:
    """The noise in second differences along rows, of which most see no edge; clipped values have less of it."""

    def seconds(array: np.ndarray) -> tuple[np.ndarray, ...]:
        rows = array.reshape(-1, SIDE, SIDE, array.shape[-1])
        return rows[:, :, :-2], rows[:, :, 1:-1], rows[:, :, 2:]

    first, middle, last = seconds(difference)
    there = np.all(seconds(inside[..., None]), 0)
    second = np.abs(first - 2 * middle + last) / math.sqrt(6)
    least, most = np.min(seconds(values), 0), np.max(seconds(values), 0)
    if not there.any():
        return 0.0
    known = np.broadcast_to(there, second.shape)
    sigma = 1.4826 * float(np.median(second[known]))
    for _ in range(3):
        chosen = known & (least > 3 * sigma) & (most < 1 - 3 * sigma) & (second <= OUTLIER * sigma)
        if chosen.sum() > 0.05 * known.sum():
            sigma = float(np.sqrt(np.mean(second[chosen] ** 2)))
    return sigma


def _clipped_mean(values: np.ndarray, sigma: float) -> np.ndarray:
    """The mean of values with normal noise that are clipped to [0, 1]."""
    from scipy.special import ndtr

    def beyond(x: np.ndarray) -> np.ndarray:
        """The mean of max(x + noise, 0)."""
        return x * ndtr(x / sigma) + sigma * np.exp(-((x / sigma) ** 2) / 2) / math.sqrt(2 * math.pi)

    return beyond(values) - beyond(values - 1)
