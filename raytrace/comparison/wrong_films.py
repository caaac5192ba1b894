"""Mistakes in what becomes of the light: the film's steps left out, done twice, or of another kind."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import permutations
from typing import Any

import numpy as np

from raytrace.comparison.develop import NEUTRAL, developed, undeveloped
from raytrace.shader.film import TONE_MAPPERS, TRANSFERS, named
from raytrace.shader.uniforms import FilmUniforms, Program

__all__ = ["channel_mistakes", "film_mistakes"]

#: The exposure is sought within so many stops, in about so many pixels; so many stops are no mistake.
_STOPS = 6
_FITTED = 1 << 12
_LEAST_STOPS = 0.01


def channel_mistakes(a: np.ndarray) -> Iterator[tuple[str, Callable[[], np.ndarray]]]:
    """What is said of B, and what `a` looks like with that mistake: the channels in every other order."""
    for order in permutations(range(3)):
        if order != (0, 1, 2):
            name = "".join("RGB"[channel] for channel in order)
            yield f"swapped in its channels ({name} for RGB)", lambda order=order: a[..., list(order)]


def film_mistakes(
    a: np.ndarray, b: np.ndarray, linear: np.ndarray | None, film: FilmUniforms, program: Program
) -> Iterator[tuple[str, Callable[[], np.ndarray]]]:
    """What is said of B, and what `a` looks like with that mistake.

    linear: the light that `a` was developed of by `film` and `program`; ``None`` to take it from `a` itself, which
        knows it up to where the film clips.
    """
    if linear is None:
        linear, film = undeveloped(a, program), NEUTRAL
    if linear is None:
        return

    def with_(film: FilmUniforms = film, **changes: str | Callable) -> Callable[[], np.ndarray]:
        return lambda: developed(linear, film, replace(program, **changes))

    mapper = program.tone_mapper if isinstance(program.tone_mapper, str) else "the scene's own"
    curve = named(TRANSFERS, program.transfer)
    yield "without gamma (the transfer function is missing)", with_(transfer="none")
    yield "with the transfer function twice (gamma twice)", with_(transfer=lambda x: curve(curve(x)))
    for name in TRANSFERS:
        if name not in (program.transfer, "none"):
            yield f"with the transfer function {name} for {program.transfer}", with_(transfer=name)
    yield "without the tone mapper", with_(tone_mapper="none")
    for name in TONE_MAPPERS:
        if name not in (mapper, "none"):
            yield f"with the tone mapper {name} for {mapper}", with_(tone_mapper=name)
    yield "linear light, not developed (linear for display)", lambda: np.clip(linear, 0, max(1, b.max()))
    yield "developed twice (display for linear)", lambda: developed(a, film, program)

    factor = _exposure(linear, film, program, b)
    if abs(np.log2(factor)) > _LEAST_STOPS:
        name = f"exposed {factor:.3g} times as much ({np.log2(factor):+.2f} stops)"
        yield name, with_(_exposed(film, factor))


def _exposed(film: FilmUniforms, factor: float) -> FilmUniforms:
    return film._replace(exposure=np.float64(factor if film.exposure is None else film.exposure * factor))


def _exposure(linear: np.ndarray, film: FilmUniforms, program: Program, b: np.ndarray) -> float:
    """The factor of exposure that brings `linear` nearest to `b`, by least squares over some of the pixels."""
    from scipy.optimize import minimize_scalar

    every = slice(None, None, 1 + b[..., 0].size // _FITTED)
    some, shown = (image.reshape(1, -1, 3)[:, every] for image in (linear, b))

    def error(stops):
        return np.mean(np.square(developed(some, _exposed(film, 2.0**stops), program) - shown))

    start = min(range(-_STOPS, _STOPS + 1, 2), key=error)
    found: Any = minimize_scalar(error, bounds=(start - 2, start + 2), method="bounded")
    return float(2**found.x)
