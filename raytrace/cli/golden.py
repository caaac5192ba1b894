"""Commands for golden images: `golden` and `check`."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from raytrace.cli.options import Layer, Size, check_outputs, size_of, taking_options
from raytrace.cli.waits import progress
from raytrace.errors import InputError
from raytrace.glsl.source import read_shader
from raytrace.golden import backend_source, folder_source, golden_folder, golden_scenes, write_goldens, write_report
from raytrace.golden.manifest import MANIFEST
from raytrace.rendering import Options

__all__ = ["check", "golden"]

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="The folder of the golden images.")]


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
    folder: Folder,
    backend: Annotated[
        str | None,
        typer.Option(help="The backend to check: jax, numpy, opengl or webgl; with --shader: opengl by default."),
    ] = None,
    images: Annotated[
        Path | None, typer.Option(help="A folder of another renderer's images to check: NAME.png, NAME.exr, ...")
    ] = None,
    display: Annotated[bool, typer.Option("--display", help="The files hold display values.")] = False,
    layer: Layer = None,
    min_ssim: Annotated[float | None, typer.Option(help="The mean SSIM, at least; default: 0.9999.")] = None,
    max_share: Annotated[
        float | None, typer.Option(help="The share of pixels over 1/255, at most; default: 0.001.")
    ] = None,
    report: Annotated[Path, typer.Option(help="The HTML report.")] = Path("report.html"),
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON.")] = False,
) -> None:
    """Check a backend, a shader or images against golden images.

    The images may be those of another renderer. Exit code 1 if any fails.
    """
    shader = options.shader
    if shader is not None and backend is None:
        backend = "opengl"
    if (images is None) == (backend is None):
        raise InputError("check: give one of --images, --backend and --shader")
    check_outputs([report], [shader, folder / MANIFEST])
    held = golden_folder(folder)
    if images is not None:
        what, source = str(images), folder_source(images, "display" if display else None, layer)
    else:
        if shader is not None:
            read_shader(shader)  # else every golden image would say that it cannot be
        source = backend_source(replace(options, backend=backend))
        what = f"backend {backend} {options.dtype}" if shader is None else f"{shader} on {backend}"
    results = []
    with progress(len(held.goldens), "comparing") as advance:
        bounds = {"min_ssim": min_ssim, "max_share": max_share}
        for result in held.check(source, {name: limit for name, limit in bounds.items() if limit is not None}):
            results.append(result)
            if not as_json:
                print(result, flush=True)
            advance(1)
    write_report(report, results, what, held.extra)
    failed = sum(bool(result.failed) for result in results)
    if as_json:
        found = {"results": [result.to_dict() for result in results], "extra": list(held.extra)}
        print(json.dumps(found, indent=1, allow_nan=False))
    else:
        for name in held.extra:
            print(f"note  {folder / name}: extra: belongs to no golden image")
        print(f"{len(results) - failed} of {len(results)} pass; {report}")
    if failed:
        raise typer.Exit(1)
