"""What a uniform of somebody's own shader stands for, by its name, and the values of all that it may stand for.

The names of the values to attach are those of ShaderLabWeb (github.com/bkainz/ShaderLabWeb).
"""

import math
import re
from typing import Any

import numpy as np

__all__ = ["MEANINGS", "meaning_of", "meanings"]

#: Every value that a uniform may stand for, and the other names that people give it.
MEANINGS: dict[str, tuple[str, ...]] = {
    "camera_position": (
        "camPos",
        "cameraPos",
        "camera",
        "eye",
        "eyePosition",
        "viewPosition",
        "ro",
        "rayOrigin",
        "cameraOrigin",
    ),
    "inverse_view_matrix": (
        *("viewToWorld", "inverseView", "invView", "invViewMatrix", "viewInverse", "viewMatrixInverse"),
        *("cameraMatrix", "cameraToWorld", "inverseVMatrix", "invVMatrix", "vMatrixInverse", "ivMatrix"),
    ),
    "inverse_projection_matrix": (
        *("ndcToView", "inverseProjection", "invProjection", "invProjectionMatrix", "projectionInverse", "invProj"),
        *("projectionMatrixInverse", "inversePMatrix", "invPMatrix", "pMatrixInverse", "ipMatrix", "clipToView"),
    ),
    "view_matrix": ("vMatrix", "view", "worldToView"),
    "projection_matrix": ("pMatrix", "projection", "viewToNdc", "proj"),
    "camera_rotation": (),
    "model_matrix": ("mMatrix", "model"),
    "inverse_model_matrix": (),
    "near_clipping_plane": ("near", "nearPlane"),
    "far_clipping_plane": ("far", "farPlane"),
    "perspective_fov": ("fov", "fieldOfView"),
    "canvas_width": ("width",),
    "canvas_height": ("height",),
    "resolution": ("canvasSize", "viewport", "viewportSize", "screenSize", "size"),
    "aspect": ("aspectRatio",),
    "time_in_milliseconds": ("time",),
    "frame_number": ("frame",),
    "mouse": (),
    "sun_color": ("lightColor",),
    "sun_direction": ("sunDir", "lightDirection", "lightDir"),
    "sky_color_low": ("skyLow",),
    "sky_color_high": ("skyHigh",),
    "void_color": ("void",),
    "exposure_factor": ("exposure",),
    "white_balance": (),
    "sphere_count": ("numSpheres", "spheresCount", "nSpheres", "numberOfSpheres"),
    "sphere_centers": ("sphereCenter", "spherePositions"),
    "sphere_radii": ("sphereRadius", "sphereRadiuses"),
    "sphere_colors": ("sphereColor",),
    "plane_count": ("numPlanes", "planesCount", "nPlanes", "numberOfPlanes"),
    "plane_point": ("planePosition",),
    "plane_normal": (),
    "tile_size": ("tile",),
}


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "", name).lower()


_KNOWN = {_plain(alias): name for name, aliases in MEANINGS.items() for alias in (name, *aliases)}


def meaning_of(name: str) -> str | None:
    """The key of `MEANINGS` for a uniform's name, however it is spelt; ``None`` if it says nothing to us.

    A leading u, u_ or i is taken for the habit that it is: ``u_sunDirection``, ``iResolution``.
    """
    plain = _plain(name)
    short = re.sub(r"^(u_|u(?=[A-Z])|i(?=[A-Z]))", "", name)
    return _KNOWN.get(plain) or _KNOWN.get(_plain(short))


def meanings(values: dict[str, Any], size: tuple[int, int]) -> dict[str, np.ndarray]:
    """The value of each key of `MEANINGS` that the scene has; `values` are those of `values_of`.

    Matrices are (16,) or (9,), column by column; lists of spheres (n, components).
    """
    to_world, to_view = (values[name].reshape(4, 4).T for name in ("viewToWorld", "ndcToView"))
    projection = np.linalg.inv(to_view)
    near, far = (_depth(to_view, z) for z in (-1.0, 1.0))
    width, height = size
    spheres, planes = values["spheres"], values["planes"]
    found = {
        "camera_position": values["camPos"],
        "inverse_view_matrix": values["viewToWorld"],
        "inverse_projection_matrix": values["ndcToView"],
        "view_matrix": np.linalg.inv(to_world).T.ravel(),
        "projection_matrix": projection.T.ravel(),
        "camera_rotation": to_world[:3, :3].T.ravel(),
        "model_matrix": np.eye(4).ravel(),
        "inverse_model_matrix": np.eye(4).ravel(),
        "near_clipping_plane": near,
        "far_clipping_plane": far,
        "perspective_fov": math.degrees(2 * math.atan(abs(to_view[1, 1]))),
        "canvas_width": width,
        "canvas_height": height,
        "resolution": [width, height],
        "aspect": width / height,
        # A still, and nobody points at it.
        "time_in_milliseconds": 0,
        "frame_number": 0,
        "mouse": np.zeros(4),
        "sun_color": values["sunColor"],
        "sun_direction": values["sunDirection"],
        "sky_color_low": values["skyColorLow"],
        "sky_color_high": values["skyColorHigh"],
        "void_color": values["voidColor"],
        "exposure_factor": values.get("exposureFactor", 1),
        "white_balance": values.get("whiteBalance", np.eye(3).ravel()),
        "sphere_count": len(spheres),
        "plane_count": len(planes),
    }
    for name, field, shape in (
        ("sphere_centers", "center", (-1, 3)),
        ("sphere_radii", "radius", (-1,)),
        ("sphere_colors", "color", (-1, 3)),
    ):
        found[name] = np.reshape([sphere[field] for sphere in spheres], shape)
    if planes:
        found |= {"plane_point": planes[0]["point"], "plane_normal": planes[0]["normal"]}
        found["tile_size"] = planes[0]["tileSize"]
    return {name: np.asarray(value, np.float64) for name, value in found.items()}


def _depth(to_view: np.ndarray, z: float) -> float:
    """How far in front of the camera the plane of depth `z` in normalised device coordinates is."""
    point = to_view @ [0, 0, z, 1]
    return float(-point[2] / point[3]) if point[3] else math.inf
