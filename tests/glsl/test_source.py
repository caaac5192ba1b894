import pytest

from raytrace.errors import InputError
from raytrace.glsl.source import ShaderSource, read_shader


def source(text):
    return ShaderSource("a.frag", text)


@pytest.mark.parametrize(
    ("log", "told"),
    [
        ("0:2(5): error: `foo' undeclared\n0:3(1): error: more", "a.frag:2: `foo' undeclared: second (and 1 more)"),
        ("ERROR: 0:3: 'foo' : undeclared identifier\n", "a.frag:3: 'foo' : undeclared identifier: third"),
        ('0(1) : error C1503: undefined variable "foo"', 'a.frag:1: undefined variable "foo": #version 300 es'),
        ("GLSL Linker failed\n\nno main", "a.frag: GLSL Linker failed no main"),
        ("0:99(1): error: unexpected end of file", "a.frag:99: unexpected end of file"),
    ],
)
def test_a_compilers_log_in_one_line(log, told):
    assert source("#version 300 es\nsecond\n  third\n").explained(log) == told


def test_a_missing_version_moves_no_line():
    unversioned = source("first\nsecond")
    assert unversioned.version == "300 es"
    assert unversioned.fragment == "#version 300 es\nfirst\nsecond"
    assert unversioned.explained("0:3(1): error: wrong") == "a.frag:2: wrong: second"


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("in vec2 uv;", "uv"),
        ("// in vec3 no;\n/* in vec2 no; */ in highp vec2 uv;", "uv"),
        ("precision highp float; in vec2 uv; void f(in vec3 x){}", "uv"),
        ("layout(location = 0) in vec2 uv;", "uv"),
        ("void main(){}", "fragmentTextureCoordinates"),
    ],
)
def test_the_vertex_shader_gives_what_is_asked_for(text, name):
    assert f"out vec2 {name};" in source(f"#version 300 es\n{text}").vertex
    assert source(f"#version 330\n{text}").vertex.startswith("#version 330\n")


@pytest.mark.parametrize("text", ["in vec3 position;", "in vec2 a;\nin vec2 b;"])
def test_another_input_is_refused(text):
    with pytest.raises(InputError, match=r"^a\.frag: input 'vec"):
        _ = source(text).vertex


def test_what_cannot_be_read(tmp_path):
    (tmp_path / "binary.frag").write_bytes(b"\xff\xfe\x00")
    for path, told in [("nowhere.frag", "no such file"), ("binary.frag", "not a text in UTF-8"), (".", "is a dir")]:
        with pytest.raises(InputError, match=told):
            read_shader(tmp_path / path)
