"""Images out of files."""

from pathlib import Path
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.image.depth import FLOAT32, Depth
from raytrace.image.formats import metadata_of
from raytrace.image.messages import complaint_of, quiet
from raytrace.image.steps import STEP_CHANNELS, steps_of

__all__ = ["read_depth", "read_image", "read_metadata", "read_planes"]


def read_image(path: str | Path) -> Any:
    """The image in a file: a float32 array (height, width, 3), integers divided by their largest value.

    A file of steps, as `write_image` writes it, gives the dict of steps. Grey is repeated; alpha is left out.

    Raises:
        InputError: there is no such file, or it is not a whole image.
    """
    planes = read_planes(path)
    if planes.keys() >= set(STEP_CHANNELS):
        return steps_of(planes)
    if planes.keys() >= {"R", "G", "B"}:
        return np.stack([planes["R"], planes["G"], planes["B"]], axis=-1)
    return np.repeat(next(iter(planes.values()))[..., None], 3, axis=-1)


def read_planes(path: str | Path) -> dict[str, np.ndarray]:
    """Every channel of a file by its name, float32 (height, width), integers divided by their largest value.

    Raises:
        InputError: there is no such file, or it is not a whole image.
    """
    import OpenImageIO as oiio

    path = Path(path)
    file = _opened(path)
    try:
        spec = file.spec()
        with quiet():
            pixels = file.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
        if pixels is None or file.has_error:
            raise InputError(f"{path}: is not a whole image: {complaint_of(file)}")
    finally:
        file.close()
    depth = _depth(spec)
    if not depth.floating:
        # OpenImageIO's quotients are not always the nearest float32, and it gives 10 bits as 16, nearly.
        pixels = depth.rounded(pixels).astype(np.float32)
    return {name: pixels[..., k] for k, name in enumerate(spec.channelnames)}


def read_metadata(path: str | Path) -> dict[str, str]:
    """The texts that `write_image` was given to store with an image.

    Raises:
        InputError: there is no such file, or it is not an image.
    """
    file = _opened(Path(path))
    try:
        return metadata_of({attribute.name: attribute.value for attribute in file.spec().extra_attribs})
    finally:
        file.close()


def read_depth(path: str | Path) -> Depth:
    """Return the depth of a file's colours, the coarsest of its colour channels.

    That is what the file says of itself, whatever its values are. Floats that are wider than float32 count as float32,
    to which they are rounded when they are read.

    Raises:
        InputError: there is no such file, or it is not an image.
    """
    file = _opened(Path(path))
    try:
        return _depth(file.spec())
    finally:
        file.close()


def _depth(spec: Any) -> Depth:
    """The depth that a file's description states."""
    formats = [spec.format]
    if spec.channelformats:
        named = dict(zip(spec.channelnames, spec.channelformats, strict=True))
        formats = [named[name] for name in "RGB" if name in named] or list(named.values())[:1]
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
