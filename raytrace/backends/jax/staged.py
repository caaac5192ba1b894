"""The engine that is fast: a block of the picture at a time, every step a kernel of its own, and nothing in vain.

What stands in the body of a `lax.cond` is not fused with what is outside (see `raytrace.backends.jax.engines` for why
that matters), and where its condition holds for no pixel of the block it is not computed. So each step of the shader is
such a body, each side of a branch is computed where a pixel takes it, and a loop over spheres runs over those that the
block's rays can meet.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jax.ad_checkpoint import checkpoint_name

from raytrace.backends.culling import Beam, Coordinates, Extent, Pencil, Region, outside, primary_rays, shadow_rays
from raytrace.backends.jax.engines import Attentive, OneProgram, computed_if, shaped
from raytrace.backends.jax.grid import Grid, candidates, grid
from raytrace.backends.jax.packing import Parts
from raytrace.backends.jax.traced import traced
from raytrace.language.control import count
from raytrace.language.glsl import select
from raytrace.shader.hit import CAMERA, Hit
from raytrace.shader.uniforms import Program, Sphere, Uniforms

__all__ = ["SEARCHED", "Culling", "Loop", "Staged", "Visible", "culling", "without_grids"]

#: With more spheres than this the small ones are in grids. A block's own rays see fewer spheres than lie between the
#: surfaces that it sees and the sun, so that a list of them all does for longer.
MANY_FOR_PRIMARY, MANY_FOR_SHADOW = 2048, 256
#: Of sums that few pixels have, so many terms are computed at a time: a block's pixels by this.
PARTS = 8
#: The name of what a search found, which is kept for reverse mode: nothing is searched again.
SEARCHED = "searched"
#: So many spheres are asked at a time whether a block's rays can meet them.
CHUNK = 1024


class Visible(NamedTuple):
    """What one kind of rays can meet: their coordinates, the spheres' rectangles there, and a grid if there are many.

    by_cell: the spheres in the order of the grid. large: the numbers of those that are too large for it, and padding.
    """

    rays: Pencil | Beam
    bounds: Extent
    grid: Grid | None = None
    by_cell: Sphere | None = None
    large: jax.Array | None = None


class Culling(NamedTuple):
    """For the rays of the camera, and for those to the sun; ``None`` where there are no such rays or no spheres."""

    primary: Visible | None
    shadow: Visible | None


def culling(
    uniforms: Uniforms, program: Program, many: tuple[int, int] = (MANY_FOR_PRIMARY, MANY_FOR_SHADOW)
) -> Culling:
    """What is prepared once for all blocks of a picture.

    many: with more spheres than this there are grids, for the camera's rays and for those to the sun.
    """
    # Which spheres are looked at has no derivative.
    uniforms = lax.stop_gradient(uniforms)
    spheres = uniforms.spheres

    def with_grid(visible: Visible | None, many: int) -> Visible | None:
        n = count(spheres)
        if visible is None or n <= many:
            return visible
        cells = grid(visible.rays, visible.bounds)
        by_cell = jax.tree.map(lambda leaf: leaf[cells.order], spheres)
        padded = jnp.pad(cells.order, (0, n))
        large = jnp.pad(lax.dynamic_slice(padded, (cells.small,), (n,)), (0, CHUNK))
        return visible._replace(grid=cells, by_cell=by_cell, large=large)

    return Culling(*map(with_grid, without_grids(uniforms, program), many))


def without_grids(uniforms: Uniforms, program: Program) -> Culling:
    """Return what is prepared of few spheres, in the uniforms' own arithmetic."""
    spheres = uniforms.spheres
    if spheres is None:
        return Culling(None, None)

    def visible(rays: Pencil | Beam) -> Visible:
        return Visible(rays, rays.bounds(spheres, program.intersection == "textbook"))

    to_sun = shadow_rays(uniforms, program)
    return Culling(visible(primary_rays(uniforms, program)), None if to_sun is None else visible(to_sun))


