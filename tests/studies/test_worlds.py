"""Worlds to differentiate in."""

import jax
import numpy as np
import pytest

import raytrace
from raytrace.studies.worlds import PARAMETERS, random_world, worlds

WORLDS = worlds()


@pytest.mark.parametrize("seed", range(5))
def test_random_worlds_are_scenes_whose_first_sphere_is_seen(seed):
    world = random_world(seed)
    raytrace.check_scene(world)
    index = raytrace.render(world, (96, 54), backend="numpy", dtype="float64", output="steps")["index"]
    assert (index == 0).any()


def changes(a, b):
    return np.concatenate([np.ravel(y) - np.ravel(x) for x, y in zip(*map(jax.tree.leaves, (a, b)), strict=True)])


@pytest.mark.parametrize("parameter", PARAMETERS)
def test_a_parameter_changes_the_scene_in_proportion(parameter):
    world = random_world(0)
    _, moved, step, *_ = PARAMETERS[parameter]
    once, twice = (changes(world, moved(world, share * step)) for share in (0.01, 0.02))
    assert np.abs(once).max() > 0
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-3, atol=1e-9)


def test_each_world_has_a_name_of_its_own():
    assert len({world.name for world in WORLDS}) == len(WORLDS)
    assert len({name.rstrip("-0123456789.") for name in (world.name for world in WORLDS)}) == 9


@pytest.mark.parametrize("world", WORLDS, ids=lambda world: world.name)
def test_worlds_are_scenes_that_have_their_parameters(world):
    raytrace.check_scene(world.scene)
    for name in world.parameters:
        moved = PARAMETERS[name].moved(world.scene, PARAMETERS[name].step)
        raytrace.check_scene(moved)
        assert moved != world.scene


def test_a_small_spheres_radius_is_told_in_pixels():
    from raytrace.studies.boundaries import reference

    (world,) = (world for world in WORLDS if world.name == "small-red-0.24")
    first = PARAMETERS["first radius"]
    plain = raytrace.Film(tone_mapper="none", transfer="none")
    scene = raytrace.Scene(world.scene.spheres, lighting="off", film=plain, sky=raytrace.Sky(*np.zeros((3, 3))))
    slope = reference(scene, {"r": (first.moved, first.step)}, world.size)["r"].image[..., 0].sum()
    # An area's derivative by the radius is twice the area over the radius.
    area = slope * float(scene.spheres.radius[0]) / 2
    assert np.sqrt(area / np.pi) == pytest.approx(0.24, rel=0.02)
