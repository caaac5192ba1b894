"""Rays at a sphere that is far, small, grazed, or about the ray's origin."""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from raytrace.arithmetic.exact import precision
from raytrace.errors import InputError
from raytrace.shader.sphere import INTERSECTIONS, sphere_intersect
from raytrace.shader.uniforms import Sphere
from raytrace.studies.stress.arithmetics import of_floats
from raytrace.studies.stress.effort import Effort
from raytrace.studies.stress.measure import INPUT, Measurement, summary, ulps
from raytrace.studies.stress.peers import embree_sphere, mitsuba_sphere
from raytrace.studies.stress.rays import Rays, answered, everywhere, given, towards
from raytrace.studies.stress.search import climb, random_rays, rows_of

__all__ = ["COMPARED", "SphereStress", "peers"]

#: Towards the sphere, along no axis.
AWAY = np.array([0.48, -0.36, -0.8], np.longdouble)
#: Where rays start, in radii.
ORIGIN = np.array([0.1, 0.7, -0.3], np.longdouble)
#: The distance/radius at which the wrong hits of the two formulas are compared, with so many more cases.
COMPARED, MORE = 3e3, 10
#: Rays pass the centre at up to this many radii.
WIDEST = 1.5
#: How many rays climb at a time.
CLIMBERS = 400


class Implementation(NamedTuple):
    """`intersect(rays)` gives t, negative where there is no hit; rays are rounded to `dtype`."""

    name: str
    dtype: Any
    intersect: Callable[[Rays], np.ndarray]


