"""Pixels at points, or as means over their squares: which of them, a program says."""

from raytrace.edges.layers import camera_ray, mean_color
from raytrace.edges.squares import cuts
from raytrace.language.control import detach, summed
from raytrace.language.glsl import Vec2, Vec3, select
from raytrace.language.jet import Jet, values
from raytrace.language.namespace import constant
from raytrace.language.tree import tree_map
from raytrace.language.types import Float
from raytrace.shader import pixel
from raytrace.shader.main import Steps, main
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
        return mean_of_square(uniforms, program, sample_ndc(square(offset), column, row, frame))

    return mean_of_samples(sample, uniforms, program, column, row, frame, keep)


def mean_of_square(uniforms: Uniforms, program: Program, ndc: Vec2) -> Vec3:
    """Return the mean of the linear image over the squares around `ndc`, of jets.

    Where no edge runs through a square that is its middle's colour; others are cut into smaller ones.
    """
    fields = ("t", "index", "hitPoint", "N", "linear")
    seen = main(uniforms, program, values(ndc), fields)
    # How a pixel is cut has no derivative.
    fixed, (ro, rd), middle = tree_map(detach, (uniforms, camera_ray(uniforms, program, ndc), seen))
    cut = cuts(fixed, program, ro, rd, middle)

    def part(k, cut, ndc):
        place, size = cut.square(k)
        moved = (x + (x.dx * place.x + x.dy * place.y) for x in ndc)
        smaller = Vec2(*(Jet(x.value, x.dx * size.x, x.dy * size.y) for x in moved))
        return mean_color(uniforms, program, smaller) * (size.x * size.y)

    zero = constant(0, ndc.x.value)
    color = select(cut.rows > 0, Vec3(zero, zero, zero), seen.linear)
    return summed(cut.columns * cut.rows, part, color, cut, ndc)


def square(center: Vec2) -> Vec2:
    """Return the square around a sample, whose side is 1: its centre, and how that changes over it."""
    one, zero = constant(1, center.x), constant(0, center.x)
    return Vec2(Jet(center.x, one, zero), Jet(center.y, zero, one))
