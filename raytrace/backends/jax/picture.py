"""A traced picture as a primitive of JAX, whose engine is known where it is lowered for a platform.

JAX traces a user's program once and lowers it for a CPU, a GPU or both. So a picture within it is one operation, which
becomes an engine's text there: a kernel has no derivative of JAX's. A picture that is differentiated is drawn, with its
derivative, by operations that JAX knows.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import core
from jax.custom_derivatives import SymbolicZero
from jax.extend.core import Primitive
from jax.interpreters import batching, mlir

from raytrace.backends.jax.choice import engine_of, or_fused
from raytrace.backends.jax.draw import Given, draw_part, prepare_spheres
from raytrace.backends.jax.kernel import MANY, Where
from raytrace.backends.job import Job
from raytrace.language.control import count
from raytrace.shader.main import COMPONENTS
from raytrace.shader.uniforms import Uniforms

__all__ = ["traced_picture"]


def traced_picture(job: Job, rows: int, uniforms: Uniforms, mode: Any, first: Any) -> dict[str, jax.Array]:
    """Return the steps that the job keeps, for `rows` rows from row `first` on: arrays (rows, width, components)."""
    leaves, tree = jax.tree.flatten(uniforms)

    @jax.custom_jvp
    def picture(leaves: list[jax.Array], mode: Any, first: Any) -> list[jax.Array]:
        return _picture.bind(*leaves, mode, first, job=job, rows=rows, tree=tree, batched=())

    def rule(primals: tuple, tangents: tuple) -> tuple:
        leaves, mode, first = primals
        moving = [i for i, tangent in enumerate(tangents[0]) if not isinstance(tangent, SymbolicZero)]
        engine = engine_of(job, "differentiated", count(uniforms.spheres))

        def drawn(*some: jax.Array) -> list[jax.Array]:
            moved = list(leaves)
            for i, leaf in zip(moving, some, strict=True):
                moved[i] = leaf
            return _drawn(engine, True, *moved, mode, first, job=job, rows=rows, tree=tree)

        return jax.jvp(drawn, tuple(leaves[i] for i in moving), tuple(tangents[0][i] for i in moving))

    picture.defjvp(rule, symbolic_zeros=True)
    return dict(zip(job.keep, picture(leaves, mode, first), strict=True))


def _drawn(engine: Any, differentiated: bool, *operands: Any, job: Job, rows: int, tree: Any) -> list[jax.Array]:
    """The images of uniforms without a batch. operands: the uniforms' leaves, the mode, the first row."""
    *leaves, mode, first = operands
    uniforms, where = tree.unflatten(leaves), Where(mode, first, 0)
    given = Given(uniforms, prepare_spheres(engine, uniforms, job.program))
    images = draw_part(job, engine, rows, job.frame.width, given, where, differentiated)
    return [images[name] for name in job.keep]


def _batch(operands: Sequence[Any], batched: tuple[bool, ...]) -> tuple[int, ...]:
    """The shape of the batch: () or (n,)."""
    return next(((x.shape[0],) for x, many in zip(operands, batched, strict=True) if many), ()) if batched else ()


def _shapes(*operands: Any, job: Job, rows: int, tree: Any, batched: tuple[bool, ...]) -> list[Any]:
    def shape(name: str) -> Any:
        dtype = np.dtype("int32" if name == "index" else job.dtype)
        return core.ShapedArray((*_batch(operands, batched), rows, job.frame.width, COMPONENTS[name]), dtype)

    return [shape(name) for name in job.keep]


def _on(platform: str) -> Callable:
    """How the primitive is lowered for a platform."""

    def lowered(context: Any, *operands: Any, batched: tuple[bool, ...], **params: Any) -> Any:
        job, tree = params["job"], params["tree"]
        many = batched or (False,) * len(operands)
        one = [jax.ShapeDtypeStruct(x.shape[axis:], x.dtype) for x, axis in zip(context.avals_in, many, strict=True)]
        spheres = count(tree.unflatten(one[: tree.num_leaves]).spheres)
        # Many small pictures of few spheres leave a kernel little to skip; a fusion shares what pixels have in common.
        plain = batched and job.engine is None and job.frame.samples == 1 and spheres <= MANY
        engine = engine_of(job, "another" if plain and platform != "cpu" else platform, spheres)

        def by(engine: Any) -> Any:
            function = partial(_drawn, engine, False, **params)
            if batched:
                function = jax.vmap(function, tuple(0 if axis else None for axis in batched))
            return mlir.lower_fun(function, multiple_results=True)(context, *operands)

        return or_fused(job, engine, spheres, by)

    return lowered


def _batched(operands: Sequence[Any], axes: Sequence[Any], batched: tuple[bool, ...], **params: Any) -> tuple:
    """A batch of pictures. A batch of batches becomes one batch of all pairs: a kernel's grid has one axis for them."""
    n = next(x.shape[axis] for x, axis in zip(operands, axes, strict=True) if axis is not None)
    moved = [x if axis is None else jnp.moveaxis(x, axis, 0) for x, axis in zip(operands, axes, strict=True)]
    now = tuple(axis is not None for axis in axes)
    if not batched:
        images = _picture.bind(*moved, batched=now, **params)
        return images, [0] * len(images)
    inner = next(x.shape[new] for x, old, new in zip(moved, batched, now, strict=True) if old)

    def paired(x: Any, old: bool, new: bool) -> Any:
        if not (old or new):
            return x
        own = x.shape[old + new :]
        x = x.reshape(n if new else 1, inner if old else 1, *own)
        return jnp.broadcast_to(x, (n, inner, *own)).reshape(n * inner, *own)

    pairs = [paired(*each) for each in zip(moved, batched, now, strict=True)]
    either = tuple(old or new for old, new in zip(batched, now, strict=True))
    images = _picture.bind(*pairs, batched=either, **params)
    return [image.reshape(n, inner, *image.shape[1:]) for image in images], [0] * len(images)


_picture = Primitive("raytrace_picture")
_picture.multiple_results = True
_picture.def_abstract_eval(_shapes)
mlir.register_lowering(_picture, _on("another"))
for _platform in ("cpu", "cuda"):
    mlir.register_lowering(_picture, _on(_platform), platform=_platform)
batching.primitive_batchers[_picture] = _batched
