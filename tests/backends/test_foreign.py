"""Somebody's own shader, run on real engines."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.export import EXPORTS
from tests.processes import command
from tests.scenes import some
from tests.strategies import many

SIZE = (160, 90)
STUDENT = """\
#version 300 es
precision highp float;
uniform mat4 u_inverseProjection, cameraMatrix;
in vec2 uv; // of the pixel
out vec4 color;
void main() {
    vec4 p = u_inverseProjection * vec4(2.*uv - 1., 1., 1.);
    color = vec4(0.5 + 0.5*normalize(mat3(cameraMatrix) * p.xyz), 1.);
}
"""


def written(text):
    Path("a.frag").write_text(text)
    return "a.frag"


def drawn(text, engine, **options):
    return raytrace.render("checkerboard", SIZE, backend=engine, shader=written(text), **options)


KINDS = [(to, data) for to in ("glsl", "shaderlabweb") for data in ("constants", "uniforms")]


@pytest.mark.parametrize(("to", "data"), some(KINDS, KINDS[0], KINDS[3]))
def test_an_exported_shader_gives_the_same_image(engine, to, data):
    scene = raytrace.load_scene("checkerboard")
    image = drawn(EXPORTS[to](scene, SIZE, data=data), engine)
    np.testing.assert_allclose(image, raytrace.render(scene, SIZE, backend=engine), atol=1e-5)


def test_an_exported_shader_with_a_texture_gives_the_same_image(engine):
    scene = replace(raytrace.load_scene("checkerboard"), spheres=many(300))
    Path("a.frag").write_text(EXPORTS["glsl"](scene, SIZE, data="uniforms"))
    image = raytrace.render(scene, SIZE, backend=engine, shader="a.frag")
    np.testing.assert_array_equal(image, raytrace.render(scene, SIZE, backend=engine))


def test_a_students_own_names_are_bound(engine):
    steps = raytrace.render("checkerboard", SIZE, backend="numpy", dtype="float64", output="steps")
    np.testing.assert_allclose(drawn(STUDENT, engine), 0.5 + 0.5 * steps["rd"], atol=1e-5)
    np.testing.assert_allclose(drawn(STUDENT.split("\n", 1)[1], engine), 0.5 + 0.5 * steps["rd"], atol=1e-5)


def test_uniforms_by_hand(engine):
    image = drawn(
        "#version 300 es\nprecision highp float;\nuniform vec3 a; uniform bool b; uniform float c[2]; uniform uint d;\n"
        "out vec4 color; void main(){color = vec4(b ? a.y : 0., c[1], float(d), 1.);}",
        engine,
        uniforms={"a": "camera_position", "b": True, "c": [1, 0.25], "d": 1},
    )
    assert image[0, 0].tolist() == [0.5, 0.25, 1]


def test_fragment_coordinates_are_those_of_the_whole_image(engine):
    image = drawn(
        "#version 300 es\nprecision highp float;\nout vec4 color; void main(){color = vec4(gl_FragCoord.xy, 0., 1.);}",
        engine,
        output="linear",
    )
    assert image[0, 0].tolist() == [0.5, SIZE[1] - 0.5, 0]
    assert image[-1, -1].tolist() == [SIZE[0] - 0.5, 0.5, 0]


def test_an_error_is_told_with_the_students_line(engine):
    with pytest.raises(raytrace.InputError, match=r"^a\.frag:8: .*missing.*: color = missing\(0\.5") as error:
        drawn(STUDENT.replace("vec4(0.5 +", "missing(0.5 +"), engine)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("cameraMatrix", "foo"), "uniform mat4 foo: is not bound to anything"),
        (("in vec2 uv", "in vec3 uv"), "input 'vec3 uv'"),
    ],
)
def test_what_is_not_given_is_named(engine, change, told):
    with pytest.raises(raytrace.InputError, match=r"^a\.frag: ") as error:
        drawn(STUDENT.replace(*change), engine)
    assert told in str(error.value)


def test_choices_that_a_shader_has_not(engine):
    for options, told in [
        ({"output": "steps"}, "output: "),
        ({"samples": 2}, "samples: "),
        ({"time_limit": 0.0}, "time_limit: "),
    ]:
        with pytest.raises(raytrace.InputError, match=f"^{told}"):
            drawn(STUDENT, engine, **options)
    with pytest.raises(raytrace.InputError, match="runs no shader; these do: opengl, webgl"):
        drawn(STUDENT, "numpy")
    with pytest.raises(raytrace.InputError, match="none is given"):
        raytrace.render("sphere", SIZE, backend=engine, uniforms={"a": 1})


def test_a_newer_shader_runs_on_opengl_only(engine):
    newer = STUDENT.replace("300 es", "330")
    if engine == "opengl":
        np.testing.assert_allclose(drawn(newer, engine), drawn(STUDENT, engine), atol=1e-6)
    else:
        with pytest.raises(raytrace.InputError, match="webgl takes '#version 300 es', found '#version 330'"):
            drawn(newer, engine)


ENDLESS = """\
#version 300 es
precision highp float;
uniform float time;
out vec4 color;
void main() {
    for(float t = 0.; t > -1. + time; t += 0.) color += sin(color + 1.);
}
"""


@pytest.mark.full
def test_an_endless_loop_is_one_line_and_exit_code_1(engine):
    args = ["render", "--shader", written(ENDLESS), "--backend", engine, "--size", "2048x2048", "--time-limit", "4"]
    done = command(*args)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith(f"raytrace: a.frag: backend {engine}: ")
    assert len(done.stderr.splitlines()) == 1
    assert [path.name for path in Path().iterdir()] == ["a.frag"]
