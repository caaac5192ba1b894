"""The sun's direction from a picture: least squares, from several starts, over an image that knows its edges."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.compare.film import developed, film_of
from raytrace.errors import InputError
from raytrace.image import read_image
from raytrace.inverse.descent import Course, Descent
from raytrace.inverse.shrunk import coarse, shrunk
from raytrace.inverse.slopes import moved
from raytrace.rendering import render
from raytrace.scene.check import check_scene
from raytrace.scene.data import Scene
from raytrace.scene.sun import sun_angles, sun_direction
from raytrace.scene.toml import load_scene

__all__ = ["Course", "SunFit", "fit_sun", "fitted_scene"]

#: Directions above the horizon that are looked at first, in pictures of so many pixels.
LOOKED_AT, SMALL = 192, 64 * 36
#: Steps of Adam's for each start, which bears a bad one; then Gauss's and Newton's for the best, which end at once.
ADAM_STEPS, LAST_STEPS = 40, 8
#: How often is looked around the end, where the picture seems to have few samples.
LOOKS_AROUND = 60
#: Starts are at least so many degrees apart.
APART = 12.0
#: Exposures that are tried, where it is unknown too.
EXPOSURES = (-2.0, -1.0, 0.0, 1.0, 2.0)


@dataclass(frozen=True)
class SunFit:
    """The sun that was found.

    direction: a unit vector (3,). azimuth, elevation: in degrees (`raytrace.sun_angles`). exposure: in stops, the
    scene's own unless it was asked for. residual: the root of the mean squared difference of display values, or
    of their means over about 192 x 108 squares where the image is larger.
    uncertainty: the standard deviation of the direction in degrees, along its least certain axis, from the curvature at
    the minimum and the residual, as if that were independent noise. history: a course for each start, the best first.
    """

    direction: np.ndarray
    azimuth: float
    elevation: float
    exposure: float
    residual: float
    uncertainty: float
    history: tuple[Course, ...]

    def __str__(self) -> str:
        x, y, z = self.direction
        return (
            f"azimuth {self.azimuth:.3f}, elevation {self.elevation:.3f} degrees, +- {self.uncertainty:.3f}; "
            f"direction [{x:.5f}, {y:.5f}, {z:.5f}]; residual {self.residual:.4f}"
        )

    def to_dict(self) -> dict[str, Any]:
        """The same for JSON, without the history."""
        return {
            "direction": self.direction.tolist(),
            "azimuth": self.azimuth,
            "elevation": self.elevation,
            "exposure": self.exposure,
            "residual": self.residual,
            "uncertainty": self.uncertainty,
        }


def fit_sun(
    image: Any,
    scene: Scene | str | Path,
    *,
    exposure: bool = False,
    starts: int = 4,
    antialias: str = "edges",
    progress: Callable[[int], Any] | None = None,
) -> SunFit:
    """The direction of the sun in a picture of `scene`, whose own sun does not matter but for its colour.

    image: display values in [0, 1], an array (height, width, 3) of at least 16 x 16 pixels, or an image file.
    exposure: whether to find the film's exposure as well.
    starts: how many of the best of the directions that are looked at first are followed.
    antialias: "none" shows what the derivative is worth that does not see edges move.
    progress: called with the number of steps done; there are `steps_of(starts)`.

    Raises:
        InputError: the image or an argument is no such thing; the scene has nothing that the sun shows on.
    """
    target = _checked(image)
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    check_scene(scene)
    if not isinstance(starts, int) or not 1 <= starts <= LOOKED_AT:
        raise InputError(f"starts: must be a whole number from 1 to {LOOKED_AT}, found {starts!r}")
    step = progress or (lambda done: None)

    courses = []
    for direction, stops in _first_looks(shrunk(target, coarse(target.shape[1::-1], SMALL)), scene, exposure, starts):
        courses.append(Descent(target, scene, exposure, antialias, direction, stops))
        courses[-1].by_adam(ADAM_STEPS, step)
    courses.sort(key=lambda course: course.losses[-1])
    best = courses[0]
    best.by_gauss_newton(LAST_STEPS // 2, step)
    sampling = best.sampling()
    best.by_gauss_newton(LAST_STEPS // 2, step, sampling)
    best.by_looking_around(LOOKS_AROUND, sampling)
    azimuth, elevation = map(float, sun_angles(best.direction))
    return SunFit(
        direction=best.direction,
        azimuth=azimuth,
        elevation=elevation,
        exposure=float(best.stops),
        residual=math.sqrt(best.losses[-1]),
        uncertainty=best.uncertainty,
        history=tuple(course.told() for course in courses),
    )


def steps_of(starts: int) -> int:
    """How many steps `fit_sun` takes."""
    return starts * ADAM_STEPS + LAST_STEPS


def fitted_scene(scene: Scene, fit: SunFit) -> Scene:
    """The scene with the sun, and the exposure, that was found."""
    return moved(scene, fit.direction, fit.exposure)


def _checked(image: Any) -> np.ndarray:
    if isinstance(image, str | Path):
        image = read_image(image)
    image = np.asarray(image)
    if image.dtype == np.uint8:
        image = image / 255
    if image.ndim != 3 or image.shape[2] not in (3, 4) or min(image.shape[:2]) < 16:
        raise InputError(f"image: must be an array (height, width, 3), 16 x 16 at least, found shape {image.shape}")
    image = np.asarray(image[..., :3], np.float32)
    if not np.isfinite(image).all():
        raise InputError("image: has values that are no numbers")
    return image


def _first_looks(small: np.ndarray, scene: Scene, exposure: bool, starts: int) -> list[tuple[np.ndarray, float]]:
    """The best directions, and exposures, of those that are looked at: evenly spread over the upper hemisphere."""
    size = small.shape[1], small.shape[0]
    known = scene.sun.direction, float(scene.film.exposure)
    films = {stops: film_of(moved(scene, known[0], stops)) for stops in (EXPOSURES if exposure else known[1:])}
    found = []
    for k in range(LOOKED_AT):
        height = (k + 0.5) / LOOKED_AT
        direction = sun_direction(k * 180 * (3 - math.sqrt(5)), math.degrees(math.asin(height)))
        linear = np.asarray(render(moved(scene, direction, known[1]), size, output="linear"), np.float64)
        for stops, film in films.items():
            found.append((float(np.mean((developed(linear, *film) - small) ** 2)), direction, stops))
    found.sort(key=lambda entry: entry[0])
    if len({loss for loss, _, _ in found}) <= len(films):
        raise InputError("scene: nothing that is seen of it depends on the sun")
    chosen: list[tuple[np.ndarray, float]] = []
    for _, direction, stops in found:
        if all(direction @ other < math.cos(math.radians(APART)) for other, _ in chosen):
            chosen.append((direction, stops))
        if len(chosen) == starts:
            break
    return chosen
