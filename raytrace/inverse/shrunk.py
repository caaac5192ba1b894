"""An image as the means over the pixels of a coarser one."""

import math

import numpy as np

__all__ = ["coarse", "shrunk"]


def coarse(size: tuple[int, int], pixels: int) -> tuple[int, int]:
    """The size (width, height) of about so many pixels, of the same shape; that of the image if it has no more."""
    factor = max(1.0, math.sqrt(size[0] * size[1] / pixels))
    return max(1, round(size[0] / factor)), max(1, round(size[1] / factor))


def shrunk(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """The means of an image (height, width, channels) over the pixels of one of `size`, (width, height)."""
    if image.shape[1::-1] == size:
        return image
    across, down = (_shares(a, b) for a, b in zip(image.shape[1::-1], size, strict=True))
    return np.einsum("yj,jic,xi->yxc", down, image, across, optimize=True)


def _shares(fine: int, coarse: int) -> np.ndarray:
    """How far each of the fine pixels along a line is in each of the coarse ones; the rows of it sum to one."""
    ends = np.linspace(0, fine, coarse + 1)
    pixels = np.arange(fine)
    overlap = np.minimum(ends[1:, None], pixels + 1) - np.maximum(ends[:-1, None], pixels)
    return np.maximum(overlap, 0) * coarse / fine
