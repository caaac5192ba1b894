"""A picture as one kernel of a GPU, by Pallas: every program of its grid draws a small tile of pixels.

A fusion of XLA's computes both sides of every branch for every pixel, and a loop of XLA's launches kernels anew in each
turn. In a kernel of one's own branches and loops are real: a tile takes only the sides that one of its pixels takes,
and its loops end when its own pixels are done. It writes the components of a pixel side by side.

The tile is drawn by the same text as everything else (`raytrace.shader`); `Kernel` says what the control words become.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import lax

from raytrace.backends.culling import Region, outside
from raytrace.backends.jax.engines import Attentive, OneProgram, any_of, shaped
from raytrace.backends.jax.staged import Culling, Loop, Visible, culling
from raytrace.backends.job import Job
from raytrace.language.control import count, running
from raytrace.shader.hit import Hit
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import pixels
from raytrace.shader.uniforms import Program, Sphere, Uniforms

__all__ = ["MANY", "Images", "Kernels", "Where", "draw_by_kernel", "prepared"]

#: With more spheres than this each ray looks into a grid; up to here the text holds every one of them, and a tile
#: skips those that none of its rays can meet.
MANY = OneProgram.few


@dataclass(frozen=True)
class Kernels:
    """The settings: the pixels of a tile, a power of two, and the warps of 32 threads that draw one.

    Four pixels and more for each thread take too many registers (notebooks/speed.md).
    """

    tile_height: int = 8
    tile_width: int = 8
    warps: int = 1
    #: One tile after the other by XLA, wherever that runs: slow, for tests.
    interpreted: bool = False


class Where(NamedTuple):
    """What a kernel is told when it runs: whether to skip nothing (1, else 0), and which pixel its first one is."""

    mode: Any
    first_row: Any
    first_column: Any


class Images(NamedTuple):
    """What a kernel draws: `rows` x `columns` pixels of a job's frame."""

    job: Job
    rows: int
    columns: int
    kernels: Kernels


class Listed:
    """An array of which a kernel reads single items: ``listed[i]``, for each pixel or for all.

    memory: an array of one dimension, or a kernel's reference to one; the items are there from `start` on.
    """

    def __init__(self, memory: Any, start: int, shape: tuple[int, ...]):
        self.memory, self.start, self.shape = memory, start, shape

    def __getitem__(self, i: Any) -> jax.Array:
        return read(self.memory, self.start + i)


def read(memory: Any, place: Any) -> jax.Array:
    """Return the number at `place` of an array of one dimension, or those at places."""
    # A Python number would be an index that is not an array, which a kernel does not take.
    place = jnp.asarray(place, jnp.int32)
    if isinstance(memory, jax.Array):
        return memory[place]
    from jax.experimental.pallas import triton

    return triton.load(memory.at[place])


@dataclass(frozen=True, eq=False, kw_only=True)
class Kernel(Attentive):
    """The engine within a kernel, for the pixels of one tile."""

    culling: Culling

    # CUDA's own functions: they err no more than `raytrace.backends.jax.elementary`, and a picture takes 7 % less.

    def exp2(self, x: jax.Array) -> jax.Array:
        return lax.exp2(x)

    def log2(self, x: jax.Array) -> jax.Array:
        return lax.log(x) * jnp.asarray(1 / math.log(2), x.dtype)

    def some(self, mask: jax.Array) -> jax.Array:
        return any_of(mask)

    def branch(self, condition: jax.Array, then: Callable, other: Callable, args: tuple) -> Any:
        assert self.active is not None
        # A uniform's condition, too: Pallas fails where a side gives a constant of shape ().
        return super().branch(jnp.broadcast_to(condition, self.active.shape), then, other, args)

    def each(self, items: Any, body: Callable, start: Any, args: tuple, unroll: bool) -> Any:
        visible = self.culling.primary if isinstance(start, Hit) else self.culling.shadow
        planes = self._planes(start)
        if isinstance(items, Sphere) and visible is not None:
            loop = _Loop(self, visible, items, body, args)
            return (loop.one_by_one if visible.grid is None else loop.run)(shaped(start, planes))
        if unroll and count(items) <= MANY:
            return super().each(items, body, start, args, unroll)

        def turn(i: jax.Array, state: Any) -> Any:
            return shaped(body(state, i, self.item(items, i), *args), planes)

        return lax.fori_loop(0, count(items), turn, shaped(start, planes))

    def _planes(self, state: Any) -> Any:
        assert self.active is not None
        shape = self.active.shape
        return jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(shape, leaf.dtype), state)

    def at(self, items: Any, index: jax.Array) -> Any:
        return jax.tree.map(lambda leaf: leaf[jnp.clip(index, 0, count(items) - 1)], items)


