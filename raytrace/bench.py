"""Run times, measured in turn in one run, so that the machine's moods are shared by all."""

import statistics
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from raytrace.rendering import Rendering, render
from raytrace.scene.toml import DEFAULT_SCENE, figures

__all__ = ["Timing", "plain_jit_timings", "scene_timings"]


class Timing(NamedTuple):
    """Milliseconds of one frame: the median, the fastest and the slowest of the runs after the first."""

    scene: str
    how: str
    median: float
    fastest: float
    slowest: float


#: The arithmetics that are compared.
_BACKENDS = (("numpy", "float64"), ("jax", "float64"), ("jax", "float32"))


def scene_timings(size: tuple[int, int], runs: int) -> Iterator[Timing]:
    """`raytrace.render` of each figure's scene on each backend, compilation apart."""
    for scene in figures():
        frames = {
            f"{backend} {dtype}": lambda backend=backend, dtype=dtype, scene=scene: render(
                scene, size, backend=backend, dtype=dtype
            )
            for backend, dtype in _BACKENDS
        }
        yield from _in_turn(scene, frames, runs)


def plain_jit_timings(size: tuple[int, int], runs: int) -> Iterator[Timing]:
    """The default scene in float32: `raytrace.render` against the same text under one plain `jax.jit`."""
    from raytrace.backends.jax import OneProgram

    plain = Rendering(DEFAULT_SCENE, size, engine=OneProgram())
    frames = {"jax float32": lambda: render(DEFAULT_SCENE, size), "one plain jit": plain.whole}
    yield from _in_turn(DEFAULT_SCENE, frames, runs)


def _in_turn(scene: str, frames: dict[str, Callable], runs: int) -> Iterator[Timing]:
    """Each of `frames` once to compile and to warm up, then `runs` times, A B C A B C ..."""
    seconds: dict[str, list[float]] = {how: [] for how in frames}
    for _ in range(runs + 1):
        for how, frame in frames.items():
            start = time.perf_counter()
            np.asarray(frame())
            seconds[how].append(time.perf_counter() - start)
    for how, (_, *times) in seconds.items():
        yield Timing(scene, how, *(1e3 * value for value in (statistics.median(times), min(times), max(times))))
