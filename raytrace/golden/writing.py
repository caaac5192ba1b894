"""Golden images into a folder."""

import json
import os
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path

import numpy as np

from raytrace.certificates import certify
from raytrace.errors import InputError
from raytrace.export.numbers import uniforms_report
from raytrace.files import whole_folder
from raytrace.golden.golden import SIZE, rendered
from raytrace.golden.manifest import MANIFEST, Entry, Manifest, file_hash, read_manifest
from raytrace.image import write_image
from raytrace.rendering import Options, Rendering
from raytrace.scene import Scene, scene_hash, scene_toml, scenes
from raytrace.shader.specification import SPECIFICATION

__all__ = ["ACCEPTANCE", "CERTIFICATE", "DISPLAY", "write_goldens"]

#: The ending of the file with the display values in full precision.
DISPLAY = ".display.exr"
#: Those of the certificates: of the real numbers, and of what a conforming GPU may print.
CERTIFICATE, ACCEPTANCE = ".certificate.exr", ".bounds.exr"


def write_goldens(
    folder: str | Path, chosen: Mapping[str, Scene], size: tuple[int, int] = SIZE, *, certified: bool = True
) -> Iterator[str]:
    """Writes the golden images of `chosen`; gives the name of each scene when its files are written.

    For a scene NAME: NAME.linear.exr and NAME.display.exr (float32), NAME.steps.exr (a layer for each step),
    NAME.png (8 bit) and NAME.uniforms.json, all from NumPy float64; and one manifest.json. `certified`: also
    NAME.certificate.exr, the bounds of the real numbers, which prove the PNG, and NAME.bounds.exr, those of what a
    conforming GPU may print (`raytrace.certify`). The same scenes and versions give the same bytes. The folder appears
    when all is written; one of golden images is replaced.

    Raises:
        InputError: the folder holds other files, or cannot be written.
    """
    _check_replaceable(Path(folder))
    with whole_folder(Path(folder)) as temporary:
        entries = {}
        for name, scene in chosen.items():
            steps = _write_scene(temporary, name, scene, size)
            proven = _write_certificates(temporary, name, scene, steps["display"]) if certified else None
            entries[name] = Entry(
                about=scenes().get(name, ""),
                toml=scene_toml(scene),
                sha256=scene_hash(scene),
                files={
                    path.name: file_hash(path)
                    for path in sorted(temporary.iterdir())
                    if path.name.startswith(f"{name}.")
                },
                proven=proven,
            )
            yield name
        versions = {"raytrace": version("raytrace"), "numpy": np.__version__}
        manifest = Manifest(specification=SPECIFICATION, size=size, versions=versions, scenes=entries)
        (temporary / MANIFEST).write_text(manifest.model_dump_json(indent=1) + "\n", encoding="utf-8")


def _write_scene(folder: Path, name: str, scene: Scene, size: tuple[int, int]) -> Mapping[str, np.ndarray]:
    """Writes the images of a scene; gives the steps that they are of."""
    steps = rendered(scene, size)
    rendering = Rendering(Options(scene, size, backend="numpy", dtype="float64"))
    metadata = rendering.metadata()
    for ending, output in ((".linear.exr", "linear"), (DISPLAY, "display"), (".png", "display")):
        write_image(folder / f"{name}{ending}", steps[output], output=output, metadata=metadata | {"output": output})
    write_image(folder / f"{name}.steps.exr", dict(steps), metadata=metadata | {"output": "steps"})
    report = json.dumps(uniforms_report(scene, size), indent=1)
    (folder / f"{name}.uniforms.json").write_text(report + "\n", encoding="utf-8")
    return steps


def _write_certificates(folder: Path, name: str, scene: Scene, display: np.ndarray) -> float:
    """Writes both certificates; gives the share of the PNG's values that are proven to be the real numbers' own."""
    size = display.shape[1::-1]
    exact = certify(scene, size)
    exact.write(folder / f"{name}{CERTIFICATE}")
    certify(scene, size, precision="glsl-highp").write(folder / f"{name}{ACCEPTANCE}")
    return float(np.mean(exact.proven & (exact.levels[0] == np.rint(255 * display))))


def _check_replaceable(shown: Path) -> None:
    folder = Path(os.path.realpath(shown))
    if not folder.parent.is_dir():
        raise InputError(f"{shown}: the folder {shown.parent} does not exist")
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{shown}: is not a folder")
    if folder.is_dir() and Path.cwd().is_relative_to(folder):
        raise InputError(f"{shown}: is the current folder, or above it; give the name of another one")
    if not folder.is_dir() or not any(folder.iterdir()):
        return
    ours: dict[str, str] = {}
    if (folder / MANIFEST).is_file():
        for entry in read_manifest(folder).scenes.values():
            ours |= entry.files
    # A manifest can name anything: only what is as we wrote it is replaced.
    other = sorted(path.name for path in folder.iterdir() if path.name != MANIFEST and not _as_written(path, ours))
    if other:
        raise InputError(f"{shown}: holds {other[0]}, which is no golden image; give a new or an empty folder")


def _as_written(path: Path, ours: Mapping[str, str]) -> bool:
    return path.is_file() and not path.is_symlink() and ours.get(path.name) == file_hash(path)
