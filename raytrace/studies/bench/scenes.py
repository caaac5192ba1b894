"""Each figure of the assignment on each backend that needs nothing more."""

from collections.abc import Iterator

from raytrace.rendering import render
from raytrace.scene.toml import figures
from raytrace.studies.bench.timing import Timing, in_turn

__all__ = ["scene_timings"]

#: The arithmetics that are compared.
BACKENDS = (("numpy", "float64"), ("jax", "float64"), ("jax", "float32"))


def scene_timings(size: tuple[int, int], runs: int) -> Iterator[tuple[str, str, Timing]]:
    """Scene, backend and time of a frame."""
    for scene in figures():
        frames = {
            f"{backend} {dtype}": lambda backend=backend, dtype=dtype, scene=scene: render(
                scene, size, backend=backend, dtype=dtype
            )
            for backend, dtype in BACKENDS
        }
        for how, timing in in_turn(frames, runs).items():
            yield scene, how, timing
