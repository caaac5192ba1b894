"""The benchmark's files: worlds, references of their images' derivatives, and what other programs give.

A folder holds

- `worlds.toml`: the side of a block, the parameters (what is changed, its unit, the limits of a derivative's error),
  and the worlds: size, parameters, and the scanlines of the reference;
- `NAME.toml` for each world: its scene;
- `references.npz`: under "WORLD/PARAMETER" the sums over blocks of the derivative of the display image, the mean of its
  channels, float32 of shape (rows, columns), without what is left of whole blocks at the right and at the bottom; under
  "WORLD/PARAMETER/error" their errors, with a sign, so that their sum is that of the total.

Another program's file is an .npz with keys "WORLD/PARAMETER", as many as it likes: such sums, or the derivative itself,
(height, width, 3) or (height, width).
"""

import zipfile
from collections.abc import Callable, Iterable
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import tomli_w

from raytrace.errors import InputError, check_choice
from raytrace.files import parsed_toml, read_text, reason, whole_file
from raytrace.scene.toml import save_scene, scene_from_toml
from raytrace.studies.boundaries import reference
from raytrace.studies.differences import BLOCK, block_sums
from raytrace.studies.worlds import PARAMETERS, World

__all__ = ["STORED", "Held", "read_benchmark", "read_theirs", "referenced", "write_benchmark"]

WORLDS, REFERENCES = "worlds.toml", "references.npz"
#: The folder that comes with the package.
STORED = resources.files("raytrace.studies") / "benchmark"


class Held(NamedTuple):
    """A world, and by its parameters' names the sums over blocks, (rows, columns), and their errors."""

    world: World
    references: dict[str, tuple[np.ndarray, np.ndarray]]


def referenced(world: World) -> Held:
    """Compute the references of a world, as they are stored."""
    moves = {name: (PARAMETERS[name].moved, PARAMETERS[name].step) for name in world.parameters}
    found = reference(world.scene, moves, world.size, world.scanlines)
    return Held(
        world, {name: (each.blocks.astype(np.float32), each.error.astype(np.float32)) for name, each in found.items()}
    )


def write_benchmark(
    folder: str | Path, worlds: Iterable[World], done: Callable[[int], Any] = lambda number: None
) -> None:
    """Compute and write the references of worlds to a folder, each as soon as it is known; others there are kept.

    done: called after each reference with how many there are more.

    Raises:
        InputError: a file cannot be written, or the folder's own files are wrong.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {reason(error)}") from None
    held = {each.world.name: each for each in read_benchmark(folder)} if (folder / WORLDS).exists() else {}
    for world in worlds:
        held[world.name] = referenced(world)
        save_scene(world.scene, folder / f"{world.name}.toml")
        _write(folder, [held[name] for name in sorted(held)])
        done(len(world.parameters))


def _write(folder: Path, held: list[Held]) -> None:
    arrays = {}
    for world, references in held:
        for name, (blocks, error) in references.items():
            arrays[f"{world.name}/{name}"] = blocks
            arrays[f"{world.name}/{name}/error"] = error
    with whole_file(folder / REFERENCES) as temporary:
        np.savez_compressed(temporary, **arrays)
    document = {
        "block": BLOCK,
        "parameters": {
            name: {"words": each.words, "limits": dict(zip(("total", "blocks"), each.limits, strict=True))}
            for name, each in PARAMETERS.items()
        },
        "worlds": {
            world.name: {
                "size": list(world.size),
                "parameters": list(world.parameters),
                "scanlines": world.scanlines,
            }
            for world, _ in held
        },
    }
    with whole_file(folder / WORLDS) as temporary:
        temporary.write_text(tomli_w.dumps(document), encoding="utf-8")


def read_benchmark(folder: Any = STORED) -> list[Held]:
    """Read the worlds and references in a folder; by default those that come with the package.

    Raises:
        InputError: a file is missing or wrong.
    """
    folder = Path(str(folder))
    document = _document(folder / WORLDS)
    arrays = _arrays(folder / REFERENCES)
    held = []
    for name, entry in document.items():
        try:
            width, height = map(int, entry["size"])
            parameters, scanlines = tuple(entry["parameters"]), int(entry["scanlines"])
        except (KeyError, TypeError, ValueError):
            raise InputError(
                f"{folder / WORLDS}: worlds.{name}: must have size = [width, height], parameters and scanlines"
            ) from None
        scene = scene_from_toml(_text(folder / f"{name}.toml"), str(folder / f"{name}.toml"))
        references = {}
        for parameter in parameters:
            check_choice(f"{folder / WORLDS}: worlds.{name}: parameter", parameter, PARAMETERS)
            keys = f"{name}/{parameter}", f"{name}/{parameter}/error"
            for key in keys:
                if key not in arrays:
                    raise InputError(f"{folder / REFERENCES}: has no {key!r}")
                shape, found = (height // BLOCK, width // BLOCK), arrays[key].shape
                if found != shape:
                    raise InputError(f"{folder / REFERENCES}: {key}: must have shape {shape}, found {found}")
            references[parameter] = (arrays[keys[0]], arrays[keys[1]])
        held.append(Held(World(name, scene, (width, height), parameters, scanlines), references))
    return held


def _document(path: Path) -> dict[str, Any]:
    try:
        document = parsed_toml(_text(path))
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: not TOML: {error}") from None
    if document.get("block") != BLOCK:
        raise InputError(f"{path}: block: must be {BLOCK}, found {document.get('block')!r}")
    worlds = document.get("worlds")
    if not isinstance(worlds, dict):
        raise InputError(f"{path}: must have worlds")
    return worlds


def _text(path: Path) -> str:
    try:
        return read_text(path, "TOML")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None


def _arrays(path: Path) -> dict[str, np.ndarray]:
    """The arrays of an .npz by their keys; numbers, all finite."""
    if not path.is_file():
        raise InputError(f"{path}: {'is not a regular file' if path.exists() else 'no such file'}")
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {key: stored[key] for key in stored.files}
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason(error)}") from None
    except (ValueError, EOFError, AttributeError, TypeError, zipfile.BadZipFile):
        raise InputError(f"{path}: not an .npz of numbers") from None
    for key, array in arrays.items():
        if array.dtype.kind not in "fiu":
            raise InputError(f"{path}: {key}: must be real numbers, found {array.dtype}")
        if not np.isfinite(array).all():
            raise InputError(f"{path}: {key}: must be finite")
    return arrays


def read_theirs(path: str | Path, held: Iterable[Held]) -> dict[tuple[str, str], np.ndarray]:
    """Read another program's derivatives as sums over blocks, by the names of a world and of a parameter.

    Raises:
        InputError: the file cannot be read, names what there is not, or an array has a wrong shape.
    """
    known = {f"{each.world.name}/{name}": (each.world, name) for each in held for name in each.references}
    found = {}
    for key, array in _arrays(Path(path)).items():
        check_choice(f"{path}: key", key, known)
        world, name = known[key]
        width, height = world.size
        sums = height // BLOCK, width // BLOCK
        if array.shape == sums:
            found[world.name, name] = array.astype(np.float64)
        elif array.shape in ((height, width), (height, width, 3)):
            found[world.name, name] = block_sums(array.astype(np.float64).reshape(height, width, -1))
        else:
            raise InputError(
                f"{path}: {key}: must have shape {sums}, {(height, width)} or {(height, width, 3)}, found {array.shape}"
            )
    if not found:
        raise InputError(f"{path}: holds no derivative")
    return found
