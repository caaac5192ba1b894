"""The way down from one start: Adam's steps, then Gauss's and Newton's, over an image that knows its edges."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from raytrace.inverse.shrunk import coarse, shrunk
from raytrace.inverse.slopes import moved, sun_slopes
from raytrace.rendering import render
from raytrace.scene.data import Scene
from raytrace.scene.sun import sun_angles

__all__ = ["Course", "Descent"]

#: Adam's first step, in radians, or stops.
ADAM_RATE = 0.02
#: Cauchy's distribution has 95 % of the efficiency of least squares for normal noise at this scale.
CAUCHY = 2.385
#: Radians, or stops, by which is looked around at first.
AROUND = 1e-3
#: Of so many pixels is the picture that descends; the differences of a larger image are means over them.
PIXELS = 192 * 108
#: The sides of the squares of samples that a picture's pixels may have been made of.
SAMPLINGS = (1, 2, 4, 16)


class Course(NamedTuple):
    """The way from one start: the loss (mean squared difference) and the sun's angles after each step."""

    loss: np.ndarray
    azimuth: np.ndarray
    elevation: np.ndarray


class Descent:
    """The way down from one start. The direction moves in its tangent plane, so that no angle is singular."""

    def __init__(self, image: np.ndarray, scene: Scene, exposure: bool, antialias: str, direction: Any, stops: float):
        self.image, self.scene, self.exposure, self.antialias = image, scene, exposure, antialias
        self.direction, self.stops = direction, stops
        self.size = coarse(image.shape[1::-1], PIXELS)
        self.target = shrunk(image, self.size)
        self.losses: list[float] = []
        self.angles: list[tuple[float, float]] = []
        self.uncertainty = math.inf

    def told(self) -> Course:
        azimuth, elevation = np.array(self.angles).T
        return Course(np.array(self.losses), azimuth, elevation)

    def by_adam(self, steps: int, step: Callable[[int], Any]) -> None:
        import optax

        optimizer = optax.adam(optax.cosine_decay_schedule(ADAM_RATE, steps))
        state = optimizer.init(np.zeros(2 + self.exposure))
        for _ in range(steps):
            difference, slopes = self._looked()
            gradient = 2 * slopes @ difference / difference.size
            change, state = optimizer.update(gradient, state)
            self._go(np.asarray(change, np.float64))
            step(1)

    def by_gauss_newton(self, steps: int, step: Callable[[int], Any], sampling: int | None = None) -> None:
        """Steps to where the weighted difference from the image has no slope.

        With a `sampling` the difference is that of a picture sampled so, and so has no bias where that is the image's
        own; the slopes are those of the mean over each pixel all the same.
        """
        for _ in range(steps):
            difference, slopes = self._looked(sampling)
            weighted = slopes * _weights(difference)
            change = -np.linalg.lstsq(weighted @ slopes.T, weighted @ difference, rcond=1e-9)[0]
            # A step is as far as the picture can be taken to be linear.
            self._go(change * min(1.0, 0.05 / max(np.abs(change).max(), 1e-30)))
            step(1)
        difference, slopes = self._looked(sampling)
        weights = _weights(difference)
        curvature = np.linalg.pinv((slopes * weights) @ slopes.T)
        covariance = curvature @ ((slopes * (weights * difference) ** 2) @ slopes.T) @ curvature
        self.uncertainty = math.degrees(math.sqrt(np.linalg.eigvalsh(covariance[:2, :2])[-1]))

    def by_looking_around(self, looks: int, sampling: int | None) -> None:
        """To where as few pixels as possible are off: with few samples a picture changes in jumps, which have no slope.

        Nelder's and Mead's simplex, over the logarithm of Cauchy's distribution.
        """
        from scipy.optimize import minimize

        if not sampling:
            return
        scale = _scale(self._sampled(sampling) - self.target)
        start, stops, axes = self.direction, self.stops, _tangents(self.direction)

        def loss(change: np.ndarray) -> float:
            self.direction, self.stops = start, stops
            self._go(change, axes)
            return float(np.log1p(((self._sampled(sampling) - self.target) / scale) ** 2).sum())

        corners = AROUND * np.vstack([np.full(2 + self.exposure, -0.3), np.eye(2 + self.exposure)])
        found = minimize(
            loss,
            0 * corners[0],
            method="Nelder-Mead",
            options={"initial_simplex": corners, "maxfev": looks, "xatol": 1e-6},
        )
        loss(found.x)
        self._looked(sampling)

    def sampling(self) -> int | None:
        """The side of the square of samples with which this sun's picture is nearest to the image; ``None``: means."""
        finest = SAMPLINGS[-1] * self.size[0] / self.image.shape[1]
        means = self._drawn()[0]
        pictures = {None: means, **{n: self._sampled(n) for n in SAMPLINGS if n == 1 or n <= finest}}
        return min(pictures, key=lambda n: float(np.median(np.abs(pictures[n] - self.target))))

    def _looked(self, sampling: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """What the picture here has more than the image, and its derivatives: arrays (n,) and (parameters, n)."""
        picture, slopes = self._drawn()
        if sampling:
            picture = self._sampled(sampling)
        difference = (picture - self.target).reshape(-1)
        self.losses.append(float(np.mean(difference**2)))
        self.angles.append(tuple(map(float, sun_angles(self.direction))))
        return difference, slopes.reshape(len(slopes), -1)

    def _drawn(self) -> tuple[np.ndarray, np.ndarray]:
        lit = moved(self.scene, self.direction, self.stops)
        picture, slopes = sun_slopes(lit, self.size, _tangents(self.direction), self.antialias)
        return picture, slopes[: 2 + self.exposure]

    def _sampled(self, samples: int) -> np.ndarray:
        """The picture at the image's own size, with so many samples, and then its means."""
        lit = moved(self.scene, self.direction, self.stops)
        return shrunk(np.asarray(render(lit, self.image.shape[1::-1], samples=samples)), self.size)

    def _go(self, change: np.ndarray, axes: np.ndarray | None = None) -> None:
        direction = self.direction + change[:2] @ (_tangents(self.direction) if axes is None else axes)
        self.direction = direction / np.linalg.norm(direction)
        if self.exposure:
            self.stops = float(np.clip(self.stops + change[2], -16, 16))


def _weights(difference: np.ndarray) -> np.ndarray:
    """How far to trust each value: Cauchy's weights, for differences that are much larger than most are.

    Where the picture was sampled too coarsely for the ground's pattern it has others than its mean, and darker ones.
    """
    return 1 / (1 + (difference / _scale(difference)) ** 2)


def _scale(difference: np.ndarray) -> float:
    """The scale of Cauchy's distribution for noise as large as most of the differences are."""
    return CAUCHY * max(1.4826 * float(np.median(np.abs(difference))), 1e-6)


def _tangents(direction: np.ndarray) -> np.ndarray:
    """Two unit vectors (2, 3) across a unit vector."""
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])
