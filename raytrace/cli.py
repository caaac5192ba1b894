"""The command line: parse, call, print."""

import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from raytrace.bench import plain_jit_timings, scene_timings
from raytrace.errors import InputError
from raytrace.files import reason
from raytrace.image import file_format, image_file
from raytrace.rendering import Rendering, check_size
from raytrace.report import pixel_report, uniforms_report
from raytrace.scene import load_scene, scene_toml, scenes
from raytrace.scene.toml import DEFAULT_SCENE

__all__ = ["app", "run"]

app = typer.Typer(
    help="The reference implementation of the ray tracing assignment.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

Scene = Annotated[str, typer.Argument(help="A built-in scene's name (see 'raytrace scenes') or a TOML file.")]
Size = Annotated[str, typer.Option(help="WIDTHxHEIGHT in pixels.")]
Changes = Annotated[list[str], typer.Option("--set", help="key=value, such as sun.direction=[0,1,0]; repeatable.")]
BackendName = Annotated[str, typer.Option(help="jax or numpy.")]
Dtype = Annotated[str, typer.Option(help="float32 or float64; with numpy also longdouble.")]
Intersection = Annotated[str | None, typer.Option(help="textbook or robust; default: robust in float32 only.")]
ExactInputs = Annotated[bool, typer.Option("--exact-inputs", help="Do not round the scene's numbers to float32.")]


@app.command()
def render(
    scene: Scene = DEFAULT_SCENE,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="The file: .png, .exr, .tif; default: the scene's name, .png.")
    ] = None,
    size: Size = "1920x1080",
    backend: BackendName = "jax",
    dtype: Dtype = "float32",
    samples: Annotated[int, typer.Option(help="n for n x n samples a pixel.")] = 1,
    output: Annotated[
        str | None, typer.Option(help="display, linear or steps; default: linear for .exr, otherwise display.")
    ] = None,
    bits: Annotated[int | None, typer.Option(help="Bits of a channel: PNG 8, 16; EXR 16, 32; TIFF 8, 16, 32.")] = None,
    changes: Changes = [],  # noqa: B006 (typer's way)
    intersection: Intersection = None,
    exact_inputs: ExactInputs = False,
) -> None:
    """Render a scene to an image file."""
    out = out or Path(f"{Path(scene).stem}.png")
    rendering = Rendering(
        load_scene(scene, changes),
        _size(size),
        backend=backend,
        dtype=dtype,
        samples=samples,
        output=output or file_format(out).output,
        intersection=intersection,
        exact_inputs=exact_inputs,
    )
    width, height, _ = rendering.frame
    seconds = 0.0
    with (
        image_file(out, (width, height), output=rendering.output, bits=bits, metadata=rendering.metadata()) as file,
        _progress(height) as advance,
    ):
        compiling = time.perf_counter()
        rendering.compile()
        started = time.perf_counter()
        compiling = started - compiling
        for band in rendering.bands():
            seconds += time.perf_counter() - started
            file.write(band)
            advance(rendering.band_height)
            started = time.perf_counter()
    compiled = f", after compiling for {compiling:.2f} s" if compiling >= 0.01 else ""
    print(f"{out}: {width}x{height}, {backend} {dtype}, rendered in {seconds:.3f} s{compiled}")


@app.command(name="scenes")
def list_scenes() -> None:
    """List the built-in scenes."""
    known = scenes()
    for name, comment in known.items():
        print(f"{name:{max(map(len, known))}}  {comment}")


@app.command()
def show(
    scene: Scene = DEFAULT_SCENE,
    as_json: Annotated[bool, typer.Option("--json", help="The uniforms, by the assignment's names, as JSON.")] = False,
    size: Size = "1920x1080",
    changes: Changes = [],  # noqa: B006
) -> None:
    """Print a scene as TOML, or as the uniforms that a shader is given."""
    loaded = load_scene(scene, changes)
    print(json.dumps(uniforms_report(loaded, _size(size)), indent=1) if as_json else scene_toml(loaded).rstrip())


@app.command()
def pixel(
    scene: Scene,
    x: Annotated[int, typer.Argument(help="Column, from 0 on the left.")],
    y: Annotated[int, typer.Argument(help="Row, from 0 on top.")],
    size: Size = "1920x1080",
    backend: BackendName = "numpy",
    dtype: Dtype = "float64",
    changes: Changes = [],  # noqa: B006
    intersection: Intersection = None,
    exact_inputs: ExactInputs = False,
) -> None:
    """Print every step of the shader at one pixel, beside its line of GLSL."""
    rendering = Rendering(
        load_scene(scene, changes),
        _size(size),
        backend=backend,
        dtype=dtype,
        output="steps",
        intersection=intersection,
        exact_inputs=exact_inputs,
    )
    print(pixel_report(rendering, x, y))


@app.command()
def bench(
    size: Size = "1920x1080",
    runs: Annotated[int, typer.Option(min=1, help="Frames that are timed, after one that is not.")] = 5,
    plain_jit: Annotated[
        bool, typer.Option("--plain-jit", help="Instead: the default scene against one plain jit (minutes).")
    ] = False,
) -> None:
    """Time a frame of each built-in scene on each backend, compilation apart."""
    timings = (plain_jit_timings if plain_jit else scene_timings)(_size(size), runs)
    print(f"{'scene':14} {'how':14} {'median ms':>10} {'fastest':>10} {'slowest':>10}", flush=True)
    for row in timings:
        print(f"{row.scene:14} {row.how:14} {row.median:10.1f} {row.fastest:10.1f} {row.slowest:10.1f}", flush=True)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        size = int(width), int(height)
    except ValueError:
        raise InputError(f"size: must be WIDTHxHEIGHT, such as 1920x1080, found {text!r}") from None
    check_size(size)
    return size


@contextmanager
def _progress(rows: int) -> Iterator:
    """A progress bar on a terminal, nothing anywhere else; gives the function that advances it."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("rendering", total=rows)
        yield lambda done: progress.advance(task, done)


@app.callback(invoke_without_command=True)
def _without_command(
    context: typer.Context,
    show_version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if show_version:
        print(f"raytrace {version('raytrace')}")
    elif context.invoked_subcommand is None:
        print(context.get_help())


# The common base of typer's own errors, of which typer.BadParameter is one, wherever the class is kept.
_UsageError = next(base for base in typer.BadParameter.__mro__ if base.__name__ == "ClickException")


_INTERRUPTED = 130


def run() -> None:
    """The command `raytrace`: 0 if all went well, 2 for bad input, with one line that says what; 130 for Ctrl-C."""
    # As `timeout` and service managers end a process: it cleans up behind itself then too.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    try:
        code = app(standalone_mode=False)
        if code == _INTERRUPTED:  # typer's own answer to Ctrl-C
            raise KeyboardInterrupt
        if sys.stdout is not None:
            sys.stdout.flush()
    except InputError as error:
        code = _failed(str(error))
    except _UsageError as error:
        code = _failed(error.format_message())
    except (KeyboardInterrupt, typer.Abort):
        code = _failed("interrupted", _INTERRUPTED)
    except BrokenPipeError:
        code = 0  # whoever reads has seen enough
    except OSError as error:
        code = _failed(f"standard output: cannot be written: {reason(error)}")
    except SystemExit as ended:
        code = ended.code
    # Not by way of the interpreter's end: after an interruption XLA may still be computing in a thread of its own,
    # and would crash when the interpreter is taken down under it.
    os._exit(code or 0)


def _failed(message: str, code: int = 2) -> int:
    if sys.stderr is not None:
        print("raytrace: " + " ".join(message.split()), file=sys.stderr, flush=True)
    return code
