"""Mitsuba 3 with Embree: the same primary and shadow rays, and nothing else: no sky, no colours, no film.

Needs LLVM's library (Debian: libllvm15 or newer) beside the package.
"""

import glob
import os
import re
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.scene.data import PerspectiveCamera, Scene

__all__ = ["built", "prepared", "queries"]

#: Mitsuba has no endless plane: half the side of the rectangle that stands for one.
FAR = 1e4
OLDEST_LLVM = 15


def prepared() -> Any:
    """The module `mitsuba` with the variant llvm_ad_rgb.

    Raises:
        InputError: it, or LLVM's library, is not installed.
    """
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        os.environ["DRJIT_LIBLLVM_PATH"] = _newest_llvm()
    import mitsuba

    mitsuba.set_variant("llvm_ad_rgb")
    return mitsuba


def _newest_llvm() -> str:
    found = {
        int(version.group(1)): path
        for pattern in ("/usr/lib/*/libLLVM*.so*", "/usr/lib/llvm-*/lib/libLLVM*.so*", "/usr/lib*/libLLVM*.so*")
        for path in glob.glob(pattern)
        if (version := re.search(r"(?:libLLVM-|llvm-|libLLVM\.so\.)(\d+)", path))
    }
    newest = max(found, default=0)
    if newest < OLDEST_LLVM:
        raise InputError(f"mitsuba: needs LLVM's library, version {OLDEST_LLVM} or newer: apt-get install libllvm15")
    return found[newest]


def built(scene: Scene) -> tuple[Any, float]:
    """The scene's spheres and planes, and the milliseconds that building Embree's structure over them took."""
    mitsuba = prepared()
    shapes: dict[str, Any] = {"type": "scene"}
    for i, (center, radius) in enumerate(zip(scene.spheres.center, scene.spheres.radius, strict=True)):
        shapes[f"sphere{i}"] = {"type": "sphere", "center": center.tolist(), "radius": float(radius)}
    for i, plane in enumerate(scene.planes):
        facing = mitsuba.ScalarTransform4f().look_at(
            origin=plane.point.tolist(), target=(plane.point + plane.normal).tolist(), up=_across(plane.normal)
        )
        shapes[f"plane{i}"] = {"type": "rectangle", "to_world": facing @ mitsuba.ScalarTransform4f().scale(FAR)}
    start = time.perf_counter()
    world = mitsuba.load_dict(shapes)
    return world, 1e3 * (time.perf_counter() - start)


def _across(normal: np.ndarray) -> list[float]:
    return np.eye(3)[np.argmin(np.abs(normal))].tolist()


def queries(scene: Scene, size: tuple[int, int], world: Any) -> Callable[[], tuple]:
    """A frame: t of the closest hit of each pixel's ray, and whether something is between it and the sun."""
    mitsuba = prepared()
    import drjit

    camera = scene.camera
    if not isinstance(camera, PerspectiveCamera):
        raise InputError("mitsuba: this comparison is for a perspective camera")
    width, height = size
    back = camera.position - camera.target
    back = back / np.linalg.norm(back)
    right = np.cross(camera.up, back)
    right = right / np.linalg.norm(right)
    up = np.cross(back, right)
    half = np.tan(np.radians(camera.field_of_view) / 2)
    origin = mitsuba.Point3f(camera.position.tolist())
    axes = [mitsuba.Vector3f(axis.tolist()) for axis in (right * (half * width / height), up * half, -back)]
    towards_sun = mitsuba.Vector3f((scene.sun.direction / np.linalg.norm(scene.sun.direction)).tolist())

    def frame() -> tuple:
        pixel = drjit.arange(mitsuba.UInt32, width * height)
        x = 2 * (mitsuba.Float(pixel % width) + 0.5) / width - 1
        y = 1 - 2 * (mitsuba.Float(pixel // width) + 0.5) / height
        ray = mitsuba.Ray3f(origin, drjit.normalize(x * axes[0] + y * axes[1] + axes[2]))
        hit = world.ray_intersect_preliminary(ray)
        point = ray(hit.t) + 1e-3 * towards_sun
        shadow = world.ray_test(mitsuba.Ray3f(point, towards_sun), active=hit.is_valid())
        drjit.eval(hit.t, shadow)
        drjit.sync_thread()
        return hit.t, shadow

    return frame
