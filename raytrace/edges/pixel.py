"""Pixels at points, or as means over their squares: which of them, a program says."""

from raytrace.edges.layers import mean_color
from raytrace.language.glsl import Vec2
from raytrace.language.jet import Jet
from raytrace.language.namespace import constant
from raytrace.language.types import Float
from raytrace.shader import pixel
from raytrace.shader.main import Steps
from raytrace.shader.pixel import Frame, mean_of_samples, sample_ndc
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["pixels"]


def pixels(
    uniforms: Uniforms, program: Program, column: Float, row: Float, frame: Frame, keep: tuple[str, ...]
) -> Steps:
    """Return the steps named in `keep` for the pixels (column, row); of several samples, their mean in linear light.

    With more than one sample, and with edges antialiased, only "linear" and "display" have a meaning.
    """
    if program.antialias == "none":
        return pixel.pixels(uniforms, program, column, row, frame, keep)

    def sample(offset, column, row):
        # A pixel is one thing there, and not the crossing of a column and a row.
        column, row = column + 0 * row, row + 0 * column
        return mean_color(uniforms, program, sample_ndc(square(offset), column, row, frame))

    return mean_of_samples(sample, uniforms, program, column, row, frame, keep)


def square(center: Vec2) -> Vec2:
    """Return the square around a sample, whose side is 1: its centre, and how that changes over it."""
    one, zero = constant(1, center.x), constant(0, center.x)
    return Vec2(Jet(center.x, one, zero), Jet(center.y, zero, one))
