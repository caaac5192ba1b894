"""The assignment's GLSL on real engines, against NumPy float64."""

import os
import signal
import threading
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

import raytrace
from raytrace.backends.gpu.drawing import Drawing, ShaderProgram, ShaderRejected
from raytrace.backends.gpu.process import EngineProcess, engine_process
from raytrace.glsl import vertex_shader
from raytrace.rendering import Options, Rendering
from tests.engines import need
from tests.scenes import examples, some
from tests.strategies import many, scenes

SIZE = (160, 90)
BASE = raytrace.load_scene("checkerboard")
WALL = raytrace.Plane(point=(0, 0, -4), normal=(0, 0, 2), pattern=raytrace.Plain((0.3, 0.4, 0.2)), casts_shadow=True)
SCENES = {
    "checkerboard": BASE,
    "no sphere": replace(BASE, spheres=raytrace.Spheres()),
    "nothing": raytrace.Scene(),
    "more spheres than uniforms": replace(BASE, spheres=many(300)),
    "lighting off": replace(BASE, lighting="off"),
    "lighting on": replace(BASE, lighting="on"),
    "two planes, one casts": replace(BASE, planes=(raytrace.Plane(), WALL)),
    "two planes, both cast": replace(BASE, planes=(raytrace.Plane(casts_shadow=True), WALL)),
    "plain": replace(BASE, planes=(WALL,)),
    "own colours": replace(BASE, planes=(raytrace.Plane(pattern=raytrace.Checkerboard(0.7, (1, 0, 0), (0, 1, 0))),)),
    "orthographic": replace(BASE, camera=raytrace.OrthographicCamera(3.0, target=(0.3, 0, -1))),
    "reinhard": replace(BASE, film=raytrace.Film(0.5, 4000.0, "reinhard", "srgb")),
    "hable": replace(BASE, film=raytrace.Film(-1.0, None, "hable", "none")),
    # Its red and green are negative after white balance.
    "negative light": replace(
        BASE, sky=raytrace.Sky((0, 0, 3.24), (0, 0.1, 3.24), (0, 0, 2)), film=raytrace.Film(1.3, 3000.0, "reinhard")
    ),
    "white point": replace(BASE, film=raytrace.Film(0.0, (0.3, 0.35), "none", "gamma2.2")),
}


def differing(a, b, bound=1e-3):
    """In how many pixels two steps differ, relative to the larger of 1 and the value."""
    apart = ~(np.abs(a.astype(np.float64) - b) <= bound * np.maximum(1, np.abs(b)))
    return int(np.atleast_3d(apart).any(axis=-1).sum())


@pytest.mark.parametrize("scene", some(SCENES, "checkerboard", "white point"))
def test_every_step_is_that_of_numpy(engine, scene):
    """But for single pixels on an edge, where float32 decides otherwise."""
    reference = raytrace.render(SCENES[scene], SIZE, backend="numpy", dtype="float64", output="steps")
    steps = raytrace.render(SCENES[scene], SIZE, backend=engine, output="steps", intersection="robust")
    assert list(steps) == list(reference)
    for name, step in steps.items():
        assert step.dtype == (np.int32 if name == "index" else np.float32)
        assert step.shape == reference[name].shape
        assert differing(step, reference[name]) <= 3, name
    for output in ("linear", "display"):
        image = raytrace.render(SCENES[scene], SIZE, backend=engine, output=output, intersection="robust")
        np.testing.assert_allclose(image, steps[output], rtol=0, atol=1e-5)


def test_textbook_is_the_formula_of_the_assignment(engine):
    """float32 cancels in b*b - c for a far sphere; the default in GLSL has that, as NumPy's textbook has."""
    far = replace(BASE, planes=(), spheres=raytrace.Spheres([[0, 0.5, -3000]], [1.0], [[1, 0, 0]]))
    camera = replace(BASE.camera, field_of_view=0.1)
    scene = replace(far, camera=camera, lighting="off")
    hits = {
        intersection: raytrace.render(scene, SIZE, backend=engine, intersection=intersection, output="steps")["index"]
        for intersection in ("textbook", "robust", None)
    }
    reference = raytrace.render(scene, SIZE, backend="numpy", dtype="float64", output="steps")["index"]
    wrong = {name: int((index != reference).sum()) for name, index in hits.items()}
    assert wrong["textbook"] == wrong[None] > 100 * max(wrong["robust"], 1)


def test_samples_are_averaged_in_linear_light(engine):
    for output in ("display", "linear"):
        image = raytrace.render("checkerboard", SIZE, backend=engine, samples=3, output=output)
        reference = raytrace.render("checkerboard", SIZE, backend="numpy", dtype="float64", samples=3, output=output)
        assert differing(image, reference, 1e-2) <= 10


