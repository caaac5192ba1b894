"""The picture of a scene, and what it has for slopes when the sun or the exposure changes, as one program."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from raytrace.inverse.programs import kept
from raytrace.rendering import render
from raytrace.scene.data import Scene
from raytrace.scene.to_uniforms import program_of

__all__ = ["moved", "sun_slopes"]


def moved(scene: Scene, direction: Any, stops: Any) -> Scene:
    """The scene with another sun and another exposure."""
    film = replace(scene.film, exposure=stops)
    return replace(scene, sun=replace(scene.sun, direction=direction), film=film)


def sun_slopes(
    scene: Scene, size: tuple[int, int], axes: Any, antialias: str = "edges"
) -> tuple[np.ndarray, np.ndarray]:
    """The picture (height, width, 3), and its derivatives (3, height, width, 3), in float64 of float32.

    They are by the sun's direction along each of two `axes`, vectors (2, 3), and by the exposure in stops. One program
    serves all scenes of as many spheres and planes; it is kept in the user's cache folder, as it takes long to compile.
    """
    given = scene, np.asarray(axes, np.float64)
    choices = program_of(scene, "robust", antialias=antialias)
    program = kept(f"slopes {size}", choices, _jitted(size, antialias), given)
    picture, slopes = program(*given)
    return np.asarray(picture, np.float64), np.asarray(slopes, np.float64)


@lru_cache
def _jitted(size: tuple[int, int], antialias: str) -> Callable:
    import jax
    import jax.numpy as jnp

    from raytrace.backends.jax.forward import forward_mode_only

    @jax.jit
    def program(scene: Scene, axes: Any) -> tuple:
        def picture(change: Any) -> Any:
            lit = moved(scene, scene.sun.direction + change[:2] @ axes, scene.film.exposure + change[2])
            return render(lit, size, antialias=antialias)

        here = jnp.zeros(3)
        with forward_mode_only():
            return jax.vmap(lambda axis: jax.jvp(picture, (here,), (axis,)), out_axes=(None, 0))(jnp.eye(3))

    return program
