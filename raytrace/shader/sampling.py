"""Where the samples of a square lie."""

from raytrace.language.glsl import Vec2
from raytrace.language.namespace import namespace
from raytrace.language.types import Float

__all__ = ["sample_grid"]


def sample_grid(n: int, like: Float) -> Vec2:
    """The centres of an n x n grid, counted in samples: two arrays of shape (n * n,)."""
    xp = namespace(like)
    centers = [k + 0.5 for k in range(n)]
    x = xp.asarray(centers * n, dtype=like.dtype)
    y = xp.asarray([center for center in centers for _ in range(n)], dtype=like.dtype)
    return Vec2(x, y)
