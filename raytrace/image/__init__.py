"""Images in files, by OpenImageIO: PNG, OpenEXR, TIFF. No colour conversion happens on the way."""

from raytrace.image.formats import file_format
from raytrace.image.reading import read_image, read_metadata
from raytrace.image.writing import image_file, write_image

__all__ = ["file_format", "image_file", "read_image", "read_metadata", "write_image"]
