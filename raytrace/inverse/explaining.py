"""Suns that explain a picture: from the guesses to the posterior, with what is left over."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from raytrace.inverse.blocks import SIDE, Blocks
from raytrace.inverse.descent import descended, widened
from raytrace.inverse.likelihood import Noise, noise_of
from raytrace.inverse.mismatch import Mismatch
from raytrace.inverse.picture import EDGES, Target, coarse, shrunk
from raytrace.inverse.posterior import Chart, Posterior, Stage, approach, degrees_between, sampled
from raytrace.inverse.relit import Relit
from raytrace.inverse.search import EXPOSURES, Guess, search
from raytrace.inverse.slopes import moved, sun_slopes
from raytrace.scene.sun import sun_angles

__all__ = ["Course", "End", "explained"]

#: Pixels of the picture in which the sun is sought first, and samples by which it is compared then, at the most.
SEARCHED, COMPARED = 1 << 12, 1 << 17
#: The largest picture of means over pixels; a larger one is shrunk to it.
LARGEST = 1920 * 1080
#: What is tried where a picture does not say how its pixels were made. At edges that decides everything: a third of the
#: pixels of a small picture are far off under another sampling than their own.
SAMPLINGS = (1, 2, 4, EDGES)
#: The standard deviations of the suns around a guess, in radians, and in stops.
AROUND = (0.01, 0.01, 0.25)
#: Another guess is followed if its picture is nearly as probable: a difference of logarithms where the noise is NOISY.
FOLLOWED, NOISY = 25.0, 0.05
#: Two suns explain a picture equally if the logarithms of its probability differ by no more than this.
EQUAL = 10.0
#: So often the picture is taken to be linear around another sun, until that is so near, in radians.
ROUNDS, NEAR = 4, 1e-4
#: Suns nearer than this, in degrees, are one.
ONE = 2.5


class Course(NamedTuple):
    """The way from one guess: the mean squared difference and the sun's angles in degrees after each step, (n,)."""

    loss: np.ndarray
    azimuth: np.ndarray
    elevation: np.ndarray


@dataclass(frozen=True)
class End:
    """An explanation of a picture.

    posterior: the likely suns, as changes of `chart`. mismatch, residual: what is left over, and the root of its mean
    square. sampling: how the pixels are made. courses: of all guesses that were followed, the best first. others: suns
    (3,) elsewhere that explain the picture equally well.
    """

    chart: Chart
    posterior: Posterior
    noise: Noise
    mismatch: Mismatch
    residual: float
    sampling: int | str
    courses: tuple[Course, ...]
    others: tuple[np.ndarray, ...]


class _Way(NamedTuple):
    """Where a guess leads to: the stage from which to sample, and the suns that were drawn last."""

    chart: Chart
    stage: Stage
    drawn: Posterior
    noise: Noise
    course: list[tuple[float, np.ndarray]]


def explained(
    target: Target, exposure: bool, starts: int, made: int | str | None, only: bool, step: Callable[[int], Any]
) -> End:
    """Return the best explanation of a picture with pixels that were made so; if that does not fit, with others.

    exposure: whether it changes too. starts: how many guesses are followed at the most. made: n for n x n samples,
    `EDGES` or, if it is unknown, ``None``. only: nothing else is tried. step: called with 1 after each step.
    """
    fitting = _Fitting(target, exposure, step)
    guesses = search(fitting.relit(1, SEARCHED), EXPOSURES if exposure else (float(target.scene.film.exposure),))
    first = made or SAMPLINGS[0]
    found: list[End] = []
    for sampling in (first,) if only else dict.fromkeys((first, *SAMPLINGS)):
        # Another sampling of the right picture has the same best guess.
        found.append(fitting.followed(sampling, guesses[: starts if sampling == first else 1]))
        if found[-1].mismatch.fits:
            return found[-1]
    return max(found, key=lambda end: (end.mismatch.explained, -end.mismatch.far))


