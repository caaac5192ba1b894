"""A function traced once, for its results' shapes and for use."""

from collections.abc import Callable
from typing import Any

import jax
from jax.extend.core import ClosedJaxpr, jaxpr_as_fun

from raytrace.backends.jax.packing import Parts

__all__ = ["traced"]


def traced(function: Callable, *args: Any, parts: Parts | None = None) -> tuple[Callable, Any]:
    """Return `function` for arguments like `args`, and the shapes of what it gives.

    parts: those of these that it closes over are taken where it runs.

    `jax.eval_shape` would run the function's Python once more, and what is nested in it twice more at each level.
    """
    # A new function each time: JAX would remember what it has traced, with what the engine held at that time.
    closed, shapes = jax.make_jaxpr(lambda *args: function(*args), return_shape=True)(*args)
    tree = jax.tree.structure(shapes)

    def run(*args: Any) -> Any:
        given = closed.consts if parts is None else map(parts.here, closed.consts)
        return tree.unflatten(jaxpr_as_fun(ClosedJaxpr(closed.jaxpr, list(given)))(*jax.tree.leaves(args)))

    return run, shapes
