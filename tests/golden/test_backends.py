"""Every backend on every built-in scene."""

import numpy as np
import pytest

import raytrace
from raytrace.compare.metrics import pixels_over, similarity
from raytrace.testing import goldens

pytestmark = pytest.mark.unchecked

#: Each is rendered once.
EVERY = goldens()


def unlike(backend):
    """The scenes in which a backend's image is not the golden one, by the bounds of `raytrace check`."""
    found = {}
    for golden in EVERY:
        image = np.asarray(raytrace.render(golden.scene, golden.size, backend=backend), np.float64)
        ssim, over = similarity(golden.image, image).mean, pixels_over(golden.image, image).mean()
        if not (ssim >= 0.9999 and over <= 0.001):
            found[golden.name] = ssim, over
    return found


@pytest.mark.slow
def test_graphics_engines(engine):
    assert unlike(engine) == {}


@pytest.mark.slow
def test_jax_in_float32():
    assert unlike("jax") == {}


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
