"""Run times, measured in turn in one run, so that the machine's moods are shared by all."""

import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from raytrace.cores import cores

__all__ = ["REST", "Timing", "in_turn", "ready", "state"]


#: Seconds of rest before each frame: some thread pools go on spinning after theirs, and would slow down the next.
REST = 0.05


class Timing(NamedTuple):
    """Milliseconds: the median, the fastest and the slowest of the runs after the first."""

    median: float
    fastest: float
    slowest: float


def state() -> str:
    """Return what the times depend on: JAX's version and devices, and the cores."""
    import jax

    devices = jax.devices()
    return f"JAX {jax.__version__} on {len(devices)} {devices[0].platform.upper()} devices; {cores()} cores"


def ready(image: Any) -> Any:
    """`image` when it is computed: JAX goes on before it is."""
    waiting = getattr(image, "block_until_ready", None)
    return image if waiting is None else waiting()


def in_turn(
    frames: Mapping[str, Callable[[], Any]],
    runs: int,
    done: Callable[[str, float], None] = lambda name, ms: None,
    rest: float = REST,
) -> dict[str, Timing]:
    """Run each of `frames` once to compile and to warm up, then `runs` times, A B C A B C ...; return their times.

    done: told of each frame, by name and milliseconds. rest: seconds before each frame.
    """
    milliseconds: dict[str, list[float]] = {name: [] for name in frames}
    for _ in range(runs + 1):
        for name, frame in frames.items():
            time.sleep(rest)
            start = time.perf_counter()
            ready(frame())
            milliseconds[name].append(1e3 * (time.perf_counter() - start))
            done(name, milliseconds[name][-1])
    return {
        name: Timing(*(float(f(times)) for f in (statistics.median, np.min, np.max)))
        for name, (_, *times) in milliseconds.items()
    }
