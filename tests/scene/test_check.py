import importlib
import subprocess
import sys

import numpy as np
import pytest

import raytrace
from raytrace.scene.check import check_scene


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


WRONG = {
    "Scene(camera=None)": "camera: must be a PerspectiveCamera or",
    "Scene(spheres=None)": "spheres: must be a Spheres, found NoneType",
    "Scene(planes=None)": "planes: must be a tuple, found NoneType",
    "Scene(planes=(3,))": "planes[0]: must be a Plane",
    "Scene(sun=Sun(direction=None))": "sun.direction: must be an array of numbers",
    "Scene(sun=Sun(direction=[1, 2]))": "sun.direction: must be of shape (3,), found (2,)",
    "Scene(spheres=Spheres(radius=[[1]]))": "spheres.radius: must be of shape (n,), found (1, 1)",
    "Scene(spheres=Spheres(center=[['a', 0, 0]]))": "center: must be numbers",
}


def test_scenes_of_the_wrong_things():
    """In another process, one for all: here the annotations, checked in the tests, would refuse them first."""
    code = "from raytrace import *\n" + "".join(
        f"try:\n    check_scene({scene})\n    print('accepted')\nexcept InputError as error:\n    print(error)\n"
        for scene in WRONG
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    for told, said in zip(WRONG.values(), done.stdout.splitlines(), strict=True):
        assert told in said


def test_lists_will_do():
    scene = raytrace.Scene(planes=[raytrace.Plane()], film=raytrace.Film(white_point=[0.31, 0.33]))
    raytrace.check_scene(scene)
    assert scene.planes == (raytrace.Plane(),)
    assert raytrace.render(scene, (4, 4), backend="numpy", dtype="float32").shape == (4, 4, 3)
    assert raytrace.Scene(planes=[]) == raytrace.Scene()


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


@pytest.mark.parametrize("library", ["numpy", "jax.numpy"])
def test_choices_may_be_numbers_of_numpy_or_jax(library):
    """They become Python's, so that scenes are equal and a program is compiled for them."""
    xp = importlib.import_module(library)
    scene = raytrace.Scene(
        planes=[raytrace.Plane(casts_shadow=xp.asarray(True))],
        film=raytrace.Film(white_point=xp.asarray([0.25, 0.375])),
    )
    assert scene.planes[0].casts_shadow is True
    assert scene.film.white_point == (0.25, 0.375)
    assert raytrace.Film(white_point=xp.asarray(4000.0)) == raytrace.Film(white_point=4000.0)
    assert raytrace.render(scene, (8, 4)).shape == (4, 8, 3)


def test_a_choice_cannot_be_traced():
    import jax

    def brightness(kelvin):
        return raytrace.render(raytrace.Scene(film=raytrace.Film(white_point=kelvin)), (8, 4)).mean()

    with pytest.raises(raytrace.InputError, match="white_point: is a constant, which JAX cannot trace"):
        jax.grad(brightness)(4000.0)


def test_a_view_matrix_of_columns_is_noticed():
    matrix = np.eye(4)
    matrix[:3, 3] = 0, 0.5, 2
    camera = raytrace.MatrixCamera(np.diag([1.0, 1, 1, 1]), matrix)
    check_scene(raytrace.Scene(camera=camera))
    with pytest.raises(
        raytrace.InputError, match=r"view_to_world must have 0 0 0 1 as its last row; is it transposed\?"
    ):
        check_scene(raytrace.Scene(camera=raytrace.MatrixCamera(camera.ndc_to_view, matrix.T)))
