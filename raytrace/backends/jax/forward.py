"""Derivatives by forward mode, whichever mode is asked for.

Reverse mode keeps or computes again whatever led to an image, and the whole program is compiled backwards as well.
Where an image depends on few numbers, as a scene's are, each of them can be followed instead: that takes no memory, and
no time for numbers whose derivative nobody asks for.

So the derivative of an image along a direction is a primitive of its own: it is linear in the direction, and its
transpose runs it along each number's axis.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jax.extend.core import ClosedJaxpr, Primitive, jaxpr_as_fun
from jax.interpreters import ad, batching, mlir

from raytrace.errors import InputError

__all__ = ["by_forward_mode", "forward_mode_only"]

#: So many directions are followed at a time.
TOGETHER = 8


_only: ContextVar[bool] = ContextVar("raytrace_forward_mode_only", default=False)


@contextmanager
def forward_mode_only() -> Iterator[None]:
    """Within this context nobody asks for reverse mode: an image and its derivatives are one program."""
    token = _only.set(True)
    try:
        yield
    finally:
        _only.reset(token)


def by_forward_mode(function: Callable, numbers: Any, once: Any, refusal: str) -> Any:
    """Return `function(numbers)`, of a structure of arrays; its derivatives take a run for each number they are by.

    function: gives a structure of arrays, and holds no traced value. once: of the structure of `numbers`, True for
    those by two of which it has no second derivative. refusal: what is said where one is asked for.

    Raises:
        InputError: a second derivative by two numbers that allow but one.
    """
    if _only.get():
        return function(numbers)
    leaves, tree = jax.tree.flatten(numbers)
    singly = tuple(jax.tree.leaves(once))
    # As JAX's own text, so that the compiler sees which devices the primitive runs on.
    text, shapes = jax.make_jaxpr(lambda *leaves: function(tree.unflatten(leaves)), return_shape=True)(*leaves)
    called = jax.custom_jvp(jaxpr_as_fun(text))

    def rule(primals: tuple, tangents: tuple) -> tuple:
        moving = tuple(i for i, tangent in enumerate(tangents) if not isinstance(tangent, SymbolicZero))
        directions = [tangents[i] for i in moving]
        again = primals
        if any(singly[i] for i in moving):
            again = [_once(x, refusal) if by else x for by, x in zip(singly, primals, strict=True)]
        return called(*primals), _along.bind(*again, *directions, text=text, moving=moving)

    called.defjvp(rule, symbolic_zeros=True)
    return jax.tree.structure(shapes).unflatten(called(*leaves))


#: The derivatives of a function, given as its `text`, along directions of those of its arguments that are `moving`.
_along = Primitive("derivative_along")
_along.multiple_results = True


def _once(x: jax.Array, refusal: str) -> jax.Array:
    """Return `x`, which is not to be differentiated by."""

    @jax.custom_jvp
    def same(x: jax.Array) -> jax.Array:
        return x

    def rule(primals: tuple, tangents: tuple) -> tuple:
        if not isinstance(tangents[0], SymbolicZero):
            raise InputError(refusal)
        return primals[0], jnp.zeros_like(primals[0])

    same.defjvp(rule, symbolic_zeros=True)
    return same(x)


def _derivatives(*given: jax.Array, text: ClosedJaxpr, moving: tuple[int, ...]) -> list[jax.Array]:
    primals, directions = _split(given, moving)
    tangents = list(map(jnp.zeros_like, primals))
    for i, direction in zip(moving, directions, strict=True):
        tangents[i] = direction
    return jax.jvp(jaxpr_as_fun(text), tuple(primals), tuple(tangents))[1]


def _split(given: Any, moving: tuple[int, ...]) -> tuple[list, list]:
    at = len(given) - len(moving)
    return list(given[:at]), list(given[at:])


def _shapes(*given: Any, text: ClosedJaxpr, **params: Any) -> list:
    return text.out_avals


def _followed_again(primals: tuple, tangents: tuple, **params: Any) -> tuple:
    """The derivative of the derivative: by JAX's own rules, along whatever directions there are."""
    known = [jnp.zeros_like(x) if isinstance(t, ad.Zero) else t for x, t in zip(primals, tangents, strict=True)]
    return jax.jvp(partial(_derivatives, **params), primals, tuple(known))


def _transposed(images: list, *given: Any, moving: tuple[int, ...], **params: Any) -> list:
    primals, directions = _split(given, moving)
    shapes = [direction.aval.shape for direction in directions]
    sizes = [direction.aval.size for direction in directions]
    ends = [sum(sizes[: k + 1]) for k in range(len(sizes))]

    def parts(numbers: jax.Array) -> list[jax.Array]:
        each = zip(ends, sizes, shapes, strict=True)
        return [numbers[end - size : end].reshape(shape) for end, size, shape in each]

    def by_number(k: jax.Array) -> Any:
        axis = (jnp.arange(ends[-1]) == k).astype(directions[0].aval.dtype)
        changes = _derivatives(*primals, *parts(axis), moving=moving, **params)
        known = [pair for pair in zip(images, changes, strict=True) if not isinstance(pair[0], ad.Zero)]
        return sum(jnp.vdot(image, change) for image, change in known)

    # Axes that there are not have no direction; a number of them that is no multiple would be compiled apart.
    together = min(TOGETHER, ends[-1])
    axes = jnp.arange(-(-ends[-1] // together) * together)
    return [None] * len(primals) + parts(jax.lax.map(by_number, axes, batch_size=together)[: ends[-1]])


def _batched(given: tuple, axes: tuple, **params: Any) -> tuple:
    """A few directions at a time share what does not depend on them; images of several scenes, one after the other."""
    batched = [axis is not None for axis in axes]
    moved = [jnp.moveaxis(x, axis, 0) if many else x for x, axis, many in zip(given, axes, batched, strict=True)]

    def one(some: list) -> list:
        rest = iter(some)
        return _derivatives(*(next(rest) if many else x for x, many in zip(moved, batched, strict=True)), **params)

    scenes, _ = _split(batched, params["moving"])
    together = None if any(scenes) else TOGETHER
    images = jax.lax.map(one, [x for x, many in zip(moved, batched, strict=True) if many], batch_size=together)
    return images, [0] * len(images)


_along.def_impl(lambda *given, **params: jax.jit(partial(_derivatives, **params))(*given))
_along.def_abstract_eval(_shapes)
# Newer JAX lowers some primitives in two steps. It asks for the first step of every primitive whose text may hold one.
_along.to_lojax = _derivatives
mlir.register_lowering(_along, mlir.lower_fun(_derivatives, multiple_results=True))
ad.primitive_transposes[_along] = _transposed
ad.primitive_jvps[_along] = _followed_again
batching.primitive_batchers[_along] = _batched
