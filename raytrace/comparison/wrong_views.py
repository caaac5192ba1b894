"""Mistakes in where a pixel looks: flipped, shifted, of another aspect ratio."""

from typing import NamedTuple

import numpy as np

__all__ = ["WrongView", "resampled", "views"]


class WrongView(NamedTuple):
    """A wrong view: at (x, y) from the image's middle it shows what the right one shows at (x * scale_x, y * scale_y).

    right, down: pixels by which what is seen is moved as well.
    """

    scale_x: float = 1.0
    scale_y: float = 1.0
    right: float = 0.0
    down: float = 0.0

    @property
    def whole(self) -> bool:
        """Whether it shows pixels of the right view, and nothing between them."""
        return {abs(self.scale_x), abs(self.scale_y)} == {1} and self.right % 1 == self.down % 1 == 0

    def pixels(self, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
        """The columns and the rows of the right view, whole or not, that the wrong one shows in its own."""
        x, y = (width - 1) / 2, (height - 1) / 2
        columns = self.scale_x * (np.arange(width) - x) + x - self.right
        rows = self.scale_y * (np.arange(height) - y) + y - self.down
        return columns, rows


_FLIPS = {
    "flipped top to bottom (y)": WrongView(scale_y=-1.0),
    "flipped left to right (x)": WrongView(scale_x=-1.0),
    "turned by 180 degrees (flipped in x and y)": WrongView(-1.0, -1.0),
}
_LENGTHS = {"one pixel": 1.0, "half a pixel": 0.5}
_DIRECTIONS = {-1: ("left", "up"), 1: ("right", "down")}


def views(width: int, height: int) -> dict[str, WrongView]:
    """The usual mistakes of an image of that size; the ones that leave it as it is are left out."""
    aspect = width / height
    aspects = {
        "drawn without the aspect ratio": WrongView(scale_x=1 / aspect),
        "drawn with the aspect ratio upside down (height / width)": WrongView(scale_x=1 / aspect**2),
        "drawn with the vertical field of view as the horizontal one": WrongView(1 / aspect, 1 / aspect),
    }
    return _FLIPS | _shifts() | (aspects if aspect != 1 else {})


def _shifts() -> dict[str, WrongView]:
    shifts = {}
    for length, pixels in _LENGTHS.items():
        for x in (-1, 0, 1):
            for y in (-1, 0, 1):
                ways = [_DIRECTIONS[x][0]] if x else []
                ways += [_DIRECTIONS[y][1]] if y else []
                if ways:
                    shifts[f"shifted by {length} {' and '.join(ways)}"] = WrongView(right=x * pixels, down=y * pixels)
    return shifts


def resampled(image: np.ndarray, view: WrongView, every: int = 1) -> np.ndarray:
    """`image` through the wrong view, between its pixels by bilinear interpolation; NaN where it does not reach.

    Of the result every so many rows and columns.
    """
    from scipy.ndimage import map_coordinates

    height, width, _ = image.shape
    columns, rows = view.pixels(width, height)
    places = np.meshgrid(rows[::every], columns[::every], indexing="ij")
    planes = [map_coordinates(plane, places, order=1, cval=np.nan) for plane in np.moveaxis(image, -1, 0)]
    return np.stack(planes, axis=-1)
