"""Rays at a sphere: problems of any difficulty, and their exact answers."""

from typing import Any, NamedTuple

import numpy as np

from raytrace.arithmetic.exact import Exact, precision
from raytrace.language.glsl import Vec3, dot
from raytrace.language.tree import tree_map

__all__ = ["ExactHit", "Rays", "answered", "given", "towards"]


class Rays(NamedTuple):
    """n rays and one sphere, longdouble or rounded to some arithmetic; leaves of shape (n,) or ()."""

    origin: Vec3
    direction: Vec3
    center: Vec3
    radius: Any


class ExactHit(NamedTuple):
    """Whether each ray meets the sphere at t >= 0, where, and how that depends on the numbers given.

    other: the root that does not count.
    condition: sum of the relative changes of t for relative changes of each number, at least 1.
    """

    hit: np.ndarray
    t: Exact
    other: Exact
    condition: np.ndarray

    def decided(self, t: np.ndarray) -> np.ndarray:
        """Whether answers t, negative for a miss, are the same decision: hit or miss, and which of the two roots."""
        right, wrong = self.t.floats(), self.other.floats()
        same_root = np.abs(t - right) <= np.abs(t - wrong)
        return ((t >= 0) == self.hit) & (same_root | ~self.hit)


def given(rays: Rays, dtype: Any) -> Rays:
    """The rays as a program in `dtype` is given them."""
    return tree_map(lambda x: np.asarray(x).astype(dtype), rays)


def answered(rays: Rays) -> ExactHit:
    """The exact answer, of the numbers as they are: the direction's length too, though it is only nearly 1.

    The geometric definition, not the shader's formula: the roots of |origin + t * direction - center| = radius, of
    which the nearer counts, or the farther where the nearer is behind the origin.
    """
    with precision():
        exact = tree_map(Exact.of, rays)
        out = exact.origin - exact.center
        a, b = dot(exact.direction, exact.direction), dot(out, exact.direction)
        c = dot(out, out) - exact.radius * exact.radius
        discriminant = b * b - a * c
        meets = (discriminant >= 0).value
        xp = discriminant.__array_namespace__()
        root = xp.sqrt(xp.maximum(discriminant, Exact.of(0.0)))
        nearer, farther = (-b - root) / a, (-b + root) / a
        behind = nearer < 0
        t, other = xp.where(behind, farther, nearer), xp.where(behind, nearer, farther)
        hit = meets & (t >= 0).value
        # The unit normal where the ray meets the sphere, times the direction: (out + t direction) . direction / radius.
        incidence = root / exact.radius
        normal = tree_map(lambda x: x.floats(np.longdouble), (out + t * exact.direction) / exact.radius)
    return ExactHit(hit, t, other, _condition(rays, t.floats(np.longdouble), normal, incidence.floats(np.longdouble)))


def _condition(rays: Rays, t: np.ndarray, normal: Vec3, incidence: np.ndarray) -> np.ndarray:
    origin, direction, center = (tree_map(np.asarray, v) for v in (rays.origin, rays.direction, rays.center))
    with np.errstate(all="ignore"):
        moved = np.asarray(rays.radius).astype(np.longdouble)
        for n, o, d, c in zip(normal, origin, direction, center, strict=True):
            moved = moved + np.abs(n) * (np.abs(o) + np.abs(c) + np.abs(t * d))
        condition = moved / (incidence * np.abs(t))
    return np.maximum(np.where(np.isnan(condition), np.inf, condition), 1).astype(np.float64)


def towards(
    random: np.random.Generator, origin: np.ndarray, center: np.ndarray, radius: Any, passing: np.ndarray
) -> Rays:
    """Rays from `origin` that pass the centre at distances `passing` (n,), in all directions around it."""
    origin, center = (np.asarray(x, np.longdouble) for x in (origin, center))
    axis = center - origin
    distance = np.sqrt(axis @ axis)
    axis = axis / distance
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side = side / np.sqrt(side @ side)
    around = random.uniform(0, 2 * np.pi, passing.shape).astype(np.longdouble)
    sine = passing / distance
    cosine = np.sqrt(1 - sine * sine)
    away = np.cos(around)[:, None] * side + np.sin(around)[:, None] * np.cross(axis, side)
    return _rays(origin, cosine[:, None] * axis + sine[:, None] * away, center, radius)


def everywhere(random: np.random.Generator, origin: np.ndarray, center: np.ndarray, radius: Any, n: int) -> Rays:
    """`n` rays from `origin` in random directions."""
    directions = random.normal(size=(n, 3)).astype(np.longdouble)
    return _rays(origin, directions / np.sqrt((directions**2).sum(axis=1))[:, None], center, radius)


def _rays(origin: Any, directions: np.ndarray, center: Any, radius: Any) -> Rays:
    numbers = (np.asarray(x, np.longdouble) for x in (origin, directions, center))
    vectors = (Vec3(*np.moveaxis(x, -1, 0)) for x in numbers)
    start, towards, middle = vectors
    return Rays(start, towards, middle, np.longdouble(radius))
