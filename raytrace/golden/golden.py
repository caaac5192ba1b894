"""One golden image: a scene, and what NumPy float64 makes of it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.comparison import Comparison, compare, failures
from raytrace.errors import InputError
from raytrace.image import read_image
from raytrace.rendering import render
from raytrace.scene import Scene, load_scene, scenes

__all__ = ["BOUNDS", "SIZE", "Golden", "golden_scenes", "rendered", "usual_bounds"]

SIZE = (480, 270)
#: What an image must keep, unless another bound is asked for, to pass for the golden one: different float32 engines do.
BOUNDS = {"min_ssim": 0.9999, "max_share": 0.001}


def usual_bounds(comparison: Comparison) -> dict[str, float]:
    """Return `BOUNDS`, without that of SSIM where an image is smaller than SSIM's window, which has none."""
    return {name: bound for name, bound in BOUNDS.items() if name != "min_ssim" or comparison.ssim is not None}


@dataclass(frozen=True)
class Golden:
    """A scene at a size, (width, height), and the file of its display values, where there is one."""

    name: str
    scene: Scene
    size: tuple[int, int] = SIZE
    file: Path | None = None

    @cached_property
    def image(self) -> np.ndarray:
        """Display values (height, width, 3).

        Raises:
            InputError: the file is not a whole image of that size.
        """
        if self.file is None:
            return rendered(self.scene, self.size)["display"]
        image = read_image(self.file)
        if image.shape != (*self.size[::-1], 3):
            raise InputError(f"{self.file}: must be {self.size[0]}x{self.size[1]}, found {image.shape[1::-1]}")
        return image

    def compare(self, image: Any, name: str = "B", kind: str | None = None) -> Comparison:
        """`image`, an array or a file, against the golden one; raises what `raytrace.compare` raises."""
        return compare(
            self.image, image, scene=self.scene, names=(f"golden {self.name}", name), kinds=("display", kind)
        )

    def check(self, image: Any, **bounds: float) -> Comparison:
        """Asserts that `image` keeps the bounds, those of `BOUNDS` unless others are given.

        Raises:
            AssertionError: it does not; the message has what it fails, and the comparison with its diagnosis.
        """
        comparison = self.compare(image)
        failed = failures(comparison, usual_bounds(comparison) | bounds)
        if failed:
            raise AssertionError(f"{self.name}: {'; '.join(failed)}\n{comparison}")
        return comparison

    def __str__(self) -> str:
        return self.name


def rendered(scene: Scene, size: tuple[int, int]) -> Mapping[str, np.ndarray]:
    """Every step of the scene in NumPy float64, from which all golden images are made."""
    return render(scene, size, backend="numpy", dtype="float64", output="steps")


def golden_scenes(names: Iterable[str] | None = None) -> dict[str, Scene]:
    """Scenes by name: all built-in ones, or those of `names`, which may be files too.

    Raises:
        InputError: there is no such scene, or two files of one name.
    """
    found: dict[str, Scene] = {}
    for name in scenes() if names is None else names:
        short = Path(name).stem if name not in scenes() else name
        if short in found:
            raise InputError(f"scenes: two are called {short!r}")
        found[short] = load_scene(name)
    if not found:
        raise InputError("scenes: none is given")
    return found
