"""Embree's own sphere (`RTC_GEOMETRY_TYPE_SPHERE_POINT`), float32, by the library that the package embreex brings.

Structures and numbers: Embree 4, `rtcore_ray.h`, `rtcore_common.h`, `rtcore_geometry.h`, `rtcore_buffer.h`.
"""

import ctypes
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from raytrace.errors import InputError
from raytrace.studies.stress.rays import Rays

__all__ = ["intersect"]

_SPHERE_POINT, _VERTEX, _FLOAT4 = 50, 1, 0x9004
_NOTHING = 0xFFFFFFFF
#: struct RTCRayHit, aligned to 16 bytes, with room for instance numbers of either kind.
_RAY_HIT = np.dtype(
    [
        ("origin", np.float32, 3),
        ("near", np.float32),
        ("direction", np.float32, 3),
        ("time", np.float32),
        ("far", np.float32),
        ("mask", np.uint32),
        ("id", np.uint32),
        ("flags", np.uint32),
        ("normal", np.float32, 3),
        ("uv", np.float32, 2),
        ("primitive", np.uint32),
        ("geometry", np.uint32),
        ("instance", np.uint32, 5),
    ]
)


@cache
def _embree() -> ctypes.CDLL:
    """The library.

    Raises:
        InputError: embreex is not installed, or does not bring it.
    """
    package = find_spec("embreex")
    folder = None if package is None or package.origin is None else Path(package.origin).parent
    folders = [] if folder is None else [folder, folder.parent / "embreex.libs"]
    found = [path for folder in folders for path in sorted(folder.glob("libembree4*.so*"))]
    if not found:
        raise InputError("embree: needs the package embreex: pip install embreex")
    # What it depends on lies beside it under a name that only the package's own modules ask for.
    __import__("embreex.rtcore")
    library = ctypes.CDLL(str(found[0]))
    for name in ("rtcNewDevice", "rtcNewScene", "rtcNewGeometry", "rtcSetNewGeometryBuffer"):
        getattr(library, name).restype = ctypes.c_void_p
    return library


def intersect(rays: Rays) -> np.ndarray:
    """t of each ray, float32, -1 where it misses."""
    library, pointer = _embree(), ctypes.c_void_p
    device = pointer(library.rtcNewDevice(None))
    scene = pointer(library.rtcNewScene(device))
    # Without it Embree may use approximations that are faster.
    library.rtcSetSceneFlags(scene, 1 << 2)
    geometry = pointer(library.rtcNewGeometry(device, _SPHERE_POINT))
    size = ctypes.c_size_t
    memory = library.rtcSetNewGeometryBuffer(geometry, _VERTEX, 0, _FLOAT4, size(16), size(1))
    sphere = np.array([*(float(x) for x in rays.center), float(rays.radius)], np.float32)
    ctypes.memmove(memory, sphere.ctypes.data, sphere.nbytes)
    library.rtcCommitGeometry(geometry)
    library.rtcAttachGeometry(scene, geometry)
    library.rtcReleaseGeometry(geometry)
    library.rtcCommitScene(scene)
    hits = _cast(library, scene, rays)
    library.rtcReleaseScene(scene)
    library.rtcReleaseDevice(device)
    return np.where(hits["geometry"] == _NOTHING, np.float32(-1), hits["far"])


def _cast(library: ctypes.CDLL, scene: ctypes.c_void_p, rays: Rays) -> np.ndarray:
    n = rays.direction.x.size
    memory = np.zeros(n * _RAY_HIT.itemsize + 16, np.uint8)
    start = -memory.ctypes.data % 16
    hits = memory[start : start + n * _RAY_HIT.itemsize].view(_RAY_HIT)
    hits["origin"] = np.array([float(x) for x in rays.origin], np.float32)
    hits["direction"] = np.stack(rays.direction, axis=-1)
    hits["far"], hits["mask"] = np.inf, _NOTHING
    hits["geometry"] = hits["instance"] = _NOTHING
    for i in range(n):
        library.rtcIntersect1(scene, ctypes.c_void_p(hits.ctypes.data + i * _RAY_HIT.itemsize), None)
    return hits
