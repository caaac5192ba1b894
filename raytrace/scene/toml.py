"""Scene files: TOML in, TOML out, and the scenes that come with the package."""

import hashlib
import re
from collections.abc import Iterable
from importlib import resources
from pathlib import Path

import tomli_w

from raytrace.errors import InputError, did_you_mean
from raytrace.files import parsed_toml, read_text, whole_file
from raytrace.scene.changes import change
from raytrace.scene.check import check_scene
from raytrace.scene.data import Scene
from raytrace.scene.document import document_of, scene_of

__all__ = [
    "DEFAULT_SCENE",
    "as_scene",
    "figures",
    "load_scene",
    "save_scene",
    "scene_from_toml",
    "scene_hash",
    "scene_toml",
    "scenes",
]

DEFAULT_SCENE = "checkerboard"

_BUILT_IN = resources.files("raytrace.scene") / "scenes"

#: A list of numbers as tomli_w writes it, a line each.
_NUMBERS = re.compile(r"\[\n((?:\s+[-+.\de]+,\n)+)\s*\]")


def scenes() -> dict[str, str]:
    """The built-in scenes, the assignment's figures first: their names, and what each one shows."""
    comments = {
        file.name.removesuffix(".toml"): file.read_text(encoding="utf-8").splitlines()[0].lstrip("# ")
        for file in _BUILT_IN.iterdir()
        if file.name.endswith(".toml")
    }
    return dict(sorted(comments.items(), key=lambda item: (not item[1].startswith("Figure"), item[1])))


def figures() -> list[str]:
    """The names of those built-in scenes that are figures of the assignment."""
    return [name for name, comment in scenes().items() if comment.startswith("Figure")]


def load_scene(scene: str | Path, changes: Iterable[str] = ()) -> Scene:
    """The scene in a TOML file, or of a built-in's name; validated.

    changes: settings like ``"sun.direction=[0, 1, 0]"`` or ``"spheres[0].radius=2"``, made before validation.

    Raises:
        InputError: there is no such scene, or its file, its TOML, or one of its values is wrong.
    """
    return scene_from_toml(_text(str(scene)), str(scene), changes)


def as_scene(scene: Scene | str | Path) -> Scene:
    """Return a checked scene: the one given, a built-in by its name, or a file's.

    Raises:
        InputError: there is no such scene, or one of its values is wrong.
    """
    if not isinstance(scene, Scene):
        return load_scene(scene)
    check_scene(scene)
    return scene


def scene_from_toml(text: str, where: str, changes: Iterable[str] = ()) -> Scene:
    """The scene that the text of a scene file describes; `where` it comes from is said in messages.

    Raises:
        InputError: its TOML or one of its values is wrong.
    """
    try:
        document = parsed_toml(text)
    except ValueError as error:
        raise InputError(f"{where}: not TOML: {error}") from None
    changed = where
    for setting in changes:
        change(document, setting)
        changed = f"{where} with {setting}"
    return scene_of(document, changed)


def _text(name: str) -> str:
    path = Path(name)
    built_in = _BUILT_IN / f"{name}.toml"
    if path.name == name and built_in.is_file():
        return built_in.read_text(encoding="utf-8")
    try:
        return read_text(path, "TOML")
    except FileNotFoundError:
        if path.suffix or path.parent != Path("."):
            raise InputError(f"{name}: no such file") from None
        raise InputError(f"{name}: no such scene; {did_you_mean(name, scenes(), 'built in')}") from None


def scene_toml(scene: Scene) -> str:
    """The scene as the text of a scene file: every value written out, floats so that they come back the same.

    Raises:
        InputError: the tone mapper is a Python function.
    """
    text = tomli_w.dumps(document_of(scene))
    return _NUMBERS.sub(lambda match: f"[{' '.join(match[1].split()).rstrip(',')}]", text)


def scene_hash(scene: Scene) -> str:
    """The SHA-256 of `scene_toml`, in hexadecimal: another value anywhere, another hash."""
    return hashlib.sha256(scene_toml(scene).encode()).hexdigest()


def save_scene(scene: Scene, path: str | Path) -> None:
    """Writes the scene to a TOML file, whole or not at all.

    Raises:
        InputError: a value of the scene is wrong, or the file cannot be written.
    """
    check_scene(scene)
    text = scene_toml(scene)
    with whole_file(Path(path)) as temporary:
        temporary.write_text(text, encoding="utf-8")
