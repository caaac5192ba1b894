"""Copies of scenes with other values, and the sun by its angles."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given

import raytrace
from raytrace.errors import InputError
from tests.strategies import directions, numbers

SCENE = raytrace.load_scene("checkerboard")


@pytest.mark.parametrize(
    "setting",
    [
        "sun.direction=[0,1,0.5]",
        "sun.direction[1]=3.0",
        "sun.azimuth=120.0",
        "sun.elevation=5.0",
        "camera.fov=30.0",
        "camera.field_of_view=31.0",
        "spheres[0].radius=0.5",
        "spheres[5].center=[1.0,2.0,3.0]",
        "spheres[5].center[2]=7.0",
        "planes[0].pattern.tile_size=1.0",
        "film.tone_mapper='hable'",
        "lighting='on'",
    ],
)
def test_a_path_leads_where_it_leads_in_a_file(setting):
    path, _, text = setting.partition("=")
    value = eval(text)
    changed, expected = SCENE.with_(path, value), raytrace.load_scene("checkerboard", [setting])
    assert changed != SCENE
    for a, b in zip(jax.tree.leaves(changed), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-15, atol=1e-15)
    assert jax.tree.structure(changed) == jax.tree.structure(expected)
    raytrace.check_scene(changed)


def test_fields_by_name_and_several_at_once():
    sun = raytrace.Sun([0, 1, 0])
    changed = SCENE.with_(sun=sun, **{"film.exposure": 1.0, "sun.color": [1, 2, 3]})
    assert changed.sun == raytrace.Sun([0, 1, 0], [1, 2, 3])
    assert changed.film.exposure == 1
    assert SCENE.sun.with_(elevation=90.0).direction == pytest.approx([0, 1, 0])
    assert SCENE.with_() == SCENE


@pytest.mark.parametrize(
    ("path", "value", "told"),
    [
        ("sunn", 1, "sunn: Scene has no 'sunn'; did you mean 'sun'? it has: spheres, planes"),
        ("sun.x", 1, "sun.x: Sun has no 'x'; it has: direction, color"),
        ("spheres[6].radius", 1, r"spheres[6].radius: has no [6]; there are 6"),
        ("spheres[0]", 1, "spheres[0]: must name a number of that sphere"),
        ("spheres[0].color", [1, 2], "spheres[0].color: must be of shape (3,)"),
        ("film.exposure[0]", 1, "film.exposure[0]: there is nothing at 0"),
        ("sun direction", 1, "with_: must be given a path such as 'sun.direction', found 'sun direction'"),
        (3, 1, "with_: must be given a path such as 'sun.direction', found 3"),
    ],
)
def test_a_path_that_leads_nowhere(path, value, told):
    with pytest.raises(InputError) as error:
        SCENE.with_(path, value)
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_a_path_without_a_value():
    with pytest.raises(InputError, match="takes a path and its value"):
        SCENE.with_("sun.azimuth")


def test_values_may_be_traced():
    def azimuth(angle):
        return SCENE.with_("sun.azimuth", angle).sun.azimuth

    def third(radius):
        return SCENE.with_("spheres[2].radius", radius).spheres.radius

    assert jax.grad(azimuth)(30.0) == pytest.approx(1, rel=1e-5)
    np.testing.assert_array_equal(jax.jacfwd(third)(1.0), [0, 0, 1, 0, 0, 0])
    np.testing.assert_allclose(third(jnp.float32(2)), [*SCENE.spheres.radius[:2], 2, *SCENE.spheres.radius[3:]])


@given(directions, numbers(-179, 179), numbers(-89, 89))
def test_the_sun_has_angles(direction, azimuth, elevation):
    sun = raytrace.Sun(azimuth=azimuth, elevation=elevation)
    assert (sun.azimuth, sun.elevation) == pytest.approx((azimuth, elevation), abs=1e-9)
    assert (*raytrace.sun_angles(direction),) == (raytrace.Sun(direction).azimuth, raytrace.Sun(direction).elevation)


@pytest.mark.parametrize("angles", [{"azimuth": 1}, {"elevation": 1}, {"direction": [0, 1, 0], "azimuth": 1}])
def test_a_sun_in_two_ways_or_by_half(angles):
    with pytest.raises(InputError, match="takes either a direction or an azimuth and an elevation"):
        raytrace.Sun(**angles)
