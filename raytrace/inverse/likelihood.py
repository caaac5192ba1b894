"""How probable a picture's values are if a model is right: noise, rounding, clipping, and a few pixels that are wrong.

A value is the model's, plus normal noise, clipped to [0, 1] and rounded to what the file can store. So its probability
is that of the noise between two limits, and the same rounding of many equal pixels is no independent evidence. A pixel
may also be wrong altogether, where an edge runs through a sample and another engine's last bit decides.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

__all__ = ["LEAST_NOISE", "WRONG", "Noise", "log_likelihood", "noise_of"]

#: The least noise, in display values, where a picture holds floats: what correct engines differ by at the most (Mesa's
#: llvmpipe, 2.6e-4). Where values are rounded, that is more than most engines' errors and less than any rounding.
LEAST_NOISE, LEAST_ROUNDED = 3e-4, 2e-5
#: How often a pixel is wrong altogether.
WRONG = 1e-3
#: Where a file stores floats, a value stands for this share of the noise to either side.
SHARE = 1 / 8
#: Noise of less than this times half a step is lost in the rounding: its likelihood is asked.
LOST = 1.5
#: What is off by more than so many standard deviations has not that noise; it is 1 of 16,000 of what has.
OUTLIER = 4.0
#: Pixels of a chunk.
CHUNK = 1 << 12


class Noise(NamedTuple):
    """sigma: the standard deviation before rounding. half: half of the step between stored values; 0 for floats."""

    sigma: float
    half: float

    def numbers(self) -> tuple[np.float32, np.float32]:
        """Return sigma, and what a value stands for on either side, for `log_likelihood`."""
        half = self.half if self.half >= LEAST_NOISE else SHARE * self.sigma
        return np.float32(self.sigma), np.float32(half)


def log_likelihood(target: Any, values: Any, inside: Any, sigma: Any, half: Any) -> Any:
    """Return the logarithm of the probability of `target`, JAX arrays (pixels, 3), where `values` are right.

    values: a triple of arrays (pixels,). inside: which pixels count, (pixels,).
    """
    import jax.numpy as jnp
    from jax import lax
    from jax.scipy.special import erfc

    values = jnp.stack(values)
    target = target.T
    away = jnp.abs(target - values)
    scale = 1 / (sigma * math.sqrt(2))
    dark, bright = target <= 0, target >= 1

    def fine() -> Any:
        """Noise that is larger than the rounding, which then adds its variance."""
        variance = sigma**2 + half**2 / 3
        chance = 2 * half * jnp.exp(-(away**2) / (2 * variance)) / jnp.sqrt(2 * math.pi * variance)

        def clipped() -> Any:
            """What was clipped is beyond one limit."""
            beyond = erfc((jnp.where(dark, values, 1 - values) - half) * scale) / 2
            return jnp.where(dark | bright, beyond, chance)

        return lax.cond(jnp.any(dark | bright), clipped, lambda: chance)

    def rough() -> Any:
        """The chance of the noise between two limits, one of which is missing where the value was clipped."""
        least = jnp.where(dark, values, jnp.where(bright, 1 - values, away)) - half
        beyond = jnp.where(dark | bright, 0, erfc((away + half) * scale))
        return (erfc(least * scale) - beyond) / 2

    chance = lax.cond(sigma > LOST * half, fine, rough)
    right = jnp.prod(jnp.maximum(chance, 1e-12), 0) * (1 - WRONG)
    return jnp.sum(jnp.where(inside, jnp.log(right + WRONG * (2 * half) ** 3), 0))


def noise_of(target: np.ndarray, values: np.ndarray, half: float) -> Noise:
    """Return the noise that most of a target's pixels (n, 3) have beside a model's values, whatever the others have.

    half: half of the step between two values that the picture can store; 0 for floats.
    """
    away = np.abs(target - values)
    sigma = 1.4826 * float(np.median(away))
    # The median of rounded values is rounded. The mean square is not, of all but outliers and what may be clipped.
    for _ in range(3):
        inner = (values > 3 * sigma) & (values < 1 - 3 * sigma) & (away <= OUTLIER * sigma)
        if inner.mean() > 0.05:
            sigma = float(np.sqrt(np.mean(away[inner] ** 2)))
    if half < LEAST_NOISE:
        return Noise(max(sigma, LEAST_NOISE), half)
    if sigma > LOST * half:
        return Noise(math.sqrt(sigma**2 - half**2 / 3), half)
    # Equal pixels are rounded equally, so the differences do not tell how large the noise was; their probability does.
    sigmas = np.geomspace(LEAST_ROUNDED, LOST * half, 12).astype(np.float32)
    logs = np.zeros(len(sigmas))
    for first in range(0, len(target), CHUNK):
        some = np.arange(first, first + CHUNK)
        parts = (part[some % len(target)].astype(np.float32) for part in (target, values))
        logs += np.asarray(_by_noise()(*parts, some < len(target), sigmas, np.float32(half)), np.float64)
    return Noise(float(sigmas[np.argmax(logs)]), half)


@lru_cache
def _by_noise() -> Callable:
    import jax

    def by_noise(target: Any, values: Any, inside: Any, sigmas: Any, half: Any) -> Any:
        triple = values[:, 0], values[:, 1], values[:, 2]
        return jax.lax.map(lambda sigma: log_likelihood(target, triple, inside, sigma, half), sigmas)

    return jax.jit(by_noise)
