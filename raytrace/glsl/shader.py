"""The whole fragment shader."""

from typing import Any

from raytrace.glsl.choices import Choices, choices_of
from raytrace.glsl.declarations import declarations
from raytrace.glsl.functions import functions
from raytrace.glsl.main import main_function, step_function
from raytrace.glsl.values import values_of
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["fragment_shader", "shader_text"]


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
