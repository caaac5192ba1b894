"""The fast backend: JAX in float32 or float64, compiled, differentiable."""

from raytrace.errors import InputError

try:
    import jax  # noqa: F401 (before what uses it)
except ValueError as error:  # of a variable of the environment, which JAX reads now
    raise InputError(f"jax: {error}") from None

from raytrace.backends.jax.engines import OneProgram
from raytrace.backends.jax.renderer import Renderer
from raytrace.backends.jax.staged import Staged

__all__ = ["OneProgram", "Renderer", "Staged"]
