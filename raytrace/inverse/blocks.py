"""Which pixels of a picture are looked at: blocks of neighbours, all of them or a random choice."""

from typing import NamedTuple

import numpy as np

__all__ = ["SIDE", "Blocks"]

#: Pixels along a side of a block: enough for the noise within it, and few enough for errors that change slowly.
SIDE = 8


class Blocks(NamedTuple):
    """Pixels by block, row-major within each: arrays (blocks, SIDE * SIDE). inside: whether there is such a pixel."""

    row: np.ndarray
    column: np.ndarray
    inside: np.ndarray

    @classmethod
    def of(cls, size: tuple[int, int], most: int) -> "Blocks":
        """Return the blocks of a picture of `size` (width, height), or `most` of them, chosen at random.

        The choice depends on the size alone, so that the same picture gives the same answer.
        """
        width, height = size
        across, down = -(-width // SIDE), -(-height // SIDE)
        number = np.arange(across * down)
        if len(number) > most:
            number = np.sort(np.random.default_rng(0).choice(number, most, replace=False))
        y, x = np.divmod(np.arange(SIDE * SIDE), SIDE)
        row = number[:, None] // across * SIDE + y
        column = number[:, None] % across * SIDE + x
        inside = (row < height) & (column < width)
        return cls(np.minimum(row, height - 1), np.minimum(column, width - 1), inside)

    def values(self, image: np.ndarray) -> np.ndarray:
        """Return the values (blocks, SIDE * SIDE, channels) of an image (height, width, channels)."""
        return image[self.row, self.column]

    def take(self, order: np.ndarray) -> "Blocks":
        """Return the blocks of those numbers."""
        return Blocks(*(part[order] for part in self))
