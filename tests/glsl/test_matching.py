from typing import NamedTuple

import numpy as np
import pytest

import raytrace
from raytrace.errors import InputError
from raytrace.glsl.matching import matched, parse_uniforms
from raytrace.glsl.meanings import MEANINGS, meaning_of, meanings
from raytrace.glsl.values import values_of
from raytrace.scene.to_uniforms import uniforms_of

VALUES = values_of(uniforms_of(raytrace.load_scene("checkerboard"), 2.0))


class Uniform(NamedTuple):
    name: str
    type: str
    length: int = 1


def value(uniform, given=None):
    found, _ = matched("a.frag", [uniform], VALUES, (200, 100), given or {}, {"spheres": "[8]"})
    return found[uniform.name].tolist()


@pytest.mark.parametrize(
    ("name", "meaning"),
    [
        ("camPos", "camera_position"),
        ("u_cameraPosition", "camera_position"),
        ("Camera Position", "camera_position"),
        ("uCamPos", "camera_position"),
        ("viewToWorld", "inverse_view_matrix"),
        ("inverse_view_matrix", "inverse_view_matrix"),
        ("vMatrix", "view_matrix"),
        ("iResolution", "resolution"),
        ("sunDirection", "sun_direction"),
        ("foo", None),
    ],
)
def test_a_name_says_what_it_means(name, meaning):
    assert meaning_of(name) == meaning


def test_no_name_means_two_things():
    plain = [alias.replace("_", "").lower() for name, aliases in MEANINGS.items() for alias in (name, *aliases)]
    assert sorted(set(plain)) == sorted(plain)


def test_the_scenes_own_names():
    assert value(Uniform("spheres[1].center", "vec3")) == [-0.5, 0.0, -2.0]
    assert value(Uniform("planes[0].tileSize", "float")) == [0.5]
    assert value(Uniform("voidColor", "vec3")) == np.float32([0.025, 0.05, 0.075]).tolist()


def test_a_longer_array_is_filled_up_with_zeros():
    assert value(Uniform("spheres[7].center", "vec3")) == [0, 0, 0]
    radii = value(Uniform("sphereRadii", "float", 8))
    assert radii[:6] == np.float32([1.5, 0.6, 0.8, 0.2, 0.2, 0.3]).tolist()
    assert radii[6:] == [0, 0]


def test_types_are_fitted():
    assert value(Uniform("camPos", "vec4")) == [0, 0.5, 2, 1]
    assert value(Uniform("sunDirection", "vec4")) == [1, 0.75, 1, 0]
    assert value(Uniform("viewToWorld", "mat3")) == [1, 0, 0, 0, 1, 0, 0, 0, 1]
    assert value(Uniform("resolution", "ivec2")) == [200, 100]
    assert value(Uniform("sphereCount", "int")) == [6]


def test_inverse_matrices_are_inverse():
    known = meanings(VALUES, (200, 100))
    for name in ("view_matrix", "projection_matrix"):
        a, b = (known[key].reshape(4, 4).T for key in (name, f"inverse_{name}"))
        np.testing.assert_allclose(a @ b, np.eye(4), atol=1e-12)
    near, far, angle = (float(known[name]) for name in ("near_clipping_plane", "far_clipping_plane", "perspective_fov"))
    np.testing.assert_allclose([near, far, angle], [0.1, 100, 60])


def test_values_may_be_given():
    assert value(Uniform("foo", "vec3"), {"foo": "camera position"}) == [0, 0.5, 2]
    assert value(Uniform("foo", "float"), {"foo": 2}) == [2]
    assert value(Uniform("foo", "bool"), {"foo": True}) == [1]
    assert value(Uniform("sunColor", "vec3"), {"sunColor": [1, 2, 3]}) == [1, 2, 3]
    assert parse_uniforms(["a=camera_position", "b = [1, 2]", "c=1.5", "d=true"]) == {
        "a": "camera_position",
        "b": [1, 2],
        "c": 1.5,
        "d": True,
    }


@pytest.mark.parametrize(
    ("uniform", "given", "told"),
    [
        (Uniform("foo", "float"), {}, "uniform float foo: is not bound to anything"),
        (Uniform("image", "sampler2D"), {}, "uniform sampler2D image: is not bound to anything"),
        (Uniform("image", "sampler2D"), {"image": 1}, "a value of this type cannot be given"),
        (Uniform("camPos", "vec2"), {}, "has 2 components, its value 3"),
        (Uniform("foo", "vec3"), {"foo": "camera_pos1tion"}, "did you mean 'camera_position'"),
        (Uniform("foo", "vec3"), {"foo": {"a": 1}}, "must be a name, a number"),
        (Uniform("camPos", "vec3"), {"campos": 1}, "uses no uniform 'campos'; did you mean 'camPos'"),
    ],
)
def test_what_cannot_be_bound(uniform, given, told):
    with pytest.raises(InputError, match=r"^a\.frag: ") as error:
        value(uniform, given)
    assert told in str(error.value)


def test_settings_that_are_none():
    for setting in ("a", "=1", "a="):
        with pytest.raises(InputError, match=r"^--uniform "):
            parse_uniforms([setting])
