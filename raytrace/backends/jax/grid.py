"""Many spheres in the cells of grids over the two coordinates of rays (`raytrace.backends.jax.culling`).

A sphere stands once, in the cell of its middle, in the finest grid whose cells are no smaller than half of it. So a
ray that can meet it is in that cell or beside it: three runs of neighbours in each grid. A sphere too large for the
coarsest grid is in none; those are few, and a block of rays asks each of them.

All of it is array code of shapes that depend on the number of spheres alone: other centres and radii, another camera or
sun compile nothing again.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp

from raytrace.backends.jax.culling import Beam, Bounds, Coordinates, Pencil, Region, outside

__all__ = ["LEVELS", "ROWS", "Grid", "grid", "runs"]

LEVELS = 5
#: Runs of neighbouring cells to look at in each level: the rows above, at and below.
ROWS = 3
#: How much larger than a cell a sphere's half may be, less this part of the finest cell; half of that for the rays' errors.
ROOM = 1 / 8


class Grid(NamedTuple):
    """The small spheres by cell, and the numbers of the large ones.

    order: (n,) indices of spheres: those in cells, cell by cell; those that no ray meets; the large ones.
    first: (cells + 1,) where in `order` each cell begins.
    small, large: how many are in cells or met by no ray; how many are large.
    u, v: lower corner; cell_u, cell_v: the finest cells' sizes.
    box: holds every small sphere.
    """

    order: jax.Array
    first: jax.Array
    small: jax.Array
    large: jax.Array
    u: jax.Array
    v: jax.Array
    cell_u: jax.Array
    cell_v: jax.Array
    box: Bounds


def _side(n: int) -> int:
    """Cells along each side of the finest grid: about four cells a sphere."""
    return min(2048, max(1 << LEVELS, 1 << (4 * n - 1).bit_length() // 2))


def _offset(side: int, level: int) -> int:
    return sum((side >> finer) ** 2 for finer in range(level))


def grid(rays: Pencil | Beam, bounds: Bounds) -> Grid:
    """The grid for spheres of these bounds."""
    n = bounds.u_low.shape[0]
    side = _side(n)
    dtype = bounds.u_low.dtype
    # A pencil's rays are those of pixels, in [-1, 1]; a little more, for the rounding of rays at the border.
    edge = 1.01 if isinstance(rays, Pencil) else jnp.inf
    unmet = outside(bounds, Region(-edge, edge, -edge, edge, -jnp.inf))
    middles = [(low + high) / 2 for low, high in ((bounds.u_low, bounds.u_high), (bounds.v_low, bounds.v_high))]
    halves = [(high - low) / 2 for low, high in ((bounds.u_low, bounds.u_high), (bounds.v_low, bounds.v_high))]
    finite = jnp.isfinite(middles[0] + middles[1] + halves[0] + halves[1])
    seen = finite & ~unmet
    (u, cell_u), (v, cell_v) = (
        _axis(middle, half, seen, side) for middle, half in zip(middles, halves, strict=True)
    )

    # The coarsest level that is needed by either axis, as the number of levels whose cells are too small.
    level = jnp.zeros(n, jnp.int32)
    for half, cell in zip(halves, (cell_u, cell_v), strict=True):
        level = jnp.maximum(level, sum(half + ROOM * cell > cell * 2**k for k in range(LEVELS)).astype(jnp.int32))
    large = ~unmet & (~finite | (level == LEVELS))
    key = jnp.zeros(n, jnp.int32)
    for k in range(LEVELS):
        here = _offset(side, k) + _cell(middles[1], v, cell_v, side, k) * (side >> k) + _cell(
            middles[0], u, cell_u, side, k
        )
        key = jnp.where(level == k, here, key)
    cells = _offset(side, LEVELS)
    key = jnp.where(large, cells + 1, jnp.where(unmet, cells, key))
    order = jnp.argsort(key, stable=True).astype(jnp.int32)
    counts = jnp.zeros(cells + 2, jnp.int32).at[key].add(1)
    first = jnp.concatenate([jnp.zeros(1, jnp.int32), jnp.cumsum(counts[:cells], dtype=jnp.int32)])
    small = ~large & ~unmet
    box = Bounds(
        *(jnp.min(jnp.where(small, x, jnp.inf)) if name.endswith("low") else jnp.max(jnp.where(small, x, -jnp.inf))
          for name, x in bounds._asdict().items())
    )
    number = jnp.sum(large, dtype=jnp.int32)
    return Grid(order, first, n - number, number, u, v, cell_u.astype(dtype), cell_v.astype(dtype), box)


def _axis(middle: jax.Array, half: jax.Array, seen: jax.Array, side: int) -> tuple[jax.Array, jax.Array]:
    """Lower end and cell size along an axis: most of the middles, whatever a few far ones do.

    What lies beyond is in the border's cells; that moves no two things farther apart.
    """
    count = jnp.maximum(jnp.sum(seen), 1)

    def mean(x: jax.Array) -> jax.Array:
        return jnp.sum(jnp.where(seen, x, 0)) / count

    center = mean(middle)
    spread = 2.5 * jnp.sqrt(mean((middle - center) ** 2))
    low = jnp.maximum(jnp.min(jnp.where(seen, middle, jnp.inf)), center - spread)
    high = jnp.minimum(jnp.max(jnp.where(seen, middle, -jnp.inf)), center + spread)
    cell = jnp.maximum((high - low) / side, mean(half) / 2)
    ordinary = jnp.isfinite(low) & jnp.isfinite(cell) & (cell > 0)
    return jnp.where(ordinary, low, 0), jnp.where(ordinary, cell, 1)


def _cell(x: jax.Array, low: jax.Array, cell: jax.Array, side: int, level: int) -> jax.Array:
    return jnp.clip(jnp.floor((x - low) / (cell * 2**level)), 0, (side >> level) - 1).astype(jnp.int32)


def runs(
    grid: Grid, where: Coordinates, among: jax.Array, everything: jax.Array, n: int
) -> list[tuple[jax.Array, jax.Array]]:
    """For each ray, LEVELS * ROWS runs of `order` (first, end) that hold all small spheres that it can meet.

    Of a ray that is not `among` the others they are empty. With `everything`, or where a ray's coordinates err by too
    much for cells of that size, the first run is all that are small.
    """
    side = _side(n)
    box, error = grid.box, where.error
    near = among & ~(
        (where.u + error < box.u_low)
        | (where.u - error > box.u_high)
        | (where.v + error < box.v_low)
        | (where.v - error > box.v_high)
        | (where.w - where.w_error > box.w_high)
    )
    sharp = error <= jnp.minimum(grid.cell_u, grid.cell_v) * (ROOM / 2)
    scanned = everything | jnp.any(near & ~sharp)
    found = []
    for level in range(LEVELS):
        width = side >> level
        column = _cell(where.u, grid.u, grid.cell_u, side, level)
        row = _cell(where.v, grid.v, grid.cell_v, side, level)
        for step in range(ROWS):
            beside = row + (step - 1)
            there = near & (beside >= 0) & (beside < width)
            start = _offset(side, level) + jnp.clip(beside, 0, width - 1) * width
            begin = grid.first[start + jnp.maximum(column - 1, 0)]
            end = grid.first[start + jnp.minimum(column + 1, width - 1) + 1]
            whole = grid.small if not found else 0
            found.append(
                (jnp.where(there & ~scanned, begin, 0), jnp.where(scanned, whole, jnp.where(there, end, 0)))
            )
    return found
