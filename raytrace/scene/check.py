"""Whether a scene made in Python holds what a scene file may hold."""

import sys
from dataclasses import fields, replace
from typing import Any, get_args, get_type_hints

import numpy as np

from raytrace.errors import InputError
from raytrace.scene.data import PATTERNS, Film, Plane, Scene, Spheres
from raytrace.scene.document import document_of, scene_of
from raytrace.scene.kinds import Kind

__all__ = ["check_scene", "check_structure", "is_traced"]


def check_scene(scene: Scene, where: str = "scene") -> None:
    """Checks every value of a concrete scene by the rules of the scene file.

    Raises:
        InputError: the first mistake: `where`, the value's path, what was found, what would be right.
    """
    _check_sections(scene, where)
    _check_spheres(scene.spheres, where)
    film = replace(scene.film, tone_mapper="none") if callable(scene.film.tone_mapper) else scene.film
    scene_of(document_of(replace(scene, spheres=Spheres(), film=film)), where)


def check_structure(scene: Scene, where: str = "scene") -> None:
    """Checks what is known of a traced scene too: everything but its numbers, that is sections, shapes and choices.

    Raises:
        InputError: the first mistake.
    """
    _check_sections(scene, where)
    film = Film(white_point=scene.film.white_point, tone_mapper=scene.film.tone_mapper, transfer=scene.film.transfer)
    check_scene(Scene(lighting=scene.lighting, film=film), where)


def _check_sections(scene: Scene, where: str) -> None:
    hints = get_type_hints(Scene)
    for name in (entry.name for entry in fields(Scene)):
        part, kinds, path = getattr(scene, name), hints[name], f"{where}: {name}"
        if name == "spheres":
            _check_class(part, (Spheres,), path)
            if np.ndim(part.radius) != 1:
                raise InputError(f"{path}.radius: must be of shape (n,), found {np.shape(part.radius)}")
            _check_shapes(part, path, np.shape(part.radius))
        elif name == "planes":
            _check_class(part, (tuple,), path)
            for i, plane in enumerate(part):
                _check_class(plane, (Plane,), f"{path}[{i}]")
                _check_class(plane.pattern, tuple(PATTERNS.values()), f"{path}[{i}].pattern")
                _check_shapes(plane, f"{path}[{i}]")
                _check_shapes(plane.pattern, f"{path}[{i}].pattern")
        elif name != "lighting":
            _check_class(part, get_args(kinds) or (kinds,), path)
            _check_shapes(part, path)


def _check_class(part: Any, kinds: tuple[type, ...], path: str) -> None:
    if not isinstance(part, kinds):
        expected = " or ".join(kind.__name__ for kind in kinds)
        raise InputError(f"{path}: must be a {expected}, found {type(part).__name__}")


def _check_shapes(record: Any, path: str, count: tuple[int, ...] = ()) -> None:
    """Check that each array has the shape of its kind; count: (n,) for n of them."""
    for name, kind in _kinds(record).items():
        value, shape = getattr(record, name), (*count, *kind.shape)
        if not hasattr(value, "shape"):
            raise InputError(f"{path}.{name}: must be an array of numbers, found {type(value).__name__}")
        if value.shape != shape:
            raise InputError(f"{path}.{name}: must be of shape {shape}, found {value.shape}")


def _kinds(record: Any) -> dict[str, Kind]:
    return {entry.name: entry.metadata["kind"] for entry in fields(record) if "kind" in entry.metadata}


def _check_spheres(spheres: Spheres, where: str) -> None:
    """All spheres at once: there may be a million."""
    for name, kind in _kinds(spheres).items():
        values = np.asarray(getattr(spheres, name))
        for rule in kind.rules:
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
    from jax.core import Tracer

    return any(isinstance(leaf, Tracer) for leaf in jax.tree_util.tree_leaves(scene))