class _Loop(Loop):
    """``each`` over spheres, in a kernel."""

    def one_by_one(self, state: Any) -> Any:
        """Few spheres: those whose rectangle a ray of the tile may be in."""
        active = self.engine.active
        assert active is not None
        where = self.where(active.shape)
        region = Region.of(where, active)
        # A GPU's minimum leaves NaN out. Such a ray may meet anything.
        unsure = any_of(active & jnp.isnan(where.u + where.v + where.w + where.error))
        for i in range(count(self.spheres)):
            bounds, sphere = jax.tree.map(lambda leaf, i=i: leaf[i], (self.visible.bounds, self.spheres))
            needed = ~outside(bounds, region) | unsure | self.engine.everything

            def met(i: int = i, sphere: Sphere = sphere, state: Any = state) -> Any:
                return shaped(self.body(state, i, sphere, *self.args), state)

            state = lax.cond(needed, met, lambda state=state: state)
        return state

    def run(self, state: Any) -> Any:
        """Many: the large ones one by one, then each ray over those of its own cells."""
        grid, large, active = self.visible.grid, self.visible.large, self.engine.active
        assert grid is not None
        assert large is not None
        assert active is not None
        where = self.where(active.shape)

        def of_large(k: jax.Array, state: Any) -> Any:
            i = large[k]
            return self.turn(i, self.engine.item(self.spheres, i), state)

        state = self.while_needed(lambda _: grid.large, active, lambda k: k, of_large, state)
        return self.in_cells(grid, where, active, state)


def prepared(uniforms: Uniforms, program: Program) -> Culling | None:
    """Return what tells a tile which spheres its rays can meet; ``None`` where there are none."""
    if uniforms.spheres is None:
        return None
    # Where many spheres are constants XLA would build their grids itself, for minutes, before the program runs.
    return culling(lax.optimization_barrier(uniforms), program, (MANY, MANY))


def _needed(visible: Visible | None) -> Visible | None:
    """What a kernel asks for: with a grid a ray's own cells decide, and nobody asks for the rectangles."""
    return visible if visible is None or visible.grid is None else visible._replace(bounds=None)


def draw_by_kernel(images: Images, uniforms: Uniforms, culled: Culling | None, where: Where) -> list[jax.Array]:
    """Return the steps that the job keeps: arrays (rows, columns, components).

    culled: what `prepared` gives.
    """
    given = _Given(images, uniforms, culled, where)
    return given.interpreted() if images.kernels.interpreted else given.called()


class _Tile(NamedTuple):
    """The pixels of a tile: planes of one dimension."""

    row: jax.Array
    column: jax.Array
    inside: jax.Array


