"""Simulated machines, which err as far as the table allows, print nothing outside the bounds."""

import numpy as np
import pytest

from raytrace.certificates import certify
from raytrace.language.tree import tree_map
from raytrace.scene import load_scene
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.camera import pixel_to_ndc
from raytrace.shader.main import main
from raytrace.shader.sphere import INTERSECTIONS
from raytrace.studies.conformance import STRUCTURES, random_scene
from tests.arithmetic.intervals.machine import Machine, Number
from tests.certificates.provoking import provoking_scene

SIZE = (12, 7)
#: So many machines draw each pixel.
MACHINES = 20


def drawn(scene, intersection, size, random):
    """Return linear and display values (machine, pixel, 3) of many machines at once."""
    width, height = size
    xp = Machine(random)
    pixels = np.tile(np.arange(width * height), MACHINES)
    uv = texture_coordinates(*divmod(pixels, width)[::-1], size, xp)
    uniforms = tree_map(xp.given, uniforms_of(scene, width / height))
    with np.errstate(all="ignore"):
        steps = main(uniforms, program_of(scene, intersection), pixel_to_ndc(*uv), ("linear", "display"))

    def image(color):
        return np.stack([np.broadcast_to(c.value, pixels.shape) for c in color], axis=-1).reshape(MACHINES, -1, 3)

    return {"linear": image(steps.linear), "display": image(steps.display)}


def texture_coordinates(column, row, size, xp):
    """Interpolated, or the fragment's coordinates over the resolution, rows from the bottom or from the top."""
    width, height = size
    x, up, down = column + 0.5, height - row - 0.5, row + 0.5
    varying = [Number(xp.within(exact, 0, 2.0**-23), xp) for exact in (x / width, up / height)]
    across, upwards, downwards = (
        Number(xp.within(a / b, 2.5), xp) for a, b in ((x, width), (up, height), (down, height))
    )
    return xp.one_of(varying[0], across), xp.one_of(varying[1], upwards, 1 - downwards)


def assert_inside(scene, intersection, size, seed):
    random = np.random.default_rng(seed)
    bounds = certify(scene, size, precision="glsl-highp", intersection=intersection).bounds
    for kind, values in drawn(scene, intersection, size, random).items():
        low, high = (end.reshape(-1, 3) for end in getattr(bounds, kind))
        outside = ~((low <= values) & (values <= high))
        assert not outside.any(), f"seed {seed}, {kind}: {np.argwhere(outside)[:3].tolist()}"


@pytest.mark.parametrize("number", range(len(STRUCTURES)))
def test_random_scenes(number):
    structure = STRUCTURES[number]
    for seed in range(2):
        for intersection in INTERSECTIONS:
            scene = random_scene(np.random.default_rng([seed, number, 77]), structure)
            assert_inside(scene, intersection, SIZE, seed)


@pytest.mark.full
@pytest.mark.parametrize("number", range(len(STRUCTURES)))
def test_many_random_scenes(number):
    for seed in range(3, 9):
        scene = random_scene(np.random.default_rng([seed, number, 77]), STRUCTURES[number])
        assert_inside(scene, ("textbook", "robust")[seed % 2], SIZE, seed)


@pytest.mark.parametrize("name", ["checkerboard", "inside-a-sphere", "sun-in-the-picture"])
def test_built_in_scenes(name):
    for intersection in INTERSECTIONS:
        assert_inside(load_scene(name), intersection, (24, 13), 0)


def test_scenes_whose_decisions_are_open():
    for seed in range(20):
        assert_inside(provoking_scene(seed), "textbook", (3, 3), seed)
