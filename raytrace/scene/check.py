"""Whether a scene made in Python holds what a scene file may hold."""

import sys
from dataclasses import fields, replace
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.scene.data import (
    Checkerboard,
    Film,
    MatrixCamera,
    OrthographicCamera,
    PerspectiveCamera,
    Plain,
    Plane,
    Scene,
    Sky,
    Spheres,
    Sun,
)
from raytrace.scene.document import document_of, scene_of
from raytrace.scene.rules import COORDINATE, INTENSITY, POSITIVE

__all__ = ["check_scene", "check_structure", "is_traced"]

_SECTIONS = {
    "spheres": (Spheres,),
    "planes": (tuple,),
    "sun": (Sun,),
    "sky": (Sky,),
    "camera": (PerspectiveCamera, OrthographicCamera, MatrixCamera),
    "film": (Film,),
}
#: One record of each class, for the shapes of its arrays.
_TEMPLATES = {
    type(record): record
    for record in (
        Plane(),
        Checkerboard(),
        Plain([0, 0, 0]),
        Sun(),
        Sky(),
        Film(),
        PerspectiveCamera(),
        OrthographicCamera(1),
        MatrixCamera(np.eye(4), np.eye(4)),
    )
}
#: The shape of one sphere's entry in each array, and its rules.
_SPHERES = {"center": ((3,), COORDINATE), "radius": ((), POSITIVE), "color": ((3,), INTENSITY)}


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
    for name, kinds in _SECTIONS.items():
        if not isinstance(getattr(scene, name), kinds):
            found = type(getattr(scene, name)).__name__
            expected = " or ".join(kind.__name__ for kind in kinds)
            raise InputError(f"{where}: {name}: must be a {expected}, found {found}")
    count = np.shape(scene.spheres.radius)
    if len(count) != 1:
        raise InputError(f"{where}: spheres.radius: must be of shape (n,), found {count}")
    for name, (shape, _) in _SPHERES.items():
        _check_shape(getattr(scene.spheres, name), count + shape, f"{where}: spheres.{name}")
    for i, plane in enumerate(scene.planes):
        if not isinstance(plane, Plane) or not isinstance(plane.pattern, Checkerboard | Plain):
            raise InputError(f"{where}: planes[{i}]: must be a Plane with a Checkerboard or Plain pattern")
        _check_record(plane, f"{where}: planes[{i}]")
        _check_record(plane.pattern, f"{where}: planes[{i}].pattern")
    for name in ("sun", "sky", "camera", "film"):
        _check_record(getattr(scene, name), f"{where}: {name}")


def _check_record(record: Any, path: str) -> None:
    """Each array of the record has the shape that its class gives it."""
    template = _TEMPLATES[type(record)]
    for entry in fields(record):
        expected = getattr(template, entry.name)
        if isinstance(expected, np.ndarray):
            _check_shape(getattr(record, entry.name), expected.shape, f"{path}.{entry.name}")


def _check_shape(value: Any, shape: tuple[int, ...], path: str) -> None:
    if not hasattr(value, "shape"):
        raise InputError(f"{path}: must be an array of numbers, found {type(value).__name__}")
    if value.shape != shape:
        raise InputError(f"{path}: must be of shape {shape}, found {value.shape}")


def _check_spheres(spheres: Spheres, where: str) -> None:
    """All spheres at once: there may be a million."""
    for name, (_, rules) in _SPHERES.items():
        values = np.asarray(getattr(spheres, name))
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
