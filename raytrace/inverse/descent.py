"""Pictures whose pixels are means over their squares: least squares, and the linear function that they end in.

Such a picture has slopes everywhere, those of its edges too. So the least squares are SciPy's, with the Jacobian by
JAX's forward mode, and near the end the picture is linear in the sun as far as its noise can tell.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from raytrace.inverse.blocks import Blocks
from raytrace.inverse.likelihood import WRONG, Noise, log_likelihood, noise_of
from raytrace.inverse.posterior import Chart, Posterior, Stage

__all__ = ["Linear", "descended", "widened"]

#: Pictures from which the slopes are computed, at the most, with one estimate of the noise.
MOST = 10
#: How often the noise is estimated anew.
ROUNDS = 4
#: The descent has ended where a step changes the sun by less than this, in radians.
STEP = 1e-7
#: Cauchy's distribution has 95 % of the efficiency of least squares for normal noise at this scale.
CAUCHY = 2.385
#: A pull towards the start that keeps a direction in its place along which the picture does not change.
WEAK = 1e-6
#: The spread around its end that is looked at, in radians (or stops).
LEAST_SPREAD, MOST_SPREAD = 2e-5, 0.01
#: Pixels of a chunk.
CHUNK = 1 << 12

#: The values (blocks, SIDE * SIDE, 3) under a sun and an exposure, and their slopes along two axes and by stops.
Drawn = Callable[[np.ndarray, float, np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Linear:
    """A picture near one sun: `values` + `changes` @ `slopes`, at the pixels of `blocks`.

    chart: the coordinates of the changes, around that sun. values, target: (blocks, SIDE * SIDE, 3). slopes:
    (dimensions, blocks, SIDE * SIDE, 3). noise: of most pixels. course: the mean squared difference and the sun after
    each step.
    """

    chart: Chart
    blocks: Blocks
    target: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    noise: Noise
    course: list[tuple[float, np.ndarray]]

    def log_likelihoods(self, changes: np.ndarray) -> np.ndarray:
        """Return the logarithm of the target's probability for changes (n, dimensions) of the sun."""
        pixels = self.target.reshape(-1, 3), self.values.reshape(-1, 3), self.slopes.reshape(len(self.slopes), -1, 3)
        total, count = np.zeros(len(changes)), len(pixels[0])
        for first in range(0, count, CHUNK):
            some = np.arange(first, first + CHUNK)
            inside = self.blocks.inside.reshape(-1)[some % count] & (some < count)
            target, values, slopes = (part[..., some % count, :].astype(np.float32) for part in pixels)
            found = _log_likelihoods()(
                target, values, slopes, inside, changes.astype(np.float32), *self.noise.numbers()
            )
            total += np.asarray(found, np.float64)
        return total

    def moved(self, drawn: Drawn, change: np.ndarray) -> "Linear":
        """Return the picture around another sun, in the chart around that."""
        chart = Chart.around(*self.chart.sun(change))
        values, slopes = drawn(*chart)
        inside = self.blocks.inside
        course = [*self.course, (float(np.mean((values - self.target)[inside] ** 2)), chart.direction)]
        noise = noise_of(self.target[inside], values[inside], self.noise.half)
        return replace(self, chart=chart, values=values, slopes=slopes[: len(change)], noise=noise, course=course)

    def laplace(self) -> Stage:
        """Return the normal distribution of the changes if the noise is independent and the picture right."""
        slopes, weights = self._weighted()
        change = np.linalg.lstsq((slopes * weights) @ slopes.T, (slopes * weights) @ self._left(), rcond=1e-12)[0]
        return Stage(change, np.linalg.inv((slopes * weights) @ slopes.T + 1e-12 * np.eye(len(slopes))))

    def around(self) -> Stage:
        """Return a distribution that is wide enough for what the slopes do not know, such as shadows that move."""
        stage = self.laplace()
        slopes, weights = self._weighted()
        # Equal pixels are rounded equally: all errors may have the sign that moves the sun most.
        rounding = np.abs(stage.covariance @ (slopes * weights)).sum(-1) * self.noise.half
        values, vectors = np.linalg.eigh(9 * (stage.covariance + self.clustered()) + np.diag(rounding**2))
        spread = np.clip(values, LEAST_SPREAD**2, MOST_SPREAD**2)
        return Stage(np.zeros(len(stage.mean)), (vectors * spread) @ vectors.T)

    def clustered(self) -> np.ndarray:
        """Return the covariance (dimensions, dimensions) that holds where errors within a block depend on each other.

        That is the sandwich of the inverse curvature and the scatter of the blocks' scores (K.-Y. Liang, S. L. Zeger,
        Biometrika 73, 1986): it counts in the model's own error, which lies along edges.
        """
        slopes, weights = self._weighted()
        scores = (slopes * weights * self._left()).reshape(len(slopes), len(self.target), -1).sum(-1)
        inverse = np.linalg.inv((slopes * weights) @ slopes.T + 1e-12 * np.eye(len(slopes)))
        return inverse @ (scores @ scores.T) @ inverse

    def _left(self) -> np.ndarray:
        return np.where(self.blocks.inside[..., None], self.target - self.values, 0).reshape(-1)

    def _weighted(self) -> tuple[np.ndarray, np.ndarray]:
        """The slopes, and each value's weight: the inverse variance, times the chance that its pixel is not wrong."""
        variance = self.noise.sigma**2 + self.noise.half**2 / 3
        squared = ((self.target - self.values) ** 2).sum(-1) / variance
        density = (1 - WRONG) * np.exp(-squared / 2) / (2 * np.pi * variance) ** 1.5
        weights = density / (density + WRONG) / variance * self.blocks.inside
        return self.slopes.reshape(len(self.slopes), -1), np.repeat(weights.reshape(-1), 3)


