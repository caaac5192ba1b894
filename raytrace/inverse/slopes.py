"""The picture of a scene, and what it has for slopes when the sun or the exposure changes, as one program."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from raytrace.rendering import render
from raytrace.scene.data import Scene
from raytrace.uniforms import program_of

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
    picture, slopes = _program(size, antialias, *given)(*given)
    return np.asarray(picture, np.float64), np.asarray(slopes, np.float64)


_programs: dict[str, Any] = {}


def _program(size: tuple[int, int], antialias: str, scene: Scene, axes: Any) -> Any:
    import jax

    from raytrace.backends.jax.devices import ask_for_all_cores, one_device
    from raytrace.backends.jax.stored import choices_as_text, stored

    ask_for_all_cores()
    program = _jitted(size, antialias)
    choices = choices_as_text(program_of(scene, "robust", antialias=antialias))
    if choices is None:
        return program
    shapes = [(np.shape(leaf), str(np.asarray(leaf).dtype)) for leaf in jax.tree.leaves(scene)]
    name = repr((choices, jax.tree.structure(scene), shapes, size, jax.config.jax_enable_x64))
    if name not in _programs:
        devices = list(one_device().devices.flat)
        _programs[name] = stored(name, devices, lambda: program.lower(scene, axes).compile())
    return _programs[name]


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
