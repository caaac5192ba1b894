"""From pixels to the image: where the samples of a pixel lie, and their mean."""

from typing import NamedTuple

from raytrace.shader.camera import pixel_to_ndc
from raytrace.shader.control import each
from raytrace.shader.film import develop
from raytrace.shader.glsl import Vec2, Vec3
from raytrace.shader.main import Steps, main
from raytrace.shader.namespace import constant, namespace
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

    With more than one sample only "linear" and "display" have a meaning.
    """

    def sample(offset, column, row, keep):
        uv = texture_coordinates(column, row, offset, frame)
        return main(uniforms, program, pixel_to_ndc(uv.x, uv.y), keep)

    if frame.samples == 1:
        return sample(Vec2(0.5, 0.5), column, row, keep)

    def add(total, _, offset, column, row):
        return total + sample(offset, column, row, ("linear",)).linear

    zero = constant(0, column)
    total = each(sample_grid(frame.samples, column), add, Vec3(zero, zero, zero), column, row, unroll=False)
    linear = total / frame.samples**2
    display = develop(linear, uniforms.film, program) if "display" in keep else None
    return Steps(linear=linear, display=display).only(keep)


def sample_grid(n: int, like: Float) -> Vec2:
    """The centres of an n x n grid, counted in samples: two arrays of shape (n * n,)."""
    xp = namespace(like)
    centers = [k + 0.5 for k in range(n)]
    x = xp.asarray(centers * n, dtype=like.dtype)
    y = xp.asarray([center for center in centers for _ in range(n)], dtype=like.dtype)
    return Vec2(x, y)
