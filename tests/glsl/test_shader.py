"""The emitted text itself; what it computes is tested with the engines."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import raytrace
from raytrace.glsl import fragment_shader
from raytrace.glsl.numbers import number, vector
from raytrace.scene.to_uniforms import program_of, uniforms_of

BASE = raytrace.load_scene("checkerboard")


def text(scene, **options):
    return fragment_shader(uniforms_of(scene, 16 / 9), program_of(scene, "textbook"), **options)


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_numbers_come_back_as_they_were(x):
    written = number(x)
    assert np.float32(written) == np.float32(x)
    assert re.fullmatch(r"-?\d+\.\d+|-?\d+(\.\d+)?e-?\d+", written)


def test_numbers_are_short():
    assert [number(x) for x in (0.1, 1, -0.5, 2400, 1e-12, 3e9, 1 / 3)] == [
        *("0.1", "1.0", "-0.5", "2400.0", "1e-12", "3e9", "0.33333334")
    ]
    assert vector([1, 1, 1]) == "vec3(1.0)"
    assert vector([1, 0.5, 1]) == "vec3(1.0, 0.5, 1.0)"


def printed():
    """The functions as the assignment prints them, but for the departures that the issue names."""
    return {
        "planeIntersect": "return dot(p-ro,n)/dot(rd,n);",
        "backgroundColor": "const float skyGradient = 1./4.;",
        "sphereIntersect": "if(t1 < 0.0) return t2; // Potentially inside",
        "closestSphereIntersect": "if(t < 0.0 || t > closestHit) continue; closestHit = bestT = t;",
        "shadowRay": "return 1.-step(0.0,tSphere); // 1 if tSphere < 0 else 0",
        "lightAtPoint": "float shadow = shadowRay(point + 1e-3*N, L);",
        "checkerboard": "return mix(vec3(1.),vec3(.1),mod(t.x+t.y,2.));",
        "tonemapAndGammaCorrect": "(x*(2.51*x+0.03))/(x*(2.43*x+0.59)+0.14)",
        "main": "vec3 rd = normalize(mat3(viewToWorld) * pixelViewSpace);",
    }


def test_the_assignments_functions_are_there_in_its_words():
    emitted = "".join(text(BASE).split())
    for name, line in printed().items():
        assert f"{name}(" in emitted
        assert "".join(line.split()) in emitted


def test_departures_are_marked():
    def departures(scene, **options):
        return re.findall(r"// Departure: ([^\n]*)", text(scene, **options))

    (brackets, infinity, bracket, unset) = departures(BASE)
    assert "lost the brackets" in brackets
    assert "1./0." in infinity
    assert "bracket too many" in bracket
    assert "unset" in unset
    assert any("no sphere" in line for line in departures(replace(BASE, spheres=raytrace.Spheres())))
    many = raytrace.Spheres(np.zeros((100, 3)), np.ones(100), np.ones((100, 3)))
    assert any(
        "more spheres than uniforms allow" in line for line in departures(replace(BASE, spheres=many), data="uniforms")
    )


@pytest.mark.parametrize("output", ["display", "steps"])
@pytest.mark.parametrize("exposure", [0.0, 1.0])
def test_light_is_at_least_0_after_white_balance(output, exposure):
    """A marked departure, only where a white point is given."""
    emitted = text(replace(BASE, film=raytrace.Film(exposure, 3000.0)), output=output)
    inner = "whiteBalance * (exposureFactor * col)" if exposure else "whiteBalance * col"
    assert f"tonemapAndGammaCorrect(max({inner}, 0.))" in emitted
    assert "// Departure: white balance makes components of saturated colors negative" in emitted
    without = text(replace(BASE, film=raytrace.Film(exposure)), output=output)
    assert "white balance makes" not in without
    assert ("tonemapAndGammaCorrect(exposureFactor * col)" if exposure else "tonemapAndGammaCorrect(col)") in without


def test_what_a_scene_lacks_is_not_in_its_text():
    bare = text(raytrace.Scene())
    for word in ("Sphere", "Plane", "lightAtPoint", "checkerboard", "infinity", "for("):
        assert word not in bare
    assert "shadowRay" not in text(replace(BASE, lighting="on"))
    assert "lightAtPoint" not in text(replace(BASE, lighting="off"))


def test_scene_data_as_constants_or_uniforms():
    constants, uniforms = text(BASE), text(BASE, data="uniforms")
    assert "const vec3 sunColor = vec3(1.64, 1.27, 0.99);" in constants
    assert "Sphere(vec3(-2.0, 1.5, -3.5), 1.5, vec3(0.8))," in constants
    assert set(re.findall(r"uniform \w+ (\w+)", constants)) == {"camPos", "ndcToView", "viewToWorld"}
    assert "uniform Sphere spheres[6];" in uniforms
    assert not re.search(r"const (Sphere|Plane|vec3) \w+ ?[=\[]", uniforms)
    brighter = replace(BASE, sun=raytrace.Sun(color=(2, 2, 2)))
    assert text(brighter, data="uniforms") == uniforms
    assert text(brighter) != constants


@pytest.mark.parametrize("line", ["void main(){", "out vec4 fragColor;", "#version 300 es"])
def test_samples_have_one_main(line):
    assert text(BASE, samples=2, size=(4, 4)).count(line) == 1
