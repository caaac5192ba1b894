"""Versions of GLSL, the texture coordinates that a shader asks for, and the vertex shader that gives them."""

import pytest

from raytrace.errors import InputError
from raytrace.glsl.dialects import VertexOutput, dialect_of, vertex_output, vertex_shader
from raytrace.glsl.source import ShaderSource


@pytest.mark.parametrize(
    ("directive", "version"),
    [
        ("300 es", "300 es"),
        ("100", "100"),
        ("120", "140"),
        ("330", "330"),
        ("330 core", "330"),
        ("450 compatibility", "450"),
        ("300", None),
        ("450 es", None),
        ("100 core", None),
        ("a", None),
    ],
)
def test_versions(directive, version):
    assert dialect_of(directive) == version


@pytest.mark.parametrize(
    ("code", "version"),
    [
        ("in vec2 uv; out vec4 c;", "300 es"),
        ("void mainImage(out vec4 c, in vec2 p){}", "300 es"),
        ("precision mediump float; varying vec2 uv;", "100"),
        ("void main(){ gl_FragColor = vec4(1.); }", "140"),
    ],
)
def test_a_shader_without_version_is_known_by_its_words(code, version):
    assert ShaderSource("a.frag", code).version == version


@pytest.mark.parametrize(
    ("code", "name", "qualifiers"),
    [
        ("", "fragmentTextureCoordinates", ""),
        ("in vec2 uv;", "uv", ""),
        ("varying highp vec2 vUv ;", "vUv", ""),
        ("layout(location = 0) in vec2 uv;", "uv", "layout(location = 0)"),
        ("layout ( location=3 ) noperspective in vec2 uv;", "uv", "layout ( location=3 ) noperspective"),
        ("#define GL\nprecision highp float; centroid in vec2 uv;", "uv", "centroid"),
        ("#ifdef OLD\nvarying vec2 uv;\n#else\nin vec2 uv;\n#endif", "uv", ""),
        ("float f(in vec2 a, in float b){ return b; }\nvoid g(\n in vec2 a);", "fragmentTextureCoordinates", ""),
        ("struct A{ float b; }; in vec2 c;", "c", ""),
    ],
)
def test_the_input_is_found(code, name, qualifiers):
    assert vertex_output("a.frag", code) == VertexOutput(name, qualifiers)
    assert f"out vec2 {name};" in vertex_shader("300 es", VertexOutput(name, qualifiers))


@pytest.mark.parametrize(
    ("code", "told"),
    [
        ("in vec3 uv;", "input 'vec3 uv'"),
        ("in vec2 uv[2];", "input 'vec2 uv[2]'"),
        ("in vec2 uv, b;", "input 'vec2 uv, vec2 b'"),
        ("in vec2 uv; in vec3 normal;", "input 'vec3 normal'"),
        ("in Data{ vec2 uv; } data;", "input 'Data {...}'"),
    ],
)
def test_other_inputs_are_refused(code, told):
    with pytest.raises(InputError) as error:
        vertex_output("a.frag", code)
    assert str(error.value).startswith(f"a.frag: {told}")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("#version 300\nvoid main(){}", "a.frag:1: '#version 300': is no version of GLSL"),
        ("\n  #  version 12 es\n", "a.frag:2: '#version 12 es': is no version"),
        ('#version 300 es\n\n#include "common.glsl"\n', "a.frag:3: #include: GLSL has none"),
        ("#version 430\nlayout(std430) buffer Data{ float x[]; };", "a.frag:2: buffer Data: a storage buffer"),
    ],
)
def test_what_no_compiler_would_say_so(text, told):
    with pytest.raises(InputError) as error:
        ShaderSource("a.frag", text).check()
    assert str(error.value).startswith(told)
    assert "\n" not in str(error.value)


def test_a_comment_is_no_include():
    ShaderSource("a.frag", '#version 300 es\n// #include "a"\n/*\n#include "b"\n*/\nvoid main(){}').check()
