"""Images in files, by OpenImageIO: PNG, OpenEXR, TIFF. No colour conversion happens on the way."""

from raytrace.image.depth import Depth
from raytrace.image.formats import file_format
from raytrace.image.reading import (
    FileImage,
    largest_image,
    read_depth,
    read_file,
    read_image,
    read_metadata,
    read_planes,
)
from raytrace.image.writing import image_file, write_image, write_planes

__all__ = [
    "Depth",
    "FileImage",
    "file_format",
    "image_file",
    "largest_image",
    "read_depth",
    "read_file",
    "read_image",
    "read_metadata",
    "read_planes",
    "write_image",
    "write_planes",
]
