"""Commands that render: `render` and `pixel`."""

import time
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Annotated

import typer

from raytrace.cli.options import (
    Antialias,
    BackendName,
    Changes,
    Dtype,
    ExactInputs,
    Intersection,
    Scene,
    Shader,
    ShaderUniforms,
    ShadowStart,
    Size,
    Skip,
    TimeLimit,
    progress,
    size_of,
)
from raytrace.cluster import cluster
from raytrace.errors import InputError
from raytrace.glsl.matching import parse_uniforms
from raytrace.image import file_format, image_file
from raytrace.rendering import Rendering
from raytrace.report import pixel_report
from raytrace.scene import load_scene
from raytrace.scene.toml import DEFAULT_SCENE

__all__ = ["pixel", "render"]


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
    shadow_start: ShadowStart = "offset",
    antialias: Antialias = "none",
    exact_inputs: ExactInputs = False,
    skip: Skip = True,
    shader: Shader = None,
    uniforms: ShaderUniforms = [],  # noqa: B006
    time_limit: TimeLimit = 60.0,
    cache: Annotated[bool, typer.Option("--cache/--no-cache", help="Keep compiled programs for the next time.")] = True,
    coordinator: Annotated[
        str | None, typer.Option(help="HOST:PORT of process 0, where several processes render one image.")
    ] = None,
    hosts: Annotated[int | None, typer.Option(min=1, help="How many processes there are.")] = None,
    process_id: Annotated[int | None, typer.Option(min=0, help="Which of them this is; 0 writes the file.")] = None,
    scheduled: Annotated[
        bool, typer.Option("--cluster", help="The same, as the cluster's scheduler says: Slurm, MPI, Kubernetes.")
    ] = False,
) -> None:
    """Render a scene to an image file."""
    out = out or Path(f"{Path(scene).stem}.png")
    together = scheduled or any(value is not None for value in (coordinator, hosts, process_id))
    if together and backend != "jax":
        raise InputError(f"backend {backend}: only jax renders on several hosts")
    with (
        _programs(backend, cache),
        cluster(coordinator, hosts, process_id) if together else nullcontext(True) as writes,
    ):
        rendering = Rendering(
            load_scene(scene, changes),
            size_of(size),
            backend=backend,
            dtype=dtype,
            samples=samples,
            output=output or file_format(out).output,
            intersection=intersection,
            shadow_start=shadow_start,
            antialias=antialias,
            exact_inputs=exact_inputs,
            skip=skip,
            shader=shader,
            uniforms=parse_uniforms(uniforms),
            time_limit=time_limit,
        )
        if writes:
            _to_file(rendering, out, bits)
        else:
            rendering.compile()
            for _ in rendering.bands():
                pass  # process 0 has it too


def _programs(backend: str, cache: bool) -> AbstractContextManager:
    """Whether compiled programs are kept on disk; only JAX has any."""
    if cache or backend != "jax":
        return nullcontext()
    from raytrace.backends.jax.stored import not_stored

    return not_stored()


def _to_file(rendering: Rendering, out: Path, bits: int | None) -> None:
    """Renders band by band, each of which is written before the next, and says how long it took."""
    width, height, _ = rendering.frame
    seconds = 0.0
    with (
        image_file(out, (width, height), output=rendering.output, bits=bits, metadata=rendering.metadata()) as file,
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
    print(f"{out}: {width}x{height}, {rendering.backend} {rendering.dtype}, rendered in {seconds:.3f} s{compiled}")


def pixel(
    scene: Scene,
    x: Annotated[int, typer.Argument(help="Column, from 0 on the left.")],
    y: Annotated[int, typer.Argument(help="Row, from 0 on top.")],
    size: Size = "1920x1080",
    backend: BackendName = "numpy",
    dtype: Dtype = "float64",
    changes: Changes = [],  # noqa: B006
    intersection: Intersection = None,
    shadow_start: ShadowStart = "offset",
    exact_inputs: ExactInputs = False,
) -> None:
    """Print every step of the shader at one pixel, beside its line of GLSL."""
    rendering = Rendering(
        load_scene(scene, changes),
        size_of(size),
        backend=backend,
        dtype=dtype,
        output="steps",
        intersection=intersection,
        shadow_start=shadow_start,
        exact_inputs=exact_inputs,
    )
    print(pixel_report(rendering, x, y))
