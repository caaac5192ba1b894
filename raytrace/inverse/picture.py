"""The picture that a sun is sought in: display values, how finely they are stored, and how its pixels were made."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.comparison.develop import developed, film_of
from raytrace.comparison.inputs import finite, read_picture
from raytrace.errors import InputError
from raytrace.image import read_metadata
from raytrace.scene.data import Scene
from raytrace.scene.toml import DEFAULT_SCENE, as_scene, load_scene, scene_from_toml

__all__ = ["EDGES", "Target", "coarse", "scene_seen", "shrunk", "target_of"]

#: How pixels were made that are means over their squares; others are made of n x n samples.
EDGES = "edges"
#: The least side of a picture, in pixels.
SMALLEST = 16
#: Steps from 0 to 1 that a file of integers may have had whose values come as floats.
USUAL_LEVELS = (255, 1023, 4095, 65535)
#: How far outside [0, 1] a display value may be.
ROUNDING = 1e-3


@dataclass(frozen=True)
class Target:
    """The picture to be explained.

    values: display values (height, width, 3) in [0, 1]. half: half of the step between two values that can be stored, 0
    for floats. made: how its pixels were made, n for n x n samples or `EDGES`, if the file says so. scene: the scene
    that is seen.
    """

    values: np.ndarray
    half: float
    made: int | str | None
    scene: Scene


def target_of(
    image: Any, scene: Scene | str | Path | None, kind: str | None = None, layer: str | None = None
) -> Target:
    """Return the picture in a file or an array; the arguments are those of `raytrace.fit_sun`.

    Raises:
        InputError: it is no such picture.
    """
    name = str(image) if isinstance(image, str | Path) else "image"
    is_file = isinstance(image, str | Path)
    if scene is None and is_file:
        scene = scene_seen(Path(image), None)
    scene = as_scene(DEFAULT_SCENE if scene is None else scene)
    source, levels = (image, None) if is_file else _floats(image)
    picture = read_picture(source, name, kind, with_scene=False, layer=layer)
    if min(picture.values.shape[:2]) < SMALLEST:
        height, width = picture.values.shape[:2]
        raise InputError(f"{name}: must have {SMALLEST} x {SMALLEST} pixels at least, found {width} x {height}")
    if picture.kind == "linear":
        values, levels = finite(developed(picture.values, *film_of(scene)), name), None
    else:
        values = _display(picture.values, name)
        if is_file and not picture.depth.floating:
            levels = 2**picture.depth.bits - 1
        levels = levels or _levels_of(values)
    return Target(values, 0.5 / levels if levels else 0.0, _made(picture.metadata), scene)


def scene_seen(image: Path, scene: str | Path | None, changes: Iterable[str] = ()) -> Scene:
    """Return the scene that is named, or else the one in an image file's metadata, or the default one.

    changes: settings, as for `raytrace.load_scene`.

    Raises:
        InputError: there is no such scene, or no such file.
    """
    if scene is not None:
        return load_scene(scene, changes)
    text = read_metadata(image).get("scene")
    if text is None:
        return load_scene(DEFAULT_SCENE, changes)
    return scene_from_toml(text, f"{image}: the scene in its metadata", changes)


def _floats(image: Any) -> tuple[np.ndarray, int | None]:
    """An array as floats with 1 for white, and its steps from 0 to 1 where they are known."""
    array = np.asarray(image)
    if array.ndim == 3 and array.shape[2] == 4:
        array = array[..., :3]
    if array.dtype in (np.uint8, np.uint16):
        levels = int(np.iinfo(array.dtype).max)
        return array / levels, levels
    whole = array.dtype.kind in "iu" or (
        array.dtype.kind == "f" and array.size and bool((array == np.rint(array)).all())
    )
    if whole and array.size and array.min() >= 0 and 1 < array.max() <= 255:
        return array / 255.0, 255
    if array.dtype.kind in "iu":
        raise InputError(f"image: integers must be uint8, uint16 or from 0 to 255, found {array.dtype}")
    return array, None


def _display(values: np.ndarray, name: str) -> np.ndarray:
    least, most = float(values.min()), float(values.max())
    if least < -ROUNDING or most > 1 + ROUNDING:
        raise InputError(
            f"{name}: display values lie from 0 to 1, found {least:.4g} to {most:.4g}; linear light needs kind 'linear'"
        )
    return np.clip(values, 0, 1)


def _levels_of(values: np.ndarray) -> int | None:
    """The fewest usual steps of which all values are multiples, within the precision of float32."""
    for levels in USUAL_LEVELS:
        steps = values * levels
        if (np.abs(steps - np.rint(steps)) < 2e-7 * levels + 1e-6).all():
            return levels
    return None


def _made(metadata: Any) -> int | str | None:
    """How the pixels were made, as `Rendering.metadata` says it."""
    samples, antialias = metadata.get("samples", ""), metadata.get("antialias", "")
    if antialias == EDGES:
        return EDGES
    return int(samples) if samples.isdecimal() and int(samples) > 0 else None


def coarse(size: tuple[int, int], pixels: int) -> tuple[int, int]:
    """Return a size (width, height) of about so many pixels and the same shape; that of the image if it has no more."""
    factor = max(1.0, math.sqrt(size[0] * size[1] / pixels))
    return max(1, round(size[0] / factor)), max(1, round(size[1] / factor))


def shrunk(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return the means of an image (height, width, channels) over the pixels of one of `size`, (width, height)."""
    if image.shape[1::-1] == size:
        return image
    across, down = (_shares(a, b) for a, b in zip(image.shape[1::-1], size, strict=True))
    return np.einsum("yj,jic,xi->yxc", down, image, across, optimize=True)


def _shares(fine: int, coarse: int) -> np.ndarray:
    """How far each of the fine pixels along a line is in each of the coarse ones; the rows of it sum to one."""
    ends = np.linspace(0, fine, coarse + 1)
    pixels = np.arange(fine)
    overlap = np.minimum(ends[1:, None], pixels + 1) - np.maximum(ends[:-1, None], pixels)
    return np.maximum(overlap, 0) * coarse / fine
