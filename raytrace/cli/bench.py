"""The command `bench`."""

from typing import Annotated

import typer

from raytrace.bench import plain_jit_timings, scene_timings
from raytrace.cli.options import Size, size_of

__all__ = ["bench"]


def bench(
    size: Size = "1920x1080",
    runs: Annotated[int, typer.Option(min=1, help="Frames that are timed, after one that is not.")] = 5,
    plain_jit: Annotated[
        bool, typer.Option("--plain-jit", help="Instead: the default scene against one plain jit (minutes).")
    ] = False,
) -> None:
    """Time a frame of each figure of the assignment on each backend, compilation apart."""
    timings = (plain_jit_timings if plain_jit else scene_timings)(size_of(size), runs)
    print(f"{'scene':14} {'how':14} {'median ms':>10} {'fastest':>10} {'slowest':>10}", flush=True)
    for row in timings:
        print(f"{row.scene:14} {row.how:14} {row.median:10.1f} {row.fastest:10.1f} {row.slowest:10.1f}", flush=True)
