"""The rays whose t is most wrong, sought by hill climbing.

Random rays seldom meet the worst case of a formula. So some climbers start at random rays and at the worst rays of the
other axes. Each changes its ray at random, and keeps the change where the error of t over the condition number does not
become smaller. From time to time the lowest climbers start anew, or beside the highest ones.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from raytrace.arithmetic.exact import precision
from raytrace.language.glsl import Vec3
from raytrace.studies.stress.measure import ulps
from raytrace.studies.stress.rays import Rays, answered, given

__all__ = ["Climb", "Found", "climb", "random_rays", "rows_of"]

#: After so many steps the lowest climbers start anew: this share of all, and as many beside the highest ones.
ROUND, SHARE = 8, 0.2
#: Lengths that are tried, within those that a scene may have.
SHORTEST, LONGEST = 1e-9, 1e11
#: How near a number is to the next one, in powers of ten: the smallest changes.
FINEST = {np.float32: -8.5, np.float64: -16.5}


class Found(NamedTuple):
    """The errors of t of n rays in units in the last place, and the problems' condition numbers; 0 and 1 where the
    decision is another one, of which no t is right.
    """

    ulp: np.ndarray
    condition: np.ndarray

    @property
    def height(self) -> np.ndarray:
        return self.ulp / self.condition


class Climb(NamedTuple):
    """Where n climbers are: their rays (n, 10), origin, direction, centre and radius; what was found there."""

    numbers: np.ndarray
    found: Found


def climb(
    intersect: Callable[[Rays], np.ndarray], dtype: Any, start: np.ndarray, steps: int, random: np.random.Generator
) -> Climb:
    """Climb from the rays `start` (n, 10), longdouble; `intersect` gives t of rays that are rounded to `dtype`."""
    numbers, found = start.copy(), _measured(intersect, dtype, start)
    for step in range(1, steps + 1):
        tried = _changed(numbers, dtype, random)
        there = _measured(intersect, dtype, tried)
        up = there.height >= found.height
        numbers[up] = tried[up]
        for mine, others in zip(found, there, strict=True):
            mine[up] = others[up]
        if step % ROUND == 0:
            order, some = np.argsort(found.height), int(SHARE * len(numbers))
            anew, beside, highest = order[:some], order[some : 2 * some], order[-some:]
            numbers[anew] = random_rays(random, some)
            for mine, others in zip(found, _measured(intersect, dtype, numbers[anew]), strict=True):
                mine[anew] = others
            numbers[beside] = numbers[highest]
            for mine in found:
                mine[beside] = mine[highest]
    return Climb(numbers, found)


def random_rays(random: np.random.Generator, n: int) -> np.ndarray:
    """Rays (n, 10) from near a surface and from afar, in scenes about the origin and far away from it."""
    radius = 10 ** random.uniform(-3, 3, n)
    center = _directions(random, n) * (radius * 10 ** random.uniform(-1, 5, n) * _either(random, n, 0.0, 1.0))[:, None]
    near = _either(random, n, -1.0, 1.0) * 10 ** random.uniform(-9, 0, n)
    height = np.where(random.random(n) < 0.3, 10 ** random.uniform(0, 7, n), np.maximum(near, -0.999))
    origin = center + (radius * (1 + height))[:, None] * _directions(random, n)
    return np.column_stack([origin, _directions(random, n), center, radius]).astype(np.longdouble)


def rows_of(rays: Rays) -> np.ndarray:
    """The same rays as (n, 10)."""
    columns = [*rays.origin, *rays.direction, *rays.center, rays.radius]
    return np.column_stack(np.broadcast_arrays(*(np.asarray(x, np.longdouble) for x in columns)))


def _measured(intersect: Callable, dtype: Any, numbers: np.ndarray) -> Found:
    origin, direction, center = (Vec3(*numbers[:, i : i + 3].T) for i in (0, 3, 6))
    rays = given(Rays(origin, direction, center, numbers[:, 9]), dtype)
    exact, t = answered(rays), intersect(rays)
    counted = exact.decided(t) & exact.hit
    # An origin or a sphere that is out of a scene's bounds is no case.
    lengths = np.abs(numbers[:, [0, 1, 2, 6, 7, 8]]).max(axis=1)
    counted &= (lengths < LONGEST) & (numbers[:, 9] > SHORTEST) & (numbers[:, 9] < LONGEST)
    errors, condition = np.zeros(len(numbers)), np.ones(len(numbers))
    with precision():
        errors[counted] = ulps(t[counted], exact.t[counted], dtype)
    condition[counted] = exact.condition[counted]
    return Found(errors, condition)


def _changed(numbers: np.ndarray, dtype: Any, random: np.random.Generator) -> np.ndarray:
    """Each ray after one of `CHANGES`, its direction of unit length."""
    which = random.integers(0, len(CHANGES), len(numbers))
    changed = numbers.copy()
    for i, change in enumerate(CHANGES):
        mine = which == i
        changed[mine] = change(numbers[mine], FINEST[dtype], random)
    changed[:, 3:6] = _unit(changed[:, 3:6])
    return changed


def _all_numbers(numbers: np.ndarray, finest: float, random: np.random.Generator) -> np.ndarray:
    """All a little larger or smaller."""
    size = 10 ** random.uniform(finest, -0.3, len(numbers))[:, None]
    return numbers * (1 + size * random.normal(size=numbers.shape))


def _one_number(numbers: np.ndarray, finest: float, random: np.random.Generator) -> np.ndarray:
    """One of them a little larger or smaller."""
    changed, row = numbers.copy(), np.arange(len(numbers))
    column = random.integers(0, numbers.shape[1], len(numbers))
    changed[row, column] *= 1 + 10 ** random.uniform(finest, -0.3, len(numbers)) * random.normal(size=len(numbers))
    return changed


def _last_places(numbers: np.ndarray, finest: float, random: np.random.Generator) -> np.ndarray:
    """By a few units in the last place."""
    return numbers * (1 + 10.0 ** (finest + 1) * random.integers(-3, 4, numbers.shape))


def _to_the_surface(numbers: np.ndarray, finest: float, random: np.random.Generator) -> np.ndarray:
    """The origin onto the sphere, or just beside it."""
    changed, n = numbers.copy(), len(numbers)
    height = np.maximum(_either(random, n, -1.0, 1.0) * 10 ** random.uniform(finest, 0, n), -0.999)
    outward = _unit(numbers[:, 0:3] - numbers[:, 6:9])
    changed[:, 0:3] = numbers[:, 6:9] + (numbers[:, 9] * (1 + height))[:, None] * outward
    return changed


def _tangential(numbers: np.ndarray, finest: float, random: np.random.Generator) -> np.ndarray:
    """The direction across that to the centre, nearly."""
    changed, n = numbers.copy(), len(numbers)
    outward, direction = _unit(numbers[:, 0:3] - numbers[:, 6:9]), numbers[:, 3:6]
    across = _unit(direction - (direction * outward).sum(axis=1, keepdims=True) * outward)
    angle = _either(random, n, -1.0, 1.0) * 10 ** random.uniform(finest, 0, n)
    changed[:, 3:6] = across + angle[:, None] * outward
    return changed


def _grazing(numbers: np.ndarray, finest: float, random: np.random.Generator) -> np.ndarray:
    """The direction past the sphere's silhouette, nearly; from inside, across that to the centre."""
    changed, n = numbers.copy(), len(numbers)
    axis = numbers[:, 6:9] - numbers[:, 0:3]
    distance, axis, direction = np.sqrt((axis**2).sum(axis=1)), _unit(axis), numbers[:, 3:6]
    across = _unit(direction - (direction * axis).sum(axis=1, keepdims=True) * axis)
    passing = numbers[:, 9] * (1 + _either(random, n, -1.0, 1.0) * 10 ** random.uniform(finest, -0.5, n))
    sine = np.minimum(passing / np.maximum(distance, SHORTEST), 1)[:, None]
    changed[:, 3:6] = np.sqrt(1 - sine**2) * axis + sine * across
    return changed