@dataclass(frozen=True)
class Staged(OneProgram):
    """The settings; `at_block` makes the engine itself."""

    #: Pixels of a block, about.
    block: int | None = 1 << 13

    def at_block(
        self, program: Program, culling: Culling, mode: Any, differentiated: bool, parts: Parts | None
    ) -> "Block":
        return Block(
            few=self.few,
            quadratic=program.intersection == "textbook",
            culling=culling,
            everything=mode > 0,
            always=mode >= 0,
            differentiated=differentiated,
            parts=parts,
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Block(Attentive):
    """The engine for one block of pixels.

    always: true, which the compiler must not know. differentiated: whether the picture is being differentiated.
    """

    culling: Culling
    always: Any
    differentiated: bool

    def step(self, function: Callable, args: tuple) -> Any:
        run, planes, shapes = self.body(function, args)
        return computed_if(self.always, run, shapes, planes)

    def summed(self, number: jax.Array, term: Callable, start: Any, args: tuple) -> Any:
        if self.active is not None:
            number = jnp.where(self.active, number, 0)
        n, size = number.size, -(-number.size // PARTS)
        # The terms one after the other, so many of them at a time.
        ends = jnp.cumsum(number, dtype=jnp.int32)
        begins, total = ends - number, ends[-1]

        def of_part(terms: jax.Array, args: tuple) -> Any:
            pixels = jnp.searchsorted(ends, terms, side="right").astype(jnp.int32)
            k = terms - begins.at[pixels].get(mode="clip")
            some = jax.tree.map(lambda plane: plane.at[pixels].get(mode="clip") if jnp.ndim(plane) else plane, args)
            with self.only(terms < total):
                found = term(k, *some)
            return pixels, jax.tree.map(lambda plane: jnp.broadcast_to(plane, (size,)), found)

        within = jnp.arange(size, dtype=jnp.int32)
        of_part, (_, shapes) = traced(of_part, within, args, parts=self.parts)
        image = jax.tree.map(lambda plane, _: jnp.broadcast_to(plane, (n,)), start, shapes)

        def with_part(part: jax.Array, image: Any) -> Any:
            pixels, found = of_part(part * size + within, args)
            return jax.tree.map(lambda whole, part: whole.at[pixels].add(part, mode="drop"), image, found)

        return lax.fori_loop(0, -(-total // size), with_part, image)

    def each(self, items: Any, body: Callable, start: Any, args: tuple, unroll: bool) -> Any:
        visible = self.culling.primary if isinstance(start, CAMERA) else self.culling.shadow
        if not isinstance(items, Sphere) or visible is None:
            return super().each(items, body, start, args, unroll)
        loop_items, loop_args = lax.stop_gradient((items, args)) if self.differentiated else (items, args)
        loop = Loop(self, visible, loop_items, body, loop_args)
        shape = jax.eval_shape(lambda state: body(state, 0, self.item(items, 0), *args), start)
        state = jax.tree.map(lambda leaf: checkpoint_name(leaf, SEARCHED), loop.run(shaped(start, shape)))
        if not (isinstance(start, Hit) and self.differentiated):
            return state
        return self.winner(items, body, start, state.index, args)


class Loop(NamedTuple):
    """``each`` over spheres: first those that the block's rays may meet one by one, then those of each ray's cells."""

    engine: Attentive
    visible: Visible
    spheres: Sphere
    body: Callable
    args: tuple

    def run(self, state: Any) -> Any:
        n, grid = count(self.spheres), self.visible.grid
        plane = jax.tree.leaves(state)[0]
        active = jnp.ones(plane.shape, bool) if self.engine.active is None else self.engine.active
        active = jnp.broadcast_to(active, plane.shape)
        where = self.where(plane.shape)
        region = Region.of(where, active)
        size = min(n, CHUNK)
        bounds, large = self.visible.bounds, self.visible.large
        if grid is None or large is None:
            met = ~outside(bounds, region) | self.engine.everything
            return self._listed(jnp.arange(n, dtype=jnp.int32), met, active, state)

        def of_chunk(k: jax.Array, state: Any) -> Any:
            indices = lax.dynamic_slice(large, (k * size,), (size,))
            met = ~outside(jax.tree.map(lambda leaf: leaf[indices], bounds), region) | self.engine.everything
            return self._listed(indices, met & (k * size + jnp.arange(size) < grid.large), active, state)

        state = lax.fori_loop(0, -(-grid.large // size), of_chunk, state)
        return self.in_cells(grid, where, active, state)

    def where(self, shape: tuple[int, ...]) -> Coordinates:
        """The coordinates of the rays, planes of that shape."""
        where = self.visible.rays.coordinates(self.args[0], self.args[1], self.engine.quadratic)
        return shaped(where, jax.tree.map(lambda x: jax.ShapeDtypeStruct(shape, x.dtype), where))

    def _listed(self, indices: jax.Array, wanted: jax.Array, active: jax.Array, state: Any) -> Any:
        """Over those of the spheres numbered `indices` that are wanted."""
        n = count(self.spheres)
        listed = jnp.sort(jnp.where(wanted, indices, n))
        number = jnp.sum(wanted, dtype=jnp.int32)

        leaves, tree = jax.tree.flatten(self.spheres)
        parts = self.engine.parts

        def item(k: jax.Array) -> tuple[jax.Array, Any]:
            i = lax.dynamic_index_in_dim(listed, k, keepdims=False, allow_negative_indices=False)
            column = None if parts is None else parts.column(leaves, i)
            return i, self.engine.item(self.spheres, i) if column is None else column

        def turn(item: tuple[jax.Array, Any], state: Any) -> Any:
            i, sphere = item
            return self.turn(i, tree.unflatten(sphere) if isinstance(sphere, jax.Array) else sphere, state)

        return self.while_needed(lambda _: number, active, item, turn, state)

    def in_cells(self, grid: Grid, where: Any, active: jax.Array, state: Any) -> Any:
        """Over the small spheres, each ray over those of its own cells."""
        asked = candidates(grid, where, active, self.engine.everything, count(self.spheres))

        def turn(k: jax.Array, state: Any) -> Any:
            place = asked.place(k)
            index, sphere = jax.tree.map(lambda leaf: taken(leaf, place), (grid.order, self.visible.by_cell))
            return select(k < asked.total, self.turn(index, sphere, state), state)

        def rounds(open: jax.Array) -> jax.Array:
            return jnp.max(jnp.where(open, asked.total, 0))

        return self.while_needed(rounds, active, lambda k: k, turn, state)

    def turn(self, i: jax.Array, sphere: Sphere, state: Any) -> Any:
        changed = self.body(state, i, sphere, *self.args)
        if isinstance(state, Hit) and self.visible.grid is not None:
            # Grids are not in the spheres' order. Of spheres at equal t the last one in it wins all the same.
            changed = select((changed.t == state.t) & (i < state.index), state, changed)
        return shaped(changed, state)

    def while_needed(self, rounds: Callable, active: jax.Array, item: Callable, turn: Callable, state: Any) -> Any:
        """`turn(item(k), state)` for k from 0 to `rounds(open)`, as long as it can change an `active` ray that is open.

        The next item is carried: computed on the spot it would be computed for each pixel. There may be no next one.
        """
        start = item(jnp.int32(0))
        if isinstance(state, tuple):
            _, state = lax.fori_loop(0, rounds(active), lambda k, carry: (item(k + 1), turn(*carry)), (start, state))
            return state

        def rounds_left(blocked: jax.Array) -> jax.Array:
            # One sphere is enough for a shadow.
            open = active & ~blocked
            return jnp.where(self.engine.some(open) | self.engine.everything, rounds(open | self.engine.everything), 0)

        def more(carry: tuple) -> jax.Array:
            k, _, blocked = carry
            return k < rounds_left(blocked)

        def one_more(carry: tuple) -> tuple:
            k, now, blocked = carry
            return k + 1, item(k + 1), turn(now, blocked)

        *_, state = lax.while_loop(more, one_more, (jnp.int32(0), start, state))
        return state


def taken(leaf: Any, places: jax.Array) -> jax.Array:
    """Return the items at `places`, all of which exist."""
    return leaf.at[places].get(mode="promise_in_bounds") if isinstance(leaf, jax.Array) else leaf[places]
