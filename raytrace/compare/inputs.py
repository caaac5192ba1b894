"""Two images, from wherever they come, made comparable: finite display values of one shape."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.compare.film import developed, film_of
from raytrace.errors import InputError, did_you_mean
from raytrace.image import file_format, read_image, read_metadata
from raytrace.rendering import Rendering
from raytrace.scene import Scene, load_scene
from raytrace.scene.toml import scene_from_toml

__all__ = ["KINDS", "NotFinite", "comparable", "finite", "of_8_bits", "rendering_of"]

#: What an image's values can be.
KINDS = ("display", "linear")
_BACKEND = "backend:"


class NotFinite(InputError):
    """An image holds NaN or infinity, which no metric may be asked about: its name, how many, and the first one."""


@dataclass(frozen=True)
class _Image:
    """An image as it was found: its values (height, width, 3), what they are, and the scene its file tells of."""

    name: str
    values: np.ndarray
    kind: str
    scene: Scene | None


def comparable(
    sources: tuple[Any, Any],
    names: tuple[str, str] | None,
    kinds: tuple[str | None, str | None],
    scene: Scene | str | Path | None,
    size: tuple[int, int],
) -> tuple[tuple[np.ndarray, np.ndarray], tuple[str, str], Scene | None]:
    """The display values of both in float64, of 8 bits if either is, their names, and the scene that is known.

    That is the one given, or else that of the first file that tells.
    The arguments are those of `raytrace.compare`, which says what is raised.
    """
    if scene is not None and not isinstance(scene, Scene):
        scene = load_scene(scene)
    names = names or tuple(_name(source, letter) for source, letter in zip(sources, "AB", strict=True))
    found = [
        None if _is_backend(source) else _read(source, name, kind, with_scene=scene is None)
        for source, name, kind in zip(sources, names, kinds, strict=True)
    ]
    known = scene or next((image.scene for image in found if image is not None and image.scene is not None), None)
    a, b = (
        _rendered(source, name, known, size) if image is None else image
        for image, source, name in zip(found, sources, names, strict=True)
    )
    if a.values.shape != b.values.shape:
        sizes = " and ".join(f"{image.name} of {_size(image.values)}" for image in (a, b))
        raise InputError(f"{sizes}: images of different sizes cannot be compared")
    return _of_equal_depth(_display(a, known), _display(b, known)), names, known


def of_8_bits(image: np.ndarray) -> bool:
    """Whether display values are all k / 255, as a file of 8 bits a channel gives them, and not all 0 or 1."""
    steps = image * 255
    return bool((np.abs(steps - np.rint(steps)) < 1e-3).all() and ((image > 0) & (image < 1)).any())


def _of_equal_depth(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both; where only one is of 8 bits, the other rounded to them: what such a file cannot hold is no difference."""
    coarse = of_8_bits(a), of_8_bits(b)
    if coarse[0] == coarse[1]:
        return a, b
    return tuple(np.rint(np.clip(image, 0, 1) * 255) / 255 for image in (a, b))


def rendering_of(text: str, scene: Scene | str | Path, size: tuple[int, int]) -> Rendering:
    """The rendering that ``backend:NAME`` or ``backend:NAME:DTYPE`` stands for; float32 unless another is asked for.

    Raises:
        InputError: there is no such backend or arithmetic, or it cannot run here.
    """
    backend, _, dtype = text.removeprefix(_BACKEND).partition(":")
    return Rendering(scene, size, backend=backend, dtype=dtype or "float32")


def _is_backend(source: Any) -> bool:
    return isinstance(source, str) and source.startswith(_BACKEND)


def _name(source: Any, letter: str) -> str:
    return str(source) if isinstance(source, str | Path) else letter


def _size(values: np.ndarray) -> str:
    return f"{values.shape[1]}x{values.shape[0]}"


def _rendered(text: str, name: str, scene: Scene | None, size: tuple[int, int]) -> _Image:
    if scene is None:
        raise InputError(f"{name}: needs a scene to render (--scene)")
    image = np.asarray(rendering_of(text, scene, size).whole())
    return _Image(name, _checked(image, name), "display", None)


def _read(source: Any, name: str, kind: str | None, with_scene: bool) -> _Image:
    """A file or an array. The scene is looked for only where it is wanted: it may be wrong where another is given."""
    if kind is not None and kind not in KINDS:
        raise InputError(f"{name}: unknown kind of values {kind!r}; {did_you_mean(kind, KINDS, 'there is')}")
    if not isinstance(source, str | Path):
        return _Image(name, _checked(source, name), kind or "display", None)
    image, metadata = read_image(source), read_metadata(source)
    scene = _scene_in(metadata, name) if with_scene else None
    if isinstance(image, dict):
        return _Image(name, _checked(image["display"], name), "display", scene)
    told = metadata.get("output")
    kind = kind or (told if told in KINDS else file_format(Path(source)).output)
    return _Image(name, _checked(image, name), kind, scene)


def _scene_in(metadata: Mapping[str, str], name: str) -> Scene | None:
    """The scene that a file of ours was rendered from."""
    if "scene" not in metadata:
        return None
    return scene_from_toml(metadata["scene"], f"{name}: the scene in its metadata")


def _checked(image: Any, name: str) -> np.ndarray:
    array = np.asarray(image)
    if array.ndim != 3 or array.shape[2] != 3 or not array.size:
        raise InputError(f"{name}: an image is an array (height, width, 3), found {array.shape}")
    if array.dtype.kind != "f":
        raise InputError(f"{name}: an image's values are floats, with 1 for white, found {array.dtype}")
    return finite(array.astype(np.float64, copy=False), name)


def finite(values: np.ndarray, name: str) -> np.ndarray:
    """`values`, (height, width, 3), as they are.

    Raises:
        NotFinite: not all of them are finite.
    """
    wrong = ~np.isfinite(values).all(axis=-1)
    if wrong.any():
        y, x = np.argwhere(wrong)[0]
        found = " ".join(map(str, values[y, x]))
        raise NotFinite(
            f"{name}: {np.count_nonzero(wrong)} of {wrong.size} pixels are not finite; "
            f"the first one is at x {x}, y {y}: {found}"
        )
    return values


def _display(image: _Image, known: Scene | None) -> np.ndarray:
    """The image's display values; linear light is developed by the film of its own scene, or of the one given."""
    if image.kind == "display":
        return image.values
    scene = image.scene or known
    if scene is None:
        raise InputError(
            f"{image.name}: holds linear light, and no scene is known whose film would develop it; give one (--scene)"
        )
    return finite(developed(image.values, *film_of(scene)), image.name)
