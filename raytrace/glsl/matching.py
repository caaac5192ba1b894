"""The values of the uniforms that somebody's own shader uses, found by their names."""

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from raytrace.errors import InputError, did_you_mean, unknown
from raytrace.files import parsed_toml
from raytrace.glsl.declarations import sphere_texture
from raytrace.glsl.meanings import MEANINGS, meaning_of, meanings
from raytrace.glsl.values import PLANE_FIELDS, flat_values

__all__ = ["matched", "parse_uniforms"]

#: Numbers of each type; whole ones for int, uint and bool.
_COMPONENTS = {
    **{f"{prefix}vec{n}": n for prefix in ("", "i", "b") for n in (2, 3, 4)},
    **dict.fromkeys(("float", "int", "uint", "bool"), 1),
    **{f"mat{n}": n * n for n in (2, 3, 4)},
}
#: By a type's first letter.
_NUMBERS = {"i": np.int32, "b": np.int32, "u": np.uint32}
_ELEMENT = re.compile(r"(?:\w+\.)?(spheres|planes|shadowPlanes)\[(\d+)\]\.(\w+)")
#: The fields of the scene's structs, empty.
_SPHERE = {"center": np.zeros(3), "radius": np.zeros(()), "color": np.zeros(3)}
_PLANE = {name: np.zeros(() if name == "tileSize" else 3) for name in PLANE_FIELDS}
#: What stands for a direction and is extended to four components with 0, not 1.
_DIRECTIONS = {"sun_direction", "plane_normal"}


def matched(
    shader: str,
    active: Iterable[Any],
    values: dict[str, Any],
    size: tuple[int, int],
    given: Mapping[str, Any],
    declared: Mapping[str, str],
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The uniforms and textures for a program's active uniforms (name, type, length).

    shader: its name, for messages.
    values: those of `values_of`; an array longer than the scene's is filled up with zeros.
    given: by a uniform's name a key of `MEANINGS`, however spelt, or a number or numbers; or by an array's name. A
        matrix is a list of its rows, or of all its numbers, column by column.
    declared: the uniforms that the text declares, used or not (`raytrace.glsl.source.ShaderSource.declared`); one with
        a value of its own keeps it.

    Raises:
        InputError: a uniform that says nothing to us, or whose type is another; an array that the scene does not fit
            in; a name in `given` that is not there.
    """
    known, own = meanings(values, size), flat_values(values)
    uniforms, textures, unused = {}, {}, dict(given)
    active = list(active)
    _check_lengths(shader, active, values, declared)
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
        if found is None and "=" in declared.get(uniform.name, ""):
            continue
        if found is None:
            raise InputError(
                f"{where}: is not bound to anything; give --uniform {uniform.name}=NAME with a NAME of "
                f"{', '.join(MEANINGS)}, or a value"
            )
        uniforms[uniform.name] = _fitted(found, uniform, meaning, where)
    # A uniform that changes nothing in the picture is left out by compilers: by some, not by all.
    for name in (name for name in unused if re.split(r"[.\[]", name)[0] not in declared):
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
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{where}: must be a name, a number or a list of numbers, found {str(value)[:80]}") from None


def _check_lengths(shader: str, active: list[Any], values: dict[str, Any], declared: Mapping[str, str]) -> None:
    """Check that the scene's spheres and planes fit in a shader's arrays of structs."""
    used: dict[str, int] = {}
    for uniform in active:
        if element := _ELEMENT.fullmatch(uniform.name):
            used[element[1]] = max(used.get(element[1], 0), int(element[2]) + 1)
    for array, count in used.items():
        # A compiler leaves out the elements that are never used.
        stated = re.match(r"\[\s*(\d{1,9})\s*\]", declared.get(array, ""))
        room = max(count, int(stated[1])) if stated else count
        if room < len(values[array]):
            raise InputError(f"{shader}: uniform {array}[{room}]: is too short for the scene's {len(values[array])}")


def _found(name: str, own: dict[str, np.ndarray], known: dict[str, np.ndarray]) -> tuple[np.ndarray | None, str | None]:
    """The value for a uniform's name, and what it means."""
    if name in own:
        return own[name], meaning_of(name)
    element = _ELEMENT.fullmatch(name)
    if element:
        array, _, field = element.groups()
        if field == "color" and array != "spheres":
            field = "evenColor"
        fields = _SPHERE if array == "spheres" else _PLANE
        # What is not among the scene's is of an array with room for more.
        return own.get(f"{array}[{element[2]}].{field}", fields.get(field)), None
    # A member of a struct or of a block says what it is, alone or together with that: scene.eye, camera.position.
    owner, _, member = name.partition(".")
    if member and (found := _found(member, own, known))[0] is not None:
        return found
    meaning = meaning_of(owner + member)
    return (None if meaning is None else known.get(meaning)), meaning


def _fitted(value: np.ndarray, uniform: Any, meaning: str | None, where: str) -> np.ndarray:
    """`value` as the numbers of the uniform's type."""
    components = _COMPONENTS.get(uniform.type)
    if components is None:
        raise InputError(f"{where}: a value of this type cannot be given")
    if (
        uniform.type.startswith("mat")
        and value.ndim > 1
        and value.shape[-2:] in ((4, 4), (math.isqrt(components),) * 2)
    ):
        value = value.swapaxes(-1, -2).reshape(*value.shape[:-2], -1)  # rows, as scene files have them
    # One row for each element of an array.
    several = uniform.length > 1 and (value.ndim > 1 or (value.ndim == 1 and components == 1))
    flat = value.reshape(len(value), math.prod(value.shape[1:])) if several else value.reshape(1, -1)
    if (uniform.type, flat.shape[1]) == ("mat3", 16):
        flat = flat.reshape(-1, 4, 4)[:, :3, :3].reshape(-1, 9)
    if (uniform.type, flat.shape[1]) == ("vec4", 3):
        flat = np.pad(flat, ((0, 0), (0, 1)), constant_values=0 if meaning in _DIRECTIONS else 1)
    if (uniform.type, flat.shape[1], meaning) == ("vec3", 2, "resolution"):
        flat = np.pad(flat, ((0, 0), (0, 1)), constant_values=1)  # Shadertoy's third is the shape of a pixel
    if flat.shape[1] != components:
        raise InputError(f"{where}: has {components} components, its value {flat.shape[1]}")
    if len(flat) > uniform.length:
        raise InputError(f"{where}: has {uniform.length} elements, too few for the {len(flat)} of its value")
    full = np.pad(flat, ((0, uniform.length - len(flat)), (0, 0)))
    return _numbers(full.ravel(), uniform.type, where)


def _numbers(values: np.ndarray, kind: str, where: str) -> np.ndarray:
    """`values` in the numbers of a GLSL type, which hold them."""
    if kind[0] == "b":
        return (values != 0).astype(np.int32)
    numbers = _NUMBERS.get(kind[0], np.float32)
    limits = np.finfo(numbers) if numbers is np.float32 else np.iinfo(numbers)
    wrong = np.isfinite(values) & ((values < limits.min) | (values > limits.max))
    if numbers is not np.float32:
        wrong = wrong | (values != np.trunc(values)) | ~np.isfinite(values)
    if wrong.any():
        right = "numbers of float32" if numbers is np.float32 else f"whole numbers from {limits.min} to {limits.max}"
        raise InputError(f"{where}: takes {right}, found {values[wrong][0]:g}")
    return values.astype(numbers)
