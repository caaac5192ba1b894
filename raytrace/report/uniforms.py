"""What the shader is given, for somebody who feeds another renderer."""

from typing import Any

import numpy as np

from raytrace.scene.data import OrthographicCamera, Plain, Scene
from raytrace.shader.glsl import Mat4, Vec3
from raytrace.uniforms import uniforms_of

__all__ = ["uniforms_report"]


def uniforms_report(scene: Scene, size: tuple[int, int]) -> dict[str, Any]:
    """The uniforms of `scene`, by the assignment's names, for JSON.

    Every number is a dict: "value" in double, as it was computed; "float32", what it is rounded to and rendered with;
    that number's hexadecimal notation ("hex", as in C and Python) and its 32 bits ("bits"). Vectors are lists,
    matrices lists of 16 in GLSL's order, column by column.
    """
    uniforms = uniforms_of(scene, size[0] / size[1])
    camera, sun, sky, film = uniforms.camera, uniforms.sun, uniforms.sky, uniforms.film
    return {
        "camPos": _vector(camera.view_to_world.w.xyz),
        "ndcToView": _matrix(camera.ndc_to_view),
        "viewToWorld": _matrix(camera.view_to_world),
        "sunColor": _vector(sun.color),
        "sunDirection": _vector(sun.direction),
        "skyColorLow": _vector(sky.low),
        "skyColorHigh": _vector(sky.high),
        "voidColor": _vector(sky.void),
        "spheres": _structs(uniforms.spheres),
        "planes": [
            struct | {"castsShadow": plane.casts_shadow, "plain": isinstance(plane.pattern, Plain)}
            for struct, plane in zip(_structs(uniforms.planes), scene.planes, strict=True)
        ],
        "orthographic": isinstance(scene.camera, OrthographicCamera),
        "lighting": scene.lighting,
        "exposureFactor": None if film.exposure is None else _number(film.exposure),
        "whiteBalance": None if film.white_balance is None else [_vector(column) for column in film.white_balance],
        "toneMapper": scene.film.tone_mapper,
        "transfer": scene.film.transfer,
    }


def _number(x: Any) -> dict[str, Any]:
    rounded = np.float32(x)
    return {
        "value": float(x),
        "float32": float(rounded),
        "hex": float(rounded).hex(),
        "bits": f"0x{rounded.view(np.uint32):08x}",
    }


def _vector(vector: tuple) -> list:
    return [_number(component) for component in vector]


def _matrix(matrix: Mat4) -> list:
    return [_number(component) for column in matrix for component in column]


_STRUCT_NAMES = {"tile_size": "tileSize", "even": "evenColor", "odd": "oddColor", "line": "lineColor"}


def _structs(structs: Any) -> list[dict[str, Any]]:
    """One dict a struct, of a struct of arrays."""
    if structs is None:
        return []

    def item(array: Any, i: int) -> Any:
        return _vector(Vec3(*(component[i] for component in array))) if isinstance(array, Vec3) else _number(array[i])

    return [
        {_STRUCT_NAMES.get(name, name): item(array, i) for name, array in structs._asdict().items()}
        for i in range(len(structs[0].x))
    ]
