import numpy as np
import pytest
from hypothesis import given

import raytrace
from raytrace.language.glsl import Vec2, dot
from raytrace.scene.to_uniforms import uniforms_of
from raytrace.shader.camera import orthographic_ray, pixel_to_ndc, primary_ray
from tests.strategies import cameras, numbers


def matrices(camera, aspect=1.0):
    return uniforms_of(raytrace.Scene(camera=camera), aspect).camera


def test_ndc_by_hand():
    """2 * (0.25, 1) - 1 = (-0.5, 1)."""
    assert pixel_to_ndc(np.float64(0.25), np.float64(1)) == (-0.5, 1)


def test_primary_ray_by_hand():
    """90 degrees: the top edge's middle is at tan 45 = 1 above the axis at distance 1.

    From (1,2,3) towards -z that is the direction (0, 1, -1) / sqrt(2).
    """
    camera = raytrace.PerspectiveCamera(position=[1, 2, 3], target=[1, 2, 0], field_of_view=90)
    ro, rd = primary_ray(matrices(camera), Vec2(np.float64(0), np.float64(1)))
    assert ro == (1, 2, 3)
    assert rd == pytest.approx((0, np.sqrt(0.5), -np.sqrt(0.5)), abs=1e-15)


def test_aspect_widens_the_view():
    """At aspect 2 the right edge's middle is at (2, 0, -1) / sqrt(5)."""
    camera = raytrace.PerspectiveCamera(position=[0, 0, 0], target=[0, 0, -1], field_of_view=90)
    _, rd = primary_ray(matrices(camera, 2.0), Vec2(np.float64(1), np.float64(0)))
    assert rd == pytest.approx((2 / np.sqrt(5), 0, -1 / np.sqrt(5)), abs=1e-15)


def test_orthographic_ray_by_hand():
    """Height 4: the top edge is 2 above the axis; the near plane is 0.5 ahead of (0,0,5); rays run along -z."""
    camera = raytrace.OrthographicCamera(position=[0, 0, 5], target=[0, 0, 0], height=4, near=0.5)
    ro, rd = orthographic_ray(matrices(camera), Vec2(np.float64(0), np.float64(1)))
    assert ro == pytest.approx((0, 2, 4.5), abs=1e-15)
    assert rd == (0, 0, -1)


@given(cameras(), numbers(-1, 1), numbers(-1, 1))
def test_directions_are_unit_and_ahead(camera, x, y):
    ray = orthographic_ray if isinstance(camera, raytrace.OrthographicCamera) else primary_ray
    _, rd = ray(matrices(camera), Vec2(np.float64(x), np.float64(y)))
    assert dot(rd, rd) == pytest.approx(1, abs=1e-14)
    assert np.dot(rd, camera.target - camera.position) > 0
