"""The whole fragment shader, and the vertex shader in front of it."""

from typing import Any

from raytrace.glsl.choices import Choices, choices_of
from raytrace.glsl.declarations import declarations
from raytrace.glsl.functions import functions
from raytrace.glsl.main import main_function, step_function
from raytrace.glsl.values import values_of
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["fragment_shader", "vertex_shader"]


def fragment_shader(uniforms: Uniforms, program: Program, **options: Any) -> str:
    """The assignment's fragment shader for a scene, GLSL ES 3.00; `options` are those of `choices_of`."""
    choices = choices_of(uniforms, program, **options)
    return shader_text(choices, values_of(uniforms))


def shader_text(choices: Choices, values: dict[str, Any]) -> str:
    """The fragment shader's text; it depends on `values` only where the data are constants."""
    paragraphs = [*declarations(choices, values), *functions(choices)]
    if choices.output == "steps":
        paragraphs.append(step_function())
    paragraphs.append(main_function(choices))
    return "\n".join(["#version 300 es", *paragraphs])


def vertex_shader(version: str = "300 es", coordinates: str = "fragmentTextureCoordinates") -> str:
    """A quad over the whole viewport, two triangles as a strip of four vertices without buffers.

    coordinates: the name under which the fragment shader is given its texture coordinates, from 0 to 1.
    """
    return f"""\
#version {version}
out vec2 {coordinates};

void main(){{
    {coordinates} = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(2.*{coordinates} - 1., 0., 1.);
}}
"""
