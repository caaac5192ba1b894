"""The commands `export` and `view`."""

import sys
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from raytrace.cli.options import STANDARD_OUTPUT, Changes, Scene, Size, check_outputs, size_of
from raytrace.errors import check_choice
from raytrace.export import EXPORTS
from raytrace.files import whole_file
from raytrace.scene import load_scene
from raytrace.scene.toml import DEFAULT_SCENE
from raytrace.shader.sphere import INTERSECTIONS

__all__ = ["export", "view"]

_ENDINGS = {"glsl": ".frag", "shaderlabweb": ".frag", "html": ".html", "header": ".h", "wgsl-constants": ".wgsl"}


def export(
    scene: Scene = DEFAULT_SCENE,
    to: Annotated[
        str, typer.Option(help="glsl, shaderlabweb, html; its numbers: header (C), wgsl-constants.")
    ] = "glsl",
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="The file; - for standard output; default: SCENE.frag, .html, .h or .wgsl."),
    ] = None,
    size: Size = "1920x1080",
    changes: Changes = [],  # noqa: B006 (typer's way)
    intersection: Annotated[str, typer.Option(help="textbook or robust.")] = "textbook",
    data: Annotated[str, typer.Option(help="The scene's numbers as constants or uniforms (glsl).")] = "constants",
) -> None:
    """Write a scene as GLSL, as a web page, or as numbers in C or WGSL."""
    check_choice("--to", to, EXPORTS)
    check_choice("--intersection", intersection, INTERSECTIONS)
    check_choice("--data", data, ("constants", "uniforms"))
    out = out or Path(f"{Path(scene).stem}{_ENDINGS[to]}")
    check_outputs([out], [scene])
    text = EXPORTS[to](load_scene(scene, changes), size_of(size), intersection=intersection, data=data)
    if str(out) == STANDARD_OUTPUT:
        sys.stdout.write(text)
        return
    with whole_file(out) as temporary:
        temporary.write_text(text, encoding="utf-8")
    print(f"{out}: {scene} as {to}")


def view(
    scene: Scene = DEFAULT_SCENE,
    changes: Changes = [],  # noqa: B006
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Keep the page in this file; default: one that is temporary.")
    ] = None,
) -> None:
    """Open a scene in a browser, to turn it and move its sun."""
    import webbrowser

    loaded = load_scene(scene, changes)
    if out is None:
        # It has to outlive this process: the browser reads it later.
        out = Path(tempfile.mkdtemp(prefix="raytrace-")) / f"{Path(scene).stem}.html"
    check_outputs([out], [scene])
    with whole_file(out) as temporary:
        temporary.write_text(EXPORTS["html"](loaded, (1920, 1080)), encoding="utf-8")
    opened = webbrowser.open(out.resolve().as_uri())
    print(f"{out}: {scene}{'' if opened else '; no browser is found here, open the file in one'}")
