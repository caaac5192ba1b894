"""Changes to a scene's document from the command line: ``sun.direction=[0, 1, 0]``."""

import re
from typing import Any

from raytrace.errors import InputError
from raytrace.files import parsed_toml
from raytrace.scene.data import Sun
from raytrace.scene.path import parts_of
from raytrace.scene.sun import sun_angles

__all__ = ["change"]

_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_.-]*")

_ANGLES = ("azimuth", "elevation")
#: Which keys say the same as the one that is set.
_SAME: dict[tuple[str | int, ...], tuple[str, ...]] = {
    ("sun", "direction"): _ANGLES,
    ("camera", "fov"): ("field_of_view",),
    ("camera", "field_of_view"): ("fov",),
}


def change(document: dict, setting: str) -> None:
    """Sets one value of `document`: `setting` is ``path=value`` with a TOML value or a bare word.

    Raises:
        InputError: the setting has no ``=`` or no path, or the path leads through something that is not there,
            or the value cannot be read.
    """
    path, equals, text = setting.partition("=")
    path = path.strip()
    parts = parts_of(path)
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
    value = _value(text.strip(), setting)
    if isinstance(place, dict):
        _make_room(place, parents, str(last))
    place[last] = value


def _make_room(table: dict, where: list[str | int], key: str) -> None:
    """Take out of a table what says in other words what `key` is to say."""
    for name in _SAME.get((*where, key), ()):
        table.pop(name, None)
    if where == ["sun"] and key in _ANGLES and not any(angle in table for angle in _ANGLES if angle != key):
        # One angle is set; the other stays what the direction says.
        try:
            angles = map(float, sun_angles(table.pop("direction", Sun().direction)))
        except (TypeError, ValueError):
            return  # no direction, which is said where the whole scene is read
        table.update(zip(_ANGLES, angles, strict=True))


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
