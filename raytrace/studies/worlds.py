"""Random worlds with spheres over the checkerboard, and numbers of theirs to differentiate by."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from raytrace.scene.data import MatrixCamera, PerspectiveCamera, Plane, Scene, Spheres, Sun
from raytrace.scene.sun import sun_angles, sun_direction

__all__ = ["PARAMETERS", "Parameter", "random_world"]

#: Within so many degrees of the middle of the picture a sphere is taken to be seen.
SEEN = 25.0


def random_world(seed: int) -> Scene:
    """Six spheres of radius 0.2 to 0.9 on or above the ground, seen from above, and a sun at 20 to 75 degrees.

    The spheres that are seen come first, the nearest of them before the others.
    """
    random = np.random.default_rng(seed)
    n = 6
    radius = random.uniform(0.2, 0.9, n)
    height = radius - 0.5 + random.uniform(-0.1, 0.8, n)
    center = np.stack([random.uniform(-2.5, 2.5, n), height, random.uniform(-4, -0.8, n)], -1)
    albedo = random.uniform(0.2, 0.9, (n, 3))
    sun = Sun(direction=sun_direction(random.uniform(-180, 180), random.uniform(20, 75)))
    position = random.uniform([-1, 0.3, 1.5], [1, 1.5, 2.5])
    target = random.uniform([-0.5, -0.3, -2], [0.5, 0.3, -2])
    away, ahead = center - position, (target - position) / np.linalg.norm(target - position)
    distance = np.linalg.norm(away, axis=-1)
    order = np.lexsort([distance, away @ ahead < np.cos(np.radians(SEEN)) * distance])
    return Scene(
        spheres=Spheres(center[order], radius[order], albedo[order]),
        planes=(Plane(),),
        sun=sun,
        camera=PerspectiveCamera(position=position, target=target),
    )


class Parameter(NamedTuple):
    """A number of a scene: how to change it, by how much a difference should, and what errors a derivative may have.

    limits: of the total and of the blocks' sums, relative. differences: from so many the reference is averaged.
    """

    moved: Callable[[Scene, Any], Scene]
    step: float
    limits: tuple[float, float] = (0.05, 0.1)
    differences: int = 12


def _turned(azimuth: float, elevation: float) -> Callable[[Scene, Any], Scene]:
    def moved(scene: Scene, h: Any) -> Scene:
        angles = sun_angles(scene.sun.direction)
        return replace(
            scene, sun=replace(scene.sun, direction=sun_direction(angles[0] + azimuth * h, angles[1] + elevation * h))
        )

    return moved


def _sphere(number: int, center: tuple[float, ...] = (0.0, 0.0, 0.0), radius: float = 0.0) -> Callable:
    def moved(scene: Scene, h: Any) -> Scene:
        one = np.arange(len(scene.spheres.radius)) == number
        return replace(
            scene,
            spheres=replace(
                scene.spheres,
                center=scene.spheres.center + one[:, None] * np.array(center) * h,
                radius=scene.spheres.radius + radius * one * h,
            ),
        )

    return moved


def _camera(*along: float) -> Callable[[Scene, Any], Scene]:
    def moved(scene: Scene, h: Any) -> Scene:
        camera = scene.camera
        assert not isinstance(camera, MatrixCamera)
        return replace(scene, camera=replace(camera, position=camera.position + np.array(along) * h))

    return moved


def _raised(scene: Scene, h: Any) -> Scene:
    ground = scene.planes[0]
    return replace(scene, planes=(replace(ground, point=ground.point + np.array([0.0, 1.0, 0.0]) * h),))


#: The sun's may err by less.
SUN = (0.02, 0.05)
#: Degrees for the sun's angles, lengths for the rest. The steps move edges by some tenths of a pixel at most: as tones
#: are not linear in the light, an edge that moves further has another derivative. That is worst where edges lie along
#: the rows, which also pass many samples at once: up and down there are smaller steps, and more of them.
PARAMETERS = {
    "sun azimuth": Parameter(_turned(1.0, 0.0), 0.05, SUN),
    "sun elevation": Parameter(_turned(0.0, 1.0), 0.05, SUN),
    "sphere's x": Parameter(_sphere(0, (1.0, 0.0, 0.0)), 0.0025),
    "sphere's z": Parameter(_sphere(1, (0.0, 0.0, 1.0)), 0.005),
    "sphere's radius": Parameter(_sphere(2, radius=1.0), 0.0025),
    "camera's x": Parameter(_camera(1.0, 0.0, 0.0), 0.01),
    "camera's y": Parameter(_camera(0.0, 1.0, 0.0), 0.0025, differences=24),
    "plane's height": Parameter(_raised, 0.0025, differences=24),
}
