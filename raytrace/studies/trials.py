"""How near `fit_sun` comes to suns that are known, and how often they are in the regions that it reports."""

import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from raytrace.inverse.fit import DoesNotFit, NotDetermined, fit_sun
from raytrace.inverse.posterior import degrees_between
from raytrace.rendering import render
from raytrace.scene.data import Scene

__all__ = ["Trial", "summary", "trials"]

#: The standard deviation of the noise, in display values.
NOISE = 2 / 255


class Trial(NamedTuple):
    """A sun's elevation, how far the fitted one is from it, and the radii that are to hold it with 68 % and 95 %.

    All in degrees; NaN where the fit says that the picture does not determine the sun, or that nothing explains it.
    """

    elevation: float
    error: float
    within_68: float
    within_95: float
    seconds: float


def trials(scene: Scene, number: int, size: tuple[int, int], samples: int, seed: int = 0) -> Iterator[Trial]:
    """Fit random suns above the horizon, in images of 8 bits with noise of two levels.

    The suns are uniform over the hemisphere. The fit is not told how many samples a pixel has.
    """
    random = np.random.default_rng(seed)
    for _ in range(number):
        direction = random.normal(size=3)
        direction[1] = abs(direction[1])
        direction /= np.linalg.norm(direction)
        image = np.asarray(render(scene.with_("sun.direction", direction), size, samples=samples), np.float64)
        noisy = np.clip(image + random.normal(0, NOISE, image.shape), 0, 1)
        begun = time.perf_counter()
        found = np.nan, np.nan, np.nan
        try:
            fit = fit_sun(np.round(255 * noisy).astype(np.uint8), scene)
            found = float(degrees_between(direction, fit.direction)), fit.within_68, fit.within_95
        except (NotDetermined, DoesNotFit):
            pass
        yield Trial(float(np.degrees(np.arcsin(direction[1]))), *found, time.perf_counter() - begun)


def summary(found: list[Trial]) -> str:
    """Return a line for each, and what they come to."""
    lines = ["elevation     error  68 % within  95 % within   seconds"]
    lines += [
        f"{t.elevation:9.1f}  {t.error:8.4f}     {t.within_68:8.4f}     {t.within_95:8.4f}  {t.seconds:8.1f}"
        for t in found
    ]
    error, within_68, within_95 = (
        np.array([getattr(t, n) for t in found]) for n in ("error", "within_68", "within_95")
    )
    known = np.isfinite(error)
    lines.append(f"{len(found)} suns, of which {np.count_nonzero(~known)} are called undetermined or not explained")
    if known.any():
        error, within_68, within_95 = error[known], within_68[known], within_95[known]
        lines.append(
            f"of {len(error)}: {100 * np.mean(error <= within_68):.1f} % in the 68 % region, "
            f"{100 * np.mean(error <= within_95):.1f} % in the 95 % region; "
            f"{100 * np.mean(error <= 0.1):.1f} % within 0.1 degrees, "
            f"median {np.median(error):.4f}, worst {error.max():.4f}"
        )
    seconds = [t.seconds for t in found]
    lines.append(f"seconds: median {np.median(seconds):.2f}, first, with compiling, {seconds[0]:.1f}")
    return "\n".join(lines)
