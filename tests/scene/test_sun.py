import numpy as np
import pytest
from hypothesis import given

import raytrace
from tests.strategies import directions, numbers


def test_by_hand():
    """Azimuth 0 looks along -z, 90 degrees along +x; (1, 0.75, 1) is behind to the right: atan2(1, -1) = 135.

    Its elevation is asin(0.75 / sqrt(2.5625)) = 27.938...
    """
    assert raytrace.sun_direction(0, 0) == pytest.approx([0, 0, -1])
    assert raytrace.sun_direction(90, 0) == pytest.approx([1, 0, 0])
    assert raytrace.sun_direction(17, 90) == pytest.approx([0, 1, 0])
    azimuth, elevation = raytrace.sun_angles([1, 0.75, 1])
    assert azimuth == pytest.approx(135)
    assert elevation == pytest.approx(np.degrees(np.arcsin(0.75 / np.sqrt(2.5625))))


@given(numbers(-179, 179), numbers(-89, 89))
def test_there_and_back(azimuth, elevation):
    assert raytrace.sun_angles(raytrace.sun_direction(azimuth, elevation)) == pytest.approx(
        (azimuth, elevation), abs=1e-9
    )


@given(directions, numbers(-15, 15))
def test_any_length(direction, exponent):
    scaled = np.multiply(direction, 10.0 ** (20 * exponent))
    assert raytrace.sun_angles(scaled) == pytest.approx(raytrace.sun_angles(direction), abs=1e-9)


def test_jax_arrays_stay_jax_arrays():
    import jax
    import jax.numpy as jnp

    direction = raytrace.sun_direction(jnp.float32(30), jnp.float32(40))
    assert isinstance(direction, jax.Array)
    slope = jax.jacfwd(lambda azimuth: raytrace.sun_angles(raytrace.sun_direction(azimuth, 40.0))[0])(jnp.float32(30))
    assert slope == pytest.approx(1, rel=1e-5)
