"""Random worlds, and the table of errors."""

import jax
import numpy as np
import pytest

import raytrace
from raytrace.inverse.accuracy import PARAMETERS, Error, random_world, table


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
    moved, step, _ = PARAMETERS[parameter]
    once, twice = (changes(world, moved(world, share * step)) for share in (0.01, 0.02))
    assert np.abs(once).max() > 0
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-3, atol=1e-9)


def test_the_table_has_medians_and_the_worst():
    def entry(error, left):
        return {"edges": Error(error, error / 2, left, 0.01), "none": Error(1.0, 0.5, left, 0.01)}

    text = table({"sun azimuth": [entry(0.01, 0.9), entry(0.03, 0.9), entry(0.5, 0.1)]})
    assert "2.0 (3.0)" in text  # the total of the third world is a difference of nearly equal sums
    assert "1.5 (25.0)" in text
    assert "2/3 totals" in text
