"""The values of the uniforms that somebody's own shader uses, found by their names."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from raytrace.errors import InputError, did_you_mean, unknown
from raytrace.files import parsed_toml
from raytrace.glsl.declarations import sphere_texture
from raytrace.glsl.meanings import MEANINGS, meaning_of, meanings
from raytrace.glsl.values import flat_values

__all__ = ["matched", "parse_uniforms"]

#: Numbers of each type; whole ones for int, uint and bool.
_COMPONENTS = {
    **{f"{prefix}vec{n}": n for prefix in ("", "i", "b") for n in (2, 3, 4)},
    **dict.fromkeys(("float", "int", "uint", "bool"), 1),
    **{f"mat{n}": n * n for n in (2, 3, 4)},
}
#: By a type's first letter.
_NUMBERS = {"i": np.int32, "b": np.int32, "u": np.uint32}
_ELEMENT = re.compile(r"(spheres|planes|shadowPlanes)\[(\d+)\]\.(\w+)")
#: What stands for a direction and is extended to four components with 0, not 1.
_DIRECTIONS = {"sun_direction", "plane_normal"}


def matched(
    shader: str, active: Iterable[Any], values: dict[str, Any], size: tuple[int, int], given: Mapping[str, Any]
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The uniforms and textures for a program's active uniforms (name, type, length).

    shader: its name, for messages.
    values: those of `values_of`; an array longer than the scene's is filled up with zeros.
    given: by a uniform's name a key of `MEANINGS`, however spelt, or a number or numbers; or by an array's name.

    Raises:
        InputError: a uniform that says nothing to us, or whose type is another; a name in `given` that is not there.
    """
    known, own = meanings(values, size), flat_values(values)
    uniforms, textures, unused = {}, {}, dict(given)
    for uniform in active:
        where = f"{shader}: uniform {uniform.type} {uniform.name}"
        if uniform.name in given:
            found, meaning = _given(given[uniform.name], known, where)
            unused.pop(uniform.name, None)
        elif uniform.name == "sphereTexture":
            textures[uniform.name] = sphere_texture(values["spheres"])
            continue
        else:
            found, meaning = _found(uniform.name, own, known)
        if found is None:
            raise InputError(
                f"{where}: is not bound to anything; give --uniform {uniform.name}=NAME with a NAME of "
                f"{', '.join(MEANINGS)}, or a value"
            )
        uniforms[uniform.name] = _fitted(found, uniform, meaning in _DIRECTIONS, where)
    for name in unused:
        names = [uniform.name for uniform in active]
        used = did_you_mean(name, names, "used") if names else "it uses none"
        raise InputError(f"{shader}: uses no uniform {name!r}; {used}")
    return uniforms, textures


def parse_uniforms(settings: Iterable[str]) -> dict[str, Any]:
    """``name=camera_position`` or ``name=[1, 2, 3]``, as the command line gives them.

    Raises:
        InputError: it is neither.
    """
    parsed = {}
    for setting in settings:
        name, equals, text = (part.strip() for part in setting.partition("="))
        if not (name and equals and text):
            raise InputError(f"--uniform {setting}: must be name=camera_position, name=1.5 or name=[1,2,3]")
        try:
            parsed[name] = parsed_toml(f"value = {text}")["value"]
        except ValueError:
            parsed[name] = text
    return parsed


def _given(value: Any, known: dict[str, np.ndarray], where: str) -> tuple[np.ndarray | None, str | None]:
    if isinstance(value, str):
        meaning = meaning_of(value)
        if meaning is None:
            raise InputError(f"{where}: {unknown(value, MEANINGS)}")
        if meaning not in known:
            raise InputError(f"{where}: the scene has no {meaning}")
        return known[meaning], meaning
    try:
        return np.asarray(value, np.float64), None
    except (TypeError, ValueError):
        raise InputError(f"{where}: must be a name, a number or a list of numbers, found {value!r}") from None


def _found(name: str, own: dict[str, np.ndarray], known: dict[str, np.ndarray]) -> tuple[np.ndarray | None, str | None]:
    """The value for a uniform's name, and what it means."""
    if name in own:
        return own[name], meaning_of(name)
    element = _ELEMENT.fullmatch(name)
    if element:
        array, _, field = element.groups()
        if field == "color" and array != "spheres":
            return own.get(name.replace(".color", ".evenColor"), np.zeros(3)), None
        first = own.get(f"{array}[0].{field}")
        # An array with room for more than the scene has.
        return (None if first is None else np.zeros_like(first)), None
    meaning = meaning_of(name)
    return (None if meaning is None else known.get(meaning)), meaning


def _fitted(value: np.ndarray, uniform: Any, direction: bool, where: str) -> np.ndarray:
    """`value` as the numbers of the uniform's type."""
    components = _COMPONENTS.get(uniform.type)
    if components is None:
        raise InputError(f"{where}: a value of this type cannot be given")
    flat = value.reshape(len(value), -1) if uniform.length > 1 and value.ndim else value.reshape(1, -1)
    if uniform.length > 1 and value.ndim == 1 and components > 1:
        flat = value.reshape(1, -1)
    if (uniform.type, flat.shape[1]) == ("mat3", 16):
        flat = flat.reshape(-1, 4, 4)[:, :3, :3].reshape(-1, 9)
    if (uniform.type, flat.shape[1]) == ("vec4", 3):
        flat = np.pad(flat, ((0, 0), (0, 1)), constant_values=0 if direction else 1)
    if flat.shape[1] != components:
        raise InputError(f"{where}: has {components} components, its value {flat.shape[1]}")
    rows = flat[: uniform.length]
    full = np.pad(rows, ((0, uniform.length - len(rows)), (0, 0)))
    return full.ravel().astype(_NUMBERS.get(uniform.type[0], np.float32))
