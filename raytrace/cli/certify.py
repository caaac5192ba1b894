"""Commands on certified images: `certify` and `verify`."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from raytrace.certificates.verify import proposal
from raytrace.cli.options import Changes, Layer, Scene, Size, check_outputs, size_of, taking_options
from raytrace.cli.waits import progress
from raytrace.errors import InputError
from raytrace.image.depth import Depth
from raytrace.rendering import Options, Rendering
from raytrace.scene import data
from raytrace.scene.toml import DEFAULT_SCENE, load_scene

__all__ = ["certify", "verify"]

Precision = Annotated[
    str, typer.Option(help="real: bounds of the exact values; glsl-highp: of what a conforming GPU may print.")
]
Formula = Annotated[str, typer.Option(help="With glsl-highp, the sphere's formula: textbook, robust, or either.")]


def certify(
    scene: Scene = DEFAULT_SCENE,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Also write the bounds, an .exr file.")] = None,
    size: Size = "480x270",
    precision: Precision = "real",
    intersection: Formula = "either",
    changes: Changes = [],  # noqa: B006 (typer's way)
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Bound every pixel, and say what of the image that proves."""
    from raytrace.certificates import certify as certified

    if out and out.suffix.lower() != ".exr":
        raise InputError(f"{out}: a certificate must be named *.exr")
    check_outputs([out], [scene])
    width, height = shape = size_of(size)
    with progress(width * height, "bounding") as advance:
        found = certified(
            load_scene(scene, changes), shape, precision=precision, intersection=intersection, done=advance
        )
    if out:
        found.write(out)
    print(json.dumps(found.to_dict(), indent=1) if as_json else found)


@taking_options("shader", "uniforms", "time_limit", "size", size="480x270")
def verify(
    options: Options,
    image: Annotated[str | None, typer.Argument(help="An image file, or backend:NAME[:DTYPE].")] = None,
    scene: Annotated[str | None, typer.Option("--scene", help="A built-in scene's name or a TOML file.")] = None,
    changes: Changes = [],  # noqa: B006
    certificate: Annotated[Path | None, typer.Option(help="A file that certify has written, instead.")] = None,
    precision: Precision = "glsl-highp",
    intersection: Formula = "either",
    linear: Annotated[bool, typer.Option("--linear", help="The file holds linear light.")] = False,
    display: Annotated[bool, typer.Option("--display", help="The file holds display values.")] = False,
    layer: Layer = None,
    marked: Annotated[Path | None, typer.Option(help="Also write the image with the pixels outside in red.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Say whether a conforming program can print an image.

    An image, or your shader's on Mesa; exit code 1 if not.
    """
    from raytrace.certificates import certify as certified
    from raytrace.certificates import read_certificate
    from raytrace.certificates import verify as verified
    from raytrace.image import write_image

    check_outputs([marked], [image, scene, certificate, options.shader])
    if linear and display:
        raise InputError("--linear and --display: give one of them")
    if (image is None) == (options.shader is None):
        raise InputError("verify: give an image, or a shader with --shader")
    if scene is not None and certificate is None:
        bounds, known, shape = None, load_scene(scene, changes), options.size
    elif scene is None and certificate is not None:
        bounds = read_certificate(certificate)
        known, shape = bounds.scene, bounds.size
        if changes:
            raise InputError("--set: a certificate's scene is as it is")
    else:
        raise InputError("verify: needs the image's scene (--scene), or a certificate (--certificate)")
    if image is not None:
        values, kind, depth = _values(
            image, known, shape, "display" if display else "linear" if linear else None, layer
        )
    else:
        shown = Rendering(replace(options, scene=known, size=shape, backend="opengl")).whole()
        values, kind, depth = np.asarray(shown), "display", None
    if bounds is None:
        height, width = values.shape[:2]
        with progress(width * height, "bounding") as advance:
            bounds = certified(known, (width, height), precision=precision, intersection=intersection, done=advance)
    found = verified(values, bounds, kind, depth)
    if marked:
        write_image(marked, found.marked())
    print(json.dumps(found.to_dict(), indent=1) if as_json else found)
    if not found.inside:
        proposed = None if linear or as_json else proposal(values, bounds, kind, depth)
        if proposed is not None:
            print(proposed)
        raise typer.Exit(1)


def _values(
    image: str, scene: data.Scene, size: tuple[int, int], kind: str | None, layer: str | None
) -> tuple[np.ndarray, str, Depth | None]:
    """The values of a file or a backend, finite or not, whether they are display or linear ones, and a file's depth."""
    from raytrace.comparison.inputs import file_picture, rendering_of

    if image.startswith("backend:"):
        return np.asarray(rendering_of(image, scene, size).whole()), "display", None
    picture = file_picture(image, kind=kind, layer=layer)
    return picture.values, picture.kind, picture.depth
