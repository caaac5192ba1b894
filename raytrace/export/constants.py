"""A scene's numbers as constants of another language: C (a header for C++ and CUDA, too) and WGSL."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from raytrace.glsl import values_of
from raytrace.scene.data import Scene
from raytrace.scene.to_uniforms import uniforms_of

__all__ = ["c_header", "wgsl_constants"]


class _Language(NamedTuple):
    """How a language writes constants by their names: a whole number; floats, perhaps those of `several` things."""

    whole: Callable[[str, int], str]
    floats: Callable[[str, np.ndarray, bool], str]


def c_header(scene: Scene, size: tuple[int, int], *, intersection: str = "textbook", data: str = "constants") -> str:
    """Return a header for C, C++ and CUDA with the scene's numbers, by the assignment's names.

    They are float32, written so that they are read back bit by bit; matrices column by column. Of the spheres and
    planes there is an array for each member: `sphereCenter[n][3]`, `sphereRadius[n]`. `intersection` and `data`, which
    other exports take, change nothing.

    Raises:
        InputError: the scene has what GLSL cannot have.
    """
    return f"#pragma once\n{_constants(scene, size, C)}"


def wgsl_constants(
    scene: Scene, size: tuple[int, int], *, intersection: str = "textbook", data: str = "constants"
) -> str:
    """Return the same as constants of WGSL: `vec3<f32>`, `mat4x4<f32>`, and arrays of them."""
    return _constants(scene, size, WGSL)


def _constants(scene: Scene, size: tuple[int, int], language: _Language) -> str:
    values = values_of(uniforms_of(scene, size[0] / size[1]))
    lines = [
        f"// A scene's numbers at {size[0]}x{size[1]}: float32, exactly; matrices column by column.",
        language.whole("imageWidth", size[0]),
        language.whole("imageHeight", size[1]),
    ]
    for name, value in values.items():
        if not isinstance(value, list):
            lines.append(language.floats(name, np.asarray(value, np.float32), False))
        elif name != "shadowPlanes":
            one = name.removesuffix("s")
            lines.append(language.whole(f"{one}Count", len(value)))
            for member in value[0] if value else ():
                column = np.array([each[member] for each in value], np.float32)
                lines.append(language.floats(f"{one}{member[0].upper()}{member[1:]}", column, True))
    lines += [language.whole(f"plane{i}CastsShadow", 1) for i, plane in enumerate(scene.planes) if plane.casts_shadow]
    return "\n".join([*lines, ""])


def _float(x: Any) -> str:
    """The shortest decimal that is read back as that float32."""
    x = np.float32(x)
    text = np.format_float_positional(x, trim="0") if 1e-4 <= abs(x) < 1e7 or x == 0 else str(x)
    return text if any(mark in text for mark in ".e") else f"{text}.0"


def _c_floats(name: str, array: np.ndarray, several: bool) -> str:
    def braced(part: Any) -> str:
        return f"{_float(part)}f" if part.ndim == 0 else f"{{{', '.join(map(braced, part))}}}"

    return f"static const float {name}{''.join(f'[{n}]' for n in array.shape)} = {braced(array)};"


#: WGSL's types of so many numbers.
_WGSL_TYPES = {3: "vec3<f32>", 9: "mat3x3<f32>", 16: "mat4x4<f32>"}


def _wgsl_value(part: Any) -> tuple[str, str]:
    """The type and the text of a number, a vector or a matrix."""
    if np.ndim(part) == 0:
        return "f32", _float(part)
    kind = _WGSL_TYPES[len(part)]
    return kind, f"{kind}({', '.join(map(_float, part))})"


def _wgsl_floats(name: str, array: np.ndarray, several: bool) -> str:
    if not several:
        kind, value = _wgsl_value(array)
    else:
        kinds, values = zip(*map(_wgsl_value, array), strict=True)
        kind = f"array<{kinds[0]}, {len(kinds)}>"
        value = f"{kind}({', '.join(values)})"
    return f"const {name}: {kind} = {value};"


C = _Language(lambda name, n: f"enum {{ {name} = {n} }};", _c_floats)
WGSL = _Language(lambda name, n: f"const {name}: u32 = {n}u;", _wgsl_floats)
