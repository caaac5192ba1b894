"""Scenes with any number of spheres: crowds in front of the camera, and wide fields."""

from dataclasses import replace
from typing import cast

import numpy as np

from raytrace.scene.data import PerspectiveCamera, Scene, Spheres
from raytrace.scene.toml import DEFAULT_SCENE, load_scene

__all__ = ["crowd", "field"]

#: The corners of the box that the centres are in, in front of the default scene's camera and above its ground.
BOX = (-4.0, -0.5, -9.0), (4.0, 3.5, -1.0)
#: The mean radius of a single sphere; of n, this over the root of n: as much of the picture is covered by any number.
RADIUS = 1.2

#: Half the side of a field, whose middle is the camera's place on the ground, and the range of its spheres' radii.
HALF, RADII = 100.0, (0.03, 0.3)
#: Towards the sun over a field, which stands 10 degrees high, so that shadows are long.
LOW_SUN = (0.70, 0.18, 0.69)


def crowd(n: int, seed: int = 0) -> Scene:
    """The default scene with n spheres, evenly at random in a box, of radii within a factor of three of each other.

    Its own six for n = 6.
    """
    scene = load_scene(DEFAULT_SCENE)
    if n == scene.spheres.radius.shape[0]:
        return scene
    random = np.random.default_rng(seed)
    center = random.uniform(*BOX, (n, 3))
    radius = RADIUS / np.sqrt(n) * random.uniform(0.5, 1.5, n)
    return replace(scene, spheres=Spheres(center=center, radius=radius, color=random.uniform(0.2, 1, (n, 3))))


def field(n: int, seed: int = 0) -> Scene:
    """Return the default scene with n spheres that lie on a wide ground, most of them far and small.

    Their radii are as often within one octave of the range as within another.
    """
    scene = load_scene(DEFAULT_SCENE)
    random = np.random.default_rng(seed)
    smallest, largest = np.log(RADII)
    radius = np.exp(random.uniform(smallest, largest, n))
    x, z = random.uniform(-HALF, HALF, (2, n))
    middle, ground = cast(PerspectiveCamera, scene.camera).position, scene.planes[0].point[1]
    center = np.stack([middle[0] + x, ground + radius, middle[2] + z], axis=1)
    spheres = Spheres(center=center, radius=radius, color=random.uniform(0.2, 1, (n, 3)))
    return replace(scene, spheres=spheres, sun=replace(scene.sun, direction=np.array(LOW_SUN)))
