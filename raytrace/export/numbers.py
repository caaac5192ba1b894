"""What the shader is given, for somebody who feeds another renderer."""

from typing import Any

import numpy as np

from raytrace.glsl import values_of
from raytrace.scene.data import OrthographicCamera, Plain, Scene
from raytrace.scene.to_uniforms import uniforms_of

__all__ = ["uniforms_report"]


def uniforms_report(scene: Scene, size: tuple[int, int]) -> dict[str, Any]:
    """The uniforms of `scene`, by the assignment's names, for JSON.

    Every number is a dict: "value" in double, as it was computed; "float32", what it is rounded to and rendered with;
    that number's hexadecimal notation ("hex", as in C and Python) and its 32 bits ("bits"). Vectors are lists,
    matrices lists of 16 or 9 in GLSL's order, column by column.
    """
    uniforms = uniforms_of(scene, size[0] / size[1])
    values = values_of(uniforms)
    planes = [
        struct | {"castsShadow": plane.casts_shadow, "plain": isinstance(plane.pattern, Plain)}
        for struct, plane in zip(values["planes"], scene.planes, strict=True)
    ]
    film = {"exposureFactor": None, "whiteBalance": None}
    del values["shadowPlanes"]
    return {name: _report(value) for name, value in (film | values | {"planes": planes}).items()} | {
        "orthographic": isinstance(scene.camera, OrthographicCamera),
        "lighting": scene.lighting,
        "toneMapper": scene.film.tone_mapper,
        "transfer": scene.film.transfer,
    }


def _report(value: Any) -> Any:
    """The numbers of an array, a list or a dict; anything else as it is."""
    if isinstance(value, dict):
        return {name: _report(member) for name, member in value.items()}
    if isinstance(value, list) or np.ndim(value):
        return [_report(member) for member in value]
    return _number(value) if isinstance(value, np.ndarray | np.floating) else value


def _number(x: Any) -> dict[str, Any]:
    rounded = np.float32(x)
    return {
        "value": float(x),
        "float32": float(rounded),
        "hex": float(rounded).hex(),
        "bits": f"0x{rounded.view(np.uint32):08x}",
    }
