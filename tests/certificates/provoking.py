"""Scenes that provoke undecided comparisons: rays that are known badly, and surfaces that they may or may not meet."""

import numpy as np

import raytrace

__all__ = ["provoking_scene"]

SIZE = (3, 3)
RED, GREEN, BLUE = np.eye(3)


def provoking_scene(seed, lighting=None):
    """Return a scene for an image of 3x3 pixels whose middle pixel looks at `target` along a ray that errs much.

    A field of view near 180 degrees makes the rounding of a texture coordinate large. On the ray there are phantoms,
    small spheres beside it that the textbook's formula cannot tell from hits, and behind them surfaces through one
    point of it, whose order is undecided where no phantom is hit.
    """
    random = np.random.default_rng(seed)
    ray = unit(random.normal(size=3))
    half = 10.0 ** random.uniform(1.5, 3.5)
    error, distance = half * 2.0**-23, 10.0 ** random.uniform(0, 2)
    point = distance * ray
    centers, radii, colors = [], [], []
    for _ in range(random.choice([1, 1, 1, 2])):
        t = distance * random.uniform(0.2, 0.7)
        beside = 10 ** random.uniform(0.8, 2) * error * t * 4
        centers.append(t * ray + beside * across(random, ray))
        radii.append(beside * 10 ** random.uniform(-1.5, -0.1))
        colors.append(BLUE)
    for color in (RED, GREEN, GREEN):
        normal = unit(-ray + across(random, ray) * random.uniform(0.1, 0.8))
        radius = distance * random.uniform(0.2, 0.45)
        centers.append(point - normal * radius)
        radii.append(radius)
        colors.append(color)
    order = random.permutation(len(radii)) if random.random() < 0.1 else np.arange(len(radii))
    planes = ()
    if random.random() < 0.2:
        normal = unit(-ray + across(random, ray) * random.uniform(0.1, 0.8))
        planes = (
            raytrace.Plane(exact(point), exact(normal), raytrace.Plain((0.5, 0.5, 0.0)), bool(random.random() < 0.5)),
        )
    return raytrace.Scene(
        spheres=raytrace.Spheres(*(exact(np.array(x)[order]) for x in (centers, radii, colors))),
        planes=planes,
        sun=raytrace.Sun(direction=exact(random.normal(size=3))),
        camera=camera(random, ray, half),
        lighting=lighting or str(random.choice(["off", "off", "off", "shadow"])),
        film=raytrace.Film(tone_mapper="none", transfer="none"),
    )


def camera(random, ray, half):
    """Return a camera at the origin that looks along `ray`, as angles or as matrices."""
    up = across(random, ray)
    if random.random() < 0.5:
        angle = 2 * np.degrees(np.arctan(half))
        return raytrace.PerspectiveCamera((0, 0, 0), tuple(ray), tuple(up), field_of_view=angle)
    projection = np.array([[half, 0, 0, 0], [0, half, 0, 0], [0, 0, 0, -1], [0, 0, -4.995, 5.005]])
    view = np.eye(4)
    view[:3, :3] = np.stack([np.cross(ray, up), up, -ray], axis=1)
    return raytrace.MatrixCamera(exact(projection), exact(view))


def unit(vector):
    return vector / np.linalg.norm(vector)


def across(random, ray):
    """Return a random unit vector that is perpendicular to the ray."""
    vector = random.normal(size=3)
    return unit(vector - vector @ ray * ray)


def exact(numbers):
    """Round to float32, so that all programs are given the same numbers."""
    return np.float32(numbers).astype(float)
