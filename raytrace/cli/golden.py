"""Commands for golden images: `golden` and `check`."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from raytrace.cli.options import Changes, Layer, Require, Size, check_outputs, scene_if_given, size_of, taking_options
from raytrace.cli.waits import progress
from raytrace.comparison import requirements
from raytrace.errors import InputError
from raytrace.glsl.source import read_shader
from raytrace.golden import (
    backend_source,
    folder_source,
    golden_folder,
    golden_scenes,
    one_image,
    stray_images,
    write_goldens,
    write_report,
)
from raytrace.golden.manifest import MANIFEST
from raytrace.rendering import Options

__all__ = ["check", "golden"]

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="The folder of the golden images.")]
Checkable = Annotated[
    Path, typer.Argument(metavar="DIR|IMAGE", help="The folder of the golden images; or one image, with its --scene.")
]


def golden(
    folder: Folder,
    chosen: Annotated[
        str | None, typer.Option("--scenes", help="Names or TOML files, separated by commas; default: all built in.")
    ] = None,
    size: Size = "480x270",
    certified: Annotated[
        bool, typer.Option("--certify/--no-certify", help="Also bounds: of the exact image, and of a conforming GPU's.")
    ] = True,
) -> None:
    """Write golden images of scenes, and their bounds, to a folder.

    All are from NumPy float64.
    """
    found = golden_scenes(None if chosen is None else [name for name in chosen.split(",") if name])
    with progress(len(found), "golden images") as advance:
        for _ in write_goldens(folder, found, size_of(size), certified=certified):
            advance(1)
    print(f"{folder}: golden images of {len(found)} scenes, {size}")


@taking_options("dtype", "shader", "uniforms", "time_limit")
def check(
    options: Options,
    folder: Checkable,
    scene: Annotated[
        str | None, typer.Option(help="Of one IMAGE: a built-in scene or a TOML file; default: what the image says.")
    ] = None,
    changes: Changes = [],  # noqa: B006
    backend: Annotated[
        str | None,
        typer.Option(help="The backend to check: jax, numpy, opengl or webgl; with --shader: opengl by default."),
    ] = None,
    images: Annotated[
        Path | None, typer.Option(help="A folder of another renderer's images to check: NAME.png, NAME.exr, ...")
    ] = None,
    display: Annotated[bool, typer.Option("--display", help="The files hold display values.")] = False,
    layer: Layer = None,
    require: Require = [],  # noqa: B006 (typer's way)
    report: Annotated[Path, typer.Option(help="The HTML report.")] = Path("report.html"),
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON.")] = False,
) -> None:
    """Check a backend, a shader or images against golden images.

    The images may be those of another renderer. One image is checked without a folder: its golden image and the bounds
    are made for it. Exit code 1 if any fails.
    """
    bounds, shader = requirements(require), options.shader
    if shader is not None and backend is None:
        backend = "opengl"
    kind = "display" if display else None
    check_outputs([report], [shader, scene, folder if folder.is_file() else folder / MANIFEST])
    if folder.is_file():
        if images is not None or backend is not None:
            raise InputError("check: one IMAGE is checked by itself, without --images, --backend and --shader")
        known = scene_if_given(scene, changes)
        with progress(1, "bounding every pixel") as advance:
            held, source = one_image(folder, known, kind, layer, done=advance)
        what = str(folder)
    elif scene is not None and not folder.exists():
        raise InputError(f"{folder}: no such image")
    elif (images is None) == (backend is None):
        raise InputError("check: give one of --images, --backend and --shader, or one IMAGE and its --scene")
    elif scene is not None or changes:
        raise InputError("--scene: is that of one IMAGE; the golden images of a folder have their own")
    else:
        held = golden_folder(folder)
        if images is not None:
            what, source = str(images), folder_source(images, kind, layer)
        else:
            if shader is not None:
                read_shader(shader)  # else every golden image would say that it cannot be
            source = backend_source(replace(options, backend=backend))
            what = f"backend {backend} {options.dtype}" if shader is None else f"{shader} on {backend}"
    strays = [] if images is None else stray_images(images, (golden.name for golden in held.goldens))
    results = []
    with progress(len(held.goldens), "comparing") as advance:
        for result in held.check(source, bounds):
            results.append(result)
            if not as_json:
                print(result, flush=True)
            advance(1)
    write_report(report, results, what, held.extra)
    failed = sum(bool(result.failed) for result in results)
    if as_json:
        found = {"results": [result.to_dict() for result in results], "extra": list(held.extra), "stray": strays}
        print(json.dumps(found, indent=1, allow_nan=False))
    else:
        for name in held.extra:
            print(f"note  {folder / name}: extra: belongs to no golden image")
        for line in strays:
            print(f"note  {line}")
        print(f"{len(results) - failed} of {len(results)} pass; {report}")
    if failed:
        raise typer.Exit(1)
