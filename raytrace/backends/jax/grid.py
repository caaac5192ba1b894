"""Many spheres in the cells of grids over the two coordinates of rays (`raytrace.backends.culling`).

There are grids of several cell sizes, and a sphere is in the finest one whose rows are no lower than half of it. It is
in each row that it touches, three at most, at the column of its middle. A ray looks in its own row at a run of columns
as wide as the grid's largest spheres. A sphere that is too large for the coarsest grid is in none; those are few, and
a block of rays asks each of them.

All of it is array code of shapes that depend on the number of spheres alone: other centres and radii, another camera or
sun compile nothing again.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp

from raytrace.backends.culling import EDGE, Beam, Coordinates, Extent, Pencil, Region, outside
from raytrace.backends.jax.engines import any_of

__all__ = ["Candidates", "Grid", "candidates", "grid"]

LEVELS = 5
#: Rows that a sphere may touch.
ROWS = 3
#: Columns are finer than rows: a run of many costs no more than one of few.
FINE = 4
#: A sphere and what its coordinates and a ray's may err by fit into a row; this part of it is for the ray's.
ROOM = 1 / 16


class Grid(NamedTuple):
    """The small spheres by cell, and the numbers of the large ones.

    order: (ROWS * n,) indices of spheres: those in cells, cell by cell; those that no ray meets; the large ones.
    first: (cells + 1,) where in `order` each cell begins.
    small, large: how many entries are in cells or met by no ray; how many are large.
    u, v: lower corner; cell_u, cell_v: the finest grid's row height, and the width of FINE of its columns.
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
    box: Extent


class Candidates(NamedTuple):
    """For each ray `total` places in a grid's `order` that hold all small spheres that it can meet; planes."""

    #: Number k is at ``k + shifts[level]`` for the last level for which ``starts[level] <= k``.
    starts: tuple[jax.Array, ...]
    shifts: tuple[jax.Array, ...]
    total: jax.Array

    def place(self, k: jax.Array) -> jax.Array:
        """Where number k is, for each ray; 0 where there are not so many."""
        shift = self.shifts[0]
        for start, other in zip(self.starts[1:], self.shifts[1:], strict=True):
            shift = jnp.where(start <= k, other, shift)
        return jnp.where(k < self.total, k + shift, 0)


