"""The readable backend: NumPy in float32, float64 or longdouble.

The image is rendered in tiles, a few at a time, one a thread; memory is bounded by the result and those tiles. A branch
computes only the pixels that take it, and a loop over spheres asks those alone that the tile's rays can meet. Every
pixel's bits are those of the plain engine: NumPy's elementwise functions do not care where in an array a number stands.
"""

from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from raytrace.backends.culling import Beam, Extent, Pencil, Region, outside, primary_rays, shadow_rays
from raytrace.backends.job import Job
from raytrace.cores import in_threads
from raytrace.edges import pixels
from raytrace.language.control import Engine, running
from raytrace.language.tree import tree_map
from raytrace.scene.to_uniforms import rounded
from raytrace.shader.hit import CAMERA
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import Frame
from raytrace.shader.uniforms import Program, Sphere, Uniforms

__all__ = ["Masked", "Renderer", "drawn"]

#: Sides of a tile, in pixels: its planes fit into the cache, and Python's own share of the time is small.
TILE = 256
#: So many terms of sums are computed at a time.
TERMS = 1 << 16


class Visible(NamedTuple):
    """Where one kind of rays can meet spheres."""

    rays: Pencil | Beam
    bounds: Extent


class Masked(Engine):
    """Leaves out what no pixel needs.

    A branch calls each side with the pixels that take it, and not at all where there are none.
    """

    def __init__(self, uniforms: Uniforms, program: Program):
        self.quadratic = program.intersection == "textbook"
        kinds = primary_rays(uniforms, program), shadow_rays(uniforms, program)
        self.primary, self.shadow = (
            None
            if rays is None or uniforms.spheres is None
            else Visible(rays, rays.bounds(uniforms.spheres, self.quadratic))
            for rays in kinds
        )

    def each(self, items: Any, body: Callable, start: Any, args: tuple, unroll: bool) -> Any:
        visible = self.primary if isinstance(start, CAMERA) else self.shadow
        if visible is None or not isinstance(items, Sphere):
            return super().each(items, body, start, args, unroll)
        region = Region.of(visible.rays.coordinates(args[0], args[1], self.quadratic), np.True_)
        state = start
        for i in np.flatnonzero(~outside(visible.bounds, region)):
            state = body(state, i, tree_map(lambda leaf, i=i: leaf[i], items), *args)
        return state

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

    def summed(self, number: Any, term: Callable, start: Any, args: tuple) -> Any:
        total = tree_map(lambda plane: np.array(np.broadcast_to(plane, number.shape)), start)
        number = number.reshape(-1)
        ends = np.cumsum(number)
        # The terms one after the other: a pixel's terms are added in order.
        for first in range(0, int(ends[-1]), TERMS):
            terms = np.arange(first, min(first + TERMS, int(ends[-1])))
            pixels = np.searchsorted(ends, terms, side="right")
            k = (terms - (ends - number)[pixels]).astype(number.dtype)
            some = tree_map(lambda plane, at=pixels: plane.reshape(-1)[at] if np.ndim(plane) else plane, args)
            tree_map(lambda plane, one, at=pixels: np.add.at(plane.reshape(-1), at, one), total, term(k, *some))
        return total


class Renderer:
    """A scene, ready to be rendered; see `raytrace.backends.Renderer`."""

    def __init__(self, uniforms: Uniforms, job: Job):
        self.uniforms = tree_map(
            lambda x: np.asarray(x, job.dtype), uniforms if job.exact_inputs else rounded(uniforms)
        )
        self.job = job
        with np.errstate(all="ignore"):
            usual = Masked(self.uniforms, job.program) if job.skip else Engine()
        self.engine = usual if job.engine is None or isinstance(job.engine, str) else job.engine

    def about(self) -> dict[str, str]:
        return {"renderer": f"NumPy {np.__version__}"}

    def compile(self, count: int) -> None:
        """Nothing to compile."""

    def draw(self, first: int, count: int) -> dict[str, np.ndarray]:
        columns, rows = (
            np.arange(*ends, dtype=self.job.dtype) for ends in ((self.job.frame.width,), (first, first + count))
        )
        return drawn(self.uniforms, self.job.program, columns, rows, self.job.frame, self.job.keep, self.engine)


def drawn(
    uniforms: Uniforms,
    program: Program,
    columns: np.ndarray,
    rows: np.ndarray,
    frame: Frame,
    keep: tuple[str, ...],
    engine: Engine,
) -> dict[str, np.ndarray]:
    """Return the steps named in `keep` of the pixels where `columns` and `rows` cross.

    uniforms, columns, rows: of one dtype, in which everything is computed. columns, rows: (width,) and (height,); whole
    numbers for pixels, and others between them.

    Gives arrays (height, width) or (height, width, components).
    """
    images = {name: _empty(name, len(rows), len(columns), rows.dtype) for name in keep}

    def fill(tile: tuple[slice, slice]) -> None:
        across, down = columns[None, tile[1]], rows[tile[0], None]
        with running(engine), np.errstate(all="ignore"):
            steps = pixels(uniforms, program, across, down, frame, keep)
        for name, image in images.items():
            if COMPONENTS[name] == 1:
                image[tile] = getattr(steps, name)
            else:
                for component, plane in enumerate(getattr(steps, name)):
                    image[*tile, component] = plane

    starts = product(range(0, len(rows), TILE), range(0, len(columns), TILE))
    for _ in in_threads(fill, [(slice(row, row + TILE), slice(column, column + TILE)) for row, column in starts]):
        pass
    return images


def _empty(name: str, height: int, width: int, dtype: np.dtype) -> np.ndarray:
    components = COMPONENTS[name]
    shape = (height, width) if components == 1 else (height, width, components)
    return np.empty(shape, np.int32 if name == "index" else dtype)
