"""Images in files, by OpenImageIO: PNG, OpenEXR, TIFF. No colour conversion happens on the way.

Traps of OpenImageIO (3.2.2) that this file walks around: it adds a ``DateTime`` of its own; attributes of type
double vanish and floats are rounded, so numbers are stored as text; channels may come back in another order; an
incomplete file is closed without a complaint.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from raytrace.errors import InputError
from raytrace.files import whole_file
from raytrace.shader.main import COMPONENTS

__all__ = ["FORMATS", "ImageFile", "file_format", "image_file", "read_image", "read_metadata", "write_image"]


class Format(NamedTuple):
    """A file format: the bits of a channel that it offers (the first is the default) and what they are."""

    bits: dict[int, str]
    #: The output that is written unless another is asked for.
    output: str


_TIFF = Format({16: "uint16", 8: "uint8", 32: "float"}, "display")
FORMATS = {
    ".png": Format({8: "uint8", 16: "uint16"}, "display"),
    ".exr": Format({32: "float", 16: "half"}, "linear"),
    ".tif": _TIFF,
    ".tiff": _TIFF,
}

#: A moment for files that are to be equal whenever they are written.
_EPOCH = "1970:01:01 00:00:00"


def file_format(path: Path) -> Format:
    """The format that the ending of `path` stands for.

    Raises:
        InputError: there is no such format.
    """
    known = FORMATS.get(path.suffix.lower())
    if known is None:
        raise InputError(f"{path}: unknown file ending {path.suffix!r}; there is: {', '.join(FORMATS)}")
    return known


class ImageFile:
    """An image file that is being written from the top down."""

    def __init__(self, output: Any, path: Path, names: list[str], bits: str):
        self._output, self._path, self._names, self._bits, self._row = output, path, names, bits, 0

    def write(self, band: Any) -> None:
        """Appends rows: an array (rows, width, components) or, for steps, the dict of them."""
        pixels = _channels(band, self._names)
        if self._bits.startswith("uint"):
            pixels = _quantized(pixels, np.dtype(self._bits))
        else:
            pixels = pixels.astype(np.float32, copy=False)
        last = self._row + len(pixels)
        if not self._output.write_scanlines(self._row, last, 0, np.ascontiguousarray(pixels)):
            raise InputError(f"{self._path}: cannot be written: {_last_line(self._output.geterror())}")
        self._row = last


@contextmanager
def image_file(
    path: str | Path,
    size: tuple[int, int],
    *,
    output: str = "display",
    bits: int | None = None,
    metadata: Mapping[str, str] | None = None,
) -> Iterator[ImageFile]:
    """A file of `size` (width, height) to be written by the body; it appears whole when the body ends well.

    output: what the values are: "display", "linear", or "steps" (one OpenEXR file with a layer for each step).
    bits: of a channel: 8 or 16 for PNG, 8, 16 or 32 (float) for TIFF, 16 (half) or 32 (float) for OpenEXR.
    metadata: texts that are stored with it, under their names with "raytrace:" in front.

    Raises:
        InputError: the format cannot hold this, or the file cannot be written.
    """
    import OpenImageIO as oiio

    path = Path(path)
    offered = file_format(path).bits
    kind = offered.get(bits or next(iter(offered)))
    if kind is None:
        raise InputError(f"{path}: {path.suffix} has no {bits} bits a channel; there is: {', '.join(map(str, offered))}")
    if output == "steps" and path.suffix.lower() != ".exr":
        raise InputError(f"{path}: output 'steps' has many layers, which only .exr can hold")
    names = _STEP_CHANNELS if output == "steps" else ["R", "G", "B"]
    with whole_file(path) as temporary:
        spec = oiio.ImageSpec(*size, len(names), kind)
        spec.channelnames = tuple(names)
        spec.attribute("DateTime", _EPOCH)
        spec.attribute("oiio:ColorSpace", "lin_rec709_scene" if output == "linear" else "srgb_rec709_display")
        for name, text in _attributes(path, metadata or {}).items():
            spec.attribute(name, text)
        file = oiio.ImageOutput.create(str(temporary))
        if file is None or not file.open(str(temporary), spec):
            raise InputError(f"{path}: cannot be written: {_last_line(file.geterror() if file else oiio.geterror())}")
        try:
            writer = ImageFile(file, path, names, kind)
            yield writer
        finally:
            closed = file.close()
        if not closed or file.has_error or writer._row != size[1]:
            raise InputError(f"{path}: cannot be written: {_last_line(file.geterror()) or 'it is incomplete'}")


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
    first = next(iter(image.values())) if isinstance(image, dict) else image
    if not isinstance(image, dict) and (np.ndim(image) != 3 or np.shape(image)[2] != 3):
        raise InputError(f"{path}: an image is an array (height, width, 3), found {np.shape(image)}")
    height, width = np.shape(first)[:2]
    output = "steps" if isinstance(image, dict) else output
    with image_file(path, (width, height), output=output, bits=bits, metadata=metadata) as file:
        file.write(image)


_AXES = {2: "XY", 3: "XYZ"}
#: Colours by name, vectors by axis, numbers by themselves; the layer without a name is what a viewer shows.
_STEP_LAYERS = {
    name: [""] if n == 1 else list("RGB" if name in ("albedo", "linear", "display") else _AXES[n])
    for name, n in COMPONENTS.items()
}
_STEP_CHANNELS = [
    component if name == "display" else f"{name}.{component}".rstrip(".")
    for name in ("display", *(name for name in COMPONENTS if name != "display"))
    for component in _STEP_LAYERS[name]
]


def _channels(band: Any, names: list[str]) -> np.ndarray:
    """The band's channels in the order of `names`, as an array (rows, width, channels)."""
    if not isinstance(band, dict):
        return np.asarray(band)
    planes = {}
    for name, array in band.items():
        array = np.asarray(array)
        for k, component in enumerate(_STEP_LAYERS[name]):
            channel = component if name == "display" else f"{name}.{component}".rstrip(".")
            planes[channel] = array[..., k] if COMPONENTS[name] > 1 else array
    return np.stack([planes[name].astype(np.float32, copy=False) for name in names], axis=-1)