def test_bands_are_rows_of_the_image(engine, monkeypatch):
    """Written in bands, and drawn in parts: the pixels of the whole, to a rounding of the interpolated coordinates."""
    whole = raytrace.render("checkerboard", SIZE, backend=engine)
    monkeypatch.setattr("raytrace.rendering.BAND", 7 * SIZE[0])
    monkeypatch.setattr("raytrace.backends.gpu.renderer.TESTS", 3 * SIZE[0] * (2 * 6 + 1 + 8))
    bands = list(Rendering(Options("checkerboard", SIZE, backend=engine)).bands())
    assert len(bands) == 13
    assert differing(np.concatenate(bands), whole, 5e-5) <= 2
    pixel = Rendering(Options("checkerboard", SIZE, backend=engine, output="steps")).pixel(80, 60)
    np.testing.assert_allclose(pixel["display"], whole[60, 80], rtol=1e-4)


@examples(8, 25)
@given(scene=scenes())
def test_random_scenes(scene):
    """Every scene that there may be compiles, and looks like NumPy's."""
    need("opengl")
    steps = raytrace.render(scene, (48, 27), backend="opengl", intersection="robust", output="steps")
    reference = raytrace.render(scene, (48, 27), backend="numpy", dtype="float64", output="steps")
    wrong = (steps["index"] != reference["index"]).sum()
    assert wrong <= 30
    same = steps["index"] == reference["index"]
    apart = np.abs(steps["display"] - reference["display"]).max(axis=-1) > 1e-2
    assert (apart & same).sum() <= 60


def test_metadata_names_the_real_renderer(engine):
    renderer = Rendering(Options("sphere", (4, 4), backend=engine)).metadata()["renderer"]
    assert ("OpenGL" in renderer) if engine == "opengl" else ("WebGL 2" in renderer and "Chromium" in renderer)


def program(body):
    fragment = f"#version 300 es\nprecision highp float;\nin vec2 fragmentTextureCoordinates;\nout vec4 c;\n{body}"
    return ShaderProgram(vertex_shader(), fragment)


def test_a_rejected_shader_says_where(engine):
    with pytest.raises(ShaderRejected, match=r"0:6\b"):
        engine_process(engine).active_uniforms(program("void main(){\nc = missing;\n}"))


def test_active_uniforms(engine):
    body = (
        "struct S{vec3 a; float b;}; uniform S s[2]; uniform float f[3]; uniform mat3 m; uniform int unused;\n"
        "void main(){c = vec4(s[1].a * m, f[2] + s[0].b);}"
    )
    found = {
        uniform.name: (uniform.type, uniform.length)
        for uniform in engine_process(engine).active_uniforms(program(body))
    }
    assert found["s[1].a"] == ("vec3", 1)
    assert found["f"] == ("float", 3)
    assert found["m"] == ("mat3", 1)
    assert "unused" not in found


def endless():
    """llvmpipe leaves a loop after 65,536 rounds, which take minutes on so many pixels."""
    loop = program("uniform int n; void main(){c = vec4(0); for(int i = 0; i != n; i += 0) c += sin(c + 1.);}")
    return Drawing(loop, 2048, 2048, 0, 2048, {"n": np.array(1, np.int32)})


@pytest.mark.full
def test_an_endless_shader_is_ended(engine):
    process = EngineProcess(engine)
    process.about()
    with pytest.raises(raytrace.EngineFailure, match=f"^backend {engine}: "):
        process.draw(endless(), limit=3.0)
    # And the next one starts anew.
    assert process.about()
    process.stop()


def test_a_crash_is_told(engine):
    process = EngineProcess(engine)
    process.about()
    threading.Timer(1, os.kill, (process._process.pid, signal.SIGSEGV)).start()
    with pytest.raises(raytrace.EngineFailure, match="the engine crashed"):
        process.draw(endless(), limit=60.0)


def test_too_large_an_image_is_refused(engine):
    with pytest.raises(raytrace.InputError, match=rf"^backend {engine}: draws at most \d+x\d+ pixels"):
        raytrace.render("sphere", (65536, 1), backend=engine)


@pytest.mark.parametrize("name", ["opengl", "webgl"])
def test_a_missing_engine_names_the_package(name, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.setenv("LD_LIBRARY_PATH", "")
    monkeypatch.setenv("PYTHONPATH", os.getcwd())
    with open("moderngl.py", "w") as module:
        module.write("def create_standalone_context(**options):\n    raise Exception('no libEGL')\n")
    process = EngineProcess(name)
    for _ in range(2):  # asked again, it says the same
        with pytest.raises(raytrace.InputError, match=f"^backend {name}: needs .*apt-get install ") as error:
            process.about()
    process.stop()
    assert {"opengl": "libegl1 libgl1-mesa-dri", "webgl": "chromium"}[name] in str(error.value)


def test_what_glsl_has_not(engine):
    mapper = replace(BASE, film=raytrace.Film(tone_mapper=lambda x: x))
    with pytest.raises(raytrace.InputError, match="Python function cannot be written in GLSL"):
        raytrace.render(mapper, SIZE, backend=engine)
    with pytest.raises(raytrace.InputError, match="planes: a GLSL shader holds 33"):
        raytrace.render(replace(BASE, planes=(raytrace.Plane(),) * 34), SIZE, backend=engine)
    with pytest.raises(raytrace.InputError, match="unknown 'float64'"):
        raytrace.render(BASE, SIZE, backend=engine, dtype="float64")
