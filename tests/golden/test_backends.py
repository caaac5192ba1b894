"""Every backend on every built-in scene."""

import numpy as np
import pytest

import raytrace
from raytrace.comparison.metrics import pixels_over, similarity
from raytrace.testing import goldens

EVERY = pytest.mark.parametrize(
    "golden", [pytest.param(g, marks=() if g.name == "checkerboard" else pytest.mark.full) for g in goldens()], ids=str
)


def assert_alike(golden, backend):
    """By the bounds of `raytrace check`."""
    image = np.asarray(raytrace.render(golden.scene, golden.size, backend=backend), np.float64)
    assert similarity(golden.image, image).mean >= 0.9999
    assert pixels_over(golden.image, image).mean() <= 0.001


@EVERY
def test_graphics_engines(golden, engine):
    assert_alike(golden, engine)


@EVERY
def test_jax_in_float32(golden):
    assert_alike(golden, "jax")


def test_at_an_odd_height_only_centres_on_a_tiles_edge_differ(engine):
    """x = (2i - 479) / (2 (j - 135)), which is an odd multiple of 1/4 for 859 pixels of the ground; see the README."""
    reference = raytrace.render("checkerboard", (480, 271), backend="numpy", dtype="float64", output="steps")
    i, j = np.meshgrid(np.arange(480), np.arange(271))
    below = np.maximum(j - 135, 1)
    quarters, rest = np.divmod(2 * (2 * i - 479), below)
    on_edge = (reference["index"] == 6) & (rest == 0) & (quarters % 2 == 1)
    assert on_edge.sum() == 859
    for backend in (engine, "jax"):
        image = np.asarray(raytrace.render("checkerboard", (480, 271), backend=backend), np.float64)
        over = pixels_over(reference["display"], image)
        assert over.sum() > 100
        assert not (over & ~on_edge).any()
