"""The readable backend: NumPy in float32, float64 or longdouble.

The image is rendered in blocks of rows, a few at a time, one a thread; memory is bounded by the result and those
blocks. A branch computes only the pixels that take it. Every pixel's bits are those of the plain engine: NumPy's
elementwise functions do not care where in an array a number stands.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from raytrace.backends.job import Job
from raytrace.cores import cores
from raytrace.shader.control import Engine, running
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import pixels
from raytrace.shader.tree import tree_map
from raytrace.shader.uniforms import Uniforms

__all__ = ["Masked", "Renderer"]

#: Pixels of a block: its planes fit into the cache.
BLOCK = 1 << 14


class Masked(Engine):
    """A branch calls each side with the pixels that take it, and not at all where there are none."""

    def branch(self, condition: Any, then: Callable, other: Callable, args: tuple) -> Any:
        chosen = np.flatnonzero(condition)
        if len(chosen) == condition.size:
            return then(*args)
        if len(chosen) == 0:
            return other(*args)
        rest = np.flatnonzero(~condition)

        def of(pixels: np.ndarray) -> tuple:
            return tree_map(lambda plane: plane.reshape(-1)[pixels] if np.ndim(plane) else plane, args)

        def merged(a: Any, b: Any) -> np.ndarray:
            plane = np.empty(condition.size, a.dtype)
            plane[chosen], plane[rest] = a, b
            return plane.reshape(condition.shape)

        return tree_map(merged, then(*of(chosen)), other(*of(rest)))


_MASKED = Masked()


class Renderer:
    """A scene, ready to be rendered; see `raytrace.backends.Renderer`."""

    def __init__(self, uniforms: Uniforms, job: Job):
        given = np.float64 if job.exact_inputs else np.float32
        self.uniforms = tree_map(lambda x: np.asarray(x, given).astype(job.dtype), uniforms)
        self.job = job

    def about(self) -> dict[str, str]:
        return {"renderer": f"NumPy {np.__version__}"}

    def compile(self, count: int) -> None:
        """Nothing to compile."""

    def draw(self, first: int, count: int) -> dict[str, np.ndarray]:
        images = {name: _empty(name, count, self.job.frame.width, self.job.dtype) for name in self.job.keep}
        rows = max(1, BLOCK // self.job.frame.width)
        starts = range(0, count, rows)
        pool = ThreadPoolExecutor(cores())
        try:
            for block in [pool.submit(self._fill, images, first, slice(start, start + rows)) for start in starts]:
                block.result()
        finally:
            # After an error or an interruption the blocks that have not begun are not begun.
            pool.shutdown(cancel_futures=True)
        return images

    def _fill(self, images: dict[str, np.ndarray], first: int, rows: slice) -> None:
        """Renders those rows of `images`, whose row 0 is the image's row `first`."""
        parts = {name: image[rows] for name, image in images.items()}
        height = len(next(iter(parts.values())))
        column = np.arange(self.job.frame.width, dtype=self.job.dtype)[None, :]
        row = np.arange(first + rows.start, first + rows.start + height, dtype=self.job.dtype)[:, None]
        with running(self.job.engine or (_MASKED if self.job.skip else Engine())), np.errstate(all="ignore"):
            steps = pixels(self.uniforms, self.job.program, column, row, self.job.frame, self.job.keep)
        for name, part in parts.items():
            if COMPONENTS[name] == 1:
                part[...] = getattr(steps, name)
            else:
                for component, plane in enumerate(getattr(steps, name)):
                    part[..., component] = plane


def _empty(name: str, height: int, width: int, dtype: str) -> np.ndarray:
    components = COMPONENTS[name]
    shape = (height, width) if components == 1 else (height, width, components)
    return np.empty(shape, np.int32 if name == "index" else dtype)
