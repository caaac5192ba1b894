"""The command `compare`."""

from pathlib import Path
from typing import Annotated

import typer

from raytrace.cli.options import Changes, Layer, Require, Size, check_outputs, scene_if_given, size_of
from raytrace.comparison import NotFinite, failures, matrix, requirements, write_diff
from raytrace.comparison import compare as compare_images
from raytrace.errors import InputError
from raytrace.scene import load_scene
from raytrace.scene.toml import DEFAULT_SCENE

__all__ = ["compare"]

_FAILED = 1

_Image = Annotated[str | None, typer.Argument(help="An image file, backend:NAME, or backend:NAME:DTYPE.")]
_Kind = Annotated[str | None, typer.Option(help="display or linear; default: what the file says, or its ending.")]


def compare(
    a: _Image = None,
    b: _Image = None,
    against: Annotated[
        str | None, typer.Option(metavar="REFERENCE", help="The right image, instead of B: A's mistake is sought.")
    ] = None,
    scene: Annotated[
        str | None,
        typer.Option(help="What both show; its film develops linear light. Default: what the files say."),
    ] = None,
    changes: Changes = [],  # noqa: B006 (typer's way)
    size: Size = "1920x1080",
    layer: Layer = None,
    a_is: _Kind = None,
    b_is: _Kind = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    diff: Annotated[Path | None, typer.Option(help="A PNG of A, B and where they differ.")] = None,
    diagnose: Annotated[bool, typer.Option(help="Seek the usual mistakes.")] = True,
    every_backend: Annotated[
        bool, typer.Option("--matrix", help="Instead: every backend against every other on the scene.")
    ] = False,
    require: Require = [],  # noqa: B006
) -> None:
    """Compare two images: how far apart, where, by which mistake.

    The reference is the image after --against; or what a backend renders; or the only file of raytrace's own; or A.
    """
    bounds = requirements(require)
    if every_backend:
        if a is not None or against is not None or diff is not None or bounds:
            raise InputError("--matrix: takes a scene and a size, and no images, --require or --diff")
        table = matrix(load_scene(scene or DEFAULT_SCENE, changes), size_of(size))
        print(table.to_json() if as_json else table)
        return
    if against is not None:
        if b is not None:
            raise InputError("--against: takes the place of B; give one image and its reference")
        b = against
    if a is None or b is None:
        raise InputError("compare: takes two images, A and B; or one and --against REFERENCE; or --matrix")
    known = scene_if_given(scene, changes)
    check_outputs([diff], [a, b, scene])
    try:
        comparison = compare_images(
            a,
            b,
            scene=known,
            size=size_of(size),
            kinds=(a_is, b_is),
            diagnose=diagnose,
            layer=layer,
            reference=None if against is None else "b",
        )
    except NotFinite as error:
        _fail(str(error))
    if diff is not None:
        write_diff(diff, comparison)
    print(comparison.to_json() if as_json else comparison)
    failed = failures(comparison, bounds)
    if failed:
        _fail("; ".join(failed))


def _fail(message: str) -> None:
    """The check ran, and this is what failed."""
    typer.echo(f"raytrace: {message}", err=True)
    raise typer.Exit(_FAILED)
