"""A part of a picture in tiles: each is drawn by itself, then all are put together."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from raytrace.backends.jax.packing import Parts
from raytrace.backends.jax.traced import traced

__all__ = ["Tiles"]

#: One tile's images by name: arrays (height, width, components).
Images = dict[str, jax.Array]


class Tiles(NamedTuple):
    """A picture of `height` x `width` pixels, cut into `down` x `across` tiles of `tile_height` x `tile_width`.

    The tiles of the last row and column may stand over the picture's edge.
    """

    height: int
    width: int
    tile_height: int
    tile_width: int

    @classmethod
    def of(cls, height: int, width: int, pixels: int | None) -> "Tiles":
        """Tiles of about that many pixels, as equal as can be, twice as wide as high; ``None`` for a single one."""
        if pixels is None:
            return cls(height, width, height, width)
        across = -(-width // max(1, round((2 * pixels) ** 0.5)))
        tile_width = -(-width // across)
        down = -(-height // max(1, pixels // tile_width))
        return cls(height, width, -(-height // down), tile_width)

    @property
    def down(self) -> int:
        return -(-self.height // self.tile_height)

    @property
    def across(self) -> int:
        return -(-self.width // self.tile_width)

    def _corner(self, i: jax.Array) -> tuple[jax.Array, jax.Array]:
        return i // self.across * self.tile_height, i % self.across * self.tile_width

    def pixels(self, row: jax.Array, column: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Row and column of every pixel of the tile at that corner, one after the other."""
        # Constants, as counting them out costs divisions.
        within = np.arange(self.tile_height * self.tile_width, dtype=np.int32)
        return row + within // self.tile_width, column + within % self.tile_width

    def draw(self, tile: Callable[[jax.Array, jax.Array], Images], parts: Parts | None = None) -> Images:
        """The picture of which `tile(row, column)` draws the tile with that corner.

        Each tile is written to its place when it is ready. One that would stand over the edge is moved inside. parts:
        those of these that a tile reads are taken within it.
        """
        tile, shapes = traced(tile, jnp.int32(0), jnp.int32(0), parts=parts)
        corners = [
            jnp.array([min(i * side, end - side) for i in range(-(-end // side))], jnp.int32)
            for side, end in ((self.tile_height, self.height), (self.tile_width, self.width))
        ]

        def put(i: jax.Array, carry: tuple) -> tuple:
            row, column, whole = carry

            def placed(image: jax.Array, part: jax.Array) -> jax.Array:
                # Two dimensions, so that what is copied are whole rows of a tile.
                flat = part.reshape(self.tile_height, -1)
                start = row, column * (flat.shape[1] // self.tile_width)
                return lax.dynamic_update_slice(image, flat, start, allow_negative_indices=False)

            whole = jax.tree.map(placed, whole, tile(row, column))
            # The next corner is carried: computed on the spot it would be computed for each pixel that is copied.
            return corners[0][(i + 1) // self.across], corners[1][(i + 1) % self.across], whole

        def empty(shape: Any) -> jax.Array:
            return lax.empty((self.height, self.width * shape.shape[2]), shape.dtype)

        start = jnp.int32(0), jnp.int32(0), jax.tree.map(empty, shapes)
        _, _, whole = lax.fori_loop(0, self.down * self.across, put, start)
        return jax.tree.map(lambda image: image.reshape(self.height, self.width, -1), whole)

    def map(self, tile: Callable[[jax.Array, jax.Array], Images], kept: str) -> Images:
        """The same for what is to be differentiated.

        Reverse mode computes each tile again rather than keep it, but for what bears the name `kept`.
        """
        again = jax.checkpoint(tile, policy=jax.checkpoint_policies.save_only_these_names(kept))
        tiles = lax.map(lambda i: again(*self._corner(i)), jnp.arange(self.down * self.across, dtype=jnp.int32))

        def joined(image: jax.Array) -> jax.Array:
            parts = image.reshape(self.down, self.across, *image.shape[1:])
            whole = parts.swapaxes(1, 2).reshape(self.down * self.tile_height, self.across * self.tile_width, -1)
            return whole[: self.height, : self.width]

        return jax.tree.map(joined, tiles)
