import numpy as np
import pytest

import raytrace
from raytrace.comparison.develop import NEUTRAL, developed, film_of, undeveloped


def scene(**settings):
    return raytrace.Scene(film=raytrace.Film(**settings))


@pytest.mark.parametrize("tone_mapper", ["aces", "reinhard", "hable", "none"])
@pytest.mark.parametrize("transfer", ["gamma2.2", "srgb", "none"])
def test_undeveloped_light_develops_to_the_same(tone_mapper, transfer):
    display = np.random.default_rng(0).uniform(0, 0.99, (8, 9, 3))
    program = film_of(scene(tone_mapper=tone_mapper, transfer=transfer))[1]
    np.testing.assert_allclose(developed(undeveloped(display, program), NEUTRAL, program), display, atol=1e-5)


def test_a_film_that_is_not_one_to_one_is_not_undone():
    program = film_of(scene(tone_mapper=lambda x: x * (1 - x)))[1]
    assert undeveloped(np.full((1, 1, 3), 0.2), program) is None


def test_developing_is_what_the_renderer_does():
    """The same bits, with exposure and white balance."""
    changed = raytrace.load_scene("skybox", ["film.exposure=0.7", "film.white_point=4500"])
    linear, display = (
        raytrace.render(changed, (16, 9), backend="numpy", dtype="float64", output=output)
        for output in ("linear", "display")
    )
    np.testing.assert_array_equal(developed(linear, *film_of(changed)), display)
