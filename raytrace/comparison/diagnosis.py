"""Which of the usual mistakes, made in A, gives B.

The rule: a mistake is named only where it explains at least 9/10 of the squared difference over 1/255 and leaves fewer
than half of the pixels over 1/255; of several, the one that explains most, then the one with the least RMSE. What 8
bits round is so left out. The few pixels in which two engines differ are no mistake, since every mistake changes the
whole image. In images under 11 x 11 none is sought.

Half a pixel's shift of a sharp image cannot be told from its pixels alone: that needs the scene.
"""

from collections.abc import Callable
from functools import partial
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np

from raytrace.comparison.develop import film_of
from raytrace.comparison.metrics import LEVEL, WINDOW, pixels_over, rmse
from raytrace.comparison.reference import Reference
from raytrace.comparison.wrong_films import channel_mistakes, film_mistakes
from raytrace.comparison.wrong_views import WrongView, resampled, views
from raytrace.scene import Scene

__all__ = ["Diagnosis", "diagnosis"]

#: Of the squared difference over 1/255, at least.
_EXPLAINED = 0.9
#: Of the pixels over 1/255, fewer.
_LEFT = 0.5
#: Of the image, at least: what a shift or a rescaled image does not reach is left out on both sides.
_REACHED = 0.5
#: The mistakes are ranked by about so many pixels, in rows and columns at equal distances; the best few by all.
_RANKED = 1 << 17
_WEIGHED = 3
#: Of the squared difference between A and B, at most, is between A and its scene: then A is the scene's image.
_SAME = 0.05


class Diagnosis(NamedTuple):
    """A mistake of an image.

    mistake: as it follows "this is", such as "flipped top to bottom (y)".
    explained: the share of the squared difference over 1/255 that the mistake explains.
    rmse, over: the RMSE and the number of pixels over 1/255, before and after A is given the mistake too, where A
        with the mistake is known.
    name: the image's.
    """

    mistake: str
    explained: float
    rmse: tuple[float, float]
    over: tuple[int, int]
    name: str = "B"

    @property
    def sentence(self) -> str:
        """Return the mistake as a sentence: "mine.png has no tone mapper"."""
        for words, verb in (("without the ", "has no "), ("without ", "has no "), ("with ", "has ")):
            if self.mistake.startswith(words):
                return f"{self.name} {verb}{self.mistake.removeprefix(words)}"
        return f"{self.name} is {self.mistake}"

    def __str__(self) -> str:
        return (
            f"{self.sentence}: explains {100 * self.explained:.1f} % of the squared difference over 1/255; "
            f"RMSE {self.rmse[0]:.4g} -> {self.rmse[1]:.4g}, pixels over 1/255 {self.over[0]} -> {self.over[1]}"
        )


def diagnosis(a: np.ndarray, b: np.ndarray, reference: Reference | None) -> Diagnosis | None:
    """The mistake that explains how `b` differs from `a`, display values both; ``None`` if none of them does.

    reference: the scene, if one is known. Where `a` is its image, what lies between the pixels of `a` is rendered
        instead of interpolated, and light that the film clips is known.
    """
    if min(a.shape[:2]) < WINDOW:
        return None
    if reference is None:
        film, program = film_of(Scene())
    else:
        film, program = film_of(reference.scene)
        if not _excess(a, reference.steps["display"]) <= _SAME * _excess(a, b):
            reference = None
    linear = None if reference is None else reference.steps["linear"]

    height, width, _ = a.shape

    def mistakes(every: int) -> list[tuple[str, Callable[[], np.ndarray]]]:
        """What is said of B, and every so many rows and columns of A with that mistake."""
        some_a, some_b = a[::every, ::every], b[::every, ::every]
        light = None if linear is None else linear[::every, ::every]
        return [
            *((name, partial(_through, view, a, reference, every)) for name, view in views(width, height).items()),
            *channel_mistakes(some_a),
            *film_mistakes(some_a, some_b, light, film, program),
        ]

    def weighed(chosen: list[int], every: int) -> list[tuple[Diagnosis, int]]:
        """Those of the mistakes, the one that explains most first."""
        some_a, some_b = a[::every, ::every], b[::every, ::every]
        known = mistakes(every)
        found = [(_weighed(known[n][0], some_a, known[n][1](), some_b), n) for n in chosen or range(len(known))]
        return sorted(found, key=lambda item: (-item[0].explained, item[0].rmse[1]))

    every = ceil(sqrt(height * width / _RANKED))
    ranked = weighed([], every)
    if every > 1:
        ranked = weighed([n for _, n in ranked[:_WEIGHED]], 1)
    best, _ = ranked[0]
    return best if best.explained >= _EXPLAINED and best.over[1] < _LEFT * best.over[0] else None


def _through(view: WrongView, a: np.ndarray, reference: Reference | None, every: int) -> np.ndarray:
    return resampled(a, view, every) if reference is None or view.whole else reference.through(view, every)


def _weighed(name: str, a: np.ndarray, wrong: np.ndarray, b: np.ndarray) -> Diagnosis:
    """How well `wrong`, which is `a` with the mistake, explains `b`, over the pixels that it reaches."""
    reached = ~np.isnan(wrong[..., 0])
    if not reached.all():
        a, wrong, b = a[reached], wrong[reached], b[reached]
    before = _excess(a, b)
    if before == 0 or np.count_nonzero(reached) < _REACHED * reached.size:
        return Diagnosis(name, 0.0, (0.0, 0.0), (0, 0))
    over = int(np.count_nonzero(pixels_over(a, b))), int(np.count_nonzero(pixels_over(wrong, b)))
    return Diagnosis(name, 1 - _excess(wrong, b) / before, (rmse(a, b), rmse(wrong, b)), over)


def _excess(a: np.ndarray, b: np.ndarray) -> float:
    """The mean square of what the difference has over 1/255."""
    return float(np.mean(np.square(np.maximum(np.abs(a - b) - LEVEL, 0))))
