"""The ground's pattern (assignment, 'Procedural Pattern')."""

from raytrace.language.control import step
from raytrace.language.glsl import Vec3, floor, isfinite, mix, mod, select
from raytrace.language.types import Float

__all__ = ["checkerboard"]


@step
def checkerboard(point: Vec3, tile_size: Float, even: Vec3, odd: Vec3, line: Vec3) -> Vec3:
    """The colour of the checkerboard in the plane of world x and z, with a middle line on each axis.

    The pattern looks at x and z whatever the plane's normal is, as printed.
    """
    t = floor(point.xz / tile_size + 0.5)
    # Floats are even from 2**24 (float32) on, so is a coordinate too large for the arithmetic.
    tile = t.x + t.y
    parity = select(isfinite(tile), mod(tile, 2), 0)
    middle_line = (t.x == 0) | (t.y == 0)
    return select(middle_line, line, mix(even, odd, parity))