def descended(
    drawn: Drawn,
    target: np.ndarray,
    half: float,
    blocks: Blocks,
    start: tuple[np.ndarray, float],
    exposure: bool,
    step: Callable[[int], Any],
) -> Linear:
    """Return the picture around the sun that explains `target`, (blocks, SIDE * SIDE, 3), best.

    half: half of the step between two values that the picture can store. start: a sun's direction and an exposure.
    exposure: whether that changes too. step: called with 1 after each picture.
    """
    from scipy import optimize

    # Its annotations know neither a function for `jac` nor ``None`` for `gtol`.
    least_squares: Any = optimize.least_squares

    chart, dimensions = Chart.around(*start), 2 + exposure
    inside = blocks.inside
    known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}
    course: list[tuple[float, np.ndarray]] = []

    def picture(change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        key = change.tobytes()
        if key not in known:
            # A direction may have any length, so the slopes along the axes are those of the chart.
            stops = chart.stops + (float(change[2]) if exposure else 0.0)
            values, slopes = drawn(chart.direction + change[:2] @ chart.axes, stops, chart.axes)
            known[key] = values, slopes[:dimensions]
            course.append((float(np.mean((values - target)[inside] ** 2)), chart.sun(change)[0]))
            step(1)
        return known[key]

    def residual(change: np.ndarray) -> np.ndarray:
        return np.append((picture(change)[0] - target)[inside].reshape(-1), WEAK * change)

    def jacobian(change: np.ndarray) -> np.ndarray:
        return np.vstack([picture(change)[1][:, inside].reshape(dimensions, -1).T, WEAK * np.eye(dimensions)])

    change = np.zeros(dimensions)
    for _ in range(ROUNDS):
        # Most pixels have the noise alone; as they come to fit, those that do not fit count less.
        values = picture(change)[0][inside]
        noise = noise_of(target[inside], values, half)
        scale = CAUCHY * math.hypot(noise.sigma, half / math.sqrt(3))
        found = least_squares(
            residual, change, jacobian, loss="cauchy", f_scale=scale, xtol=STEP, ftol=1e-9, gtol=None, max_nfev=MOST
        )
        before, change = change, found.x
        if np.abs(change - before).max() < 10 * STEP:
            break
    there = Linear(chart, blocks, target, *picture(change), noise, course)
    # The slopes once more, along tangents of the sun that was found.
    return there.moved(drawn, change)


def widened(posterior: Posterior, covariance: np.ndarray) -> Posterior:
    """Return the posterior with its changes spread to the variance of `covariance` where this is larger."""
    mean, own = posterior.stage()
    root = np.linalg.cholesky(own + 1e-18 * np.eye(len(own)))
    whitened = np.linalg.solve(root, np.linalg.solve(root, covariance).T)
    values, vectors = np.linalg.eigh((whitened + whitened.T) / 2)
    spread = vectors @ np.diag(np.sqrt(np.maximum(values, 1))) @ vectors.T
    away = np.linalg.solve(root, (posterior.changes - mean).T)
    return posterior._replace(changes=mean + (root @ spread @ away).T)


@lru_cache
def _log_likelihoods() -> Any:
    import jax
    import jax.numpy as jnp

    def many(target: Any, values: Any, slopes: Any, inside: Any, changes: Any, sigma: Any, half: Any) -> Any:
        def one(change: Any) -> Any:
            there = jnp.clip(values + jnp.tensordot(change, slopes, 1), 0, 1)
            return log_likelihood(target, tuple(jnp.moveaxis(there, -1, 0)), inside, sigma, half)

        return jax.lax.map(one, changes)

    return jax.jit(many)
