"""What several commands share: options, sizes, progress."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from raytrace.errors import InputError
from raytrace.rendering import check_size

__all__ = [
    "Antialias",
    "BackendName",
    "Changes",
    "Dtype",
    "ExactInputs",
    "Intersection",
    "Scene",
    "Shader",
    "ShaderUniforms",
    "ShadowStart",
    "Size",
    "Skip",
    "TimeLimit",
    "check_plot",
    "progress",
    "size_of",
]

Scene = Annotated[str, typer.Argument(help="A built-in scene's name (see 'raytrace scenes') or a TOML file.")]
Size = Annotated[str, typer.Option(help="WIDTHxHEIGHT in pixels.")]
Changes = Annotated[list[str], typer.Option("--set", help="key=value, such as sun.direction=[0,1,0]; repeatable.")]
BackendName = Annotated[str, typer.Option(help="jax, numpy, opengl or webgl.")]
Dtype = Annotated[str, typer.Option(help="float32; jax, numpy: float64; numpy: longdouble.")]
Intersection = Annotated[str | None, typer.Option(help="textbook or robust; default: robust in float32 only.")]
ShadowStart = Annotated[
    str, typer.Option(help="offset, the assignment's 1e-3 along the normal; jax, numpy: surface, which has no scale.")
]
Antialias = Annotated[
    str, typer.Option(help="none, or edges: each pixel the mean over its square, along its edges too; jax, numpy.")
]
Shader = Annotated[
    Path | None, typer.Option(help="Your own fragment shader, to run instead; with --backend opengl or webgl.")
]
ShaderUniforms = Annotated[
    list[str], typer.Option("--uniform", help="What a uniform stands for, name=camera_position; repeatable.")
]
TimeLimit = Annotated[float, typer.Option(help="Seconds that your own shader may take.")]
Skip = Annotated[bool, typer.Option("--skip/--no-skip", help="Leave out what a part of the image does not need.")]
ExactInputs = Annotated[bool, typer.Option("--exact-inputs", help="Do not round the scene's numbers to float32.")]


def size_of(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        size = int(width), int(height)
    except ValueError:
        raise InputError(f"size: must be WIDTHxHEIGHT, such as 1920x1080, found {text!r}") from None
    check_size(size)
    return size


def check_plot(path: Path | None) -> None:
    """Before anything is measured: whether a plot can have that name."""
    if path and path.suffix not in (".svg", ".png"):
        raise InputError(f"{path}: the plot must be named *.svg or *.png")


@contextmanager
def progress(total: int, what: str = "rendering") -> Iterator:
    """A progress bar on a terminal, nothing anywhere else; gives the function that advances it."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import Progress

    # What is printed meanwhile must not end up beside the bar, on standard error, where it was not meant to be.
    to_terminal = sys.stdout is not None and sys.stdout.isatty()
    with Progress(console=Console(stderr=True), transient=True, redirect_stdout=to_terminal) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done: bar.advance(task, done)
