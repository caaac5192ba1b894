"""Commands that render: `render` and `pixel`."""

import time
from pathlib import Path
from typing import Annotated

import typer

from raytrace.cli.options import (
    BackendName,
    Changes,
    Dtype,
    ExactInputs,
    Intersection,
    Scene,
    Shader,
    ShaderUniforms,
    Size,
    TimeLimit,
    progress,
    size_of,
)
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
    exact_inputs: ExactInputs = False,
    shader: Shader = None,
    uniforms: ShaderUniforms = [],  # noqa: B006
    time_limit: TimeLimit = 60.0,
) -> None:
    """Render a scene to an image file."""
    out = out or Path(f"{Path(scene).stem}.png")
    rendering = Rendering(
        load_scene(scene, changes),
        size_of(size),
        backend=backend,
        dtype=dtype,
        samples=samples,
        output=output or file_format(out).output,
        intersection=intersection,
        exact_inputs=exact_inputs,
        shader=shader,
        uniforms=parse_uniforms(uniforms),
        time_limit=time_limit,
    )
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
    print(f"{out}: {width}x{height}, {backend} {dtype}, rendered in {seconds:.3f} s{compiled}")


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
        size_of(size),
        backend=backend,
        dtype=dtype,
        output="steps",
        intersection=intersection,
        exact_inputs=exact_inputs,
    )
    print(pixel_report(rendering, x, y))
