"""The sun's direction from a picture, with regions that hold it, or the reason why the picture does not tell it."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.errors import InputError, check_choice
from raytrace.inverse.explaining import Course, End, explained
from raytrace.inverse.picture import EDGES, Target, target_of
from raytrace.inverse.posterior import degrees_between, quantile
from raytrace.inverse.search import KEPT
from raytrace.inverse.slopes import moved
from raytrace.rendering import MOST_SAMPLES
from raytrace.scene.check import check_scene
from raytrace.scene.data import Scene
from raytrace.scene.sun import sun_angles

__all__ = ["Course", "DoesNotFit", "NotDetermined", "SunFit", "fit_sun", "fitted_scene"]

#: The sun is not determined where the region that holds it with 95 % reaches farther than this, in degrees.
WIDEST = 10.0


@dataclass(frozen=True)
class SunFit:
    """The sun that was found.

    direction: a unit vector (3,). azimuth, elevation: in degrees (`raytrace.sun_angles`). exposure: in stops, the
    scene's own unless it was asked for.
    within_68, within_95: the true sun is within so many degrees of the direction, with a probability of 68 % and 95 %.
    uncertainty: the standard deviation of the direction in degrees, along its least certain axis.
    residual: the root of the mean squared difference of display values. noise: the standard deviation of the noise that
    most pixels have, in display values and before rounding.
    sampling: how the picture's pixels were made: n for n x n samples, or "edges" for means.
    history: a course for each guess that was followed, the best first.
    """

    direction: np.ndarray
    azimuth: float
    elevation: float
    exposure: float
    within_68: float
    within_95: float
    uncertainty: float
    residual: float
    noise: float
    sampling: int | str
    history: tuple[Course, ...]

    def __str__(self) -> str:
        x, y, z = self.direction
        return (
            f"azimuth {self.azimuth:.3f}, elevation {self.elevation:.3f} degrees; "
            f"68 % within {self.within_68:.2g}, 95 % within {self.within_95:.2g} degrees; "
            f"direction [{x:.5f}, {y:.5f}, {z:.5f}]; residual {self.residual:.4f}"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the same for JSON, without the history."""
        found = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "history"}
        return found | {"direction": self.direction.tolist()}


class NotDetermined(RuntimeError):
    """The picture does not tell where the sun is: very different suns explain it equally well."""


class DoesNotFit(RuntimeError):
    """No sun explains the picture: what is left over is not the picture's noise.

    proposals: what explains it, as flags of the command: `--exposure`, `--set film.transfer=srgb`. fit: the best sun
    all the same.
    """

    def __init__(self, message: str, proposals: tuple[str, ...], fit: SunFit):
        super().__init__(message)
        self.proposals, self.fit = proposals, fit


def fit_sun(
    image: Any,
    scene: Scene | str | Path | None = None,
    *,
    kind: str | None = None,
    exposure: bool = False,
    starts: int = 4,
    samples: int | None = None,
    antialias: str | None = None,
    layer: str | None = None,
    progress: Callable[[int], Any] | None = None,
) -> SunFit:
    """Find the direction of the sun in a picture of `scene`, whose own sun does not matter but for its colour.

    image: a file, or an array (height, width, 3) of at least 16 x 16 pixels: floats from 0 to 1, uint8, uint16, or
    numbers from 0 to 255.
    scene: by default the one in the file's metadata, or else the default one.
    kind: "display" or "linear", what the values are; by default what the file says, or its ending.
    exposure: whether to find the film's exposure as well.
    starts: how many guesses are followed at the most; a second one is if it is nearly as likely as the first.
    samples, antialias: how the picture's pixels were made, as for `raytrace.render`; by default what the file says. For
    a picture that does not say it, one sample a pixel is tried at first; where that does not fit, 2 x 2, 4 x 4 and
    means.
    layer: which layer, or part, of an OpenEXR file is meant, if it has several with red, green and blue.
    progress: called with 1 after each step; there are about `steps_of(starts)`.

    Raises:
        InputError: the image or an argument is wrong.
        NotDetermined: very different suns explain the picture equally well.
        DoesNotFit: no sun explains the picture.
    """
    target = target_of(image, scene, kind, layer)
    check_scene(target.scene)
    if not isinstance(starts, int) or not 1 <= starts <= KEPT:
        raise InputError(f"starts: must be a whole number from 1 to {KEPT}, found {starts!r}")
    given = _sampling(samples, antialias)
    step = progress or (lambda done: None)
    end = explained(target, exposure, starts, given or target.made, given is not None, step)
    fit = _fit_of(end)
    if not end.mismatch.fits:
        raise _does_not_fit(end, fit, target, exposure, step)
    _check_determined(end, fit)
    return fit


