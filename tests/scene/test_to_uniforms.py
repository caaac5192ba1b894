import numpy as np
import pytest
from hypothesis import given

import raytrace
from raytrace.language.glsl import dot
from raytrace.language.tree import tree_leaves
from raytrace.scene.to_uniforms import uniforms_of
from tests.strategies import cameras, directions


def matrix(columns):
    return np.array(columns).T


def test_perspective_matrices_by_hand():
    """60 degrees at aspect 2: the inverse projection's scales are 2 tan 30 and tan 30.

    Its depth part maps z_ndc = 1 to distance far: w = 1 / far there, and z = -1.
    """
    camera = raytrace.PerspectiveCamera(position=[1, 2, 3], target=[1, 2, -4], near=0.5, far=50)
    uniforms = uniforms_of(raytrace.Scene(camera=camera), 2.0).camera
    ndc_to_view = matrix(uniforms.ndc_to_view)
    tan = np.tan(np.radians(30))
    assert ndc_to_view @ [1, 1, 1, 1] == pytest.approx([2 * tan, tan, -1, 1 / 50])
    assert ndc_to_view @ [0, 0, -1, 1] == pytest.approx([0, 0, -1, 1 / 0.5])
    expected = [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    assert matrix(uniforms.view_to_world).tolist() == expected


@given(cameras())
def test_the_cameras_axes_are_orthonormal(camera):
    view_to_world = matrix(uniforms_of(raytrace.Scene(camera=camera), 1.5).camera.view_to_world)
    axes = view_to_world[:3, :3]
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-14)
    assert np.linalg.det(axes) == pytest.approx(1)
    assert view_to_world[:, 3].tolist() == [*camera.position, 1]


def test_explicit_matrices_are_given_as_they_are():
    """The image of a perspective camera and of its own matrices are equal, bit for bit."""
    scene = raytrace.load_scene("checkerboard")
    camera = uniforms_of(scene, 64 / 36).camera
    explicit = raytrace.MatrixCamera(matrix(camera.ndc_to_view), matrix(camera.view_to_world))
    options = {"size": (64, 36), "backend": "numpy", "dtype": "float64"}
    from dataclasses import replace

    np.testing.assert_array_equal(
        raytrace.render(scene, **options), raytrace.render(replace(scene, camera=explicit), **options)
    )


@pytest.mark.parametrize("length", [1e-38, 1e-20, 1.0, 1e20, 1e38])
def test_a_direction_of_any_length_can_be_normalised_in_float32(length):
    scene = raytrace.Scene(sun=raytrace.Sun(direction=np.multiply([0.6, 0.64, 0.48], length)))
    direction = uniforms_of(scene, 1.0).sun.direction
    squared = np.float32(dot(direction, direction))
    assert np.finfo(np.float32).smallest_normal < squared < np.finfo(np.float32).max
    np.testing.assert_allclose(np.array([*direction]) / np.sqrt(float(squared)), [0.6, 0.64, 0.48], rtol=1e-6)


@given(directions)
def test_plane_normals_are_normalised_and_not_flipped(normal):
    plane = uniforms_of(raytrace.Scene(planes=(raytrace.Plane(normal=normal),)), 1.0).planes
    given_ = np.array([n[0] for n in plane.normal])
    assert np.linalg.norm(given_) == pytest.approx(1, abs=1e-15)
    assert np.dot(given_, normal) > 0


def test_what_a_scene_lacks_has_no_uniforms():
    uniforms = uniforms_of(raytrace.Scene(), 1.0)
    assert uniforms.spheres is None
    assert uniforms.planes is None
    assert uniforms.shadow_planes is None
    assert len(tree_leaves(uniforms)) == 32 + 6 + 9


def test_the_scene_is_rounded_to_float32_once():
    """0.1 is no float32: rendered in float64 it is the float32 nearest to it, unless exact inputs are asked for."""
    scene = raytrace.Scene(sky=raytrace.Sky(void=[0.1, 0.2, 0.3]))
    options = {"size": (4, 4), "dtype": "float64", "output": "linear"}
    for backend in ("numpy", "jax"):
        bottom = raytrace.render(scene, backend=backend, **options)[-1, 0]
        assert bottom.tolist() == np.float32([0.1, 0.2, 0.3]).astype(float).tolist()
        bottom = raytrace.render(scene, backend=backend, exact_inputs=True, **options)[-1, 0]
        assert bottom.tolist() == [0.1, 0.2, 0.3]
