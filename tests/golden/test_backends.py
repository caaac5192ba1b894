"""Every backend on every built-in scene."""

import numpy as np
import pytest

import raytrace
from raytrace.compare.metrics import pixels_over, similarity
from raytrace.testing import goldens


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
@pytest.mark.parametrize("backend", ["jax", "numpy"])
def test_float32(backend):
    assert unlike(backend) == {}
