"""Scenes as plain documents, and plain documents as scenes."""

from dataclasses import fields
from typing import Any

import numpy as np
from pydantic import ValidationError

from raytrace.errors import InputError
from raytrace.scene.data import CAMERAS, PATTERNS, Film, Plane, Scene, Sky, Spheres, Sun
from raytrace.scene.schema import SceneDocument

__all__ = ["document_of", "scene_of"]


def scene_of(document: dict, where: str) -> Scene:
    """The scene that `document` describes.

    Raises:
        InputError: the first mistake in it: `where` (a file's name), the key's path, what was found, what is right.
    """
    try:
        tables = SceneDocument.model_validate(document).model_dump()
    except ValidationError as error:
        raise InputError(f"{where}: {_explained(error, document)}") from None
    except RecursionError:
        raise InputError(f"{where}: nested too deeply") from None
    camera = tables["camera"]
    spheres = tables["spheres"]
    return Scene(
        spheres=Spheres(
            center=np.reshape([sphere["center"] for sphere in spheres], (-1, 3)).astype(np.float64),
            radius=np.array([sphere["radius"] for sphere in spheres], dtype=np.float64),
            color=np.reshape([sphere["color"] for sphere in spheres], (-1, 3)).astype(np.float64),
        ),
        planes=tuple(_plane(table) for table in tables["planes"]),
        sun=Sun(**tables["sun"]),
        sky=Sky(**tables["sky"]),
        lighting=tables["lighting"],
        camera=CAMERAS[camera.pop("projection")](**camera),
        film=Film(**tables["film"]),
    )


def _plane(table: dict) -> Plane:
    pattern = table.pop("pattern")
    return Plane(**table, pattern=PATTERNS[pattern.pop("type")](**pattern))


def document_of(scene: Scene) -> dict:
    """The document that describes `scene`: every value, defaults too, but for the ones that are ``None``.

    Raises:
        InputError: the tone mapper is a Python function, which no file can hold.
    """
    if callable(scene.film.tone_mapper):
        raise InputError("film.tone_mapper: a Python function cannot be written to a scene file")
    spheres = scene.spheres
    return {
        "lighting": scene.lighting,
        "camera": {"projection": _name(CAMERAS, scene.camera), **_table(scene.camera)},
        "sun": _table(scene.sun),
        "sky": _table(scene.sky),
        "film": _table(scene.film),
        "planes": [
            {**_table(plane), "pattern": {"type": _name(PATTERNS, plane.pattern), **_table(plane.pattern)}}
            for plane in scene.planes
        ],
        "spheres": [
            {"center": center, "radius": radius, "color": color}
            for center, radius, color in zip(*map(_plain, (spheres.center, spheres.radius, spheres.color)), strict=True)
        ],
    }


def _name(kinds: dict[str, type], record: Any) -> str:
    return next(name for name, kind in kinds.items() if type(record) is kind)


def _table(record: Any) -> dict:
    return {entry.name: _plain(value) for entry in fields(record) if (value := getattr(record, entry.name)) is not None}


def _plain(value: Any) -> Any:
    if hasattr(value, "__array_namespace__"):
        return np.asarray(value, dtype=np.float64).tolist()
    return list(value) if isinstance(value, tuple) else value


def _explained(error: ValidationError, document: Any) -> str:
    """The first mistake in one line: path, what would be right, what was found; and how many more there are."""
    first, *more = error.errors(include_url=False)
    context = first.get("ctx", {})
    path = _path(first["loc"], document)
    if first["type"] == "wrong_key":
        mistake = f"{_join(path, context['key'])}: {first['msg']}"
    elif first["type"] == "missing":
        mistake = f"{path}: missing"
    else:
        message = first["msg"].replace("Input should", "must")
        mistake = f"{path or 'scene'}: {message}{'' if 'found' in message else _found(first['input'])}"
    return mistake + (f" (and {len(more)} more)" if more else "")


def _found(value: Any) -> str:
    """What was found, where it is short enough to say."""
    try:
        text = repr(value) if not isinstance(value, dict) else ""
    except (RecursionError, ValueError):  # nested too deeply, or a number of too many digits
        text = ""
    return f", found {text}" if 0 < len(text) <= 60 else ""


def _path(location: tuple, document: Any) -> str:
    """``spheres[3].radius`` for pydantic's location, which also holds the tags of unions."""
    path = ""
    for part in location:
        there = isinstance(document, dict) and part in document
        if part in (*CAMERAS, *PATTERNS) and not there:
            continue
        path = _join(path, part)
        in_list = isinstance(part, int) and isinstance(document, list) and part < len(document)
        document = document[part] if there or in_list else None
    return path


def _join(path: str, part: str | int) -> str:
    if isinstance(part, int):
        return f"{path}[{part}]"
    return f"{path}.{part}" if path else part