class _Given:
    """What a kernel is given, as arrays of one dimension, and what it makes of them again."""

    def __init__(self, images: Images, uniforms: Uniforms, culled: Culling | None, where: Where):
        self.images = images
        leaves, self.tree = jax.tree.flatten(uniforms)
        self.shapes = [leaf.shape for leaf in leaves]
        self.starts = [sum(leaf.size for leaf in leaves[:k]) for k in range(len(leaves))]
        cells, self.cell_tree = jax.tree.flatten(None if culled is None else Culling(*map(_needed, culled)))
        self.cell_shapes = [leaf.shape for leaf in cells]
        # One array for all that is small, made by one operation.
        small = [leaf.dtype == leaves[0].dtype and leaf.size <= MANY for leaf in cells]
        together = [*leaves, *(leaf for leaf, together in zip(cells, small, strict=True) if together)]
        ends = iter([sum(leaf.size for leaf in together[:k]) for k in range(len(leaves), len(together))])
        #: Where each leaf of the cells begins among the numbers; ``None`` for one that is an array by itself.
        self.cell_starts = [next(ends) if together else None for together in small]
        self.arrays = [
            jnp.concatenate([leaf.reshape(-1) for leaf in together]),
            *(jnp.asarray(x, jnp.int32).reshape(1) for x in where),
            *(leaf.reshape(-1) for leaf, together in zip(cells, small, strict=True) if not together),
        ]
        kernels = images.kernels
        self.down, self.across = -(-images.rows // kernels.tile_height), -(-images.columns // kernels.tile_width)
        names = images.job.keep
        self.kinds = [(COMPONENTS[name], "int32" if name == "index" else images.job.dtype) for name in names]

    def tile(self, i: Any, j: Any) -> _Tile:
        """Return tile (i, j)."""
        height, width = self.images.kernels.tile_height, self.images.kernels.tile_width
        within = lax.iota(jnp.int32, height * width)
        row, column = i * height + within // width, j * width + within % width
        return _Tile(row, column, (row < self.images.rows) & (column < self.images.columns))

    def drawing(self, inputs: Sequence[Any]) -> Callable[[_Tile], list[tuple]]:
        """Return what draws a tile: the planes of each step. `inputs` are the arrays in memory."""
        job = self.images.job
        numbers, *where, cells = *inputs[:4], inputs[4:]
        mode, first_row, first_column = (read(memory, 0) for memory in where)

        def items(memory: Any, start: int, shape: tuple[int, ...]) -> Any:
            return read(memory, start) if shape == () else Listed(memory, start, shape)

        uniforms = self.tree.unflatten(items(numbers, *leaf) for leaf in zip(self.starts, self.shapes, strict=True))
        rest = iter(cells)
        culled = self.cell_tree.unflatten(
            items(next(rest), 0, shape) if start is None else items(numbers, start, shape)
            for start, shape in zip(self.cell_starts, self.cell_shapes, strict=True)
        )

        def draw(tile: _Tile) -> list[tuple]:
            engine = Kernel(
                quadratic=job.program.intersection == "textbook",
                everything=mode > 0,
                contexts=[tile.inside],
                culling=Culling(None, None) if culled is None else culled,
            )
            x, y = (tile.column + first_column).astype(job.dtype), (tile.row + first_row).astype(job.dtype)
            with running(engine):
                steps = pixels(uniforms, job.program, x, y, job.frame, job.keep)
            images = [getattr(steps, name) for name in job.keep]
            return [image if isinstance(image, tuple) else (image,) for image in images]

        return draw

    def called(self) -> list[jax.Array]:
        """Run the kernel: a program for each tile."""
        from jax.experimental import pallas
        from jax.experimental.pallas import triton

        images, kernels = self.images, self.images.kernels

        def kernel(*refs: Any) -> None:
            draw = self.drawing(refs[: len(self.arrays)])
            outputs = refs[len(self.arrays) :]

            tile = self.tile(pallas.program_id(0), pallas.program_id(1))
            for planes, output in zip(draw(tile), outputs, strict=True):
                for k, plane in enumerate(planes):
                    place = output.at[tile.row, tile.column * len(planes) + k]
                    triton.store(place, jnp.broadcast_to(plane, tile.row.shape), mask=tile.inside)

        drawn = pallas.pallas_call(
            kernel,
            # The components of a row's pixels one after the other.
            out_shape=[jax.ShapeDtypeStruct((images.rows, images.columns * n), dtype) for n, dtype in self.kinds],
            grid=(self.down, self.across),
            compiler_params=triton.CompilerParams(num_warps=kernels.warps, num_stages=1),
        )(*self.arrays)
        return [image.reshape(images.rows, images.columns, -1) for image in drawn]

    def interpreted(self) -> list[jax.Array]:
        """Draw the same tiles one after the other, without a kernel."""
        images, kernels = self.images, self.images.kernels
        draw, size = self.drawing(self.arrays), kernels.tile_height * kernels.tile_width

        def tile(k: jax.Array) -> list[jax.Array]:
            drawn = draw(self.tile(k // self.across, k % self.across))
            return [jnp.stack([jnp.broadcast_to(plane, (size,)) for plane in planes], -1) for planes in drawn]

        def joined(tiles: jax.Array) -> jax.Array:
            parts = tiles.reshape(self.down, self.across, kernels.tile_height, kernels.tile_width, -1).swapaxes(1, 2)
            whole = parts.reshape(self.down * kernels.tile_height, self.across * kernels.tile_width, -1)
            return whole[: images.rows, : images.columns]

        return [joined(tiles) for tiles in lax.map(tile, jnp.arange(self.down * self.across, dtype=jnp.int32))]
