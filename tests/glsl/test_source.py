"""The text of a user's shader: its version, its comments, in time that grows with its length."""

import time
from contextlib import suppress

import pytest

from raytrace.errors import InputError
from raytrace.glsl.source import ShaderSource, without_comments
from raytrace.glsl.turns import loops

BODY = "precision highp float;\nin vec2 uv;\nout vec4 color;\nvoid main(){ color = vec4(uv, 0., 1.); }\n"


@pytest.mark.parametrize(
    ("head", "version"),
    [
        ("#version 300 es\n", "300 es"),
        ("#version 300 es // the browser's\n", "300 es"),
        ("#version  300   es\n", "300 es"),
        ("\n\n#version 300 es\n", "300 es"),
        ("/* mine\n*/ # version 450\n", "450"),
        ("// #version 450\n#version 300 es\n", "300 es"),
        ("/* #version 450 */\n", "300 es"),
        ("", "300 es"),
    ],
)
def test_the_version_is_found_and_comes_first(head, version):
    source = ShaderSource("a.frag", head + BODY)
    assert source.version == version
    assert source.fragment.startswith(f"#version {version}\n")
    assert source.fragment.endswith(BODY)
    assert without_comments(source.fragment).count("version") == 1
    assert "in vec2 position" in source.vertex or "uv" in source.vertex


def test_the_students_line_is_that_of_the_file():
    """Lines before the directive stay, empty, behind the one that is compiled first."""
    source = ShaderSource("a.frag", "\n// mine\n#version 300 es\nint x = 1.;\n")
    assert source.fragment.split("\n")[4] == "int x = 1.;"
    assert source.explained("0:5(9): error: no") == "a.frag:4: no: int x = 1.;"


def test_what_stands_before_the_directive_is_the_compilers_to_refuse():
    text = "int x;\n#version 300 es\n"
    assert ShaderSource("a.frag", text).fragment == text


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("a // b\nc", "a  \nc"),
        ("a /* b\n\n*/ c", "a  \n\n c"),
        ("a / b /* c", "a / b  "),
        ("a //", "a  "),
        ("// /* \n b */", " \n b */"),
    ],
)
def test_comments_leave_their_line_breaks(text, code):
    assert without_comments(text) == code


@pytest.mark.parametrize(
    "text",
    [
        *("#version a" + " \t" * 12_000 + "x", "/*" * 50_000, "/" * 100_000, "\n#" * 50_000, "#version" * 20_000),
        *("layout(" * 20_000, "uniform " * 20_000, ";in " * 20_000, "uniform a{" * 20_000, ";highp " * 20_000),
        *("highp " * 20_000, "uniform a{}" * 20_000, "for(" * 20_000, ";in a," + "b," * 20_000, "in" + " " * 50_000),
    ],
    ids=lambda text: text[:12],
)
def test_no_text_takes_long(text):
    """A square of the length would be minutes, its multiples milliseconds."""
    source, begun = ShaderSource("a.frag", text), time.process_time()
    assert source.version
    assert source.fragment
    assert len(source.declared) <= 20_000
    loops(source.fragment_code)
    with suppress(InputError):
        source.check()
    assert time.process_time() - begun < 2
