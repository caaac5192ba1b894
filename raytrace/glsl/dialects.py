"""The versions of GLSL that a fragment shader may be written in, and the vertex shader that goes with each."""

import re
from typing import NamedTuple

from raytrace.errors import InputError

__all__ = ["USUAL", "VertexOutput", "dialect_of", "implied_dialect", "vertex_output", "vertex_shader"]

#: What a shader without ``#version`` is taken for, unless its words are older.
USUAL = "300 es"
_ES = ("100", "300 es", "310 es", "320 es")
_DESKTOP = (*("110", "120", "130", "140", "150", "330"), *(f"4{minor}0" for minor in range(7)))
#: Core profiles have no GLSL 1.10 and 1.20; in 1.40 their words are still there.
_OLDEST_DESKTOP = {"110": "140", "120": "140"}
_OLD_WORDS = re.compile(r"\b(?:varying|attribute|gl_FragColor|gl_FragData|texture2D)\b")

_INPUT = re.compile(
    r"(?:^|(?<=[;}]))\s*"
    r"((?:layout\s*\([^)]{0,200}\)\s*|(?:smooth|flat|centroid|noperspective|invariant|lowp|mediump|highp)\s+)*)"
    r"(?:in|varying)\s+(?:(?:lowp|mediump|highp)\s+)?(\w+)\s*([^;(){}]*)([;{])"
)
#: What the vertex shader's output must say as the input does.
_SHARED = re.compile(r"layout\s*\([^)]*\)|\b(?:smooth|flat|centroid|noperspective)\b")


class VertexOutput(NamedTuple):
    """The texture coordinates, as the fragment shader takes them: their name, and words such as ``flat``."""

    name: str = "fragmentTextureCoordinates"
    qualifiers: str = ""


def dialect_of(directive: str) -> str | None:
    """Return the version to compile with, for what stands behind ``#version``; ``None`` if there is no such version.

    The profile is left out: a context has the one that it has.
    """
    words = directive.split()
    if len(words) == 2 and words[1] in ("core", "compatibility") and words[0] in _DESKTOP:
        words = words[:1]
    version = " ".join(words)
    return _OLDEST_DESKTOP.get(version, version) if version in (*_ES, *_DESKTOP) else None


def implied_dialect(code: str) -> str:
    """Return the version of a shader without ``#version``, by its words; `code` has no comments.

    That would be GLSL ES 1.00 in a browser and GLSL 1.10 elsewhere, which knows no default precision.
    """
    if not _OLD_WORDS.search(code):
        return USUAL
    return "100" if re.search(r"\bprecision\b", code) else _OLDEST_DESKTOP["110"]


def vertex_output(name: str, code: str) -> VertexOutput:
    """Return the texture coordinates under the name that a fragment shader asks for.

    name: the shader's, for messages. code: its text without comments.

    Raises:
        InputError: it asks for another input.
    """
    code = "\n".join(line for line in code.split("\n") if not line.lstrip().startswith("#"))
    inputs: dict[str, VertexOutput] = {}
    for qualifiers, kind, names, end in _INPUT.findall(code):
        if end == "{":
            inputs[f"{kind} {{...}}"] = VertexOutput()
            continue
        for each in names.split(","):
            shared = " ".join(found[0] for found in _SHARED.finditer(qualifiers))
            # The same input may stand in both branches of an #if.
            inputs.setdefault(f"{kind} {each.strip()}", VertexOutput(each.strip(), shared))
    wrong = [found for found in inputs if not re.fullmatch(r"vec2 \w+", found)]
    if wrong or len(inputs) > 1:
        raise InputError(
            f"{name}: input '{wrong[0] if wrong else ', '.join(inputs)}': a shader is given one input, "
            "the texture coordinates as 'in vec2 fragmentTextureCoordinates'"
        )
    return next(iter(inputs.values()), VertexOutput())


def vertex_shader(version: str = USUAL, output: VertexOutput = VertexOutput()) -> str:  # noqa: B008 (a constant)
    """Return the vertex shader of a quad over the whole viewport: two triangles, as a strip of four vertices.

    GLSL ES 1.00 does not number the vertices: there the attribute ``corner`` is (0, 0), (1, 0), (0, 1) and (1, 1).
    """
    coordinates = output.name
    if version == "100":
        head = f"attribute vec2 corner;\n{output.qualifiers}varying vec2 {coordinates};"
        corner = "corner"
    else:
        head = f"{output.qualifiers} out vec2 {coordinates};".lstrip()
        corner = "vec2(gl_VertexID & 1, gl_VertexID >> 1)"
    return f"""\
#version {version}
{head}

void main(){{
    {coordinates} = {corner};
    gl_Position = vec4(2.*{coordinates} - 1., 0., 1.);
}}
"""