def _quantized(pixels: np.ndarray, integer: np.dtype) -> np.ndarray:
    scaled = np.clip(pixels, 0, 1) * np.iinfo(integer).max
    return np.rint(scaled).astype(integer)


def _last_line(message: str) -> str:
    """What OpenImageIO said, in one line."""
    lines = message.strip().splitlines()
    return lines[-1] if lines else ""


def read_image(path: str | Path) -> Any:
    """The image in a file: a float32 array (height, width, 3), integers divided by their largest value.

    A file of steps, as `write_image` writes it, gives the dict of steps. Grey is repeated; alpha is left out.

    Raises:
        InputError: there is no such file, or it is not a whole image.
    """
    import OpenImageIO as oiio

    path = Path(path)
    file = _opened(path)
    try:
        spec = file.spec()
        pixels = file.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
        if pixels is None or file.has_error:
            raise InputError(f"{path}: is not a whole image: {_last_line(file.geterror())}")
    finally:
        file.close()
    planes = {name: pixels[..., k] for k, name in enumerate(spec.channelnames)}
    if set(_STEP_CHANNELS) <= set(planes):
        return {name: _step(name, planes) for name in COMPONENTS}
    if {"R", "G", "B"} <= set(planes):
        return np.stack([planes["R"], planes["G"], planes["B"]], axis=-1)
    return np.repeat(pixels[..., :1], 3, axis=-1)


def _step(name: str, planes: dict[str, np.ndarray]) -> np.ndarray:
    if COMPONENTS[name] == 1:
        return planes[name].astype(np.int32) if name == "index" else planes[name]
    prefix = "" if name == "display" else f"{name}."
    return np.stack([planes[f"{prefix}{component}"] for component in _STEP_LAYERS[name]], axis=-1)


def read_metadata(path: str | Path) -> dict[str, str]:
    """The texts that `write_image` was given to store with an image.

    Raises:
        InputError: there is no such file, or it is not an image.
    """
    file = _opened(Path(path))
    try:
        attributes = {attribute.name: attribute.value for attribute in file.spec().extra_attribs}
    finally:
        file.close()
    if str(attributes.get(_DESCRIPTION, "")).startswith(_PREFIX):
        return json.loads(attributes[_DESCRIPTION].removeprefix(_PREFIX))
    return {
        name.removeprefix(_PREFIX): str(value) for name, value in attributes.items() if name.startswith(_PREFIX)
    }


_PREFIX = "raytrace:"
_DESCRIPTION = "ImageDescription"


def _attributes(path: Path, metadata: Mapping[str, str]) -> dict[str, str]:
    """The metadata as attributes of a file; TIFF knows no names of ours, so its description holds them as JSON."""
    if path.suffix.lower() in (".tif", ".tiff"):
        return {_DESCRIPTION: _PREFIX + json.dumps(dict(metadata))} if metadata else {}
    return {_PREFIX + name: text for name, text in metadata.items()}


def _opened(path: Path) -> Any:
    import OpenImageIO as oiio

    if not path.is_file():
        raise InputError(f"{path}: no such file")
    file = oiio.ImageInput.open(str(path))
    if file is None:
        raise InputError(f"{path}: is not an image: {_last_line(oiio.geterror())}")
    return file
