"""How near `fit_sun` comes to suns that are known."""

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from raytrace.inverse.fit import fit_sun
from raytrace.rendering import render
from raytrace.scene.data import Scene

__all__ = ["Trial", "told", "trials"]

#: The standard deviation of the noise, in display values.
NOISE = 2 / 255


class Trial(NamedTuple):
    """A sun's elevation, how far the fitted one is from it and how uncertain that says it is, in degrees; seconds."""

    elevation: float
    error: float
    uncertainty: float
    seconds: float


def trials(scene: Scene, number: int, size: tuple[int, int], samples: int, seed: int = 0) -> Iterator[Trial]:
    """Fits of random suns above the horizon, from images of 8 bits with noise of two levels."""
    random = np.random.default_rng(seed)
    for _ in range(number):
        direction = random.normal(size=3)
        direction[1] = abs(direction[1])
        direction /= np.linalg.norm(direction)
        lit = replace(scene, sun=replace(scene.sun, direction=direction))
        image = np.asarray(render(lit, size, samples=samples), np.float64)
        noisy = np.clip(image + random.normal(0, NOISE, image.shape), 0, 1)
        begun = time.perf_counter()
        fit = fit_sun(np.round(255 * noisy).astype(np.uint8), scene)
        seconds = time.perf_counter() - begun
        error = np.arctan2(np.linalg.norm(np.cross(direction, fit.direction)), direction @ fit.direction)
        yield Trial(np.degrees(np.arcsin(direction[1])), np.degrees(error), fit.uncertainty, seconds)


def told(found: list[Trial]) -> str:
    """A line for each, and what they come to."""
    lines = ["elevation   error   uncertainty   seconds"]
    lines += [f"{t.elevation:9.1f}  {t.error:.4f}        {t.uncertainty:.4f}    {t.seconds:6.1f}" for t in found]
    errors = np.array([t.error for t in found])
    lines.append(
        f"{len(found)} suns: {100 * np.mean(errors <= 0.1):.0f} % within 0.1 degrees, median {np.median(errors):.4f}, "
        f"worst {errors.max():.4f}; seconds: median {np.median([t.seconds for t in found]):.1f}, "
        f"first, with compiling, {found[0].seconds:.1f}"
    )
    return "\n".join(lines)
