"""The arithmetics that a formula is tried in."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from raytrace.arithmetic.exact import BITS, Exact, precision
from raytrace.language.control import Engine, running
from raytrace.language.tree import tree_map

__all__ = ["Arithmetic", "exactly", "of_floats"]


class Arithmetic(NamedTuple):
    """A way to compute. `of(function)` takes NumPy's numbers, rounds them to `dtype` and gives such numbers."""

    name: str
    dtype: Any
    of: Callable[[Callable], Callable]


def of_floats() -> list[Arithmetic]:
    """NumPy and JAX, each in float32 and float64."""
    return [
        Arithmetic(f"{name} {dtype.__name__}", dtype, partial(kind, dtype))
        for dtype in (np.float32, np.float64)
        for name, kind in (("numpy", _numpy), ("jax", _jax))
    ]


def exactly(function: Callable, *args: Any, bits: int = BITS) -> Any:
    """`function(*args)` of the numbers as they are, as arrays of `arb` of so many binary digits."""
    with running(Engine()), precision(bits):
        return function(*tree_map(Exact.of, args))


def _numpy(dtype: Any, function: Callable) -> Callable:
    def run(*args: Any) -> Any:
        with running(Engine()), np.errstate(all="ignore"):
            return tree_map(np.asarray, function(*_given(args, dtype)))

    return run


def _jax(dtype: Any, function: Callable) -> Callable:
    """As the backend compiles it, with its own elementary functions."""
    import jax

    from raytrace.backends.jax.engines import OwnFunctions
    from raytrace.backends.jax.renderer import OPTIONS

    @partial(jax.jit, compiler_options=OPTIONS)
    def program(*args: Any) -> Any:
        with running(OwnFunctions()):
            return function(*args)

    def run(*args: Any) -> Any:
        with jax.enable_x64(dtype == np.float64):
            return tree_map(np.asarray, program(*_given(args, dtype)))

    return run


def _given(args: Any, dtype: Any) -> Any:
    with np.errstate(all="ignore"):
        return tree_map(lambda x: np.asarray(x).astype(dtype), args)
