"""Where the sun may be: the whole sphere at first, and then nearer and nearer around what is likely."""

import math
from typing import NamedTuple

import numpy as np

from raytrace.inverse.likelihood import Noise
from raytrace.inverse.posterior import Chart, degrees_between
from raytrace.inverse.relit import Relit

__all__ = ["EXPOSURES", "Guess", "evenly", "search", "sky_candidates"]

#: Directions over the whole sphere, about 5.5 degrees apart.
DIRECTIONS = 1280
#: Exposures that are tried, in stops, where that is unknown too.
EXPOSURES = tuple(np.arange(-4.0, 5.0, 1.0))
#: So many guesses are followed, to steps of so many degrees, with noise that is taken to be so large at each.
KEPT = 8
STEPS = ((3.0, 0.15), (1.5, 0.1), (0.75, 0.07), (0.4, 0.05))
#: Pixels of the sky that the lobe may be in, and by how many degrees it may be below them.
BRIGHTEST = 24
BELOW = (0.0, 1.0, 2.0, 3.5)


class Guess(NamedTuple):
    """A sun (3,), an exposure in stops, and the logarithm of the picture's probability."""

    direction: np.ndarray
    stops: float
    log: float


def evenly(number: int) -> np.ndarray:
    """Return directions (number, 3) that are spread evenly over the sphere, on a Fibonacci spiral."""
    k = np.arange(number)
    y = 1 - (2 * k + 1) / number
    turn = k * math.pi * (3 - math.sqrt(5))
    level = np.sqrt(1 - y**2)
    return np.stack([level * np.sin(turn), y, -level * np.cos(turn)], -1)


def sky_candidates(relit: Relit, stops: float) -> np.ndarray:
    """Return directions (n, 3) in which the sky of the picture differs most from one without a sun, and below them.

    The lobe is narrower than the directions of `evenly` are apart, and it may stand above a sun below the horizon.
    """
    rays, is_sky = relit.sky_rays()
    if not is_sky.any():
        return np.zeros((0, 3))
    # This sun has no lobe above the horizon.
    away = np.abs(relit.target - relit.values(np.array([0.0, -1.0, 0.0]), stops)).max(-1)
    order = np.argsort(-away[is_sky])[:BRIGHTEST]
    found = rays[is_sky][order]
    lowered = [found - np.array([0.0, math.tan(math.radians(below)), 0.0]) for below in BELOW]
    return np.concatenate([each / np.linalg.norm(each, axis=-1, keepdims=True) for each in lowered])


def search(relit: Relit, stops: tuple[float, ...]) -> list[Guess]:
    """Return the likeliest suns, the best first, none near another; `stops` are the exposures that are tried."""
    suns = np.concatenate(
        [evenly(DIRECTIONS), *(sky_candidates(relit, stop) for stop in stops[:: max(1, len(stops) - 1)])]
    )
    directions, exposures = np.repeat(suns, len(stops), 0), np.tile(stops, len(suns))
    logs = _logs(relit, directions, exposures, STEPS[0][1])
    change = (stops[1] - stops[0]) if len(stops) > 1 else 0.0
    for (step, _), (_, sigma) in zip(STEPS, (*STEPS[1:], STEPS[-1]), strict=True):
        change /= 2
        kept = _apart(directions, logs, step)
        directions, exposures = _around(directions[kept], exposures[kept], step, change)
        logs = _logs(relit, directions, exposures, sigma)
    kept = _apart(directions, logs, 2 * STEPS[-1][0])
    return [Guess(directions[k], float(exposures[k]), float(logs[k])) for k in kept]


def _logs(relit: Relit, directions: np.ndarray, stops: np.ndarray, sigma: float) -> np.ndarray:
    return relit.log_likelihoods(directions, stops, Noise(sigma, 0.0))


def _apart(directions: np.ndarray, logs: np.ndarray, degrees: float) -> list[int]:
    """The numbers of the likeliest directions, each at least so far from those before it."""
    kept: list[int] = []
    for k in np.argsort(-logs, kind="stable"):
        if not kept or degrees_between(directions[kept], directions[k]).min() > degrees:
            kept.append(int(k))
            if len(kept) == KEPT:
                break
    return kept


def _around(directions: np.ndarray, stops: np.ndarray, degrees: float, change: float) -> tuple[np.ndarray, np.ndarray]:
    """Each direction, six around it, and the exposures beside its own."""
    turns = np.arange(6) * math.pi / 3
    ring = np.vstack([np.zeros(2), np.stack([np.cos(turns), np.sin(turns)], -1)]) * math.radians(degrees)
    found, exposures = [], []
    for direction, stop in zip(directions, stops, strict=True):
        for beside in (0.0,) if change == 0 else (-change, 0.0, change):
            suns, same = Chart.around(direction, stop + beside).suns(ring)
            found.append(suns)
            exposures.append(same)
    return np.concatenate(found), np.concatenate(exposures)
