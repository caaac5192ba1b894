"""Pictures under other suns, in blocks."""

import numpy as np
import pytest

import raytrace
from raytrace.inverse.blocks import Blocks
from raytrace.inverse.relit import Relit
from tests.inverse.worlds import under, world
from tests.scenes import some


@pytest.mark.parametrize("size", [(16, 16), (64, 36), (97, 54)])
def test_blocks_hold_every_pixel_once(size):
    blocks = Blocks.of(size, 10**6)
    found = (blocks.row * size[0] + blocks.column)[blocks.inside]
    np.testing.assert_array_equal(np.sort(found), np.arange(size[0] * size[1]))
    some = Blocks.of((970, 540), 30)
    assert some.row.shape == (30, 64)
    assert len(np.unique(some.row[:, 0] * 970 + some.column[:, 0])) == 30


@pytest.mark.parametrize("samples", some([1, 2], 1))
def test_the_values_are_those_of_render(samples):
    size = (64, 36)
    image = np.zeros((36, 64, 3))
    for azimuth, elevation in ((-70.0, 35.0), (0.0, 3.0), (100.0, -20.0)):
        scene = under(world(), azimuth, elevation)
        relit = Relit(scene, image, samples, Blocks.of(size, 100))
        values = relit.values(scene.sun.direction, 0.0)
        drawn = np.asarray(raytrace.render(scene, size, samples=samples), np.float64)
        away = np.abs(values - relit.blocks.values(drawn))[relit.blocks.inside].max(-1)
        assert np.quantile(away, 0.999) < 2e-5


def test_slopes_are_those_of_differences():
    scene = under(world(), -70.0, 35.0)
    relit = Relit(scene, np.zeros((36, 64, 3)), 1, Blocks.of((64, 36), 100))
    axes, h = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]), 2e-3
    values, slopes = relit.slopes(scene.sun.direction, 0.0, axes)
    np.testing.assert_array_equal(values, relit.values(scene.sun.direction, 0.0))
    moves = [(scene.sun.direction + h * axis, scene.sun.direction - h * axis, 0.0, 0.0) for axis in axes]
    for slope, (ahead, back, more, less) in zip(slopes, [*moves, (*[scene.sun.direction] * 2, h, -h)], strict=True):
        difference = (relit.values(ahead, more) - relit.values(back, less)) / (2 * h)
        # A shadow's edge that passes a sample has no slope.
        assert np.median(np.abs(difference - slope)) < 1e-3
        assert np.quantile(np.abs(difference - slope), 0.8) < 0.02
