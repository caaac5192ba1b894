"""From pixels to the image: where the samples of a pixel lie, and their mean."""

from typing import NamedTuple

from raytrace.shader.camera import pixel_to_ndc
from raytrace.shader.control import each
from raytrace.shader.film import develop
from raytrace.shader.glsl import Vec2, Vec3
from raytrace.shader.jet import Jet
from raytrace.shader.layers import mean_color
from raytrace.shader.main import Steps, main
from raytrace.shader.namespace import constant
from raytrace.shader.sampling import sample_grid
from raytrace.shader.types import Float
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["Frame", "pixels"]


class Frame(NamedTuple):
    """The image as a grid: `width` x `height` pixels of `samples` x `samples` samples each."""

    width: int
    height: int
    samples: int = 1


def texture_coordinates(column: Float, row: Float, offset: Vec2, frame: Frame) -> Vec2:
    """(u, v) in [0, 1] of the sample at `offset`, counted in samples, of the pixel; row 0 is on top.

    With one sample: u = (column + 1/2) / width, v = 1 - (row + 1/2) / height.
    """
    n = frame.samples
    u = (n * column + offset.x) / (n * frame.width)
    v = 1 - (n * row + offset.y) / (n * frame.height)
    return Vec2(u, v)


def pixels(
    uniforms: Uniforms, program: Program, column: Float, row: Float, frame: Frame, keep: tuple[str, ...]
) -> Steps:
    """The steps named in `keep` for the pixels (column, row); of several samples, their mean in linear light.

    With more than one sample, and with edges antialiased, only "linear" and "display" have a meaning.
    """

    def ndc(offset, column, row):
        uv = texture_coordinates(column, row, offset, frame)
        return pixel_to_ndc(uv.x, uv.y)

    def sample(offset, column, row):
        if program.antialias == "edges":
            # A pixel is one thing there, and not the crossing of a column and a row.
            column, row = column + 0 * row, row + 0 * column
            return mean_color(uniforms, program, ndc(square(offset), column, row))
        return main(uniforms, program, ndc(offset, column, row), ("linear",)).linear

    def add(total, _, offset, column, row):
        return total + sample(offset, column, row)

    if frame.samples == 1:
        center = Vec2(constant(0.5, column), constant(0.5, column))
        if program.antialias == "none":
            return main(uniforms, program, ndc(center, column, row), keep)
        linear = sample(center, column, row)
    else:
        zero = constant(0, column)
        total = each(sample_grid(frame.samples, column), add, Vec3(zero, zero, zero), column, row, unroll=False)
        linear = total / frame.samples**2
    display = develop(linear, uniforms.film, program) if "display" in keep else None
    return Steps(linear=linear, display=display).only(keep)


def square(center: Vec2) -> Vec2:
    """The square around a sample, whose side is 1: its centre, and how that changes over it."""
    one, zero = constant(1, center.x), constant(0, center.x)
    return Vec2(Jet(center.x, one, zero), Jet(center.y, zero, one))
