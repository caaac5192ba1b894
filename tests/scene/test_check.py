import numpy as np
import pytest

import raytrace


def refused(scene):
    with pytest.raises(raytrace.InputError) as error:
        raytrace.check_scene(scene)
    return str(error.value)


def balls(n=3, **changes):
    arrays = {"center": np.zeros((n, 3)), "radius": np.ones(n), "color": np.ones((n, 3))} | changes
    return raytrace.Scene(spheres=raytrace.Spheres(**arrays))


def test_scenes_made_in_python_follow_the_files_rules():
    assert refused(raytrace.Scene(sun=raytrace.Sun(color=[0, -1, 0]))) == (
        "scene: sun.color[1]: must not be negative, found -1.0"
    )
    assert "camera: must not look along up" in refused(
        raytrace.Scene(camera=raytrace.PerspectiveCamera(position=[0, 5, 0], target=[0, 0, 0]))
    )


def test_arrays_of_spheres_name_the_sphere():
    assert refused(balls(radius=[1.0, -2.0, 1.0])) == "scene: spheres[1].radius: must be greater than 0, found -2.0"
    center = np.zeros((3, 3))
    center[2, 1] = np.nan
    assert refused(balls(center=center)) == "scene: spheres[2].center[1]: must be a finite number, found nan"
    assert "spheres.center: must be of shape (3, 3), found (2, 3)" in refused(balls(center=np.zeros((2, 3))))


def test_a_million_spheres_are_checked():
    raytrace.check_scene(balls(1_000_000))


def test_render_checks_what_it_is_given():
    with pytest.raises(raytrace.InputError, match="radius"):
        raytrace.render(balls(radius=[1.0, 0.0, 1.0]), (4, 4))


def test_records_are_frozen_and_compare_by_value():
    sun = raytrace.Sun(direction=[0, 1, 0])
    assert sun == raytrace.Sun(direction=(0.0, 1.0, 0.0))
    assert sun != raytrace.Sun(direction=[0, 1, 1e-300])
    assert sun != "sun"
    with pytest.raises(AttributeError):
        sun.direction = [1, 0, 0]
