"""Whether a scene made in Python holds what a scene file may hold."""

import sys
from dataclasses import replace
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.scene.data import (
    Film,
    MatrixCamera,
    OrthographicCamera,
    PerspectiveCamera,
    Scene,
    Sky,
    Spheres,
    Sun,
)
from raytrace.scene.document import document_of, scene_of
from raytrace.scene.rules import COORDINATE, INTENSITY, POSITIVE

__all__ = ["check_choices", "check_scene", "is_traced"]

_SECTIONS = {
    "spheres": (Spheres,),
    "planes": (tuple,),
    "sun": (Sun,),
    "sky": (Sky,),
    "camera": (PerspectiveCamera, OrthographicCamera, MatrixCamera),
    "film": (Film,),
}
#: The shape of one sphere's entry in each array, and its rules.
_SPHERES = {"center": ((3,), COORDINATE), "radius": ((), POSITIVE), "color": ((3,), INTENSITY)}


def check_scene(scene: Scene, where: str = "scene") -> None:
    """Checks every value of a concrete scene by the rules of the scene file.

    Raises:
        InputError: the first mistake: `where`, the value's path, what was found, what would be right.
    """
    for name, kinds in _SECTIONS.items():
        if not isinstance(getattr(scene, name), kinds):
            found = type(getattr(scene, name)).__name__
            expected = " or ".join(kind.__name__ for kind in kinds)
            raise InputError(f"{where}: {name}: must be a {expected}, found {found}")
    _check_spheres(scene.spheres, where)
    film = replace(scene.film, tone_mapper="none") if callable(scene.film.tone_mapper) else scene.film
    scene_of(document_of(replace(scene, spheres=Spheres(), film=film)), where)


def check_choices(scene: Scene, where: str = "scene") -> None:
    """Checks what is known of a traced scene too: everything but its numbers.

    Raises:
        InputError: the first mistake.
    """
    film = Film(white_point=scene.film.white_point, tone_mapper=scene.film.tone_mapper, transfer=scene.film.transfer)
    check_scene(Scene(lighting=scene.lighting, film=film), where)


def _check_spheres(spheres: Spheres, where: str) -> None:
    """All spheres at once: there may be a million."""
    n = len(spheres.radius) if np.ndim(spheres.radius) else 0
    for name, (shape, rules) in _SPHERES.items():
        values = np.asarray(getattr(spheres, name))
        if values.shape != (n, *shape):
            raise InputError(f"{where}: spheres.{name}: must be of shape {(n, *shape)}, found {values.shape}")
        for rule in rules:
            wrong = np.argwhere(~np.asarray(rule.holds(values)))
            if len(wrong):
                first, *component = wrong[0].tolist()
                path = f"spheres[{first}].{name}" + "".join(f"[{k}]" for k in component)
                raise InputError(f"{where}: {path}: {rule.message}, found {values[tuple(wrong[0])].item()!r}")


def is_traced(scene: Any) -> bool:
    """Whether any number of the scene is not there yet: JAX is tracing a function of it."""
    if "jax" not in sys.modules:
        return False
    import jax

    return any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree_util.tree_leaves(scene))
