"""Worlds to differentiate in, random ones and some that are hard, and numbers of theirs to differentiate by."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from raytrace.scene.data import MatrixCamera, PerspectiveCamera, Plain, Plane, Scene, Spheres, Sun
from raytrace.scene.sun import sun_angles, sun_direction

__all__ = ["PARAMETERS", "Parameter", "World", "random_world", "worlds"]

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

    words: what is changed, and its unit. limits: of the total and of the blocks' sums, relative. differences: from so
    many `raytrace.studies.differences.difference` is averaged.
    """

    words: str
    moved: Callable[[Scene, Any], Scene]
    step: float
    limits: tuple[float, float] = (0.05, 0.1)
    differences: int = 12


def _turned(azimuth: float, elevation: float) -> Callable[[Scene, Any], Scene]:
    def moved(scene: Scene, h: Any) -> Scene:
        angles = sun_angles(scene.sun.direction)
        return scene.with_("sun.direction", sun_direction(angles[0] + azimuth * h, angles[1] + elevation * h))

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
    "sun azimuth": Parameter("the sun's azimuth, degrees from -z towards +x", _turned(1.0, 0.0), 0.05, SUN),
    "sun elevation": Parameter("the sun's elevation, degrees", _turned(0.0, 1.0), 0.05, SUN),
    "sphere's x": Parameter("x of the first sphere's centre", _sphere(0, (1.0, 0.0, 0.0)), 0.0025),
    "sphere's z": Parameter("z of the second sphere's centre", _sphere(1, (0.0, 0.0, 1.0)), 0.005),
    "sphere's radius": Parameter("the third sphere's radius", _sphere(2, radius=1.0), 0.0025),
    "camera's x": Parameter("x of the camera's position, not of its target", _camera(1.0, 0.0, 0.0), 0.01),
    "camera's y": Parameter(
        "y of the camera's position, not of its target", _camera(0.0, 1.0, 0.0), 0.0025, differences=24
    ),
    "plane's height": Parameter("y of the first plane's point", _raised, 0.0025, differences=24),
    "first radius": Parameter("the first sphere's radius", _sphere(0, radius=1.0), 0.0025),
}
#: What random worlds are differentiated by: all but what comes last.
USUAL = tuple(PARAMETERS)[:-1]


class World(NamedTuple):
    """A scene to differentiate in.

    size: (width, height) in pixels. parameters: those of `PARAMETERS` that it is differentiated by. scanlines: of its
    reference (`raytrace.studies.boundaries.reference`).
    """

    name: str
    scene: Scene
    size: tuple[int, int]
    parameters: tuple[str, ...]
    scanlines: int = 12


#: Radii of small spheres, in pixels.
RADII = 0.03, 0.06, 0.13, 0.24, 0.48
#: How many random worlds there are; how many of each kind that is hard; and the size of those.
RANDOM, HARD, HARD_SIZE = 20, 2, (96, 54)


def worlds() -> list[World]:
    """Return the worlds of the benchmark: random ones, and of each kind that is hard to differentiate a few."""
    found = [World(f"random-{seed:02}", random_world(seed), (192, 108), USUAL) for seed in range(RANDOM)]
    found += [_small(f"small-red-{radius}", radius) for radius in RADII]
    lit = Scene(Spheres([[0.05, 0.53, -1]], [0.03], [[0.8] * 3]), (), Sun([1, 1, 1.0]), lighting="on")
    found.append(World("small-lit", lit, (32, 18), ("sun azimuth", "sun elevation", "first radius")))
    for name, (made, parameters) in _HARD.items():
        found += [World(f"{name}-{seed}", made(1000 + seed), HARD_SIZE, parameters, 16) for seed in range(HARD)]
    return found


def _small(name: str, radius: float) -> World:
    """A red sphere alone, without light, whose radius is told in pixels."""
    size = 32, 18
    center = np.array([0.05, 0.53, -1.0])
    distance = np.linalg.norm(center - PerspectiveCamera().position)
    pixels = size[1] / 2 / np.tan(np.radians(PerspectiveCamera().field_of_view / 2)) / distance
    scene = Scene(Spheres(center[None], [radius / pixels], [[1.0, 0.0, 0.0]]), lighting="off")
    # One that stays within a pixel changes nothing as it moves.
    moves = ("sphere's x", "camera's x") if radius > 0.26 else ()
    return World(name, scene, size, ("first radius", *moves))


def _second_beside_first(seed: int, away: Callable[[Any, Scene], Any]) -> Scene:
    """A random world whose second sphere is moved; away: from the first one's centre, in sums of their radii."""
    scene = random_world(seed)
    spheres = scene.spheres
    center = spheres.center.copy()
    step = away(np.random.default_rng([seed, 1]), scene)
    center[1] = center[0] + (spheres.radius[0] + spheres.radius[1]) * step
    return replace(scene, spheres=replace(spheres, center=center))


def _shadows_that_overlap(seed: int) -> Scene:
    def away(random: Any, scene: Scene) -> Any:
        towards = scene.sun.direction * [1, 0, 1] / np.linalg.norm(scene.sun.direction[[0, 2]])
        aside = np.array([-towards[2], 0, towards[0]])
        return 1.05 * towards + random.uniform(-0.4, 0.4) * aside

    return _second_beside_first(seed, away)


def _spheres_that_cut(seed: int) -> Scene:
    def away(random: Any, scene: Scene) -> Any:
        angle = random.uniform(0, np.pi)
        return 0.7 * np.array([np.cos(angle), 0.3, np.sin(angle)])

    return _second_beside_first(seed, away)


def _sun_at(elevation: float) -> Callable[[int], Scene]:
    def made(seed: int) -> Scene:
        scene = random_world(seed)
        azimuth = float(sun_angles(scene.sun.direction)[0])
        return scene.with_("sun.direction", sun_direction(azimuth, elevation))

    return made


def _planes_that_meet(seed: int) -> Scene:
    random = np.random.default_rng([seed, 1])
    scene = random_world(seed)
    wall = Plane([0, 0, -3.0], [random.uniform(-0.5, 0.5), random.uniform(0, 0.5), 1.0], Plain([0.5, 0.6, 0.3]))
    return replace(scene, planes=(*scene.planes, wall))


def _inside_a_sphere(seed: int) -> Scene:
    """The camera is in the first sphere, seen from inside where neither the ground nor another sphere is nearer."""
    scene = random_world(seed)
    center, radius = scene.spheres.center.copy(), scene.spheres.radius.copy()
    assert isinstance(scene.camera, PerspectiveCamera)
    center[0] = scene.camera.position + np.array([0.2, 0.1, -0.9])
    radius[0] = 2.6
    return replace(scene, spheres=replace(scene.spheres, center=center, radius=radius))


_HARD = {
    "shadows-that-overlap": (_shadows_that_overlap, ("sun azimuth", "sphere's x", "first radius")),
    "spheres-that-cut": (_spheres_that_cut, ("sun elevation", "sphere's x", "first radius")),
    "low-sun": (_sun_at(2.0), ("sun azimuth", "sun elevation", "first radius")),
    "planes-that-meet": (_planes_that_meet, ("sun azimuth", "camera's x", "first radius")),
    "inside-a-sphere": (_inside_a_sphere, ("sun elevation", "camera's x", "first radius")),
    "sun-overhead": (_sun_at(89.0), ("sun elevation", "sphere's x", "first radius")),
}
