"""Programs of JAX that are kept in the user's cache folder, as they take longer to compile than to run."""

from collections.abc import Callable
from typing import Any

import numpy as np

from raytrace.shader.uniforms import Program

__all__ = ["kept"]

_programs: dict[str, Any] = {}


def kept(name: str, program: Program, jitted: Callable, given: tuple) -> Callable:
    """Return `jitted`, compiled for arguments such as `given`, from the cache folder if it is there.

    name, program: what it depends on beside the arguments' shapes. It runs on one device, however many there are.
    """
    import jax

    from raytrace.backends.jax.devices import ask_for_all_cores, one_device
    from raytrace.backends.jax.stored import choices_as_text, stored

    ask_for_all_cores()
    choices = choices_as_text(program)
    if choices is None:
        return jitted
    leaves, tree = jax.tree.flatten(given)
    shapes = [(np.shape(leaf), str(getattr(leaf, "dtype", np.float64))) for leaf in leaves]
    key = repr((name, choices, tree, shapes, jax.config.jax_enable_x64))
    if key not in _programs:
        devices = list(one_device().devices.flat)
        _programs[key] = stored(key, devices, lambda: jitted.lower(*given).compile())
    return _programs[key]