class SphereStress:
    """All axes of the sphere; what is compiled for one is there for the next."""

    def __init__(self, effort: Effort):
        self.effort = effort
        others, _ = peers()
        self.contenders = [*_formulas(), *others]
        self.random = np.random.default_rng(effort.seed)

    def distance(self) -> Iterator[Measurement]:
        # From half a radius above the surface on, and where textbook and robust are compared.
        for ratio in sorted([*(0.5 + self.effort.decades(0, 7)), COMPARED]):
            yield from self._points("distance", ratio, self._passing(ratio))

    def radius(self) -> Iterator[Measurement]:
        for radius in self.effort.decades(-6, 6):
            yield from self._points("radius", radius, self._passing(10.0, radius))

    def offset(self) -> Iterator[Measurement]:
        for offset in self.effort.decades(0, 7):
            yield from self._points("offset", offset, self._passing(10.0, offset=offset))

    def grazing(self) -> Iterator[Measurement]:
        """Rays that meet the sphere, or miss it, at the angle's cosine times the radius from the centre."""
        sign = np.where(np.arange(self.effort.cases) % 2, 1, -1)
        for angle in self.effort.decades(-7, 0):
            passing = 1 + sign * np.longdouble(2) * np.sin(np.longdouble(angle) / 2) ** 2
            yield from self._points("grazing", angle, towards(self.random, ORIGIN, ORIGIN + 3 * AWAY, 1.0, passing))

    def inside(self) -> Iterator[Measurement]:
        yield from self._about("inside", -1)

    def outside(self) -> Iterator[Measurement]:
        yield from self._about("outside", 1)

    def search(self) -> Iterator[Measurement]:
        """Hill climbing from random rays and from rays of all other axes, by the number of steps."""
        height = 10.0 ** self.random.uniform(-8, 0)
        axes = [
            self._passing(10.0 ** self.random.uniform(0.1, 7)),
            self._passing(10.0, 10.0 ** self.random.uniform(-6, 6)),
            self._passing(10.0, offset=10.0 ** self.random.uniform(0, 7)),
            towards(
                self.random, ORIGIN, ORIGIN + 3 * AWAY, 1.0, 1 - 10.0 ** self.random.uniform(-14, 0, self.effort.cases)
            ),
            *(self._near(side, height) for side in (-1, 1)),
        ]
        known = np.concatenate([rows_of(rays)[: CLIMBERS // 10] for rays in axes])
        start = np.concatenate([known, random_rays(self.random, CLIMBERS - len(known))])
        for contender in self.contenders:
            if not contender.name.endswith("robust"):
                continue
            random = np.random.default_rng((self.effort.seed, 1))
            numbers, done = start, 0
            for steps in (self.effort.climbing // 10, self.effort.climbing):
                numbers, found = climb(contender.intersect, contender.dtype, numbers, steps - done, random)
                done = steps
                yield Measurement(
                    "search", steps, contender.name, len(numbers), None, **summary(found.ulp, found.condition)
                )

    def _about(self, axis: str, side: int) -> Iterator[Measurement]:
        """Rays from near the surface, in all directions."""
        for height in self.effort.decades(-8, 0):
            yield from self._points(axis, height, self._near(side, height))

    def _near(self, side: int, height: float) -> Rays:
        origin = ORIGIN - (1 + side * min(height, 0.999)) * AWAY
        return everywhere(self.random, origin, ORIGIN, 1.0, self.effort.cases)

    def _passing(self, ratio: float, radius: Any = 1.0, offset: float = 0.0) -> Rays:
        radius = np.longdouble(radius)
        # As likely anywhere in the disc that the rays pass through; from nearer than that, in the part that is ahead.
        widest = min(WIDEST, 0.999 * ratio)
        cases = self.effort.cases * (MORE if ratio == COMPARED else 1)
        passing = radius * widest * np.sqrt(self.random.uniform(0, 1, cases))
        origin = radius * ORIGIN + offset * np.array([0.6, 0.48, 0.64], np.longdouble)
        return towards(self.random, origin, origin + ratio * radius * AWAY, radius, passing)

    def _points(self, axis: str, x: float, rays: Rays) -> Iterator[Measurement]:
        ideal = answered(rays)
        for dtype in (np.float32, np.float64):
            rounded = given(rays, dtype)
            exact = answered(rounded)
            moved_t = np.where(exact.hit, exact.t.floats(np.longdouble), -1)
            same = ideal.decided(moved_t)
            right = same & exact.hit
            with precision():
                moved = ulps(moved_t[right], ideal.t[right], dtype)
            wrong = float(np.mean(~same))
            yield Measurement(axis, x, f"{INPUT}, {dtype.__name__}", exact.hit.size, wrong, **summary(moved))
            for contender in self.contenders:
                if contender.dtype is not dtype:
                    continue
                t = contender.intersect(rounded)
                same = exact.decided(t)
                right = same & exact.hit
                with precision():
                    errors = ulps(t[right], exact.t[right], dtype)
                fields = summary(errors, exact.condition[right])
                yield Measurement(axis, x, contender.name, t.size, float(np.mean(~same)), **fields)


def _formulas() -> list[Implementation]:
    def contender(arithmetic: Any, intersection: str) -> Implementation:
        def formula(ro: Any, rd: Any, center: Any, radius: Any) -> Any:
            return sphere_intersect(ro, rd, Sphere(center, radius, center), intersection)

        run = arithmetic.of(formula)
        return Implementation(f"{arithmetic.name} {intersection}", arithmetic.dtype, lambda rays: run(*rays))

    return [contender(arithmetic, name) for arithmetic in of_floats() for name in INTERSECTIONS]


@cache
def peers() -> tuple[list[Implementation], list[str]]:
    """The peers that are installed, and for each other a line that says what it needs."""
    found, missing = [], []
    probe = given(towards(np.random.default_rng(0), ORIGIN, ORIGIN + 3 * AWAY, 1.0, np.zeros(1)), np.float32)
    for name, intersect in (("mitsuba", mitsuba_sphere.intersect), ("embree", embree_sphere.intersect)):
        try:
            intersect(probe)
        except (InputError, ImportError) as error:
            missing.append(str(error) if isinstance(error, InputError) else f"{name}: pip install '.[bench]'")
        else:
            found.append(Implementation(f"{name} float32", np.float32, intersect))
    return found, missing
