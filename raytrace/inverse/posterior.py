"""What a picture says of the sun: samples of the posterior distribution, by adaptive importance sampling.

A picture of samples changes in jumps where a shadow's edge passes a sample, so it has no curvature that would tell an
uncertainty. Its probability can be computed for any sun, however. So suns are drawn from Student's t, weighted by how
probable the picture is under them, and drawn again around those that are likely, until draws and weights agree
(population Monte Carlo; O. Cappe et al., J. Comp. Graph. Stat. 13, 2004; mixture weights after J.-M. Cornuet et al.,
Scand. J. Stat. 39, 2012). The prior is uniform over the sphere and in stops.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from raytrace.inverse.likelihood import Noise

__all__ = ["Chart", "Posterior", "Stage", "approach", "degrees_between", "quantile", "sampled"]

#: Degrees of freedom of Student's t, whose tails are heavier than those of what is sought.
TAILS = 4
#: Suns drawn at a time on the way, and then for the result; how often at the most.
DRAWN, STAGES = 64, 40
LAST_DRAWN, LAST_STAGES = 256, 8
#: So many equally weighted suns the result is worth at least.
ENOUGH = 250
#: The share of a stage's suns that go on.
SHARE = 1 / 6
#: No step is finer than float32 can tell suns apart, in radians.
FINEST = 2e-7
#: Suns that are spread over more than this, in radians, are not where they were sought.
WIDEST = 0.5

#: The logarithm of a picture's probability under changes (n, dimensions) of a sun.
LogLikelihood = Callable[[np.ndarray], np.ndarray]


class Stage(NamedTuple):
    """A normal distribution over changes of a sun: two tangents' lengths in radians and, maybe, stops."""

    mean: np.ndarray
    covariance: np.ndarray


class Posterior(NamedTuple):
    """Weighted changes (n, dimensions) of a sun. weights: sum to one. best: the likeliest change (dimensions,)."""

    changes: np.ndarray
    weights: np.ndarray
    best: np.ndarray

    @property
    def effective(self) -> float:
        """How many equally weighted samples they are worth."""
        return 1 / float(np.sum(self.weights**2))

    def stage(self) -> Stage:
        """Return their mean and covariance."""
        mean = self.weights @ self.changes
        away = self.changes - mean
        return Stage(mean, (self.weights[:, None] * away).T @ away)


