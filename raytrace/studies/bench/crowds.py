"""Scenes with any number of spheres."""

from dataclasses import replace

import numpy as np

from raytrace.scene.data import Scene, Spheres
from raytrace.scene.toml import DEFAULT_SCENE, load_scene

__all__ = ["crowd"]

#: The corners of the box that the centres are in, in front of the default scene's camera and above its ground.
BOX = (-4.0, -0.5, -9.0), (4.0, 3.5, -1.0)
#: The mean radius of a single sphere; of n, this over the root of n: as much of the picture is covered by any number.
RADIUS = 1.2


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
