"""What the shader's control words become under JAX, translated plainly.

XLA's CPU compiler copies cheap producers into every consumer, so that a whole frame under one plain `jit` computes
its innermost loops over and over. `raytrace.backends.jax.staged` does better.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
from jax import lax

from raytrace.backends.jax import elementary
from raytrace.backends.jax.packing import Parts
from raytrace.backends.jax.traced import traced
from raytrace.language.control import Engine, count
from raytrace.language.glsl import select
from raytrace.shader.hit import Hit

__all__ = ["Attentive", "Fused", "OneProgram", "OwnFunctions", "any_of", "computed_if", "shaped"]


@dataclass(frozen=True)
class OneProgram(Engine):
    """What every engine for JAX does, and the plain translation by itself: steps and branches are fused freely."""

    #: Pixels of a block, at most; ``None`` for the whole image at once.
    block: int | None = None
    #: A loop over more items than this stays a loop, and its items are gathered; with fewer both are written out.
    few: int = 16

    def each(self, items: Any, body: Callable, start: Any, args: tuple, unroll: bool) -> Any:
        if unroll and count(items) <= self.few:
            return super().each(items, body, start, args, unroll)
        # A state without floats has no derivative, and a hit has that of the one item that was hit. Either way the
        # loop itself needs none: reverse mode would have to keep every turn of it.
        one_decides = isinstance(start, Hit)
        if one_decides or not any(jnp.issubdtype(leaf.dtype, jnp.floating) for leaf in jax.tree.leaves(start)):
            loop_items, loop_args = lax.stop_gradient((items, args))
        else:
            loop_items, loop_args = items, args

        def turn(i, state):
            return body(state, i, self.item(loop_items, i), *loop_args)

        shape = jax.eval_shape(lambda state: turn(0, state), start)
        state = lax.fori_loop(0, count(items), lambda i, state: shaped(turn(i, state), shape), shaped(start, shape))
        if not one_decides:
            return state
        return self.winner(items, body, start, state.index, args)

    def summed(self, number: jax.Array, term: Callable, start: Any, args: tuple) -> Any:
        def turn(k: jax.Array, total: Any) -> Any:
            one = term(jnp.full_like(number, k), *args)
            return jax.tree.map(lambda total, one: select(number > k, total + one, total), total, one)

        shape = jax.eval_shape(lambda start: turn(jnp.int32(0), start), start)
        return lax.fori_loop(0, jnp.max(number), turn, shaped(start, shape))

    def winner(self, items: Any, body: Callable, start: Any, index: jax.Array, args: tuple) -> Any:
        """What the one item that was hit makes of `start`: equal to the loop's result, and differentiable."""
        return select(index >= 0, body(start, index, self.at(items, index), *args), start)

    def at(self, items: Any, index: jax.Array) -> Any:
        if count(items) > self.few:
            return jax.tree.map(lambda leaf: jnp.take(leaf, index, mode="clip"), items)
        chosen = self.item(items, 0)
        for i in range(1, count(items)):
            chosen = select(index == i, self.item(items, i), chosen)
        return chosen

    def detach(self, x: jax.Array) -> jax.Array:
        return lax.stop_gradient(x)


class OwnFunctions(OneProgram):
    """With exp2 and log2 of its own: in float32 their values, and of log2 the derivative."""

    def exp2(self, x: jax.Array) -> jax.Array:
        return elementary.exp2(x) if x.dtype == jnp.float32 else jnp.exp2(x)

    def log2(self, x: jax.Array) -> jax.Array:
        return elementary.log2(x) if x.dtype == jnp.float32 else elementary.log2_double(x)


@dataclass(frozen=True)
class Fused(OwnFunctions):
    """All pixels of an image in as few fusions as XLA makes of it, as an accelerator wants it."""

    def each(self, items: Any, body: Callable, start: Any, args: tuple, unroll: bool) -> Any:
        # A loop sees to it by itself.
        written_out = unroll and 0 < count(items) <= self.few
        if not isinstance(start, Hit) or not written_out:
            return super().each(items, body, start, args, unroll)
        # What was hit alone has a derivative: that of what is missed may be infinite, and nothing times that is NaN.
        found = super().each(*lax.stop_gradient((items,)), body, start, lax.stop_gradient(args), unroll)
        return self.winner(items, body, start, found.index, args)


