"""Mitsuba 3 with Embree: the same primary and shadow rays, and nothing else: no sky, no colours, no film.

Needs LLVM's library (Debian: libllvm15 or newer) beside the package.
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.scene.data import PerspectiveCamera, Scene
from raytrace.studies.bench.peers.llvm import llvm

__all__ = ["built", "prepared", "queries"]

#: Mitsuba has no endless plane: half the side of the rectangle that stands for one.
FAR = 1e4


def prepared() -> Any:
    """Return the module `mitsuba` with the variant llvm_ad_rgb.

    Raises:
        InputError: it, or LLVM's library, is not installed.
    """
    llvm()
    import mitsuba

    mitsuba.set_variant("llvm_ad_rgb")
    return mitsuba


def built(scene: Scene, rectangles: bool = True) -> tuple[Any, float]:
    """Return the scene's shapes, and the milliseconds that building Embree's structure over them took.

    rectangles: whether the planes are among the shapes, as rectangles, or are left to `queries`.
    """
    mitsuba = prepared()
    shapes: dict[str, Any] = {"type": "scene"}
    for i, (center, radius) in enumerate(zip(scene.spheres.center, scene.spheres.radius, strict=True)):
        shapes[f"sphere{i}"] = {"type": "sphere", "center": center.tolist(), "radius": float(radius)}
    for i, plane in enumerate(scene.planes if rectangles else ()):
        facing = mitsuba.ScalarTransform4f().look_at(
            origin=plane.point.tolist(), target=(plane.point + plane.normal).tolist(), up=_across(plane.normal)
        )
        shapes[f"plane{i}"] = {"type": "rectangle", "to_world": facing @ mitsuba.ScalarTransform4f().scale(FAR)}
    start = time.perf_counter()
    world = mitsuba.load_dict(shapes)
    return world, 1e3 * (time.perf_counter() - start)


def _across(normal: np.ndarray) -> list[float]:
    return np.eye(3)[np.argmin(np.abs(normal))].tolist()


def queries(scene: Scene, size: tuple[int, int], world: Any, rectangles: bool = True) -> Callable[[], tuple]:
    """Return a frame: t of the closest hit of each pixel's ray, and whether something is between it and the sun.

    world, rectangles: what `built` gave, and was given.
    """
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
    planes = [
        (mitsuba.Point3f(plane.point.tolist()), mitsuba.Vector3f(plane.normal.tolist()))
        for plane in (() if rectangles else scene.planes)
    ]
    towards_sun = mitsuba.Vector3f((scene.sun.direction / np.linalg.norm(scene.sun.direction)).tolist())

    def frame() -> tuple:
        pixel = drjit.arange(mitsuba.UInt32, width * height)
        x = 2 * (mitsuba.Float(pixel % width) + 0.5) / width - 1
        y = 1 - 2 * (mitsuba.Float(pixel // width) + 0.5) / height
        ray = mitsuba.Ray3f(origin, drjit.normalize(x * axes[0] + y * axes[1] + axes[2]))
        hit = world.ray_intersect_preliminary(ray)
        t, met = hit.t, hit.is_valid()
        for point, normal in planes:
            of_plane = drjit.dot(point - ray.o, normal) / drjit.dot(ray.d, normal)
            nearer = (of_plane > 0) & (~met | (of_plane < t))
            t, met = drjit.select(nearer, of_plane, t), met | nearer
        start = ray(t) + 1e-3 * towards_sun
        shadow = world.ray_test(mitsuba.Ray3f(start, towards_sun), active=met)
        drjit.eval(t, shadow)
        drjit.sync_thread()
        return t, shadow

    return frame
