"""Exercises: whether an image is that of the reference, and if not, why."""

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.comparison import Comparison, compare, failures
from raytrace.errors import InputError
from raytrace.golden.golden import usual_bounds
from raytrace.notebook.pictures import pictures
from raytrace.rendering import render
from raytrace.scene import Scene
from raytrace.scene.toml import as_scene

__all__ = ["Answer", "check"]


@dataclass(frozen=True)
class Answer:
    """Whether it is right; `hint` says what is wrong, and is empty where nothing is. Shows itself in Jupyter."""

    right: bool
    hint: str
    comparison: Comparison | None = None

    def __str__(self) -> str:
        return "right" if self.right else f"wrong: {self.hint}"

    __repr__ = __str__

    def _repr_html_(self) -> str:
        return f"<b>{'✔ right' if self.right else '✘ wrong'}</b> {escape(self.hint)}"

    def look(self) -> Any:
        """The reference, the answer, and where they differ."""
        if self.comparison is None:
            raise InputError("look: there is no image to look at")
        reference, mine = self.comparison.images
        return pictures(
            reference, mine, np.abs(mine - reference).max(-1), titles=("the reference", "yours", "the difference")
        )


def check(image: Any, scene: Scene | str | Path) -> Answer:
    """Whether an image is the scene's: as near to the reference as a golden image has to be.

    image: display values (height, width, 3). It is compared with NumPy's in float64 of the same size; the hint is the
        mistake that `raytrace.compare` finds, or the part of the scene where most pixels are wrong.

    Raises:
        InputError: there is no such scene.
    """
    scene = as_scene(scene)
    mine = np.asarray(image, dtype=np.float64)
    if mine.ndim != 3 or mine.shape[2] != 3:
        return Answer(False, f"an image has the shape (height, width, 3), this one {mine.shape}")
    if not np.isfinite(mine).all():
        rows, columns = np.nonzero(~np.isfinite(mine).all(-1))
        return Answer(False, f"{len(rows)} pixels are no numbers, the first at x {columns[0]}, y {rows[0]}")
    reference = render(scene, mine.shape[1::-1], backend="numpy", dtype="float64")
    compared = compare(reference, mine, scene=scene)
    failed = failures(compared, usual_bounds(compared))
    return Answer(not failed, _hint(compared, failed) if failed else "", compared)


def _hint(compared: Comparison, failed: list[str]) -> str:
    if compared.diagnosis is not None:
        return f"this is {compared.diagnosis.mistake}"
    if not compared.over:
        return f"no pixel is off by more than 1/255, but {'; '.join(failed)}"
    parts = sorted(compared.regions, key=lambda part: (-part.over, not part.name.startswith("shadow")))
    where = "" if not parts else f", most of them of: {parts[0].name}"
    return f"{compared.over} of {compared.size[0] * compared.size[1]} pixels are off by more than 1/255{where}"