@dataclass(frozen=True, eq=False, kw_only=True)
class Attentive(OwnFunctions):
    """An engine that knows which pixels are of interest, made anew in each trace: it holds what that trace computes.

    quadratic: whether the textbook's formula is computed. everything: whether nothing is skipped: then all branches are
    computed and all lists are full. The bits are the same. parts: the scene's numbers, where they are one array.
    """

    quadratic: bool
    everything: Any
    parts: Parts | None = None
    #: The pixels of interest within the contexts that are entered, the innermost last; ``None`` for all.
    contexts: list[jax.Array | None] = field(default_factory=lambda: [None])

    # Two of them hold different arrays, and are never equal.
    __eq__ = object.__eq__  # pyright: ignore[reportAssignmentType]
    __hash__ = object.__hash__

    @property
    def active(self) -> jax.Array | None:
        return self.contexts[-1]

    def some(self, mask: jax.Array) -> jax.Array:
        """Return whether `mask` holds for any pixel."""
        return jnp.any(mask)

    def among(self, condition: jax.Array) -> Any:
        """Within this context only those pixels for which `condition` holds are of interest."""
        return self.only(condition if self.active is None else self.active & condition)

    @contextmanager
    def only(self, active: jax.Array) -> Iterator[jax.Array]:
        """The same, and whatever was of interest before is not."""
        self.contexts.append(active)
        try:
            yield active
        finally:
            self.contexts.pop()

    def branch(self, condition: jax.Array, then: Callable, other: Callable, args: tuple) -> Any:
        sides = []
        for taken, function in ((condition, then), (~condition, other)):
            with self.among(taken) as active:
                sides.append((self.some(active) | self.everything, *self.body(function, args)))
        shapes = jax.tree.map(
            lambda a, b: jax.ShapeDtypeStruct(jnp.broadcast_shapes(condition.shape, a.shape, b.shape), a.dtype),
            *(shapes for *_, shapes in sides),
        )
        return select(condition, *(computed_if(needed, side, shapes, planes) for needed, side, planes, _ in sides))

    def item(self, items: Any, i: Any) -> Any:
        parts = self.parts
        if parts is None or not isinstance(i, int):
            return super().item(items, i)
        return jax.tree.map(lambda leaf: parts.item(leaf, i), items)

    def body(self, function: Callable, args: tuple) -> tuple[Callable, list[jax.Array], Any]:
        """Return `function` as a function of planes, those planes, and the shapes of what it gives.

        Whatever of `args` is no array, or is a part of the scene's numbers, it closes over.
        """
        leaves, tree = jax.tree.flatten(args, is_leaf=lambda part: not isinstance(part, tuple))
        closed = [not isinstance(leaf, jax.Array) or (self.parts is not None and leaf in self.parts) for leaf in leaves]

        def of_planes(*planes: jax.Array) -> Any:
            given = iter(planes)
            return function(*tree.unflatten(x if kept else next(given) for x, kept in zip(leaves, closed, strict=True)))

        planes = [leaf for leaf, kept in zip(leaves, closed, strict=True) if not kept]
        run, shapes = traced(of_planes, *planes, parts=self.parts)
        return run, planes, shapes


def any_of(mask: jax.Array) -> jax.Array:
    """Return ``any(mask)``, as a maximum: Pallas' kernels know no other reduction of truth values."""
    return jnp.max(mask.astype(jnp.int32)) > 0


def shaped(tree: Any, shapes: Any) -> Any:
    """`tree` with its leaves broadcast to the shapes of those of `shapes`."""
    return jax.tree.map(lambda leaf, shape: jnp.broadcast_to(leaf, shape.shape), tree, shapes)


def computed_if(needed: jax.Array, function: Callable, shapes: Any, args: Any) -> Any:
    """`function(*args)` broadcast to `shapes`, or zeros where it is not `needed`; never fused with its callers."""

    def skipped(*_: Any) -> Any:
        return jax.tree.map(lambda shape: jnp.zeros(shape.shape, shape.dtype), shapes)

    return lax.cond(needed, lambda *args: shaped(function(*args), shapes), skipped, *args)
