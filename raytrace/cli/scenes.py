"""Commands that tell of scenes: `scenes` and `show`."""

import json
from typing import Annotated

import typer

from raytrace.cli.options import Changes, Scene, Size, size_of
from raytrace.export.numbers import uniforms_report
from raytrace.scene import load_scene, scene_toml, scenes
from raytrace.scene.toml import DEFAULT_SCENE

__all__ = ["list_scenes", "show"]


def list_scenes() -> None:
    """List the built-in scenes."""
    known = scenes()
    for name, comment in known.items():
        print(f"{name:{max(map(len, known))}}  {comment}")


def show(
    scene: Scene = DEFAULT_SCENE,
    as_json: Annotated[bool, typer.Option("--json", help="The uniforms, by the assignment's names, as JSON.")] = False,
    size: Size = "1920x1080",
    changes: Changes = [],  # noqa: B006
) -> None:
    """Print a scene as TOML, or as the uniforms of a shader."""
    loaded = load_scene(scene, changes)
    print(json.dumps(uniforms_report(loaded, size_of(size)), indent=1) if as_json else scene_toml(loaded).rstrip())
