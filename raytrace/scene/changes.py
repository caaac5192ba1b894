"""Changes to a scene's document from the command line: ``sun.direction=[0, 1, 0]``."""

import re
from typing import Any

from raytrace.errors import InputError
from raytrace.files import parsed_toml

__all__ = ["change"]

_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_.-]*")
_PART = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)((?:\[\d+\])*)")


def change(document: dict, setting: str) -> None:
    """Sets one value of `document`: `setting` is ``path=value`` with a TOML value or a bare word.

    Raises:
        InputError: the setting has no ``=`` or no path, or the path leads through something that is not there,
            or the value cannot be read.
    """
    path, equals, text = setting.partition("=")
    path = path.strip()
    parts = _parts(path)
    if not equals or not parts:
        raise InputError(f"--set {setting}: must be key=value, such as sun.direction=[0,1,0]")
    *parents, last = parts
    place: Any = document
    try:
        for part in parents:
            place = _entered(place, part)
        _entered(place, last)
    except LookupError:
        raise InputError(f"--set {setting}: the scene has no {path} to set") from None
    place[last] = _value(text.strip(), setting)


def _entered(place: object, part: str | int) -> object:
    """What is at `part` of a table (an empty table where there is nothing yet) or of a list.

    Raises:
        LookupError: `place` is neither, or the list is shorter.
    """
    if isinstance(place, dict) and isinstance(part, str):
        return place.setdefault(part, {})
    if isinstance(place, list) and isinstance(part, int):
        return place[part]
    raise LookupError(part)


def _parts(path: str) -> list[str | int]:
    """``["spheres", 0, "radius"]`` for ``spheres[0].radius``; empty if it is not a path."""
    parts: list[str | int] = []
    for name in path.split("."):
        match = _PART.fullmatch(name)
        if not match:
            return []
        parts += [match[1], *map(int, re.findall(r"\d+", match[2]))]
    return parts


def _value(text: str, setting: str) -> object:
    """A TOML value; a bare word such as ``reinhard`` is a string.

    Raises:
        InputError: it is neither.
    """
    if _WORD.fullmatch(text) and text not in ("true", "false", "inf", "nan"):
        return text
    try:
        parsed = parsed_toml(f"value = {text}")
    except ValueError:
        parsed = {}
    if parsed.keys() != {"value"}:
        raise InputError(f"--set {setting}: {text!r} is neither a TOML value nor a word")
    return parsed["value"]
