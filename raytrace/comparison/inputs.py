"""Two images, from wherever they come, made comparable: finite display values of one shape."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.comparison.develop import developed, film_of
from raytrace.errors import InputError, check_choice
from raytrace.image import Depth, file_format, read_file
from raytrace.image.depth import FLOAT32, array_of, depth_of_dtype, values_of
from raytrace.image.formats import FORMATS
from raytrace.rendering import Options, Rendering
from raytrace.scene import Scene
from raytrace.scene.toml import as_scene, scene_from_toml

__all__ = [
    "KINDS",
    "NotFinite",
    "Picture",
    "comparable",
    "file_picture",
    "finite",
    "read_picture",
    "rendering_of",
    "scene_in",
    "usual_kind",
]

#: What an image's values can be.
KINDS = ("display", "linear")
_BACKEND = "backend:"
#: Backends that run the reference itself, and no shader of a user's.
REFERENCES = ("numpy", "jax")


class NotFinite(InputError):
    """An image holds NaN or infinity, which no metric may be asked about: its name, how many, and the first one."""


@dataclass(frozen=True)
class Picture:
    """An image as it was found: its values (height, width, 3), what they are, and what its file says of its origin.

    kind: one of `KINDS`. depth: what the values are stored as. scene: the scene in the file's metadata, if that was
    asked for. metadata: all of it.
    """

    name: str
    values: np.ndarray
    kind: str
    depth: Depth
    scene: Scene | None
    metadata: Mapping[str, str] = field(default_factory=dict)


def comparable(
    sources: tuple[Any, Any],
    names: tuple[str, str] | None,
    kinds: tuple[str | None, str | None],
    scene: Scene | str | Path | None,
    size: tuple[int, int],
    layer: str | None = None,
    reference: str | None = None,
) -> tuple[tuple[np.ndarray, np.ndarray], Depth | None, tuple[str, str], Scene | None, str]:
    """The display values of both in float64, the depth that they are compared in, their names, the known scene, and
    which of them is the reference, "a" or "b".

    Where the values of one are stored more coarsely than in float32, the other's are rounded to the same: what such a
    file cannot hold is no difference. The scene is the one given, or else that of the first file that tells.
    The arguments are those of `raytrace.compare`, which says what is raised.
    """
    if reference is not None:
        check_choice("reference", reference, ("a", "b"))
    scene = None if scene is None else as_scene(scene)
    names = names or (_name(sources[0], "A"), _name(sources[1], "B"))
    found = [
        None if _is_backend(source) else read_picture(source, name, kind, with_scene=scene is None, layer=layer)
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
    images = _display(a, known), _display(b, known)
    # The depth of linear light says nothing of the display values that it is developed to.
    depths = [image.depth for image in (a, b) if image.kind == "display" and image.depth.unit > FLOAT32.unit]
    depth = max(depths, key=lambda depth: depth.unit, default=None)
    if depth is not None:
        images = depth.rounded(images[0]), depth.rounded(images[1])
    if reference is None:
        authority = [_authority(image) for image in found]
        reference = "b" if authority[1] > authority[0] else "a"
    return images, depth, names, known, reference


def _authority(image: Picture | None) -> int:
    """How likely an image is the right one of two: a backend's rendering, then a file of ours, then anything else."""
    if image is None:
        return 2
    return int(image.metadata.get("backend") in REFERENCES)


def rendering_of(text: str, scene: Scene | str | Path, size: tuple[int, int]) -> Rendering:
    """The rendering that ``backend:NAME`` or ``backend:NAME:DTYPE`` stands for; float32 unless another is asked for.

    Raises:
        InputError: there is no such backend or arithmetic, or it cannot run here.
    """
    backend, _, dtype = text.removeprefix(_BACKEND).partition(":")
    return Rendering(Options(scene, size, backend=backend, dtype=dtype or "float32"))


def _is_backend(source: Any) -> bool:
    return isinstance(source, str) and source.startswith(_BACKEND)


def _name(source: Any, letter: str) -> str:
    return str(source) if isinstance(source, str | Path) else letter


def _size(values: np.ndarray) -> str:
    return f"{values.shape[1]}x{values.shape[0]}"


