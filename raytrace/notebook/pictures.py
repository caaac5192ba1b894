"""Images as notebooks show them: as PNG, which viewers of repositories show too."""

import io
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.files import temporary_folder
from raytrace.image import write_image
from raytrace.rendering import render
from raytrace.scene import Scene

__all__ = ["Pictures", "pictures", "png", "scene_as_png"]


def png(image: Any) -> bytes:
    """An image (height, width, 3) of display values in [0, 1] as the content of a PNG file of 8 bits."""
    with temporary_folder() as folder:
        path = folder / "image.png"
        write_image(path, np.asarray(image))
        return path.read_bytes()


def scene_as_png(scene: Scene) -> bytes | None:
    """Return a scene's picture as the content of a PNG file; ``None`` of one that is traced or wrong."""
    try:
        return png(render(scene, (480, 270)))
    except (InputError, TypeError):
        return None


def pictures(*images: Any, titles: tuple[str, ...] = (), columns: int = 3, width: float = 10.0) -> "Pictures":
    """Images beside each other, with a title each.

    images: arrays (height, width, 3), clipped to [0, 1], or (height, width), which are drawn in false colours with a
        scale and in grey where they are NaN. All booleans are numbers.
    columns: so many in a row at most. width: of the whole, in inches.

    Raises:
        InputError: an image has another shape.
    """
    arrays = []
    for image in images:
        array = np.asarray(image)
        if not (array.ndim == 2 or (array.ndim == 3 and array.shape[2] == 3)):
            raise InputError(f"pictures: must have shape (height, width) or (height, width, 3), found {array.shape}")
        arrays.append(array.astype(np.float64))
    if not arrays:
        raise InputError("pictures: must be one at least")
    return Pictures(tuple(arrays), tuple(titles), min(columns, len(arrays)), width)


class Pictures:
    """What `pictures` gives; shows itself in Jupyter."""

    def __init__(self, images: tuple[np.ndarray, ...], titles: tuple[str, ...], columns: int, width: float):
        self.images, self.titles, self.columns, self.width = images, titles, columns, width

    def _repr_png_(self) -> bytes:
        from matplotlib.figure import Figure

        rows = -(-len(self.images) // self.columns)
        height, width = self.images[0].shape[:2]
        each = self.width / self.columns
        figure = Figure(figsize=(self.width, rows * (each * height / width + 0.35)), layout="constrained", dpi=100)
        for number, image in enumerate(self.images):
            axes = figure.add_subplot(rows, self.columns, number + 1)
            axes.set_axis_off()
            if number < len(self.titles):
                axes.set_title(self.titles[number], fontsize=10, parse_math=False)
            if image.ndim == 3:
                axes.imshow(np.clip(image, 0, 1))
            else:
                axes.imshow(np.where(np.isnan(image), 0.5, np.nan), cmap="gray", vmin=0, vmax=1)
                drawn = axes.imshow(np.ma.masked_invalid(image), cmap="viridis")
                figure.colorbar(drawn, ax=axes, shrink=0.8)
        content = io.BytesIO()
        figure.savefig(content, format="png")
        return content.getvalue()
