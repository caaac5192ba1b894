"""What the shader's control words become under JAX.

XLA's CPU compiler copies cheap producers into every consumer, so that a whole frame under one plain `jit` computes
its innermost loops over and over. What stands in the body of a `lax.cond` is not fused with what is outside. So
every step of the shader becomes such a body, and where its condition holds for no pixel of a block, it is skipped.
Blocks of rows keep the planes between the steps in the cache.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax import lax

from raytrace.shader.control import Engine, count
from raytrace.shader.glsl import select
from raytrace.shader.hit import Hit

__all__ = ["OneProgram", "Staged"]


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
            return body(state, i, jax.tree.map(lambda leaf: leaf[i], loop_items), *loop_args)

        shape = jax.eval_shape(lambda state: turn(0, state), start)
        state = lax.fori_loop(0, count(items), lambda i, state: _shaped(turn(i, state), shape), _shaped(start, shape))
        if not one_decides:
            return state
        index = state.index
        winner = body(start, index, self.at(items, index), *args)
        return select(index >= 0, winner, start)

    def at(self, items: Any, index: jax.Array) -> Any:
        if count(items) > self.few:
            return jax.tree.map(lambda leaf: jnp.take(leaf, index, mode="clip"), items)
        chosen = jax.tree.map(lambda leaf: leaf[0], items)
        for i in range(1, count(items)):
            chosen = select(index == i, jax.tree.map(lambda leaf, i=i: leaf[i], items), chosen)
        return chosen

    def detach(self, x: jax.Array) -> jax.Array:
        return lax.stop_gradient(x)


@dataclass(frozen=True)
class Staged(OneProgram):
    """Every step is a kernel of its own; a side of a branch that no pixel of the block takes is not computed."""

    block: int | None = 1 << 17

    def step(self, function: Callable, args: tuple) -> Any:
        leaves, tree = jax.tree.flatten(args, is_leaf=lambda part: not isinstance(part, tuple))
        planes = [leaf for leaf in leaves if isinstance(leaf, jax.Array)]

        def kernel(*planes: jax.Array) -> Any:
            given = iter(planes)
            return function(*tree.unflatten(next(given) if isinstance(leaf, jax.Array) else leaf for leaf in leaves))

        # The barrier hides that the condition is always true.
        return _computed_if(lax.optimization_barrier(True), kernel, jax.eval_shape(kernel, *planes), planes)

    def branch(self, condition: jax.Array, then: Callable, other: Callable, args: tuple) -> Any:
        shapes = jax.tree.map(
            lambda a, b: jax.ShapeDtypeStruct(jnp.broadcast_shapes(condition.shape, a.shape, b.shape), a.dtype),
            jax.eval_shape(then, *args),
            jax.eval_shape(other, *args),
        )
        chosen = _computed_if(jnp.any(condition), then, shapes, args)
        rest = _computed_if(~jnp.all(condition), other, shapes, args)
        return select(condition, chosen, rest)


def _computed_if(needed: jax.Array, function: Callable, shapes: Any, args: Any) -> Any:
    """`function(*args)` broadcast to `shapes`, or zeros where it is not `needed`; never fused with its callers."""

    def skipped(*_: Any) -> Any:
        return jax.tree.map(lambda shape: jnp.zeros(shape.shape, shape.dtype), shapes)

    return lax.cond(needed, lambda *args: _shaped(function(*args), shapes), skipped, *args)


def _shaped(tree: Any, shapes: Any) -> Any:
    return jax.tree.map(lambda leaf, shape: jnp.broadcast_to(leaf, shape.shape), tree, shapes)
