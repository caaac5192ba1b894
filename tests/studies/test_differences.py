"""Differences of supersampled images."""

from dataclasses import replace

import numpy as np
import pytest

import raytrace
from raytrace.studies.differences import _shifted, block_sums, difference
from raytrace.studies.gradients import derivative
from raytrace.studies.worlds import random_world

SIZE = 48, 27


def test_samples_a_pixel_away_are_those_of_the_neighbour():
    world = random_world(0)
    here, beside = (
        raytrace.render(_shifted(world, np.array(offset), SIZE), SIZE, backend="numpy", dtype="float64", samples=2)
        for offset in ((0, 0), (1, -1))
    )
    # To the right and, as y is up, down: row 0 is on top.
    np.testing.assert_allclose(beside[:-1, :-1], here[1:, 1:], rtol=0, atol=1e-6)
    assert np.abs(beside - here).max() > 0.01


def test_sums_over_blocks():
    image = np.random.default_rng(0).uniform(size=(27, 48, 3))
    blocks = block_sums(image)
    assert blocks.shape == (2, 4)
    assert blocks[1, 2] == pytest.approx(image[12:24, 24:36].mean(-1).sum())


def within_a_silhouette():
    """A lit sphere that is all of the picture, which is smooth but for the terminator. The sun's vector is no unit."""
    return replace(
        raytrace.load_scene("lit-sphere"),
        camera=raytrace.PerspectiveCamera((0, 0, 4), (0, 0, 0), field_of_view=10.0),
        sun=raytrace.Sun((0.3, 0.5, 1.0)),
    )


@pytest.mark.full
def test_where_nothing_has_an_edge_it_is_the_derivative():
    world = within_a_silhouette()
    found = difference(world, "sun azimuth", SIZE, 4)
    exact = block_sums(derivative(world, "sun azimuth", SIZE, "none", 4))
    largest = np.abs(exact).max()
    np.testing.assert_allclose(found.blocks, exact, rtol=0, atol=2e-3 * largest)
    assert (found.error < 2e-3 * largest).all()
