"""The fast backend: JAX in float32 or float64, compiled, differentiable."""

from raytrace.backends.jax.engines import OneProgram, Staged
from raytrace.backends.jax.renderer import Renderer

__all__ = ["OneProgram", "Renderer", "Staged"]
