"""Rays that graze a plane, and a pattern that is seen far out."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from raytrace.arithmetic.exact import precision
from raytrace.language.glsl import Vec3, dot
from raytrace.language.tree import tree_map
from raytrace.shader.checkerboard import checkerboard
from raytrace.shader.plane import plane_intersect
from raytrace.studies.stress.arithmetics import exactly, of_floats
from raytrace.studies.stress.effort import Effort
from raytrace.studies.stress.measure import INPUT, Measurement, summary, ulps

__all__ = ["PlaneStress"]

TILE = 0.7


class PlaneStress:
    """A tilted plane at grazing incidence; the checkerboard."""

    def __init__(self, effort: Effort):
        self.effort = effort
        self.random = np.random.default_rng((1, effort.seed) if effort.seed else 1)
        arithmetics = of_floats()
        self.planes = [(a.name, a.dtype, a.of(plane_intersect)) for a in arithmetics]
        self.patterns = [(a.name, a.dtype, a.of(_parity)) for a in arithmetics]

    def plane(self) -> Iterator[Measurement]:
        for angle in self.effort.decades(-7, 0):
            problem = self._grazing(angle)
            for dtype in (np.float32, np.float64):
                args = tree_map(lambda x, dtype=dtype: x.astype(dtype), problem)
                exact, condition = exactly(plane_intersect, *args), _condition(*args)
                with precision():
                    met = (exact > 0).value
                    ideal = exactly(plane_intersect, *problem)
                    same = (ideal > 0).value == met
                    moved = ulps(exact[same & met].floats(np.longdouble), ideal[same & met], dtype)
                who = f"{INPUT}, {dtype.__name__}"
                yield Measurement("plane", angle, who, met.size, float(np.mean(~same)), **summary(moved))
                for name, its_dtype, intersect in self.planes:
                    if its_dtype is dtype:
                        t = intersect(*args)
                        seen = (t > 0) & (t < np.inf)
                        right = seen & met
                        with precision():
                            errors = ulps(t[right], exact[right], dtype)
                        wrong = float(np.mean(seen != met))
                        yield Measurement("plane", angle, name, met.size, wrong, **summary(errors, condition[right]))

    def checkerboard(self) -> Iterator[Measurement]:
        for distance in self.effort.decades(0, 9):
            x, z = distance * self.random.uniform(0.5, 1, (2, self.effort.cases)).astype(np.longdouble)
            ideal = exactly(_parity, x, z, np.longdouble(TILE)).floats()
            for dtype in (np.float32, np.float64):
                args = tuple(np.asarray(number).astype(dtype) for number in (x, z, TILE))
                exact = exactly(_parity, *args).floats()
                wrong = float(np.mean(exact != ideal))
                yield Measurement("checkerboard", distance, f"{INPUT}, {dtype.__name__}", x.size, wrong)
                for name, its_dtype, parity in self.patterns:
                    if its_dtype is dtype:
                        wrong = float(np.mean(parity(*args) != exact))
                        yield Measurement("checkerboard", distance, name, x.size, wrong)

    def _grazing(self, angle: float) -> tuple:
        """(ro, rd, n, p): rays from one above a tilted plane, half of them down to it by the angle, half of them up."""
        n = np.array([0.36, 0.8, -0.48], np.longdouble)
        along = np.array([0.8, -0.36, 0.0], np.longdouble) / np.sqrt(np.longdouble(0.7696))
        across = np.cross(n, along)
        around = self.random.uniform(0, 2 * np.pi, self.effort.cases).astype(np.longdouble)[:, None]
        sign = np.where(np.arange(self.effort.cases) % 2, 1, -1)[:, None]
        flat = np.cos(around) * along + np.sin(around) * across
        rd = np.cos(np.longdouble(angle)) * flat + sign * np.sin(np.longdouble(angle)) * n
        p = np.array([0.3, -0.5, 0.2], np.longdouble)
        return tuple(Vec3(*np.moveaxis(v, -1, 0)) for v in (p + n + 3 * along, rd, n, p))


def _parity(x: Any, z: Any, tile_size: Any) -> Any:
    """0 and 1 for the tiles' colours, 2 for the middle lines."""
    colors = (Vec3(*(x * 0 + color,) * 3) for color in (0.0, 1.0, 2.0))
    return checkerboard(Vec3(x, x * 0, z), tile_size, *colors).x


def _condition(ro: Vec3, rd: Vec3, n: Vec3, p: Vec3) -> np.ndarray:
    """Sum of the relative changes of t for relative changes of each number."""
    wide = [tree_map(lambda x: x.astype(np.longdouble), v) for v in (ro, rd, n, p)]
    ro, rd, n, p = wide
    distance, approach = np.abs(dot(p - ro, n)), np.abs(dot(rd, n))
    size = (tree_map(np.abs, v) for v in wide)
    o, d, m, q = size
    with np.errstate(all="ignore"):
        condition = 2 * dot(q + o, m) / distance + 2 * dot(d, m) / approach
    return np.where(np.isfinite(condition), condition, np.inf).astype(np.float64)
