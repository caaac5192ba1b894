"""Where the samples of a square lie."""

from raytrace.language.glsl import Vec2, floor
from raytrace.language.namespace import constant, namespace
from raytrace.language.types import Float, Int

__all__ = ["sample_grid", "sample_offset"]


def sample_grid(n: int, like: Float) -> Vec2:
    """The centres of an n x n grid, counted in samples: two arrays of shape (n * n,)."""
    xp = namespace(like)
    centers = [k + 0.5 for k in range(n)]
    x = xp.asarray(centers * n, dtype=like.dtype)
    y = xp.asarray([center for center in centers for _ in range(n)], dtype=like.dtype)
    return Vec2(x, y)


def sample_offset(i: Int, n: int, like: Float) -> Vec2:
    """Return the centre of number `i` of an n x n grid, counted in samples: the same as `sample_grid` at `i`."""
    number = constant(i, like)
    # No quotient is near a whole number, so rounding does not matter.
    row = floor((number + 0.5) / n)
    return Vec2(number - n * row + 0.5, row + 0.5)
