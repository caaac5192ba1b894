"""Decisions, one after the other: where bounds leave a comparison open the program is followed both ways.

The hull over an undecided comparison is wide: of a ray that may or may not meet a sphere it would hold every distance
between -1, for a miss, and the hit's. So a pixel with an undecided comparison is computed once for each course that
its decisions can take, and each course has narrow bounds. The real program takes one of them, and what it computes is
within that one's bounds. Courses are found as they are met: where a decision is new, the pixel goes on with yes, and is
put down to be computed again with no.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from raytrace.intervals.arrays import Condition, Interval
from raytrace.intervals.culling import candidates
from raytrace.shader.control import Engine
from raytrace.shader.tree import tree_map
from raytrace.shader.uniforms import Sphere

__all__ = ["Paths"]


class Paths(Engine):
    """The engine for one array of pixels, each with the decisions that it has been given.

    given: (n, k) int8: 1 for yes and 0 for no, -1 from where a pixel's list ends.
    """

    def __init__(self, given: np.ndarray):
        self.given = given
        n = len(given)
        self.pixels = np.arange(n)
        self.met = np.zeros(n, np.int64)
        #: The new decisions: pixel and number, in the order in which they were met; all were yes.
        self.new: list[tuple[np.ndarray, np.ndarray]] = []

    def decide(self, condition: Condition) -> np.ndarray:
        """Whether the condition holds, for every pixel that it is of; those of a number for all are decided."""
        if condition.decision is None:
            holds = np.array(condition.may_hold)
            undecided = condition.may_hold & condition.may_fail
            if undecided.any():
                if holds.ndim == 0:
                    holds, undecided = (np.broadcast_to(x, self.pixels.shape).copy() for x in (holds, undecided))
                holds[undecided] = self._decisions(self.pixels[undecided])
            condition.decision = holds
        return condition.decision

    def _decisions(self, pixels: np.ndarray) -> np.ndarray:
        number = self.met[pixels]
        self.met[pixels] += 1
        known = np.full(len(pixels), -1, np.int8)
        within = number < self.given.shape[1]
        known[within] = self.given[pixels[within], number[within]]
        new = known < 0
        if new.any():
            self.new.append((pixels[new], number[new]))
        return known != 0

    def each(self, items: Any, body: Callable, start: Any, args: tuple, unroll: bool) -> Any:
        if not isinstance(items, Sphere):
            return super().each(items, body, start, args, unroll)
        state = start
        for i in candidates(*args[:2], items):
            state = body(state, int(i), tree_map(lambda leaf, i=i: leaf[i], items), *args)
        return state

    def branch(self, condition: Condition, then: Callable, other: Callable, args: tuple) -> Any:
        holds = np.broadcast_to(self.decide(condition), self.pixels.shape)
        chosen = np.flatnonzero(holds)
        if len(chosen) == holds.size:
            return then(*args)
        if len(chosen) == 0:
            return other(*args)
        rest = np.flatnonzero(~holds)
        yes, no = self._among(chosen, then, args), self._among(rest, other, args)

        def merged(a: Any, b: Any) -> Interval:
            low, high = (np.empty(holds.size, a.low.dtype) for _ in range(2))
            low[chosen], low[rest] = a.low, b.low
            high[chosen], high[rest] = a.high, b.high
            return Interval(low, high, a.xp)

        return tree_map(merged, yes, no)

    def _among(self, chosen: np.ndarray, side: Callable, args: tuple) -> Any:
        """A side of a branch for some of the pixels."""
        before, self.pixels = self.pixels, self.pixels[chosen]
        try:
            return side(*tree_map(lambda plane: plane[chosen] if plane.ndim else plane, args))
        finally:
            self.pixels = before