def _elsewhere(numbers: np.ndarray, finest: float, random: np.random.Generator) -> np.ndarray:
    """The whole scene far away, or the sphere to the coordinates' origin."""
    changed, n = numbers.copy(), len(numbers)
    far = _directions(random, n) * (numbers[:, 9] * 10 ** random.uniform(-1, 6, n))[:, None]
    shift = np.where(random.random(n)[:, None] < 0.3, -numbers[:, 6:9], far)
    changed[:, 0:3] += shift
    changed[:, 6:9] += shift
    return changed


def _other_unit(numbers: np.ndarray, finest: float, random: np.random.Generator) -> np.ndarray:
    """The whole scene in another unit of length."""
    changed = numbers.copy()
    changed[:, [0, 1, 2, 6, 7, 8, 9]] *= 10 ** random.uniform(-0.5, 0.5, (len(numbers), 1))
    return changed


CHANGES = (
    *(_all_numbers, _one_number, _last_places, _to_the_surface),
    *(_tangential, _grazing, _elsewhere, _other_unit),
)


def _either(random: np.random.Generator, n: int, one: float, other: float) -> np.ndarray:
    return np.where(random.random(n) < 0.5, one, other)


def _directions(random: np.random.Generator, n: int) -> np.ndarray:
    return _unit(random.normal(size=(n, 3)))


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.sqrt((vectors**2).sum(axis=1, keepdims=True))
    return vectors / np.where(length > 0, length, 1)
