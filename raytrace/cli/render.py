"""Commands that render: `render` and `pixel`."""

import sys
import time
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from raytrace.cli.options import STANDARD_OUTPUT, Changes, Scene, check_outputs, taking_options
from raytrace.cli.waits import progress
from raytrace.errors import InputError
from raytrace.files import temporary_folder
from raytrace.image import file_format, image_file
from raytrace.rendering import Options, Rendering
from raytrace.scene import load_scene
from raytrace.scene.toml import DEFAULT_SCENE

__all__ = ["pixel", "render"]


@taking_options(
    "size",
    "dtype",
    "samples",
    "intersection",
    "shadow_start",
    "antialias",
    "exact_inputs",
    "skip",
    "shader",
    "uniforms",
    "time_limit",
)
def render(
    options: Options,
    scene: Scene = DEFAULT_SCENE,
    backend: Annotated[
        str | None, typer.Option(help="jax, numpy, opengl or webgl; default: jax, with --shader opengl.")
    ] = None,
    output: Annotated[
        str | None, typer.Option(help="display, linear or steps; default: linear for .exr, otherwise display.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", help="The file: .png, .exr, .tif; - for PNG on standard output; default: SCENE.png."
        ),
    ] = None,
    changes: Changes = [],  # noqa: B006 (typer's way)
    bits: Annotated[int | None, typer.Option(help="Bits of a channel: PNG 8, 16; EXR 16, 32; TIFF 8, 16, 32.")] = None,
    cache: Annotated[bool, typer.Option("--cache/--no-cache", help="Keep compiled programs for the next time.")] = True,
    coordinator: Annotated[
        str | None, typer.Option(help="HOST:PORT of process 0, where several processes render one image.")
    ] = None,
    hosts: Annotated[int | None, typer.Option(help="How many processes there are.")] = None,
    process_id: Annotated[int | None, typer.Option(min=0, help="Which of them this is; 0 writes the file.")] = None,
    wait: Annotated[float, typer.Option(help="Seconds in which all of them must have come.")] = 60.0,
    scheduled: Annotated[
        bool, typer.Option("--cluster", help="The same, as the cluster's scheduler says: Slurm, MPI, Kubernetes.")
    ] = False,
) -> None:
    """Render a scene to an image file."""
    options = replace(options, backend=backend or ("jax" if options.shader is None else "opengl"))
    out = out or Path(f"{Path(scene).stem}.png")
    check_outputs([out], [scene, options.shader])
    together = scheduled or any(value is not None for value in (coordinator, hosts, process_id))
    if together and options.backend != "jax":
        raise InputError(f"backend {options.backend}: only jax renders on several hosts")
    with _programs(options.backend, cache), _joined(together, coordinator, hosts, process_id, wait) as writes:
        to_file = str(out) != STANDARD_OUTPUT
        output = output or (file_format(out).output if to_file else "display")
        rendering = Rendering(replace(options, scene=load_scene(scene, changes), output=output))
        if writes and to_file:
            print(f"{out}: {_to_file(rendering, out, bits)}")
        elif writes:
            with temporary_folder() as folder:
                _to_file(rendering, folder / "image.png", bits)
                sys.stdout.buffer.write((folder / "image.png").read_bytes())
        else:
            rendering.compile()
            for _ in rendering.bands():
                pass  # process 0 has it too


def _joined(together: bool, *cluster_of: Any) -> AbstractContextManager[bool]:
    """Whether this process writes the file: of those that render together only one does."""
    if not together:
        return nullcontext(True)
    from raytrace.backends.jax.cluster import cluster

    return cluster(*cluster_of)


def _programs(backend: str, cache: bool) -> AbstractContextManager:
    """Whether compiled programs are kept on disk; only JAX has any."""
    if cache or backend != "jax":
        return nullcontext()
    from raytrace.backends.jax.stored import not_stored

    return not_stored()


def _to_file(rendering: Rendering, out: Path, bits: int | None) -> str:
    """Render band by band, each of which is written before the next; return how long it took, in words."""
    width, height, _ = rendering.frame
    seconds = 0.0
    with (
        image_file(
            out, (width, height), output=rendering.options.output, bits=bits, metadata=rendering.metadata()
        ) as file,
        progress(height) as advance,
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
    what = f"{width}x{height}, {rendering.options.backend} {rendering.options.dtype}"
    return f"{what}, rendered in {seconds:.3f} s{compiled}"


@taking_options(
    "size", "backend", "dtype", "intersection", "shadow_start", "exact_inputs", backend="numpy", dtype="float64"
)
def pixel(
    options: Options,
    scene: Scene,
    x: Annotated[int, typer.Argument(help="Column, from 0 on the left.")],
    y: Annotated[int, typer.Argument(help="Row, from 0 on top.")],
    changes: Changes = [],  # noqa: B006
) -> None:
    """Print every step of the shader at a pixel, with its GLSL."""
    from raytrace.notebook.pixel import pixel_report

    print(pixel_report(Rendering(replace(options, scene=load_scene(scene, changes), output="steps")), x, y))
