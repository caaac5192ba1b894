"""Every available backend and arithmetic against every other."""

import json
from dataclasses import dataclass
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.backends import BACKENDS
from raytrace.comparison.inputs import finite, rendering_of
from raytrace.comparison.metrics import pixels_over, similarity
from raytrace.errors import EngineFailure, InputError
from raytrace.rendering import check_size
from raytrace.scene import Scene
from raytrace.scene.toml import as_scene

__all__ = ["Matrix", "matrix"]


@dataclass(frozen=True)
class Matrix:
    """SSIM and the number of pixels over 1/255 for each two of `labels`, (n, n); prints as a table.

    ssim: ``None`` where an image is under 11 x 11.
    missing: why a backend is not in the table, by its label.
    """

    size: tuple[int, int]
    labels: tuple[str, ...]
    ssim: tuple[tuple[float | None, ...], ...]
    over: tuple[tuple[int, ...], ...]
    missing: dict[str, str]

    def to_dict(self) -> dict[str, Any]:
        """Everything, as plain types that strict JSON holds."""
        return {
            "size": list(self.size),
            "labels": list(self.labels),
            "ssim": [list(row) for row in self.ssim],
            "over": [list(row) for row in self.over],
            "missing": self.missing,
        }

    def to_json(self) -> str:
        return json.dumps(self.to_dict(), indent=1, allow_nan=False)

    def __str__(self) -> str:
        width, height = self.size
        cells = [
            [_cell(*parts) for parts in zip(*rows, strict=True)] for rows in zip(self.ssim, self.over, strict=True)
        ]
        column = max(len(text) for row in (*cells, self.labels) for text in row)
        lines = [
            f"SSIM, and pixels over 1/255 of {width * height} ({width}x{height})",
            " " * 7 + "".join(f"  {label:>{column}}" for label in self.labels),
            *(
                f"{label:7}" + "".join(f"  {cell:>{column}}" for cell in row)
                for label, row in zip(self.labels, cells, strict=True)
            ),
            *(f"without {label}: {why}" for label, why in self.missing.items()),
        ]
        return "\n".join(line.rstrip() for line in lines)


def matrix(scene: Scene | str | Path, size: tuple[int, int] = (1920, 1080)) -> Matrix:
    """`scene` rendered by every backend in float64 and float32, as far as it has them and runs here.

    Raises:
        InputError: the scene or the size is wrong.
    """
    check_size(size)
    scene = as_scene(scene)
    images, missing = {}, {}
    for label, source in _sources().items():
        try:
            image = np.asarray(rendering_of(source, scene, size).whole())
            images[label] = finite(image.astype(np.float64, copy=False), label)
        except (InputError, EngineFailure) as error:
            missing[label] = " ".join(str(error).split())
    pairs = {(a, b): _pair(images[a], images[b]) for a, b in combinations_with_replacement(images, 2)}
    pairs |= {(b, a): pair for (a, b), pair in pairs.items()}
    ssim = tuple(tuple(pairs[a, b][0] for b in images) for a in images)
    over = tuple(tuple(pairs[a, b][1] for b in images) for a in images)
    return Matrix(size, tuple(images), ssim, over, missing)


def _sources() -> dict[str, str]:
    """The labels of the table and what they stand for: NumPy's float64, which the others are checked against, first."""
    sources = {}
    for name, backend in sorted(BACKENDS.items(), key=lambda item: item[0] != "numpy"):
        dtypes = [dtype for dtype in ("float64", "float32") if dtype in backend.dtypes]
        for dtype in dtypes:
            label = name + (dtype.removeprefix("float") if len(dtypes) > 1 else "")
            sources[label] = f"backend:{name}:{dtype}"
    return sources


def _pair(a: np.ndarray, b: np.ndarray) -> tuple[float | None, int]:
    found = similarity(a, b)
    return None if found is None else found.mean, int(np.count_nonzero(pixels_over(a, b)))


def _cell(ssim: float | None, over: int) -> str:
    return f"{'undefined' if ssim is None else f'{ssim:.6f}'} {over:>6}"