class Chart(NamedTuple):
    """Coordinates around a sun: lengths along two tangents (2, 3), in radians, and, where there is a third, stops."""

    direction: np.ndarray
    stops: float
    axes: np.ndarray

    @classmethod
    def around(cls, direction: np.ndarray, stops: float) -> "Chart":
        """Return the chart around a unit vector (3,), along two unit vectors across it: no angle is singular."""
        first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
        first /= np.linalg.norm(first)
        return cls(direction, stops, np.stack([first, np.cross(direction, first)]))

    def suns(self, changes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the directions (n, 3) and exposures (n,) of changes (n, dimensions)."""
        moved = self.direction + changes[:, :2] @ self.axes
        stops = changes[:, 2] if changes.shape[1] > 2 else np.zeros(len(changes))
        return moved / np.linalg.norm(moved, axis=-1, keepdims=True), np.clip(self.stops + stops, -16, 16)

    def sun(self, change: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the direction (3,) and the exposure of one change (dimensions,)."""
        directions, stops = self.suns(change[None])
        return directions[0], float(stops[0])


def approach(
    log_likelihood: Callable[[np.ndarray, Noise], np.ndarray],
    noise_at: Callable[[np.ndarray], Noise],
    start: Stage,
    random: np.random.Generator,
) -> tuple[Stage, Posterior, Noise]:
    """Go from a guess towards the likely suns; return where they are, the suns drawn last, and the noise there.

    The likelihood is tempered: its power is so small that a share of the drawn suns counts, and grows to 1. The noise
    is what is left over at the likeliest sun of a stage.
    """
    stage, best = start, start.mean
    noise = noise_at(best)
    for _ in range(STAGES):
        changes, density = _drawn(stage, DRAWN, random)
        changes[0] = best
        logs = log_likelihood(changes, noise)
        power = _power(logs)
        # A tempered likelihood is flat far away, so that there the draws' own density stands for a prior.
        weights = _normalized(power * logs - (density if power == 1 else 0))
        best = changes[np.argmax(logs)]
        found = Posterior(changes, weights, best)
        before, stage = stage, _widened(found.stage(), 1.5)
        known, noise = noise, noise_at(best)
        shrunk = np.linalg.slogdet(before.covariance)[1] - np.linalg.slogdet(stage.covariance)[1]
        if power == 1 and abs(shrunk) < 1 and abs(math.log(noise.sigma / known.sigma)) < 0.05:
            break
        if np.sqrt(np.diag(stage.covariance)[:2].max()) > WIDEST:
            break
    return stage, found, noise


def sampled(log_likelihood: LogLikelihood, start: Stage, random: np.random.Generator) -> Posterior:
    """Return samples of the posterior, from a distribution that is near it."""
    # The first one is wide: what it does not reach would be missed by those that follow.
    stages, changes, logs = [_widened(start, 6.0)], [], []
    for _ in range(LAST_STAGES):
        drawn, _ = _drawn(stages[-1], LAST_DRAWN, random)
        changes.append(drawn)
        logs.append(log_likelihood(drawn))
        all_changes, all_logs = np.concatenate(changes), np.concatenate(logs)
        weights = _normalized(all_logs - _density(all_changes, stages))
        found = Posterior(all_changes, weights, all_changes[np.argmax(all_logs)])
        if len(stages) > 1 and found.effective >= ENOUGH:
            break
        stages.append(_widened(found.stage(), 2.0))
    return found


def _drawn(stage: Stage, number: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Changes from Student's t, and the logarithm of their density."""
    size = len(stage.mean)
    normal = random.normal(size=(number, size)) @ np.linalg.cholesky(stage.covariance).T
    changes = stage.mean + normal * np.sqrt(TAILS / random.chisquare(TAILS, number))[:, None]
    return changes, _density(changes, [stage])


def _density(changes: np.ndarray, stages: list[Stage]) -> np.ndarray:
    """The logarithm of the mixture's density, but for a constant."""
    logs = []
    for mean, covariance in stages:
        away = changes - mean
        squared = np.einsum("ni,ni->n", away, np.linalg.solve(covariance, away.T).T)
        size = len(mean)
        logs.append(-(TAILS + size) / 2 * np.log1p(squared / TAILS) - np.linalg.slogdet(covariance)[1] / 2)
    return np.logaddexp.reduce(logs, 0)


def _normalized(logs: np.ndarray) -> np.ndarray:
    weights = np.exp(logs - logs.max())
    return weights / weights.sum()


def _power(logs: np.ndarray) -> float:
    """The largest power of the likelihood, at most 1, with which a share of the suns counts."""

    def counted(power: float) -> float:
        return 1 / float(np.sum(_normalized(power * logs) ** 2))

    least = SHARE * len(logs)
    if counted(1.0) >= least:
        return 1.0
    low, high = -12.0, 0.0
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if counted(10**middle) >= least else (low, middle)
    return 10**low


def _widened(stage: Stage, factor: float) -> Stage:
    return Stage(stage.mean, factor * stage.covariance + FINEST**2 * np.eye(len(stage.mean)))


def degrees_between(a: np.ndarray, b: np.ndarray) -> np.ndarray | np.floating:
    """Return the angles between unit vectors along the last axis."""
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(a - b, axis=-1) / 2, 0, 1)))


def quantile(values: Any, weights: np.ndarray, share: float) -> float:
    """Return the least of the weighted values that no more than `share` of them are below."""
    order = np.argsort(values)
    return float(np.interp(share, np.cumsum(weights[order]) - weights[order] / 2, values[order]))
