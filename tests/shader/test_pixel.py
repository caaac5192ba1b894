import numpy as np
import pytest

import raytrace
from raytrace.language.glsl import Vec2
from raytrace.shader.pixel import Frame, texture_coordinates
from raytrace.shader.sampling import sample_grid
from tests.scenes import some


def test_pixel_centres_by_hand():
    """4 x 2 pixels: the first column's centre is at 0.5 / 4, the top row's at 1 - 0.5 / 2."""
    column, row = np.arange(4.0)[None, :], np.arange(2.0)[:, None]
    u, v = texture_coordinates(column, row, Vec2(0.5, 0.5), Frame(4, 2))
    assert u.tolist() == [[0.125, 0.375, 0.625, 0.875]]
    assert v.tolist() == [[0.75], [0.25]]


def test_samples_by_hand():
    """2 x 2 samples of the pixel (0, 0) of 1 x 1: a quarter and three quarters across and down."""
    grid = sample_grid(2, np.float64(0))
    uv = [
        texture_coordinates(np.float64(0), np.float64(0), Vec2(*xy), Frame(1, 1, 2)) for xy in zip(*grid, strict=True)
    ]
    assert sorted(uv) == [(0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.75, 0.75)]


@pytest.mark.parametrize("backend", some(["numpy", "jax"], "numpy"))
def test_samples_are_the_mean_of_a_finer_image_in_linear_light(backend):
    options = {"backend": backend, "dtype": "float64", "output": "linear"}
    fine = np.asarray(raytrace.render("checkerboard", (48, 27 * 3), **options))
    coarse = np.asarray(raytrace.render("checkerboard", (16, 27), samples=3, **options))
    mean = fine.reshape(27, 3, 16, 3, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(coarse, mean, atol=1e-12)
