"""The values of a scene's uniforms, by the names that they have in GLSL."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from raytrace.language.control import count
from raytrace.language.tree import tree_leaves
from raytrace.shader.uniforms import Plane, Uniforms

__all__ = ["PLANE_FIELDS", "flat_values", "values_of"]

#: The fields of ``struct Plane``, in its order, beside those of `raytrace.shader.uniforms.Plane`.
PLANE_FIELDS: dict[str, str] = dict(
    zip(("point", "normal", "tileSize", "evenColor", "oddColor", "lineColor"), Plane._fields, strict=True)
)
_SPHERE_FIELDS = {name: name for name in ("center", "radius", "color")}


def values_of(uniforms: Uniforms) -> dict[str, Any]:
    """Every uniform by its GLSL name: float64 arrays of shape (), (3,), (9,) or (16,), matrices column by column.

    ``spheres``, ``planes`` and ``shadowPlanes`` are lists of dicts of them. What the film has nothing to do with
    is left out.
    """
    camera, sun, sky, film = uniforms.camera, uniforms.sun, uniforms.sky, uniforms.film
    records = {
        "camPos": camera.view_to_world.w.xyz,
        "ndcToView": camera.ndc_to_view,
        "viewToWorld": camera.view_to_world,
        "sunColor": sun.color,
        "sunDirection": sun.direction,
        "skyColorLow": sky.low,
        "skyColorHigh": sky.high,
        "voidColor": sky.void,
        "exposureFactor": film.exposure,
        "whiteBalance": film.white_balance,
    }
    return {name: _array(record) for name, record in records.items() if record is not None} | {
        "spheres": _structs(uniforms.spheres, _SPHERE_FIELDS),
        "planes": _structs(uniforms.planes, PLANE_FIELDS),
        "shadowPlanes": _structs(uniforms.shadow_planes, PLANE_FIELDS),
    }


def flat_values(values: dict[str, Any]) -> dict[str, np.ndarray]:
    """`values_of` with the structs taken apart: ``"spheres[0].center"``."""
    flat = {}
    for name, value in values.items():
        if isinstance(value, list):
            for i, struct in enumerate(value):
                flat |= {f"{name}[{i}].{field}": member for field, member in struct.items()}
        else:
            flat[name] = value
    return flat


def _array(record: Any) -> np.ndarray:
    leaves = np.array(tree_leaves(record), np.float64)
    return leaves if isinstance(record, tuple) else leaves.reshape(())


def _structs(structs: Any, names: Mapping[str, str]) -> list[dict[str, np.ndarray]]:
    """One dict a struct, of a struct of arrays."""
    if structs is None:
        return []
    fields = {name: np.array(tree_leaves(getattr(structs, field))).T for name, field in names.items()}
    fields = {name: array if array.shape[1] > 1 else array[:, 0] for name, array in fields.items()}
    # With the ellipsis a number stays an array, of shape ().
    return [{name: array[i, ...] for name, array in fields.items()} for i in range(count(structs))]
