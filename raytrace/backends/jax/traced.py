"""A function traced once, for its results' shapes and for use."""

from collections.abc import Callable
from typing import Any

import jax
from jax.extend.core import jaxpr_as_fun

__all__ = ["traced"]


def traced(function: Callable, *args: Any) -> tuple[Callable, Any]:
    """`function` for arguments like `args`, and the shapes of what it gives.

    `jax.eval_shape` would run the function's Python once more, and what is nested in it twice more at each level.
    """
    # A new function each time: JAX would remember what it has traced, with what the engine held at that time.
    closed, shapes = jax.make_jaxpr(lambda *args: function(*args), return_shape=True)(*args)
    run, tree = jaxpr_as_fun(closed), jax.tree.structure(shapes)
    return lambda *args: tree.unflatten(run(*jax.tree.leaves(args))), shapes
