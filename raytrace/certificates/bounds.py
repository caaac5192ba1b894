"""Bounds of every pixel of an image, for every program that conforms to an error model."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from raytrace.arithmetic.intervals import REAL, ErrorModel, Interval, IntervalNamespace
from raytrace.arithmetic.intervals.paths import Paths
from raytrace.arithmetic.intervals.rounding import outward
from raytrace.cores import in_threads
from raytrace.language.control import Engine, count, running
from raytrace.language.glsl import Vec2
from raytrace.language.tree import tree_map
from raytrace.shader.camera import pixel_to_ndc
from raytrace.shader.main import main
from raytrace.shader.pixel import Frame, texture_coordinates
from raytrace.shader.uniforms import Program, Sphere, Uniforms

__all__ = ["REASONS", "Bounds", "image_bounds"]

#: The sides of a tile of pixels that are computed together, and so many of them: their planes fit into the cache.
ROWS, COLUMNS = 128, 256
TILE = ROWS * COLUMNS
#: Of a pixel whose decisions take more courses than this the hull over all decisions at once is taken.
MOST_COURSES = 64
#: A colour whose bounds are wider holds more than one of a pattern's.
SEVERAL_COLORS = 1 / 255
KEEP = ("index", "albedo", "linear", "display")
#: Why a pixel is not decided; 0 where it is.
REASONS = ("", "silhouette", "horizon", "shadow edge", "pattern edge", "too many decisions")
SILHOUETTE, HORIZON, SHADOW, PATTERN, TOO_MANY = range(1, len(REASONS))


class Bounds(NamedTuple):
    """Arrays (height, width, 3) of float64: what display and linear values may be; (height, width): `reason` by
    `REASONS`, of pixels for which the program may take different decisions, and how many `courses` they can take.
    """

    display: tuple[np.ndarray, np.ndarray]
    linear: tuple[np.ndarray, np.ndarray]
    reason: np.ndarray
    courses: np.ndarray

    def hull(self, other: "Bounds") -> "Bounds":
        """What either of two programs may give."""

        def both(a: tuple, b: tuple) -> tuple:
            return np.minimum(a[0], b[0]), np.maximum(a[1], b[1])

        reason = np.where(self.reason > 0, self.reason, other.reason)
        courses = np.maximum(self.courses, other.courses)
        return Bounds(both(self.display, other.display), both(self.linear, other.linear), reason, courses)


def image_bounds(
    uniforms: Uniforms,
    program: Program,
    frame: Frame,
    model: ErrorModel,
    done: Callable[[int], object] = lambda pixels: None,
) -> Bounds:
    """The bounds for uniforms (NumPy, float32 in value) of an image with one sample a pixel; `done` counts pixels."""
    uniforms = uniforms._replace(spheres=_without_coincident(uniforms.spheres))
    shape = (frame.height, frame.width)
    display, linear = ((np.empty((*shape, 3)), np.empty((*shape, 3))) for _ in range(2))
    bounds = Bounds(display, linear, np.zeros(shape, np.uint8), np.ones(shape, np.int32))
    run = _Program(uniforms, program, frame, model)
    pixels = np.arange(frame.width * frame.height).reshape(shape)
    tiles = [
        pixels[row : row + ROWS, column : column + COLUMNS].ravel()
        for row in range(0, frame.height, ROWS)
        for column in range(0, frame.width, COLUMNS)
    ]
    for count_of_pixels in in_threads(lambda places: _fill(bounds, run, places), tiles):
        done(count_of_pixels)
    return bounds


def _without_coincident(spheres: Sphere | None) -> Sphere | None:
    """Of equal spheres the last alone: the others are met at the same t, and the last one wins."""
    if spheres is None:
        return None
    places = np.stack([*spheres.center, spheres.radius], axis=-1)[::-1]
    _, first = np.unique(places, axis=0, return_index=True)
    kept = np.sort(len(places) - 1 - first)
    return tree_map(lambda leaf: leaf[kept], spheres)


_REAL = IntervalNamespace(REAL)


class _Program(NamedTuple):
    uniforms: Uniforms
    program: Program
    frame: Frame
    model: ErrorModel

    def __call__(self, places: np.ndarray, engine: Engine, decide: Callable | None = None) -> "_Hulls":
        """The program at the pixels of those numbers; decide: as of `IntervalNamespace`."""
        xp, frame = IntervalNamespace(self.model, decide), self.frame
        with running(engine), np.errstate(all="ignore"):
            row, column = (_REAL.given(x.astype(np.float64)) for x in divmod(places, frame.width))
            uv = texture_coordinates(column, row, Vec2(0.5, 0.5), frame)
            ndc = pixel_to_ndc(*(_interpolated(x, xp) for x in uv))
            steps = main(tree_map(xp.given, self.uniforms), self.program, ndc, KEEP)
        return _Hulls.of(steps, len(places))


def _interpolated(x: Interval, xp: IntervalNamespace) -> Interval:
    """A texture coordinate: a varying, of which nobody promises how a rasterizer computes it, or a quotient."""
    error = np.asarray(xp.model.interpolation)
    x = x + Interval(-error, error, _REAL)
    return Interval(*outward(x.low, x.high, xp.model), xp)


class _Hulls(NamedTuple):
    """Of n pixels: low and high ends of the steps kept, (n, components).

    apart: of linear light the largest of all courses' low ends, and the smallest of their high ends.
    """

    index: tuple[np.ndarray, np.ndarray]
    albedo: tuple[np.ndarray, np.ndarray]
    linear: tuple[np.ndarray, np.ndarray]
    display: tuple[np.ndarray, np.ndarray]
    apart: tuple[np.ndarray, np.ndarray]

    @classmethod
    def of(cls, steps: Any, n: int) -> "_Hulls":
        def ends(planes: Any) -> tuple[np.ndarray, np.ndarray]:
            planes = planes if isinstance(planes, tuple) else (planes,)
            low, high = (
                np.stack([np.broadcast_to(getattr(plane, end), n) for plane in planes], axis=-1)
                for end in ("low", "high")
            )
            return low, high

        linear = ends(steps.linear)
        apart = linear[0].copy(), linear[1].copy()
        return cls(ends(steps.index), ends(steps.albedo), linear, ends(steps.display), apart)

    def include(self, pixels: np.ndarray, other: "_Hulls") -> None:
        """Widens the hulls of `pixels`, which may occur several times, to hold those of `other`."""
        for (low, high), (other_low, other_high) in zip(self[:-1], other[:-1], strict=True):
            np.minimum.at(low, pixels, other_low)
            np.maximum.at(high, pixels, other_high)
        np.maximum.at(self.apart[0], pixels, other.apart[0])
        np.minimum.at(self.apart[1], pixels, other.apart[1])


def _fill(bounds: Bounds, run: _Program, places: np.ndarray) -> int:
    """Fill in the pixels of those numbers, every course that they can take (`raytrace.arithmetic.intervals.paths`)."""
    n = len(places)
    questions: dict[tuple, int] = {}
    engine = Paths(np.zeros((n, 0), np.int32), questions)
    hulls = run(places, engine, engine.decide)
    courses, too_many = np.ones(n, np.int32), np.zeros(n, bool)
    pixels, given = engine.siblings()
    while len(pixels):
        courses += np.bincount(pixels, minlength=n).astype(np.int32)
        too_many |= courses > MOST_COURSES
        kept = ~too_many[pixels]
        pixels, given = pixels[kept], given[kept]
        # Not more at a time than in the beginning.
        found = []
        for i in range(0, len(pixels), TILE):
            some = pixels[i : i + TILE]
            engine = Paths(given[i : i + TILE], questions)
            hulls.include(some, run(places[some], engine, engine.decide))
            rows, more = engine.siblings()
            found.append((some[rows], more))
        pixels, given = _joined(found)
    if too_many.any():
        hulls.include(np.flatnonzero(too_many), run(places[too_many], Engine()))
    _store(bounds, hulls, courses, too_many, places, count(run.uniforms.spheres))
    return n


def _joined(parts: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    if not parts:
        return np.zeros(0, np.int64), np.zeros((0, 0), np.int32)
    depth = max(given.shape[1] for _, given in parts)
    padded = [np.pad(given, ((0, 0), (0, depth - given.shape[1])), constant_values=-1) for _, given in parts]
    return np.concatenate([pixels for pixels, _ in parts]), np.concatenate(padded)


def _store(
    bounds: Bounds, hulls: _Hulls, courses: np.ndarray, too_many: np.ndarray, places: np.ndarray, spheres: int
) -> None:
    for name in ("display", "linear"):
        for image, end in zip(getattr(bounds, name), getattr(hulls, name), strict=True):
            image.reshape(-1, 3)[places] = end
    index_low, index_high = (end[:, 0] for end in hulls.index)
    # Two courses with different results: a step lies within the bounds.
    undecided = (hulls.apart[0] > hulls.apart[1]).any(axis=-1)
    wide_albedo = (hulls.albedo[1] - hulls.albedo[0] > SEVERAL_COLORS).any(axis=-1)
    reason = np.where(wide_albedo & (index_low == index_high), PATTERN, SHADOW)
    other_surface = np.where((index_low == -1) & (index_high >= spheres), HORIZON, SILHOUETTE)
    reason = np.where(index_low != index_high, other_surface, reason)
    # A pattern under one course, as far out as the horizon: a single bound holds all of its colours.
    reason = np.where(undecided, reason, np.where(wide_albedo & (index_low >= 0), PATTERN, 0))
    reason[too_many] = TOO_MANY
    bounds.reason.reshape(-1)[places] = reason
    bounds.courses.reshape(-1)[places] = courses
