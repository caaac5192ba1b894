"""One small world for the tests of the sun's fit, so that they share their programs."""

from dataclasses import replace

import numpy as np

import raytrace

#: A whole number of blocks: what is left of one would be computed all the same.
SIZE = (48, 24)
#: Of the scene's spheres, as many as throw shadows that tell the sun. More would take longer to compile and to run.
SPHERES = [1, 2, 5]


def world(*changes):
    """Three spheres on the checkerboard, seen a little from above, with what is changed of it."""
    scene = raytrace.load_scene("checkerboard", ["camera.target=[0,0.1,0]", *changes])
    center, radius, color = scene.spheres.center, scene.spheres.radius, scene.spheres.color
    return replace(scene, spheres=raytrace.Spheres(center[SPHERES], radius[SPHERES], color[SPHERES]))


def under(scene, azimuth, elevation):
    return replace(scene, sun=replace(scene.sun, direction=raytrace.sun_direction(azimuth, elevation)))


def drawn(scene, size=SIZE, **choices):
    """The display values, float64."""
    return np.asarray(raytrace.render(scene, size, backend="numpy", **choices), np.float64)


def noisy(image, levels, seed=0):
    """8 bits, with normal noise of so many levels."""
    image = image + np.random.default_rng(seed).normal(0, levels / 255, image.shape)
    return np.round(255 * np.clip(image, 0, 1)).astype(np.uint8)


def off(fit, scene):
    """Degrees between the sun that was found and the scene's."""
    direction = scene.sun.direction / np.linalg.norm(scene.sun.direction)
    return np.degrees(2 * np.arcsin(np.linalg.norm(fit.direction - direction) / 2))
