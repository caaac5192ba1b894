"""Whether a scene made in Python holds what a scene file may hold."""

from dataclasses import replace
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.scene.data import Scene, Spheres
from raytrace.scene.document import document_of, scene_of
from raytrace.scene.rules import NOT_NEGATIVE, NUMBER, POSITIVE

__all__ = ["check_scene", "is_traced"]

_SPHERES = {"center": ((3,), NUMBER), "radius": ((), POSITIVE), "color": ((3,), NOT_NEGATIVE)}


def check_scene(scene: Scene, where: str = "scene") -> None:
    """Checks every value of a concrete scene by the rules of the scene file.

    Raises:
        InputError: the first mistake: `where`, the value's path, what was found, what would be right.
    """
    _check_spheres(scene.spheres, where)
    film = replace(scene.film, tone_mapper="none") if callable(scene.film.tone_mapper) else scene.film
    scene_of(document_of(replace(scene, spheres=Spheres(), film=film)), where)


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
    import sys

    if "jax" not in sys.modules:
        return False
    import jax

    return any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree_util.tree_leaves(scene))
