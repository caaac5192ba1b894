"""What the documentation promises, and whether a run keeps it."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from raytrace.studies.stress.measure import INPUT, Measurement
from raytrace.studies.stress.planes import TILE
from raytrace.studies.stress.spheres import COMPARED

__all__ = ["BOUNDS", "Limit", "Verdict", "verdicts"]

SPHERES = ("distance", "radius", "offset", "grazing", "inside", "outside", "search")
#: The roundings of `robust_roots`, each as large as it may be and all in the worst direction, add up to 6.3 times the
#: condition number, at far spheres. A search finds about half of that, as they seldom all add up.
ROBUST = 8
CAMERAS = ("narrow_view", "wide_view", "near_far", "camera_matrix")
#: A unit in the last place just below 1 is the unit roundoff. The products of matrices err by 4 and 3 of them in
#: |M| |P| |p|, normalising by 4 more of the result; the condition number counts either three times.
CAMERA = 4
#: Unit roundoff, and the smallest number for which the powers are meant, in each arithmetic.
EPS = {"float32": 2.0**-24, "float64": 2.0**-53}
SMALLEST = 1e-36


class Limit(NamedTuple):
    """`statement` is what is promised; `measured` gives the worst that was found, ``None`` if nothing was tried."""

    statement: str
    measured: Callable[[list[Measurement]], float | None]
    at_most: float


class Verdict(NamedTuple):
    statement: str
    found: float
    at_most: float

    @property
    def holds(self) -> bool:
        return bool(self.found <= self.at_most)


def verdicts(points: Iterable[Measurement]) -> list[Verdict]:
    """Each bound of which something was tried."""
    points = [point for point in points if not point.who.startswith(INPUT)]
    found = ((bound, bound.measured(points)) for bound in BOUNDS)
    return [Verdict(bound.statement, worst, bound.at_most) for bound, worst in found if worst is not None]


def _worst(
    value: Callable[[Measurement], float | None],
    *axes: str,
    who: str = "",
    low: float = 0,
    high: float = float("inf"),
) -> Callable[[list[Measurement]], float | None]:
    """The largest `value` of the points of those axes whose `who` has all the words, for x from `low` to `high`."""

    def measured(points: list[Measurement]) -> float | None:
        chosen = (
            value(point)
            for point in points
            if point.axis in axes
            and low <= point.x <= high
            and set(who.split()) <= set(point.who.split())
            and point.who.split()[0] in ("numpy", "jax")
        )
        return max((number for number in chosen if number is not None), default=None)

    return measured


def _wrong(point: Measurement) -> float | None:
    return point.wrong


def _ulp(point: Measurement) -> float | None:
    return point.ulp


def _of_the_smallest(point: Measurement) -> float | None:
    return None if point.ulp is None else point.ulp * 2.0**-23


def _conditioned(point: Measurement) -> float | None:
    return point.conditioned


def _beside_textbook(points: list[Measurement]) -> float | None:
    """The largest share of wrong decisions of robust in float32, over that of textbook on the same backend."""
    compared = [point for point in points if point.axis == "distance" and point.x == COMPARED]
    shares = {point.who: point.wrong for point in compared if point.wrong is not None}
    backends = [who.split()[0] for who in shares if who.endswith("float32 textbook")]
    ratios = [shares[f"{name} float32 robust"] / shares[f"{name} float32 textbook"] for name in backends]
    return max(ratios, default=None)


def _tiles(point: Measurement) -> float | None:
    """The share of wrong tiles over roundoff times the number of tiles up to there."""
    dtype = next(name for name in EPS if name in point.who)
    return None if point.wrong is None else point.wrong / (EPS[dtype] * point.x / TILE)


BOUNDS = (
    Limit(
        "robust: the error of t, in ULP, over the condition number (all axes of the sphere, search)",
        _worst(_conditioned, *SPHERES, who="robust"),
        ROBUST,
    ),
    Limit("robust float32, distance/radius 3e3: wrong decisions over textbook's", _beside_textbook, 1e-3),
    Limit(
        "robust float32: wrong decisions, distance/radius up to 1e4",
        _worst(_wrong, "distance", who="robust float32", high=1.1e4),
        2e-3,
    ),
    Limit(
        "robust float64: wrong decisions, distance/radius up to 1e7",
        _worst(_wrong, "distance", who="robust float64"),
        1e-3,
    ),
    Limit(
        "robust: wrong decisions, radius 1e-6 to 1e6, scene up to 1e7 from the origin",
        _worst(_wrong, "radius", "offset", who="robust"),
        2e-3,
    ),
    Limit(
        "camera: the error of a ray's direction or origin, in ULP of 1, over the condition number",
        _worst(_conditioned, *CAMERAS),
        CAMERA,
    ),
    Limit("plane: the error of t, in ULP, over the condition number", _worst(_conditioned, "plane"), 2),
    Limit("plane: wrong decisions, angle 1e-6 and more", _worst(_wrong, "plane", low=0.9e-6), 0),
    Limit(
        "checkerboard: wrong tiles over roundoff times distance/tile, up to 1e6",
        _worst(_tiles, "checkerboard", high=1.1e6, low=0.9e5),
        4,
    ),
    Limit("x^(1/2.2), float32, x from 1e-36: error in ULP", _worst(_ulp, "gamma", who="float32", low=SMALLEST), 64),
    Limit("x^(1/4), float32, x from 1e-36: error in ULP", _worst(_ulp, "sky_gradient", who="float32", low=SMALLEST), 1),
    Limit("x^2400, float32, normal results: error in ULP", _worst(_ulp, "sun_lobe", who="float32"), 160),
    # 2^23 units of the last place of the smallest normal number are that number.
    Limit(
        "x^2400, float32, results below 1.18e-38: error in smallest normal numbers",
        _worst(_of_the_smallest, "lobe_vanishes", who="float32"),
        1,
    ),
    Limit(
        "film, float32, linear light from 1e-36 to 1e38: error in ULP",
        _worst(_ulp, "tone_mapping", who="float32", low=SMALLEST),
        96,
    ),
    Limit(
        "normalisation, lengths 1e-30 to 1e38: error in ULP of 1",
        _worst(_ulp, "normalization", low=0.9e-30),
        3,
    ),
    Limit("the sun's direction, lengths 1e-20 to 1e20: error in ULP of 1", _worst(_ulp, "sun"), 3),
    Limit(
        "shadow_start surface, every scale: dark pixels that are lit, or lit ones that are dark",
        _worst(_wrong, "acne", "peter_panning", who="surface"),
        3e-3,
    ),
)
