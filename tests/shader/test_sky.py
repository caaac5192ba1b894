import numpy as np
import pytest

import raytrace
from raytrace.scene.to_uniforms import uniforms_of
from raytrace.shader.sky import background_color
from tests.strategies import unit, vec3


def sky(rd, **sun):
    uniforms = uniforms_of(raytrace.Scene(sun=raytrace.Sun(**sun)), 1.0)
    return background_color(vec3(rd), uniforms.sky, uniforms.sun)


def test_void_below_the_horizon():
    assert sky([0, -1, 0]) == (0.025, 0.05, 0.075)


def test_the_horizon_itself_is_sky():
    """rd.y = 0 is not < 0: 0 to the power 1/4 is 0, so the colour is skyColorLow, away from the sun."""
    assert sky([0, 0, -1]) == (0.36, 0.45, 0.57)
    assert sky([-0.0, -0.0, -1]) == (0.36, 0.45, 0.57)


def test_zenith_without_sun_by_hand():
    """rd.y = 1: the mix is all skyColorHigh; a sun on the horizon adds 0 ** 2400 = 0."""
    assert sky([0, 1, 0], direction=[1, 0, 0]) == (0.14, 0.21, 0.49)


def test_halfway_up_by_hand():
    """rd.y = 1/16 has the fourth root 1/2: red is (0.36 + 0.14) / 2 = 0.25; the sun is behind."""
    color = sky([0, 1 / 16, -np.sqrt(1 - 1 / 256)], direction=[0, 0, 1])
    assert color == pytest.approx((0.25, 0.33, 0.53), abs=1e-15)


def test_the_middle_of_the_sun_is_the_suns_colour():
    assert sky(unit([3, 4, 0]), direction=[6, 8, 0]) == pytest.approx((1.64, 1.27, 0.99), rel=1e-12)


def test_the_suns_edge_by_hand():
    """At 1 degree cos^2400 = exp(2400 ln cos) = 0.69375...: sun and sky are mixed with that share."""
    angle = np.radians(1)
    share = np.exp(2400 * np.log(np.cos(angle)))
    assert share == pytest.approx(0.6938, abs=1e-4)
    sky_red = 0.36 + (0.14 - 0.36) * np.cos(angle) ** 0.25
    red = sky([0, np.cos(angle), np.sin(angle)], direction=[0, 1, 0]).x
    assert red == pytest.approx(sky_red * (1 - share) + 1.64 * share, rel=1e-12)
