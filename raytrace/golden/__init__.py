"""Golden images: written once from NumPy float64, checked against any other renderer."""

from raytrace.golden.checking import (
    Checked,
    GoldenFolder,
    backend_source,
    folder_source,
    golden_folder,
    one_image,
    stray_images,
)
from raytrace.golden.golden import BOUNDS, SIZE, Golden, golden_scenes
from raytrace.golden.report import write_report
from raytrace.golden.writing import write_goldens

__all__ = [
    "BOUNDS",
    "SIZE",
    "Checked",
    "Golden",
    "GoldenFolder",
    "backend_source",
    "folder_source",
    "golden_folder",
    "golden_scenes",
    "one_image",
    "stray_images",
    "write_goldens",
    "write_report",
]
