"""Images out of files: the pixels of the display window, upright, with what the file says of them."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.image.channels import picture_channels
from raytrace.image.depth import FLOAT32, Depth
from raytrace.image.formats import metadata_of
from raytrace.image.messages import complaint_of, quiet
from raytrace.image.steps import STEP_CHANNELS, steps_of

__all__ = ["FileImage", "largest_image", "read_depth", "read_file", "read_image", "read_metadata", "read_planes"]

#: The most pixels of an image that is read, unless `largest_image` allows more: 16384 x 16384.
LARGEST = 1 << 28

_largest: ContextVar[int] = ContextVar("raytrace_largest_image", default=LARGEST)


@contextmanager
def largest_image(pixels: int) -> Iterator[None]:
    """Within this context images of so many pixels are read; others are refused before memory is asked for."""
    token = _largest.set(pixels)
    try:
        yield
    finally:
        _largest.reset(token)


def check_pixels(what: object, width: int, height: int) -> None:
    """Check that an image is not larger than the limit (`largest_image`); `what` begins the message.

    Raises:
        InputError: it is.
    """
    if width * height > _largest.get():
        raise InputError(f"{what}: {width}x{height} is over the limit of {_largest.get()} pixels (--largest-image)")


@dataclass(frozen=True)
class FileImage:
    """What is in a file.

    image: float32 (height, width, 3), integers divided by their largest value; or the dict of steps. metadata: the
    texts that `write_image` was given to store with it. depth: of its colours (`read_depth`).
    """

    image: Any
    metadata: dict[str, str]
    depth: Depth


def read_file(path: str | Path, layer: str | None = None) -> FileImage:
    """Return an image file's picture, and what the file says of it; the arguments are those of `read_image`.

    Raises:
        InputError: there is no such file, it is not a whole image, or which of its layers is meant is not known.
    """
    path = Path(path)
    planes, spec = _planes(path, layer)
    metadata = _metadata(spec, path)
    if planes.keys() >= set(STEP_CHANNELS) and layer is None:
        return FileImage(steps_of(planes), metadata, _depth(spec, ("R", "G", "B")))
    names = picture_channels(path, planes, layer)
    image = np.stack([planes[name] for name in names], axis=-1)
    return FileImage(np.repeat(image, 3 // len(names), axis=-1), metadata, _depth(spec, names))


def read_image(path: str | Path, layer: str | None = None) -> Any:
    """Return the image in a file: a float32 array (height, width, 3), integers divided by their largest value.

    A file of steps, as `write_image` writes it, gives the dict of steps. Grey is repeated; alpha is left out. The image
    is that of OpenEXR's display window, black where the file has no data, and upright, as TIFF and JPEG say it.

    layer: which of an OpenEXR file's layers, or parts, is meant, if it has several with red, green and blue.

    Raises:
        InputError: there is no such file, it is not a whole image, or which of its layers is meant is not known.
    """
    return read_file(path, layer).image


def read_planes(path: str | Path) -> dict[str, np.ndarray]:
    """Return every channel of a file by its name, float32 (height, width), integers divided by their largest value.

    Raises:
        InputError: there is no such file, or it is not a whole image.
    """
    return _planes(Path(path), None)[0]


def read_metadata(path: str | Path) -> dict[str, str]:
    """Return the texts that `write_image` was given to store with an image.

    Raises:
        InputError: there is no such file, it is not an image, or these texts are damaged.
    """
    path = Path(path)
    file = _opened(path)
    try:
        return _metadata(file.spec(), path)
    finally:
        file.close()


def read_depth(path: str | Path, layer: str | None = None) -> Depth:
    """Return the depth of a file's colours, the coarsest of its colour channels.

    That is what the file says of itself, whatever its values are. Floats that are wider than float32 count as float32,
    to which they are rounded when they are read.

    Raises:
        InputError: there is no such file, or it is not an image.
    """
    return read_file(path, layer).depth


def _planes(path: Path, layer: str | None) -> tuple[dict[str, np.ndarray], Any]:
    """The channels of a file by name, of its first part that has a picture, and that part's description."""
    import OpenImageIO as oiio

    file = _opened(path)
    try:
        part = _part(file, path, layer)
        if part:
            file.seek_subimage(part, 0)
        spec = file.spec()
        check_pixels(path, spec.full_width, spec.full_height)
        check_pixels(path, spec.width, spec.height)
        with quiet():
            pixels = file.read_image(part, 0, 0, spec.nchannels, oiio.FLOAT)
        if pixels is None or file.has_error:
            raise InputError(f"{path}: is not a whole image: {complaint_of(file)}")
    finally:
        file.close()
    depth = _depth(spec, spec.channelnames)
    if not depth.floating:
        # OpenImageIO's quotients are not always the nearest float32, and it gives 10 bits as 16, nearly.
        pixels = depth.rounded(pixels).astype(np.float32)
    pixels = _upright(_displayed(pixels, spec), spec.get_int_attribute("Orientation", 1))
    return {name: pixels[..., k] for k, name in enumerate(spec.channelnames)}, spec


