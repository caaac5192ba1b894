"""Images as means over coarser pixels."""

import numpy as np
import pytest

from raytrace.inverse.picture import coarse, shrunk


@pytest.mark.parametrize("size", [(16, 16), (50, 31), (97, 54)])
def test_a_coarser_image_has_the_means(size):
    image = np.random.default_rng(0).random((54, 97, 3))
    small = shrunk(image, size)
    assert small.shape == (size[1], size[0], 3)
    np.testing.assert_allclose(small.mean((0, 1)), image.mean((0, 1)))
    assert small.min() >= image.min()
    assert small.max() <= image.max()


def test_a_coarser_image_of_twice_the_width():
    image = np.random.default_rng(0).random((4, 6, 3))
    np.testing.assert_allclose(shrunk(image, (3, 2)), image.reshape(2, 2, 3, 2, 3).mean((1, 3)))
    assert coarse((1920, 1080), 192 * 108) == (192, 108)
    assert coarse((64, 36), 192 * 108) == (64, 36)