def steps_of(starts: int) -> int:
    """Return about how many steps `fit_sun` takes."""
    return 20 * starts


def fitted_scene(scene: Scene, fit: SunFit) -> Scene:
    """Return the scene with the sun, and the exposure, that was found."""
    return moved(scene, fit.direction, fit.exposure)


def _sampling(samples: int | None, antialias: str | None) -> int | str | None:
    """How pixels were made, as it is given; ``None`` where it is not."""
    if antialias is not None:
        check_choice("antialias", antialias, ("none", EDGES))
    if samples is not None and not (isinstance(samples, int) and 1 <= samples <= MOST_SAMPLES):
        raise InputError(f"samples: must be a whole number from 1 to {MOST_SAMPLES}, found {samples!r}")
    if antialias == EDGES:
        return EDGES
    return 1 if samples is None and antialias == "none" else samples


def _fit_of(end: End) -> SunFit:
    suns, stops = end.chart.suns(end.posterior.changes)
    weights = end.posterior.weights
    mean = weights @ suns
    mean /= np.linalg.norm(mean)
    away = degrees_between(suns, mean)
    azimuth, elevation = map(float, sun_angles(mean))
    return SunFit(
        direction=mean,
        azimuth=azimuth,
        elevation=elevation,
        exposure=float(weights @ stops),
        within_68=quantile(away, weights, 0.68),
        within_95=quantile(away, weights, 0.95),
        uncertainty=math.degrees(math.sqrt(np.linalg.eigvalsh(end.posterior.stage().covariance[:2, :2])[-1])),
        residual=end.residual,
        noise=end.noise.sigma,
        sampling=end.sampling,
        history=end.courses,
    )


def _check_determined(end: End, fit: SunFit) -> None:
    apart = 2 * fit.within_95 if fit.within_95 > WIDEST else 0.0
    apart = max([apart, *(float(degrees_between(other, fit.direction)) for other in end.others)])
    if apart > 0:
        raise NotDetermined(
            f"the picture does not determine the sun: suns {min(apart, 180):.0f} degrees apart explain it equally well"
        )


def _does_not_fit(end: End, fit: SunFit, target: Target, exposure: bool, step: Callable[[int], Any]) -> DoesNotFit:
    """The error for a picture that is not explained, with what would explain it."""
    message = f"the scene does not explain the picture: {end.mismatch}"
    if end.mismatch.smooth:
        hint = "; only edges are off: has it other --samples, or is it blurred or compressed?"
        return DoesNotFit(message + hint, (), fit)
    transfer = "srgb" if target.scene.film.transfer != "srgb" else "gamma2.2"
    other = replace(target, scene=replace(target.scene, film=replace(target.scene.film, transfer=transfer)))
    by_transfer = f"--set film.transfer={transfer}"
    trials = [((by_transfer,), other, exposure)]
    if not exposure:
        trials = [(("--exposure",), target, True), *trials, (("--exposure", by_transfer), other, True)]
    for flags, changed, free in trials:
        if explained(changed, free, 1, end.sampling, True, step).mismatch.smooth:
            return DoesNotFit(f"{message}; with {' '.join(flags)} it does", flags, fit)
    return DoesNotFit(f"{message}; is it another scene, another camera, cropped, blurred or compressed?", (), fit)
