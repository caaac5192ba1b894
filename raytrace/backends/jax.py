"""The fast backend: JAX in float32 or float64, compiled, differentiable.

XLA's CPU compiler copies cheap producers into every consumer, so that a whole frame under one plain `jit` computes
its innermost loops over and over. What stands in the body of a `lax.cond` is not fused with what is outside. So
every step of the shader becomes such a body, and where its condition holds for no pixel of a block, it is skipped.
Blocks of rows keep the planes between the steps in the cache.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from raytrace.errors import InputError
from raytrace.shader.control import Engine, count, running
from raytrace.shader.glsl import select
from raytrace.shader.hit import Hit
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import Frame, pixels
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["OneProgram", "Renderer", "Staged"]


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


@dataclass(frozen=True)
class Job:
    """What a program is compiled for, but for the numbers of spheres and planes: `blocks` blocks of `rows` rows."""

    program: Program
    frame: Frame
    keep: tuple[str, ...]
    dtype: str
    engine: OneProgram
    rows: int
    blocks: int


@partial(jax.jit, static_argnums=0)
def _draw(job: Job, uniforms: Uniforms, first: jax.Array) -> dict[str, jax.Array]:
    """The steps for `blocks * rows` rows from row `first` on."""
    column = jnp.arange(job.frame.width, dtype=job.dtype)[None, :]

    # In reverse mode a block is computed again rather than kept.
    @jax.checkpoint
    def block(uniforms: Uniforms, start: jax.Array) -> dict[str, jax.Array]:
        row = (start + jnp.arange(job.rows, dtype=jnp.int32)).astype(job.dtype)[:, None]
        with running(job.engine):
            steps = pixels(uniforms, job.program, column, row, job.frame, job.keep)
        return {name: _interleaved(getattr(steps, name), name, job) for name in job.keep}

    starts = first + job.rows * jnp.arange(job.blocks, dtype=jnp.int32)
    images = lax.map(partial(block, uniforms), starts)
    return jax.tree.map(lambda image: image.reshape(-1, *image.shape[2:]), images)


def _interleaved(planes: Any, name: str, job: Job) -> jax.Array:
    shape = (job.rows, job.frame.width)
    if COMPONENTS[name] == 1:
        return jnp.broadcast_to(planes, shape)
    return jnp.stack([jnp.broadcast_to(plane, shape) for plane in planes], axis=-1)


@lru_cache(maxsize=64)
def _compiled(job: Job, tree: Any, shapes: tuple[tuple[int, ...], ...]) -> Callable:
    """The program of `job` for uniforms of these shapes."""
    uniforms = tree.unflatten(jax.ShapeDtypeStruct(shape, job.dtype) for shape in shapes)
    return _draw.lower(job, uniforms, jax.ShapeDtypeStruct((), np.int32)).compile()


def _given(x: Any, dtype: str, exact: bool) -> jax.Array:
    """A uniform as the program gets it: rounded once to float32 unless `exact`, then in `dtype`.

    The gradient passes the rounding as if it were not there.
    """
    if not isinstance(x, jax.core.Tracer):
        return jnp.asarray(x if exact else np.float32(x), dtype=dtype)
    if not exact and x.dtype == jnp.float64 and dtype == "float64":
        # Neighbours' difference is exact, and so is the sum.
        return x + lax.stop_gradient(x.astype(jnp.float32).astype(dtype) - x)
    return x.astype(dtype)


class Renderer:
    """A scene, ready to be rendered; see `raytrace.backends.Renderer`.

    The uniforms may be traced, as in a `jax.grad` of the image. Arrays are JAX's, but for float64 while JAX's
    x64 mode is off: then they are NumPy's.

    Raises:
        InputError: float64 is asked of a trace without x64.
    """

    def __init__(
        self,
        uniforms: Uniforms,
        program: Program,
        frame: Frame,
        keep: tuple[str, ...],
        dtype: str,
        exact_inputs: bool = False,
        engine: OneProgram | None = None,
    ):
        self.traced = any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(uniforms))
        #: float64 without x64 mode: switched on for as long as it takes.
        self.borrows_x64 = dtype == "float64" and not jax.config.jax_enable_x64
        if self.traced and self.borrows_x64:
            raise InputError(
                "dtype float64: JAX is tracing in 32 bit; set jax_enable_x64, or trace within jax.enable_x64(True)"
            )
        self.choices = (program, frame, keep, dtype, engine or Staged())
        with self._x64():
            self.uniforms = jax.tree.map(partial(_given, dtype=dtype, exact=exact_inputs), uniforms)

    def compile(self, count: int) -> None:
        """Compiles the program for `count` rows at a time, which `draw` does otherwise."""
        if not self.traced:
            with self._x64():
                self._program(count)

    def draw(self, first: int, count: int) -> dict[str, Any]:
        with self._x64():
            if self.traced:
                images = _draw(self._job(count), self.uniforms, jnp.int32(first))
            else:
                images = self._program(count)(self.uniforms, np.int32(first))
            images = {name: image[:count] for name, image in images.items()}
            return jax.tree.map(np.asarray, images) if self.borrows_x64 else images

    def _program(self, count: int) -> Callable:
        leaves, tree = jax.tree.flatten(self.uniforms)
        return _compiled(self._job(count), tree, tuple(leaf.shape for leaf in leaves))

    def _job(self, count: int) -> Job:
        _, frame, _, _, engine = self.choices
        rows = count if engine.block is None else max(1, engine.block // frame.width)
        blocks = -(-count // rows)
        return Job(*self.choices, rows=-(-count // blocks), blocks=blocks)

    def _x64(self) -> AbstractContextManager:
        return jax.enable_x64(True) if self.borrows_x64 else nullcontext()
