"""Decisions, one after the other: where bounds leave a comparison open the program is followed both ways.

The hull over an undecided comparison is wide: of a ray that may or may not meet a sphere it would hold every distance
between -1, for a miss, and the hit's. So a pixel with an undecided comparison is computed once for each course that
its decisions can take, and each course has narrow bounds.

A decision is an answer to a question, and a question is known by its place in the program's text: the sides of the
branches around it, the numbers of the loops' items, and how many questions are asked before it in there. What a run
computes beside a pixel does not move that place: not which other pixels it has, not which spheres it leaves out, and
not which comparisons are decided without being asked about.

No course is missed. Take any program that conforms, at one pixel. To each question it has one answer (and any to a
question that it never comes to, as no number of its depends on that). A course is a set of answers. Suppose that a
course is put down all of whose answers are the program's; the empty one of the first run is. Where the run of a course
asks no new question, or gives the program's answer, yes, to each of them, every comparison in it is as in the program,
whose numbers then are within the run's bounds. Otherwise take the first new question to which the program answers no.
Up to there the run was the program's, and the course that parts there (all of the old one, yes to the new ones before,
no to this one) is put down: its answers are the program's, and one more than before. There are finitely many questions,
so that a run within whose bounds the program is comes at last.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from raytrace.arithmetic.intervals.arrays import Condition, Interval
from raytrace.arithmetic.intervals.candidates import candidates
from raytrace.language.control import Engine, count
from raytrace.language.tree import tree_map
from raytrace.shader.uniforms import Sphere

__all__ = ["Paths"]


class Paths(Engine):
    """The engine for one array of pixels, each with the answers that it has been given.

    given: (n, k) int32: a pixel's course, as 2 * question + answer (1 for yes), -1 from where it ends.
    questions: the numbers of the questions by their places; the same for all runs of some pixels, which add to it.
    """

    def __init__(self, given: np.ndarray, questions: dict[tuple, int]):
        n = len(given)
        self.pixels = np.arange(n)
        self.answers, self.length = given, (given >= 0).sum(axis=1)
        self.questions = questions
        #: The place where the text is: branches and loops around it, and how many questions were asked there.
        self.place, self.asked = (), 0
        #: The new answers, in the order in which they were given: pixels, and the place of each in its course.
        self.new: list[tuple[np.ndarray, np.ndarray]] = []

    def decide(self, condition: Condition) -> np.ndarray:
        """Return whether the condition holds, for every pixel that it is of; of a number for all, where asked, too."""
        place = (*self.place, self.asked)
        self.asked += 1
        if condition.decision is None:
            holds = condition.may_hold
            undecided = condition.may_hold & condition.may_fail
            if undecided.any():
                if undecided.size == 1:
                    undecided = np.broadcast_to(undecided, self.pixels.shape)
                holds = np.broadcast_to(holds, undecided.shape).copy()
                question = self.questions.setdefault(place, len(self.questions))
                holds[undecided] = self._answers(question, self.pixels[undecided])
            condition.decision = holds
            return holds
        return condition.decision

    def _answers(self, question: int, pixels: np.ndarray) -> np.ndarray:
        known = (self.answers[pixels] >> 1) == question
        answers = ~(known & (self.answers[pixels] & 1 == 0)).any(axis=1)
        new = pixels[~known.any(axis=1)]
        if len(new):
            at = self.length[new]
            lacking = int(at.max()) + 1 - self.answers.shape[1]
            if lacking > 0:
                self.answers = np.pad(self.answers, ((0, 0), (0, lacking)), constant_values=-1)
            self.answers[new, at] = 2 * question + 1
            self.length[new] += 1
            self.new.append((new, at))
        return answers

    def siblings(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the courses that part from those of this run: pixels (m,), and what each is given (m, k)."""
        depth = self.answers.shape[1]
        rows = np.concatenate([np.zeros(0, np.int64), *(pixels for pixels, _ in self.new)])
        last = np.concatenate([np.zeros(0, np.int64), *(at for _, at in self.new)])
        # The answers up to there, that one now no.
        given = np.where(np.arange(depth) <= last[:, None], self.answers[rows], -1)
        given[np.arange(len(rows)), last] -= 1
        return rows, given

    def each(self, items: Any, body: Callable, start: Any, args: tuple, unroll: bool) -> Any:
        # What is left out beside the rays, as in `any_sphere_intersect`, goes by number, which a box does not know.
        culled = isinstance(items, Sphere) and len(args) == 2
        numbers = candidates(body, start, items, args) if culled else range(count(items))
        state = start
        for i in map(int, numbers):
            item = tree_map(lambda leaf, i=i: leaf[i], items)
            state = self._inside(i, body, (state, i, item, *args))
        self.asked += 1
        return state

    def branch(self, condition: Condition, then: Callable, other: Callable, args: tuple) -> Any:
        holds = np.broadcast_to(self.decide(condition), self.pixels.shape)
        chosen = np.flatnonzero(holds)
        if len(chosen) == holds.size:
            return self._inside(True, then, args)
        if len(chosen) == 0:
            return self._inside(False, other, args)
        rest = np.flatnonzero(~holds)
        yes, no = self._among(chosen, True, then, args), self._among(rest, False, other, args)

        def merged(a: Any, b: Any) -> Interval:
            low, high = (np.empty(holds.size, a.low.dtype) for _ in range(2))
            low[chosen], low[rest] = a.low, b.low
            high[chosen], high[rest] = a.high, b.high
            return Interval(low, high, a.xp)

        return tree_map(merged, yes, no)

    def _among(self, chosen: np.ndarray, which: bool, side: Callable, args: tuple) -> Any:
        """Run a side of a branch for some of the pixels."""
        before, self.pixels = self.pixels, self.pixels[chosen]
        try:
            return self._inside(which, side, tree_map(lambda plane: plane[chosen] if plane.ndim else plane, args))
        finally:
            self.pixels = before

    def _inside(self, which: int, part: Callable, args: tuple) -> Any:
        """Run a part of the text whose questions have places of their own: a side of a branch, or a loop's item."""
        place, asked = self.place, self.asked
        self.place, self.asked = (*place, asked, which), 0
        try:
            return part(*args)
        finally:
            self.place, self.asked = place, asked
