"""From pixels to the image: where the samples of a pixel lie, and their mean."""

from collections.abc import Callable
from typing import NamedTuple

from raytrace.language.control import Numbers, each
from raytrace.language.glsl import Vec2, Vec3
from raytrace.language.namespace import constant
from raytrace.language.types import Float
from raytrace.shader.camera import pixel_to_ndc
from raytrace.shader.film import develop
from raytrace.shader.main import Steps, main
from raytrace.shader.sampling import sample_offset
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["Frame", "mean_of_samples", "pixels", "sample_ndc", "texture_coordinates"]


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

    With more than one sample only "linear" and "display" have a meaning.
    """

    def sample(offset, column, row):
        return main(uniforms, program, sample_ndc(offset, column, row, frame), ("linear",)).linear

    if frame.samples == 1:
        center = Vec2(constant(0.5, column), constant(0.5, column))
        return main(uniforms, program, sample_ndc(center, column, row, frame), keep)
    return mean_of_samples(sample, uniforms, program, column, row, frame, keep)


def sample_ndc(offset: Vec2, column: Float, row: Float, frame: Frame) -> Vec2:
    """Normalized device coordinates of the sample at `offset`, counted in samples, of the pixel."""
    uv = texture_coordinates(column, row, offset, frame)
    return pixel_to_ndc(uv.x, uv.y)


def mean_of_samples(
    sample: Callable[[Vec2, Float, Float], Vec3],
    uniforms: Uniforms,
    program: Program,
    column: Float,
    row: Float,
    frame: Frame,
    keep: tuple[str, ...],
) -> Steps:
    """The mean of the samples' linear colours, and its display values, as `keep` says.

    sample: gives the linear colour at an offset, counted in samples, of the pixel (column, row).
    """

    def add(total, _, number, column, row):
        return total + sample(sample_offset(number, frame.samples, column), column, row)

    if frame.samples == 1:
        linear = sample(Vec2(constant(0.5, column), constant(0.5, column)), column, row)
    else:
        zero = constant(0, column)
        total = each(Numbers(frame.samples**2), add, Vec3(zero, zero, zero), column, row, unroll=False)
        linear = total / frame.samples**2
    display = develop(linear, uniforms.film, program) if "display" in keep else None
    return Steps(linear=linear, display=display).only(keep)
