"""The file formats: what each can hold, and how it names what we tell it."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from raytrace.errors import InputError

__all__ = ["attributes", "file_format", "metadata_of"]


class Format(NamedTuple):
    """A file format: the bits of a channel that it offers (the first is the default) and what they are."""

    bits: dict[int, str]
    #: The output that is written unless another is asked for.
    output: str


_TIFF_ENDINGS = (".tif", ".tiff")
FORMATS = {
    ".png": Format({8: "uint8", 16: "uint16"}, "display"),
    ".exr": Format({32: "float", 16: "half"}, "linear"),
    **dict.fromkeys(_TIFF_ENDINGS, Format({16: "uint16", 8: "uint8", 32: "float"}, "display")),
}


def file_format(path: Path) -> Format:
    """The format that the ending of `path` stands for.

    Raises:
        InputError: there is no such format.
    """
    known = FORMATS.get(path.suffix.lower())
    if known is None:
        raise InputError(f"{path}: unknown file ending {path.suffix!r}; there is: {', '.join(FORMATS)}")
    return known


#: A moment for files that are to be equal whenever they are written; OpenImageIO would take the present one.
_EPOCH = "1970:01:01 00:00:00"
_PREFIX = "raytrace:"
_DESCRIPTION = "ImageDescription"
#: What Exif calls sRGB, and all else. Without a word on it OpenImageIO fails to write TIFF's directory of Exif data.
_SRGB, _UNCALIBRATED = 1, 0xFFFF


def attributes(path: Path, output: str, metadata: Mapping[str, str]) -> dict[str, Any]:
    """OpenImageIO's attributes for a file: the moment, the colour space, and `metadata`, all as texts.

    TIFF knows no names of ours, so its description holds them as JSON.
    """
    found: dict[str, Any] = {"DateTime": _EPOCH}
    tiff, linear = path.suffix.lower() in _TIFF_ENDINGS, output == "linear"
    if tiff:
        found["Exif:ColorSpace"] = _UNCALIBRATED if linear else _SRGB
    else:
        found["oiio:ColorSpace"] = "lin_rec709_scene" if linear else "srgb_rec709_display"
    if tiff:
        return found | ({_DESCRIPTION: _PREFIX + json.dumps(dict(metadata))} if metadata else {})
    return found | {_PREFIX + name: text for name, text in metadata.items()}


def metadata_of(attributes: Mapping[str, Any], path: Path) -> dict[str, str]:
    """Return the metadata among the attributes of the file `path`.

    Raises:
        InputError: it is damaged.
    """
    description = str(attributes.get(_DESCRIPTION, ""))
    if not description.startswith(_PREFIX):
        return {
            name.removeprefix(_PREFIX): str(value) for name, value in attributes.items() if name.startswith(_PREFIX)
        }
    try:
        found = json.loads(description.removeprefix(_PREFIX))
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict) or not all(isinstance(value, str) for value in found.values()):
        raise InputError(f"{path}: its metadata (ImageDescription) is damaged: must be a JSON object of texts")
    return found
