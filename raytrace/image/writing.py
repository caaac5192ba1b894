"""Images into files, at once or from the top down while they are rendered."""

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.files import whole_file
from raytrace.image.depth import array_of
from raytrace.image.formats import attributes, file_format
from raytrace.image.messages import complaint_of, quiet
from raytrace.image.steps import STEP_CHANNELS, step_channels
from raytrace.shader.main import COMPONENTS

__all__ = ["ImageFile", "image_file", "write_image", "write_planes"]


#: The last chunk of a PNG, with its length and checksum.
PNG_END = b"\0\0\0\0IEND\xaeB`\x82"

#: How a PNG is compressed: each row by its differences (libpng's filter 16), at level 3 of 9. A picture of 1920x1080
#: takes 45 ms and 300 kB so; as OpenImageIO does it otherwise 190 ms and 240 kB.
PNG = {"png:compressionLevel": 3, "png:filter": 16}


class ImageFile:
    """An image file that is being written from the top down."""

    def __init__(self, file: Any, path: Path, kind: str, steps: bool):
        self._file, self._path, self._kind, self._steps = file, path, kind, steps
        self.rows = 0

    def write(self, band: Any) -> None:
        """Appends rows: an array (rows, width, components) or, for steps, the dict of them."""
        pixels = step_channels(band) if self._steps else np.asarray(band)
        if not np.isfinite(pixels).all():
            raise InputError(f"{self._path}: the image holds values that are not finite")
        if self._kind.startswith("uint"):
            pixels = _quantized(pixels, np.dtype(self._kind))
        else:
            pixels = pixels.astype(np.float32, copy=False)
        last = self.rows + len(pixels)
        if not self._file.write_scanlines(self.rows, last, 0, np.ascontiguousarray(pixels)):
            raise InputError(f"{self._path}: cannot be written: {complaint_of(self._file)}")
        self.rows = last


@contextmanager
def image_file(
    path: str | Path,
    size: tuple[int, int],
    *,
    output: str = "display",
    bits: int | None = None,
    metadata: Mapping[str, str] | None = None,
    channels: Sequence[str] | None = None,
) -> Iterator[ImageFile]:
    """A file of `size` (width, height) to be written by the body; it appears whole when the body ends well.

    output: what the values are: "display", "linear", or "steps" (one OpenEXR file with a layer for each step).
    bits: of a channel: 8 or 16 for PNG, 8, 16 or 32 (float) for TIFF, 16 (half) or 32 (float) for OpenEXR.
    metadata: texts that are stored with it, under their names with "raytrace:" in front.
    channels: the names of the channels, where these are not those of `output`.

    Raises:
        InputError: the format cannot hold this, or the file cannot be written.
    """
    import OpenImageIO as oiio

    path = Path(path)
    offered = file_format(path).bits
    kind = offered.get(next(iter(offered)) if bits is None else bits)
    if kind is None:
        raise InputError(
            f"{path}: {path.suffix} has no {bits} bits a channel; there is: {', '.join(map(str, offered))}"
        )
    if output == "steps" and path.suffix.lower() != ".exr":
        raise InputError(f"{path}: output 'steps' has many layers, which only .exr can hold")
    steps = output == "steps"
    names = list(channels) if channels else STEP_CHANNELS if steps else ["R", "G", "B"]
    with whole_file(path) as temporary:
        spec = oiio.ImageSpec(*size, len(names), kind)
        spec.channelnames = tuple(names)
        for name, value in (PNG if path.suffix.lower() == ".png" else {}).items():
            spec.attribute(name, value)
        for name, value in attributes(path, output, metadata or {}).items():
            spec.attribute(name, value)
        file = oiio.ImageOutput.create(str(temporary))
        if file is None or not file.open(str(temporary), spec):
            raise InputError(f"{path}: cannot be written: {complaint_of(file or oiio)}")
        writer = ImageFile(file, path, kind, steps)
        try:
            yield writer
        except BaseException:
            with quiet():
                file.close()
            raise
        # An incomplete file is closed without a complaint, and an error may be told only by the text.
        closed = file.close()
        complaint = complaint_of(file)
        if not closed or complaint or writer.rows != size[1]:
            raise InputError(f"{path}: cannot be written: {complaint or 'it is incomplete'}")
        if not _is_whole(temporary, size[1]):
            raise InputError(f"{path}: cannot be written: not all of it is on the disk, which may be full")


def _is_whole(path: Path, height: int) -> bool:
    """Whether the end of a file is on the disk: not every library notices that one is full."""
    import OpenImageIO as oiio

    if path.suffix.lower() == ".png":
        with path.open("rb") as file:
            file.seek(-min(len(PNG_END), path.stat().st_size), os.SEEK_END)
            return file.read() == PNG_END
    with quiet():
        file = oiio.ImageInput.open(str(path))
        row = None if file is None else file.read_scanline(height - 1, 0, oiio.FLOAT)
        if file is not None:
            file.close()
    return row is not None


def write_image(
    path: str | Path,
    image: Any,
    *,
    output: str = "display",
    bits: int | None = None,
    metadata: Mapping[str, str] | None = None,
) -> None:
    """Writes an image (height, width, 3), or the dict of steps, to a file; the arguments are those of `image_file`.

    Integers are round(x * (2**bits - 1)) of x clamped to [0, 1]; OpenEXR and float TIFF keep every value.

    Raises:
        InputError: the image is of another shape, the format cannot hold it, or the file cannot be written.
    """
    if isinstance(image, dict):
        if set(image) != set(COMPONENTS):
            raise InputError(f"{path}: steps are a dict of {', '.join(COMPONENTS)}, found {', '.join(image) or 'none'}")
        output, (height, width) = "steps", np.shape(image["t"])
    else:
        array = array_of(image, str(path))
        if array.dtype.kind != "f":
            raise InputError(f"{path}: an image's values are floats, with 1 for white, found {array.dtype}")
        if output not in ("display", "linear"):
            raise InputError(f"{path}: the output of one image is 'display' or 'linear', found {output!r}")
        height, width = array.shape[:2]
    with image_file(path, (width, height), output=output, bits=bits, metadata=metadata) as file:
        file.write(image)


def write_planes(path: str | Path, planes: Mapping[str, np.ndarray], *, metadata: Mapping[str, str]) -> None:
    """Writes planes (height, width) as the float32 channels of one OpenEXR file, by their names.

    Raises:
        InputError: the file is no .exr, or cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise InputError(f"{path}: has many layers, which only .exr can hold")
    height, width = next(iter(planes.values())).shape
    with image_file(path, (width, height), bits=32, metadata=metadata, channels=list(planes)) as file:
        file.write(np.stack([plane.astype(np.float32, copy=False) for plane in planes.values()], axis=-1))


def _quantized(pixels: np.ndarray, integer: np.dtype) -> np.ndarray:
    most = np.iinfo(integer).max
    # In float64 the product is exact; few passes, as a picture is larger than a cache.
    numbers = np.multiply(pixels, most, dtype=np.float64)
    np.clip(np.rint(numbers, out=numbers), 0, most, out=numbers)
    return numbers.astype(integer)
