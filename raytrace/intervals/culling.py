"""Spheres that none of some rays can meet, whatever rounding does to the program's own test.

All rays lie in two boxes, of their origins and of their directions. For every sphere the discriminant of all lines of
the boxes is bounded in real arithmetic, and the sphere is left out where it is negative by more than any program can
err.

How much that is: let u = 2**-23 be what one operation may err relatively (either neighbour of the exact result, in
float32), D the distance of origin and centre, r the radius. A difference of origin and centre errs by u D; a scalar
product of three terms by 5 u more, so b by 7 u D, and b * b by 15 u D**2; c = D**2 - r**2 by 8 u D**2 + 2 u r**2; their
difference by 26 u (D**2 + r**2) in all. The direction's length may be off by 8 u, which moves b * b by 16 u D**2.
`SLACK` is 64 u. The robust formula errs by less: its terms are no larger than the textbook's.
"""

from typing import Any

import numpy as np

from raytrace.intervals.arrays import Interval
from raytrace.intervals.errors import REAL
from raytrace.intervals.namespace import Namespace
from raytrace.shader.glsl import Vec3, dot
from raytrace.shader.tree import tree_map
from raytrace.shader.uniforms import Sphere

__all__ = ["candidates"]

SLACK = 2.0**-17
_XP = Namespace(REAL)


def candidates(ro: Vec3, rd: Vec3, spheres: Sphere) -> np.ndarray:
    """The numbers of those spheres that any of the rays may meet; ro and rd are of intervals, of any shape."""
    origin, direction, geometry = tree_map(_box, ro), tree_map(_box, rd), (spheres.center, spheres.radius)
    center, radius = tree_map(lambda x: Interval(x.low, x.high, _XP), geometry)
    out = origin - center
    distance, square = dot(out, out), radius * radius
    nearest = out - dot(out, direction) * direction
    clearance = dot(nearest, nearest) - square
    missed = clearance.low > SLACK * (distance.high + square.high)
    return np.flatnonzero(~missed)


def _box(x: Any) -> Interval:
    """From the smallest to the largest, a number of shape ()."""
    return Interval(x.low.min(), x.high.max(), _XP)