def _side(n: int) -> int:
    """Rows of the finest grid: about one sphere for each square of it."""
    return min(2048, max(1 << LEVELS, 1 << ((n - 1).bit_length() + 1) // 2))


def _offset(side: int, level: int) -> int:
    return sum(FINE * (side >> finer) ** 2 for finer in range(level))


def _row(x: jax.Array, low: jax.Array, cell: jax.Array, rows: int) -> jax.Array:
    # It grows with x, rounding or not: what lies between two things is in a cell between theirs.
    return jnp.clip(jnp.floor((x - low) / cell), 0, rows - 1).astype(jnp.int32)


def grid(rays: Pencil | Beam, bounds: Extent) -> Grid:
    """The grid for spheres of these bounds."""
    n = bounds.u_low.shape[0]
    side = _side(n)
    edge, start = ((1 + EDGE) / 2, 0.0) if isinstance(rays, Pencil) else (jnp.inf, -jnp.inf)
    unmet = outside(bounds, Region(-edge, edge, -edge, edge, start))
    u, half_u = (bounds.u_low + bounds.u_high) / 2, (bounds.u_high - bounds.u_low) / 2
    v, half_v = (bounds.v_low + bounds.v_high) / 2, (bounds.v_high - bounds.v_low) / 2
    finite = jnp.isfinite(u + v + half_u + half_v)
    low_u, cell_u = _axis(u, half_u, finite & ~unmet, side)
    low_v, cell_v = _axis(v, half_v, finite & ~unmet, side)

    # The level is the number of grids whose cells are too small.
    level = jnp.zeros(n, jnp.int32)
    for half, cell in ((half_u, cell_u), (half_v, cell_v)):
        level = jnp.maximum(level, sum((half + 2 * ROOM * cell > cell * 2**k).astype(jnp.int32) for k in range(LEVELS)))
    large = ~unmet & (~finite | (level == LEVELS))
    cells = _offset(side, LEVELS)
    keys = [jnp.full(n, cells + 2, jnp.int32)] * ROWS
    for k in range(LEVELS):
        rows, width, height = side >> k, cell_u * 2**k / FINE, cell_v * 2**k
        column = _row(u, low_u, width, FINE * rows)
        margin = half_v + ROOM * cell_v
        lowest, highest = (_row(x, low_v, height, rows) for x in (v - margin, v + margin))
        for r in range(ROWS):
            here = _offset(side, k) + (lowest + r) * (FINE * rows) + column
            keys[r] = jnp.where((level == k) & (lowest + r <= highest), here, keys[r])
    # Those that are in no cell stand once.
    for r in range(ROWS):
        keys[r] = jnp.where(large | unmet, jnp.where(large, cells + 1, cells) if r == 0 else cells + 2, keys[r])
    key = jnp.concatenate(keys)
    numbers = jnp.concatenate([jnp.arange(n, dtype=jnp.int32)] * ROWS)
    _, order = jax.lax.sort((key, numbers), num_keys=1)
    counts = jnp.zeros(cells + 3, jnp.int32).at[key].add(1)
    ends = jnp.cumsum(counts, dtype=jnp.int32)
    small = ~large & ~unmet
    box = Extent(
        *(
            jnp.min(jnp.where(small, x, jnp.inf)) if name.endswith("low") else jnp.max(jnp.where(small, x, -jnp.inf))
            for name, x in bounds._asdict().items()
        )
    )
    first = jnp.concatenate([jnp.zeros(1, jnp.int32), ends[:cells]])
    return Grid(order, first, ends[cells], counts[cells + 1], low_u, low_v, cell_u, cell_v, box)


def _axis(middle: jax.Array, half: jax.Array, seen: jax.Array, side: int) -> tuple[jax.Array, jax.Array]:
    """Return the lower end and the cell size along an axis: most of the middles, whatever a few far ones do.

    What lies beyond is in the border's cells; that moves no two things farther apart.
    """

    def mean(x: jax.Array, among: jax.Array) -> jax.Array:
        return jnp.sum(jnp.where(among, x, 0)) / jnp.maximum(jnp.sum(among), 1)

    # The geometric mean: in a wide field a few near ones are a thousand times as large as most.
    usual = jnp.exp2(mean(jnp.log2(jnp.maximum(half, jnp.finfo(half.dtype).tiny)), seen))
    seen = seen & (half < usual * 2**LEVELS)
    center = mean(middle, seen)
    spread = 2.5 * jnp.sqrt(mean((middle - center) ** 2, seen))
    low = jnp.maximum(jnp.min(jnp.where(seen, middle, jnp.inf)), center - spread)
    high = jnp.minimum(jnp.max(jnp.where(seen, middle, -jnp.inf)), center + spread)
    cell = jnp.maximum((high - low) / side, usual / 2)
    ordinary = jnp.isfinite(low) & jnp.isfinite(cell) & (cell > 0)
    return jnp.where(ordinary, low, 0), jnp.where(ordinary, cell, 1)


def candidates(grid: Grid, where: Coordinates, among: jax.Array, everything: jax.Array, n: int) -> Candidates:
    """What rays at these coordinates have to be asked about, of the small ones among `n` spheres.

    Rays that are not `among` the others have none. With `everything`, or where a ray's coordinates err by too much for
    cells of that size, each ray has all that are small.
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
    sharp = error <= jnp.minimum(grid.cell_u, grid.cell_v) * ROOM
    scanned = everything | any_of(near & ~sharp)
    looked_up = near & ~scanned
    total = jnp.where(scanned, grid.small, jnp.zeros(among.shape, jnp.int32))
    starts, shifts = [], []
    for level in range(LEVELS):
        rows, width, height = side >> level, grid.cell_u * 2**level / FINE, grid.cell_v * 2**level
        reach = grid.cell_u * 2**level
        columns = FINE * rows
        row = _offset(side, level) + _row(where.v, grid.v, height, rows) * columns
        begin = grid.first[row + _row(where.u - reach, grid.u, width, columns)]
        end = grid.first[row + _row(where.u + reach, grid.u, width, columns) + 1]
        starts.append(total)
        shifts.append(jnp.where(looked_up, begin - total, 0))
        total = total + jnp.where(looked_up, end - begin, 0)
    # Scanned rays find everything in the first run.
    starts[1:] = [jnp.where(scanned, total + 1, start) for start in starts[1:]]
    return Candidates(tuple(starts), tuple(shifts), total)