def _part(file: Any, path: Path, layer: str | None) -> int:
    """The number of the part of the file, of which OpenEXR may have several, that has the layer, or else a picture."""
    parts = []
    while file.seek_subimage(len(parts), 0):
        parts.append(file.spec())
    file.seek_subimage(0, 0)
    file.geterror()  # that there is no further part is no error
    pictures = {}
    for number, spec in enumerate(parts if len(parts) > 1 else ()):
        with suppress(InputError):
            if len(picture_channels(path, spec.channelnames, layer)) == 3:
                pictures[spec.get_string_attribute("name") or str(number)] = number
    if layer in pictures:
        return pictures[layer]
    if len(pictures) > 1 and layer is None:
        raise InputError(f"{path}: has several parts with a picture; name one (--layer): {', '.join(pictures)}")
    return next(iter(pictures.values()), 0)


def _displayed(pixels: np.ndarray, spec: Any) -> np.ndarray:
    """The pixels of the display window: those of the data window that lie in it, and black."""
    if (spec.x, spec.y, spec.width, spec.height) == (spec.full_x, spec.full_y, spec.full_width, spec.full_height):
        return pixels
    shown = np.zeros((spec.full_height, spec.full_width, pixels.shape[2]), pixels.dtype)
    top, left = spec.y - spec.full_y, spec.x - spec.full_x
    rows = slice(max(0, top), max(0, min(spec.full_height, top + spec.height)))
    columns = slice(max(0, left), max(0, min(spec.full_width, left + spec.width)))
    shown[rows, columns] = pixels[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    return shown


def _upright(pixels: np.ndarray, orientation: int) -> np.ndarray:
    """The pixels as they are to be looked at; orientation: as TIFF and Exif number it, 1 for upright."""
    if orientation not in range(2, 9):
        return pixels
    if orientation >= 5:
        pixels = pixels.transpose(1, 0, 2)
    # Where the first row and the first column of what is stored, or of its transpose, are to be seen.
    bottom, right = {2: (0, 1), 3: (1, 1), 4: (1, 0), 5: (0, 0), 6: (0, 1), 7: (1, 1), 8: (1, 0)}[orientation]
    return np.ascontiguousarray(pixels[:: -1 if bottom else 1, :: -1 if right else 1])


def _metadata(spec: Any, path: Path) -> dict[str, str]:
    try:
        texts = {attribute.name: attribute.value for attribute in spec.extra_attribs}
    except UnicodeDecodeError:
        raise InputError(f"{path}: its texts are damaged: not UTF-8") from None
    return metadata_of(texts, path)


def _depth(spec: Any, channels: Any) -> Depth:
    """The depth that a file's description states, the coarsest of those channels."""
    formats = [spec.format]
    if spec.channelformats:
        named = dict(zip(spec.channelnames, spec.channelformats, strict=True))
        formats = [named[name] for name in channels]
    depth = max(map(_stored_in, formats), key=lambda depth: depth.unit)
    bits = spec.get_int_attribute("oiio:BitsPerSample", 0)
    return Depth(bits) if not depth.floating and 0 < bits < depth.bits else depth


def _stored_in(kind: Any) -> Depth:
    """The depth of one of OpenImageIO's types of numbers; a sign takes a bit."""
    depths = {"half": Depth(16, floating=True), "float": FLOAT32, "double": FLOAT32}
    kind = str(kind)
    if kind in depths:
        return depths[kind]
    bits = int(kind.lstrip("uint") or 32)
    return Depth(bits if kind.startswith("u") else bits - 1)


def _opened(path: Path) -> Any:
    import OpenImageIO as oiio

    if not path.is_file():
        raise InputError(f"{path}: no such file")
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)  # else PNG's colours would be multiplied by their alpha
    with quiet():
        file = oiio.ImageInput.open(str(path), config)
    if file is None:
        raise InputError(f"{path}: is not an image: {complaint_of(oiio)}")
    return file
