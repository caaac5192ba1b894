"""Random worlds, and the table of errors."""

import jax
import numpy as np
import pytest

import raytrace
from raytrace.studies import gradients
from raytrace.studies.gradients import PARAMETERS, Error, random_world, table
from tests.studies.test_differences import within_a_silhouette


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
    moved, step, *_ = PARAMETERS[parameter]
    once, twice = (changes(world, moved(world, share * step)) for share in (0.01, 0.02))
    assert np.abs(once).max() > 0
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-3, atol=1e-9)


def test_the_table_has_medians_the_worst_and_how_many_are_within_the_limits():
    def entry(error, left):
        edges = Error(error, error / 2, left, 0.01)
        return {"edges": edges, "edges, 4x4": edges, "none": Error(1.0, 0.5, left, 0.01)}

    text = table({"sun azimuth": [entry(0.01, 0.9), entry(0.03, 0.9), entry(0.5, 0.1)]})
    head, edges, finer, none = text.splitlines()[2:]
    assert head == "sun azimuth: within 2 and 5; the reference's own 1.0"
    # The total of the third world is a difference of nearly equal sums.
    assert edges.split() == ["edges", "2.0", "3.0", "1/2", "1.5", "25.0", "2/3"]
    assert finer.split()[2:] == edges.split()[1:]
    assert none.split() == ["none", "100.0", "100.0", "0/2", "50.0", "50.0", "0/3"]


def test_of_no_world_there_is_no_total():
    nothing = Error(np.nan, np.nan, np.nan, np.nan)
    assert "-" in table({"camera's x": [dict.fromkeys(("edges", "edges, 4x4", "none"), nothing)]})


def test_without_edges_the_usual_derivative_is_right(monkeypatch):
    monkeypatch.setattr(gradients, "CHOICES", {"none": ("none", 4)})
    found = gradients.errors(within_a_silhouette(), "sun azimuth", (48, 27), 4)["none"]
    assert found.blocks < 5e-3
    assert found.total < 5e-3
    assert found.cancelled <= 1
    assert found.noise < 5e-3