def _rendered(text: str, name: str, scene: Scene | None, size: tuple[int, int]) -> Picture:
    if scene is None:
        raise InputError(f"{name}: needs a scene to render (--scene)")
    image = np.asarray(rendering_of(text, scene, size).whole())
    return Picture(name, finite(_values(image, name), name), "display", FLOAT32, None)


def read_picture(source: Any, name: str, kind: str | None, with_scene: bool, layer: str | None = None) -> Picture:
    """Read a file, or take an array (height, width, 3) of floats or unsigned integers; its values become float64.

    A `Picture` is one already.

    kind: one of `KINDS`; ``None`` for what the file says, or else what its ending usually holds. An array is "display".
    with_scene: look for the scene, which may be wrong where another is given. layer: which of a file's layers, or
    parts, is meant, if it has several with red, green and blue.

    Raises:
        InputError: there is no such image, or its values are not finite.
    """
    if kind is not None:
        check_choice(f"{name}: kind of values", kind, KINDS)
    if isinstance(source, Picture):
        return replace(source, values=finite(source.values, name), kind=kind or source.kind)
    if not isinstance(source, str | Path):
        return Picture(name, finite(_values(source, name), name), kind or "display", _depth(source), None)
    picture = file_picture(source, name, kind, layer)
    scene = scene_in(picture.metadata, name) if with_scene else None
    return replace(picture, values=finite(picture.values, name), scene=scene)


def file_picture(
    path: str | Path, name: str | None = None, kind: str | None = None, layer: str | None = None
) -> Picture:
    """Return what a file holds, finite or not; of a file of steps the "display" or the "linear" ones.

    name: what it is called in messages, by default the file's own name. kind, layer: as of `read_picture`.

    Raises:
        InputError: there is no such file, it is not a whole image, or which of its layers is meant is not known.
    """
    found, name = read_file(path, layer), name or str(path)
    if isinstance(found.image, dict):
        kind = kind or "display"
        return Picture(name, _values(found.image[kind], name), kind, found.depth, None, found.metadata)
    stated = found.metadata.get("output")
    kind = kind or (stated if stated in KINDS else usual_kind(Path(path)))
    return Picture(name, _values(found.image, name), kind, found.depth, None, found.metadata)


def usual_kind(path: Path) -> str:
    """What files of that ending usually hold; those that are not written here, such as DPX, hold display values."""
    return file_format(path).output if path.suffix.lower() in FORMATS else "display"


def _depth(array: Any) -> Depth:
    """An array's depth by its type; floats that are all k / 255 are of 8 bits, unless they are all 0 or 1."""
    array = np.asarray(array)
    own = depth_of_dtype(array.dtype)
    if own.unit > FLOAT32.unit:
        return own
    steps = array * 255
    of_8_bits = (np.abs(steps - np.rint(steps)) < 1e-3).all() and ((array > 0) & (array < 1)).any()
    return Depth(8) if of_8_bits else own


def scene_in(metadata: Mapping[str, str], name: str) -> Scene | None:
    """Return the scene that a file of ours was rendered from; ``None`` of any other file."""
    if "scene" not in metadata:
        return None
    return scene_from_toml(metadata["scene"], f"{name}: the scene in its metadata")


def _values(image: Any, name: str) -> np.ndarray:
    array = array_of(image, name)
    try:
        return values_of(array)
    except InputError as error:
        raise InputError(str(error).replace("image:", f"{name}:", 1)) from None


def finite(values: np.ndarray, name: str) -> np.ndarray:
    """`values`, (height, width, 3), as they are.

    Raises:
        NotFinite: not all of them are finite.
    """
    wrong = ~np.isfinite(values).all(axis=-1)
    if wrong.any():
        y, x = np.argwhere(wrong)[0]
        found, each = " ".join(map(str, values[y, x])), np.count_nonzero(~np.isfinite(values))
        raise NotFinite(
            f"{name}: {np.count_nonzero(wrong)} of {wrong.size} pixels are not finite ({each} of {values.size} "
            f"values); the first one is at x {x}, y {y}: {found}"
        )
    return values


def _display(image: Picture, known: Scene | None) -> np.ndarray:
    """The image's display values; linear light is developed by the film of its own scene, or of the one given."""
    if image.kind == "display":
        return image.values
    scene = image.scene or known
    if scene is None:
        raise InputError(
            f"{image.name}: holds linear light, and no scene is known whose film would develop it; give one (--scene)"
        )
    return finite(developed(image.values, *film_of(scene)), image.name)
