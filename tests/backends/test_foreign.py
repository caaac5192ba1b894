"""Somebody's own shader, run on real engines."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.export import EXPORTS
from tests.engines import need
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


BODY = "void main(){ color = vec4(uv, 0.25, 1.); }"
OLD = "varying vec2 uv; void main(){ gl_FragColor = vec4(uv, 0.25, 1.); }"
DIALECTS = {
    "GLSL ES 1.00": f"#version 100\nprecision highp float; {OLD}",
    "no version": f"precision highp float; {OLD}",
    "a comment": f"#version 300 es // mine\nprecision highp float; in vec2 uv; out vec4 color; {BODY}",
    "blank lines": f"\n\n#version 300 es\nprecision highp float; in vec2 uv; out vec4 color; {BODY}",
    "Shadertoy": "\
void mainImage(out vec4 c, in vec2 p){ c = vec4(p / iResolution.xy, iTime + .25*iResolution.z, 0); }",
    "GLSL 1.20": f"#version 120\n{OLD}",
    "GLSL 1.10, no version": OLD,
    "GLSL 4.50": f"#version 450 core\nlayout(location = 0) in vec2 uv; layout(location = 0) out vec4 color; {BODY}",
    "compatibility": f"#version 330 compatibility\nin vec2 uv; out vec4 color; {BODY}",
}
#: Those that a browser does not run.
DESKTOP = ("GLSL 1.20", "GLSL 1.10, no version", "GLSL 4.50", "compatibility")


@pytest.mark.parametrize("dialect", some(DIALECTS, "GLSL ES 1.00", "Shadertoy", "GLSL 1.20", "GLSL 4.50"))
def test_dialects(engine, dialect):
    """Each is run, or refused in a line that says what is taken."""
    if engine == "webgl" and dialect in DESKTOP:
        with pytest.raises(raytrace.InputError, match=r"^a\.frag: backend webgl takes '#version 300 es', found "):
            drawn(DIALECTS[dialect], engine)
        return
    image = drawn(DIALECTS[dialect], engine)
    height, width = image.shape[:2]
    uv = (np.arange(width) + 0.5) / width, 1 - (np.arange(height) + 0.5) / height
    expected = np.stack([*np.meshgrid(*uv), np.full((height, width), 0.25)], axis=-1)
    np.testing.assert_allclose(image, expected, atol=1e-5)


HEAD = "#version 300 es\nprecision highp float; precision highp int; out vec4 color;\n"


@pytest.mark.parametrize(
    ("declared", "shown", "uniforms", "expected"),
    [
        ("uniform Scene{ mat4 viewToWorld; vec3 camPos; };", "camPos", {}, [0, 0.5, 2]),
        ("layout(std140) uniform Scene{ float x; vec3 eye; } scene;", "scene.eye * scene.x", {"scene.x": 2}, [0, 1, 4]),
        ("struct A{ vec3 position; }; uniform A camera;", "camera.position", {}, [0, 0.5, 2]),
        ("uniform mat3 m;", "m * vec3(1., 0., 0.)", {"m": [[1, 2, 3], [4, 5, 6], [7, 8, 9]]}, [1, 4, 7]),
        ("uniform mat3 m;", "m * vec3(1., 0., 0.)", {"m": [1, 2, 3, 4, 5, 6, 7, 8, 9]}, [1, 2, 3]),
        ("uniform vec3 iResolution;", "iResolution", {}, [*SIZE, 1]),
        ("uniform float unused; uniform float a;", "vec3(a)", {"unused": 3, "a": 0.5}, [0.5, 0.5, 0.5]),
        ("uniform vec3 constructor, toString; uniform float valueOf;", "constructor * toString + valueOf",
         {"constructor": [1, 2, 3], "toString": [2, 2, 2], "valueOf": 1}, [3, 5, 7]),
        ("uniform struct A{ vec3 center; float radius; vec3 color; } spheres[8];", "vec3(spheres[1].center.xy, "
         "spheres[7].radius + spheres[5].radius)", {}, [-0.5, 0, 0.3]),
    ],
)  # fmt: skip
def test_nothing_that_is_read_is_silently_zero(engine, declared, shown, uniforms, expected):
    image = drawn(f"{HEAD}{declared} void main(){{ color = vec4({shown}, 1.); }}", engine, uniforms=uniforms)
    np.testing.assert_allclose(image[0, 0], expected, rtol=1e-6)


@pytest.mark.parametrize(
    ("declared", "shown", "uniforms", "told"),
    [
        ("uniform struct A{ vec3 center; } spheres[4]; uniform int n;", "spheres[n].center", {"n": 1},
         "uniform spheres[4]: is too short for the scene's 6"),
        ("uniform float sphereRadii[3]; uniform int n;", "vec3(sphereRadii[n])", {"n": 1},
         "uniform float sphereRadii: has 3 elements, too few for the 6 of its value"),
        ("uniform int n;", "vec3(n)", {"n": 1.5}, "takes whole numbers from -2147483648 to 2147483647, found 1.5"),
        ("uniform uint n;", "vec3(n)", {"n": -1}, "takes whole numbers from 0 to 4294967295, found -1"),
        ("uniform float x;", "vec3(x)", {"x": 1e39}, "takes numbers of float32, found 1e+39"),
    ],
)  # fmt: skip
def test_what_a_uniform_does_not_hold(engine, declared, shown, uniforms, told):
    with pytest.raises(raytrace.InputError, match=r"^a\.frag: uniform ") as error:
        drawn(f"{HEAD}{declared} void main(){{ color = vec4({shown}, 1.); }}", engine, uniforms=uniforms)
    assert told in str(error.value)


def test_a_shader_that_only_discards_is_black(engine):
    assert not drawn(f"{HEAD}void main(){{ discard; }}", engine).any()


def test_our_own_vertex_shader_is_not_shown(engine):
    with pytest.raises(raytrace.InputError) as error:
        drawn(f"{HEAD}in vec2 gl_Mine; void main(){{ color = vec4(1.); }}", engine)
    assert "fragmentTextureCoordinates" not in str(error.value)
    assert "gl_VertexID" not in str(error.value)


LOOPS = {
    "for": "for(int i = 0; i != n; i += 0) color += sin(color + 1.);",
    "while": "while(true) color += sin(color + 1.);",
    "do": "do color += sin(color + 1.); while(n == 1);",
    "no condition": "for(;;){ color += sin(color + 1.); if(color.x > 1e9) break; }",
    "long": "for(int i = 0; i < 70000; i++) color += sin(color + 1.);",
    "nested": "for(int i = 0; i < 300; i++) for(int j = 0; j < 300; j++) color += sin(color + 1.);",
}


@pytest.mark.parametrize("loop", some(LOOPS, "for", "nested"))
def test_a_loop_that_is_cut_is_told(loop):
    """llvmpipe leaves it without a word, and goes on."""
    need("opengl")
    text = f"{HEAD}uniform int n;\nvoid main(){{\n for(int i = 0; i < n; i++) color += 1.;\n {LOOPS[loop]} }}"
    Path("a.frag").write_text(text)
    with pytest.raises(raytrace.EngineFailure, match=r"^a\.frag:6: this loop never ends, or takes too long"):
        raytrace.render("sphere", (8, 4), backend="opengl", shader="a.frag", uniforms={"n": 1})


@pytest.mark.parametrize("turns", [0, 1, 60_000])
@pytest.mark.parametrize("discard", ["", "if(gl_FragCoord.x < 4.) discard;"])
def test_a_loop_that_ends_is_not(turns, discard):
    need("opengl")
    text = f"{HEAD}uniform int n; void main(){{ color = vec4(0.); {discard} for(int i = 0; i < n; i++) color += 1.; }}"
    Path("a.frag").write_text(text)
    image = raytrace.render("sphere", (8, 4), backend="opengl", shader="a.frag", uniforms={"n": turns}, output="linear")
    np.testing.assert_array_equal(image[:, 4:], np.full((4, 4, 3), turns))
    np.testing.assert_array_equal(image[:, :4], np.full((4, 4, 3), 0 if discard else turns))


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
