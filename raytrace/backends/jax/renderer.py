"""A scene, compiled by JAX for blocks of rows, and rendered."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import lru_cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from raytrace.backends.jax.engines import OneProgram, Staged
from raytrace.backends.job import Job
from raytrace.errors import InputError
from raytrace.shader.control import running
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import pixels
from raytrace.shader.uniforms import Uniforms

__all__ = ["Renderer"]

_STAGED = Staged()


class _Blocks(NamedTuple):
    """`count` blocks of `rows` rows."""

    rows: int
    count: int


def _engine(job: Job) -> OneProgram:
    return job.engine or _STAGED


def _blocks(job: Job, rows: int) -> _Blocks:
    """Blocks for at least `rows` rows, as equal as can be, none of more pixels than the engine asks for."""
    most = _engine(job).block
    largest = rows if most is None else max(1, most // job.frame.width)
    blocks = -(-rows // largest)
    return _Blocks(-(-rows // blocks), blocks)


@partial(jax.jit, static_argnums=(0, 1))
def _draw(job: Job, blocks: _Blocks, uniforms: Uniforms, first: jax.Array) -> dict[str, jax.Array]:
    """The steps for the rows of all blocks, from row `first` on."""
    column = jnp.arange(job.frame.width, dtype=job.dtype)[None, :]

    # In reverse mode a block is computed again rather than kept.
    @jax.checkpoint
    def block(uniforms: Uniforms, start: jax.Array) -> dict[str, jax.Array]:
        row = (start + jnp.arange(blocks.rows, dtype=jnp.int32)).astype(job.dtype)[:, None]
        with running(_engine(job)):
            steps = pixels(uniforms, job.program, column, row, job.frame, job.keep)
        shape = (blocks.rows, job.frame.width)
        return {name: _interleaved(getattr(steps, name), name, shape) for name in job.keep}

    starts = first + blocks.rows * jnp.arange(blocks.count, dtype=jnp.int32)
    images = lax.map(partial(block, uniforms), starts)
    return jax.tree.map(lambda image: image.reshape(-1, *image.shape[2:]), images)


def _interleaved(planes: Any, name: str, shape: tuple[int, int]) -> jax.Array:
    if COMPONENTS[name] == 1:
        return jnp.broadcast_to(planes, shape)
    return jnp.stack([jnp.broadcast_to(plane, shape) for plane in planes], axis=-1)


@lru_cache(maxsize=64)
def _compiled(job: Job, blocks: _Blocks, tree: Any, shapes: tuple[tuple[int, ...], ...], device: Any) -> Callable:
    """The program of `job` for uniforms of these shapes, whatever their values; `device` is JAX's default one."""
    uniforms = tree.unflatten(jax.ShapeDtypeStruct(shape, job.dtype) for shape in shapes)
    return _draw.lower(job, blocks, uniforms, jax.ShapeDtypeStruct((), np.int32)).compile()


def _given(x: Any, dtype: str, exact: bool) -> jax.Array:
    """A uniform as the program gets it: rounded once to float32 unless `exact`, then in `dtype`.

    The gradient passes the rounding as if it were not there.
    """
    if not isinstance(x, jax.core.Tracer):
        return jnp.asarray(np.asarray(x, np.float64 if exact else np.float32), dtype=dtype)
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

    def __init__(self, uniforms: Uniforms, job: Job):
        self.job = job
        self.traced = any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(uniforms))
        #: float64 without x64 mode: switched on for as long as it takes.
        self.borrows_x64 = job.dtype == "float64" and not jax.config.jax_enable_x64
        if self.traced and self.borrows_x64:
            raise InputError(
                "dtype float64: JAX is tracing in 32 bit; set jax_enable_x64, or trace within jax.enable_x64(True)"
            )
        with self._outside():
            self.uniforms = jax.tree.map(partial(_given, dtype=job.dtype, exact=job.exact_inputs), uniforms)

    def about(self) -> dict[str, str]:
        device = jax.config.jax_default_device or jax.devices()[0]
        return {"renderer": f"JAX {jax.__version__} on {getattr(device, 'device_kind', device)}"}

    def compile(self, count: int) -> None:
        """Compiles the program for `count` rows at a time, which `draw` does otherwise."""
        if not self.traced:
            with self._outside():
                self._program(_blocks(self.job, count))

    def draw(self, first: int, count: int) -> dict[str, Any]:
        blocks = _blocks(self.job, count)
        with self._outside():
            if self.traced:
                images = _draw(self.job, blocks, self.uniforms, jnp.int32(first))
            else:
                images = self._program(blocks)(self.uniforms, np.int32(first))
            images = {name: image[:count] for name, image in images.items()}
            return jax.tree.map(np.asarray, images) if self.borrows_x64 else images

    def _program(self, blocks: _Blocks) -> Callable:
        leaves, tree = jax.tree.flatten(self.uniforms)
        shapes = tuple(leaf.shape for leaf in leaves)
        return _compiled(self.job, blocks, tree, shapes, jax.config.jax_default_device)

    @contextmanager
    def _outside(self) -> Iterator[None]:
        """x64 as it is needed; and what is not traced is computed at once, even while JAX traces something else."""
        with (
            jax.enable_x64(True) if self.borrows_x64 else nullcontext(),
            nullcontext() if self.traced else jax.ensure_compile_time_eval(),
        ):
            yield
