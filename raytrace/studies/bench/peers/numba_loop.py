"""Numba: the assignment's shader as a loop over pixels, in float32, as one would type it from the text.

For scenes of spheres and checkerboard planes under a perspective camera, with the assignment's film.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.scene.data import Checkerboard, PerspectiveCamera, Plane, Scene

__all__ = ["frame"]


def frame(scene: Scene, size: tuple[int, int], fastmath: bool) -> Callable[[], np.ndarray]:
    """A function that renders the image (height, width, 3)."""
    patterned = all(isinstance(plane.pattern, Checkerboard) for plane in scene.planes)
    if not (isinstance(scene.camera, PerspectiveCamera) and patterned and scene.lighting == "shadow"):
        raise InputError("numba: this comparison is for the assignment's last figure and its like")
    camera, spheres, sun, sky = scene.camera, scene.spheres, scene.sun, scene.sky
    width, height = size
    back = camera.position - camera.target
    back = back / np.linalg.norm(back)
    right = np.cross(camera.up, back)
    right = right / np.linalg.norm(right)
    half = math.tan(math.radians(camera.field_of_view) / 2)
    axes = np.stack([right * half * width / height, np.cross(back, right) * half, -back])
    planes = np.array([_row(plane) for plane in scene.planes]).reshape(-1, 16)
    numbers = [
        camera.position, axes, spheres.center, spheres.radius, spheres.color, planes,
        sun.direction / np.linalg.norm(sun.direction), sun.color, sky.low, sky.high, sky.void,
    ]  # fmt: skip
    arrays = [np.ascontiguousarray(array, np.float32) for array in numbers]
    image = _compiled(fastmath)
    return lambda: image(width, height, *arrays)


def _row(plane: Plane) -> np.ndarray:
    normal, pattern = plane.normal / np.linalg.norm(plane.normal), plane.pattern
    assert isinstance(pattern, Checkerboard)
    return np.concatenate([plane.point, normal, [pattern.tile_size], pattern.even, pattern.odd, pattern.line])


@cache
def _compiled(fastmath: bool) -> Any:
    import numba

    f32 = np.float32
    jit = numba.njit(fastmath=fastmath, error_model="numpy")

    @jit
    def sphere_intersect(ox, oy, oz, dx, dy, dz, radius):
        b = ox * dx + oy * dy + oz * dz
        c = ox * ox + oy * oy + oz * oz - radius * radius
        d = b * b - c
        if d < f32(0):
            return f32(-1)
        d = math.sqrt(d)
        t1 = -b - d
        return t1 if t1 >= f32(0) else -b + d

    @jit
    def film(x):
        y = (x * (f32(2.51) * x + f32(0.03))) / (x * (f32(2.43) * x + f32(0.59)) + f32(0.14))
        return min(max(y, f32(0)), f32(1)) ** f32(1 / 2.2)

    @numba.njit(parallel=True, fastmath=fastmath, error_model="numpy")
    def image(width, height, ro, axes, center, radius, color, planes, L, sun, low, high, void):
        out = np.empty((height, width, 3), np.float32)
        for row in numba.prange(height):
            y = f32(1) - f32(2) * (f32(row) + f32(0.5)) / f32(height)
            for column in range(width):
                x = f32(2) * (f32(column) + f32(0.5)) / f32(width) - f32(1)
                dx = axes[0, 0] * x + axes[1, 0] * y + axes[2, 0]
                dy = axes[0, 1] * x + axes[1, 1] * y + axes[2, 1]
                dz = axes[0, 2] * x + axes[1, 2] * y + axes[2, 2]
                length = math.sqrt(dx * dx + dy * dy + dz * dz)
                dx /= length
                dy /= length
                dz /= length

                best, sphere, plane = f32(3e38), -1, -1
                for i in range(radius.size):
                    ox, oy, oz = ro[0] - center[i, 0], ro[1] - center[i, 1], ro[2] - center[i, 2]
                    t = sphere_intersect(ox, oy, oz, dx, dy, dz, radius[i])
                    if t >= f32(0) and t <= best:
                        best, sphere = t, i
                for i in range(planes.shape[0]):
                    towards = dx * planes[i, 3] + dy * planes[i, 4] + dz * planes[i, 5]
                    above = (
                        (planes[i, 0] - ro[0]) * planes[i, 3]
                        + (planes[i, 1] - ro[1]) * planes[i, 4]
                        + (planes[i, 2] - ro[2]) * planes[i, 5]
                    )
                    if towards != f32(0):
                        t = above / towards
                        if t > f32(0) and t < best:
                            best, plane = t, i

                if sphere < 0 and plane < 0:
                    if dy < f32(0):
                        r, g, b = void[0], void[1], void[2]
                    else:
                        up = math.sqrt(math.sqrt(dy))
                        lobe = max(dx * L[0] + dy * L[1] + dz * L[2], f32(0)) ** f32(2400)
                        r = (low[0] * (f32(1) - up) + high[0] * up) * (f32(1) - lobe) + sun[0] * lobe
                        g = (low[1] * (f32(1) - up) + high[1] * up) * (f32(1) - lobe) + sun[1] * lobe
                        b = (low[2] * (f32(1) - up) + high[2] * up) * (f32(1) - lobe) + sun[2] * lobe
                else:
                    px, py, pz = ro[0] + best * dx, ro[1] + best * dy, ro[2] + best * dz
                    if plane >= 0:
                        nx, ny, nz = planes[plane, 3], planes[plane, 4], planes[plane, 5]
                        tx = math.floor(px / planes[plane, 6] + f32(0.5))
                        tz = math.floor(pz / planes[plane, 6] + f32(0.5))
                        first = 13 if tx == 0 or tz == 0 else (7 if (tx + tz) % 2 == 0 else 10)
                        ar, ag, ab = planes[plane, first], planes[plane, first + 1], planes[plane, first + 2]
                    else:
                        nx, ny, nz = px - center[sphere, 0], py - center[sphere, 1], pz - center[sphere, 2]
                        length = math.sqrt(nx * nx + ny * ny + nz * nz)
                        nx /= length
                        ny /= length
                        nz /= length
                        ar, ag, ab = color[sphere, 0], color[sphere, 1], color[sphere, 2]
                    ndl = max(nx * L[0] + ny * L[1] + nz * L[2], f32(0))
                    if ndl > f32(0):
                        sx, sy, sz = px + f32(1e-3) * nx, py + f32(1e-3) * ny, pz + f32(1e-3) * nz
                        for i in range(radius.size):
                            ox, oy, oz = sx - center[i, 0], sy - center[i, 1], sz - center[i, 2]
                            if sphere_intersect(ox, oy, oz, L[0], L[1], L[2], radius[i]) >= f32(0):
                                ndl = f32(0)
                                break
                    ambient = min(max(f32(0.5) * ny + f32(0.5), f32(0)), f32(1))
                    r = (sun[0] * ndl + high[0] * ambient) * ar
                    g = (sun[1] * ndl + high[1] * ambient) * ag
                    b = (sun[2] * ndl + high[2] * ambient) * ab
                out[row, column, 0] = film(r)
                out[row, column, 1] = film(g)
                out[row, column, 2] = film(b)
        return out

    return image
