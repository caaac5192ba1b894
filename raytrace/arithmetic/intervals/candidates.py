"""Spheres that some rays do not meet, whatever rounding does: they need not be looked at.

The rays are gathered in boxes, a few neighbours in each, and the search's own text is run on the boxes. A sphere that
changes nothing there changes nothing for any ray within: every operation on intervals is inclusion isotonic, which is
to say that narrower operands give an interval within that of wider ones. So to leave a sphere out changes no bound, and
no geometry of its own, which would have to be proven for every formula, is needed.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from raytrace.arithmetic.intervals.arrays import Condition, Interval
from raytrace.arithmetic.intervals.namespace import IntervalNamespace
from raytrace.language.control import Engine, count, running
from raytrace.language.tree import tree_leaves, tree_map
from raytrace.shader.uniforms import Sphere

__all__ = ["candidates"]

#: Rays in a box, more of them where there would be more than so many tests of a box and a sphere.
RAYS, TESTS = 16, 1 << 18


def candidates(body: Callable, start: Any, spheres: Sphere, rays: tuple) -> np.ndarray:
    """Return the numbers of those spheres that may change `start`, the state of a search that has found nothing.

    body: as of `raytrace.language.control.each`. A search passes over a sphere that it would not take if that were the
    first one. rays: the arguments of `body`, origins and directions: intervals of shape (n,) or ().
    """
    # The box's own decisions are none of the rays'.
    xp = IntervalNamespace(spheres.radius.model)
    n, m = max(leaf.low.size for leaf in tree_leaves(rays)), count(spheres)
    firsts = np.arange(0, n, max(RAYS, -(-n * m // TESTS)))

    def box(x: Interval) -> Interval:
        if x.ndim == 0:
            return Interval(x.low, x.high, xp)
        low, high = np.minimum.reduceat(x.low, firsts), np.maximum.reduceat(x.high, firsts)
        return Interval(low[:, None], high[:, None], xp)

    def row(x: Interval) -> Interval:
        return Interval(x.low[None, :], x.high[None, :], xp)

    def first(x: Interval | Condition) -> Interval | Condition:
        return type(x)(*_parts(x), xp)

    with running(Engine()):
        found = body(tree_map(first, start), 0, tree_map(row, spheres), *tree_map(box, rays))
    changed = np.zeros((1, m), np.bool)
    for before, after in zip(tree_leaves(start), tree_leaves(found), strict=True):
        for a, b in zip(_parts(before), _parts(after), strict=True):
            changed = changed | (a != b)
    return np.flatnonzero(changed.any(axis=0))


def _parts(x: Interval | Condition) -> tuple[np.ndarray, np.ndarray]:
    return (x.may_hold, x.may_fail) if isinstance(x, Condition) else (x.low, x.high)
