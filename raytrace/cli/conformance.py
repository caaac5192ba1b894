"""The command `conformance`, for the development of raytrace itself."""

import json
from typing import Annotated

import typer

from raytrace.cli.waits import progress
from raytrace.errors import check_choice

__all__ = ["conformance"]


def conformance(
    scenes: Annotated[int, typer.Option(min=1, help="How many random scenes.")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Other seeds give other scenes.")] = 0,
    built_in: Annotated[bool, typer.Option("--built-in", help="Draw the built-in scenes, too.")] = False,
    engine: Annotated[list[str], typer.Option(help="opengl, webgl, numpy or jax; all of them if none is named.")] = [],  # noqa: B006
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Hold random scenes on every engine against their bounds.

    On OpenGL, WebGL2, NumPy and JAX in float32: is every pixel within the certified bounds? Exit code 1, with a line
    for each image, if a pixel is outside.
    """
    from raytrace.scene import scenes as built_in_scenes
    from raytrace.studies.conformance import ENGINES, study

    for name in engine:
        check_choice("--engine", name, ENGINES)
    total = scenes + (len(built_in_scenes()) if built_in else 0)
    with progress(total, "verifying") as advance:
        result = study(scenes, seed, built_in=built_in, engines=tuple(engine) or ENGINES, done=advance)
    if as_json:
        print(json.dumps(result._asdict(), indent=1))
    else:
        for line in result.outside:
            print(line)
        for name, why in result.missing.items():
            print(f"left out: {name}: {why}")
        print(
            f"{result.scenes} scenes, {result.images} images, {result.pixels} pixels: "
            f"{len(result.outside)} images have pixels outside; {result.wide:.1%} of the bounds are over 1/255"
        )
    if result.outside:
        raise typer.Exit(1)