class _Fitting:
    """The picture, and what all its explanations share."""

    def __init__(self, target: Target, exposure: bool, step: Callable[[int], Any]):
        self.target, self.exposure, self.step = target, exposure, step
        self.size = target.values.shape[1::-1]
        self.random = np.random.default_rng(0)

    def relit(self, samples: int, most: int) -> Relit:
        """Return the picture with `samples` x `samples` samples a pixel, or blocks of it with `most` in all."""
        blocks = Blocks.of(self.size, max(1, most // (SIDE * samples) ** 2))
        return Relit(self.target.scene, self.target.values, samples, blocks)

    def followed(self, sampling: int | str, guesses: list[Guess]) -> End:
        """Return what the guesses lead to, the best of which is the first."""
        relit = self.relit(sampling if isinstance(sampling, int) else SAMPLINGS[0], COMPARED)
        ways: list[_Way] = []
        for guess in guesses:
            scale = max(1.0, ways[0].noise.sigma / NOISY) ** 2 if ways else 1.0
            if guess.log < guesses[0].log - FOLLOWED * scale:
                break
            if all(degrees_between(guess.direction, way.chart.sun(way.drawn.best)[0]) > ONE for way in ways):
                ways.append(self.followed_one(guess, relit))
        noise = min((way.noise for way in ways), key=lambda noise: noise.sigma)
        suns = [way.chart.sun(way.drawn.best) for way in ways]
        logs = [float(relit.log_likelihoods(sun[None], np.array([stops]), noise)[0]) for sun, stops in suns]
        first = int(np.argmax(logs))
        others = tuple(
            sun
            for (sun, _), log in zip(suns, logs, strict=True)
            if log > logs[first] - EQUAL and degrees_between(sun, suns[first][0]) > ONE
        )
        courses = (ways[first].course, *(way.course for way in ways if way is not ways[first]))
        if sampling == EDGES:
            return self.descended(ways[first], courses, others)
        return self.sampled(ways[first], relit, courses, others)

    def followed_one(self, guess: Guess, relit: Relit) -> _Way:
        """Return what one guess leads to: by least squares, which do not see shadows move, and then by draws."""
        linear = descended(
            relit.slopes, relit.target, self.target.half, relit.blocks, guess[:2], self.exposure, self.step
        )
        chart, start, course = linear.chart, linear.around(), linear.course
        if degrees_between(guess.direction, chart.direction) > ONE:
            chart, start = (
                Chart.around(*guess[:2]),
                Stage(0 * start.mean, np.diag(np.square(AROUND[: 2 + self.exposure]))),
            )

        def noise_at(change: np.ndarray) -> Noise:
            sun = chart.sun(change)
            values, target = (part[relit.blocks.inside] for part in (relit.values(*sun), relit.target))
            course.append((float(np.mean((target - values) ** 2)), sun[0]))
            self.step(1)
            return noise_of(target, values, self.target.half)

        stage, drawn, noise = approach(
            lambda changes, noise: relit.log_likelihoods(*chart.suns(changes), noise), noise_at, start, self.random
        )
        return _Way(chart, stage, drawn, noise, course)

    def sampled(self, way: _Way, relit: Relit, courses: tuple, others: tuple) -> End:
        """Return the explanation by a picture of samples, whose probability is known exactly."""

        def end(posterior: Posterior) -> End:
            values = relit.values(*way.chart.sun(posterior.best))
            return self.end(way.chart, posterior, way.noise, relit, values, relit.samples, courses, others)

        rough = end(way.drawn)
        if rough.mismatch.hopeless:
            return rough
        return end(
            sampled(lambda changes: relit.log_likelihoods(*way.chart.suns(changes), way.noise), way.stage, self.random)
        )

    def descended(self, way: _Way, courses: tuple, others: tuple) -> End:
        """Return the explanation by a picture of means, which is linear in the sun around the least squares."""
        size = coarse(self.size, LARGEST)
        target = shrunk(self.target.values, size)
        half = self.target.half if size == self.size else 0.0
        blocks = Blocks.of(size, size[0] * size[1])

        def draw(direction: np.ndarray, stops: float, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            values, slopes = sun_slopes(moved(self.target.scene, direction, stops), size, axes, "edges")
            return blocks.values(values), np.stack([blocks.values(slope) for slope in slopes])

        start = way.chart.sun(way.drawn.best)
        linear = descended(draw, blocks.values(target), half, blocks, start, self.exposure, self.step)
        for _ in range(ROUNDS):
            stage, drawn, _ = approach(
                lambda changes, noise, linear=linear: linear.log_likelihoods(changes),
                lambda change, linear=linear: linear.noise,
                linear.around(),
                self.random,
            )
            linear = linear.moved(draw, drawn.best)
            if np.abs(drawn.best).max() < NEAR:
                break
        posterior = sampled(linear.log_likelihoods, stage._replace(mean=stage.mean - drawn.best), self.random)
        posterior = widened(posterior, linear.clustered())
        courses = (courses[0] + linear.course, *courses[1:])
        return self.end(linear.chart, posterior, linear.noise, linear, linear.values, EDGES, courses, others)

    def end(
        self, chart: Chart, posterior: Posterior, noise: Noise, model: Any, values: np.ndarray, sampling: int | str,
        courses: tuple, others: tuple,
    ) -> End:  # fmt: skip
        """Return the explanation with what is left over where the picture has `values`."""
        inside = model.blocks.inside
        return End(
            chart,
            posterior,
            noise,
            Mismatch.of(model.target, values, inside, noise.half),
            float(np.sqrt(np.mean((model.target - values)[inside] ** 2))),
            sampling,
            tuple(map(_course, courses)),
            others,
        )


def _course(steps: list[tuple[float, np.ndarray]]) -> Course:
    angles = np.array([sun_angles(sun) for _, sun in steps])
    return Course(np.array([loss for loss, _ in steps]), *angles.T)
