"""The fast backend: JAX in float32 or float64, compiled, differentiable."""

from raytrace.backends.jax.engines import OneProgram
from raytrace.backends.jax.renderer import Renderer
from raytrace.backends.jax.staged import Staged

__all__ = ["OneProgram", "Renderer", "Staged"]
