"""Programs of JAX that are kept in the user's cache folder, as they take longer to compile than to run."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from raytrace.shader.uniforms import Program

__all__ = ["kept"]

#: The most programs that are held.
MOST = 32


def kept(name: str, program: Program, jitted: Callable, given: tuple) -> Callable:
    """Return `jitted`, compiled for arguments such as `given`, from the cache folder if it is there.

    name, program: what it depends on beside the arguments' shapes. It runs on one device, however many there are.
    """
    import jax

    from raytrace.backends.jax.devices import x64_mode
    from raytrace.backends.jax.stored import choices_as_text

    choices = choices_as_text(program)
    if choices is None:
        return jitted
    leaves, tree = jax.tree.flatten(given)
    shapes = tuple((np.shape(leaf), np.dtype(getattr(leaf, "dtype", np.float64))) for leaf in leaves)
    return _compiled(name, choices, jitted, tree, shapes, x64_mode())


@lru_cache(maxsize=MOST)
def _compiled(name: str, choices: str, jitted: Callable, tree: Any, shapes: tuple, x64: bool) -> Callable:
    import jax

    from raytrace.backends.jax.devices import one_device
    from raytrace.backends.jax.stored import stored

    given = tree.unflatten([jax.ShapeDtypeStruct(*shape) for shape in shapes])
    key = repr((name, choices, tree, shapes, x64))
    return stored(key, list(one_device().devices.flat), lambda: jitted.lower(*given).compile())
