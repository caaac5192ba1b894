"""What several commands share: options and sizes."""

import inspect
import os
from collections.abc import Callable, Iterable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, get_args, get_type_hints

import typer

from raytrace.errors import InputError
from raytrace.rendering import Options, check_size
from raytrace.scene import Scene as SceneOf
from raytrace.scene import load_scene

__all__ = [
    "STANDARD_OUTPUT",
    "Changes",
    "Layer",
    "Require",
    "Scene",
    "Size",
    "check_outputs",
    "scene_if_given",
    "size_of",
    "taking_options",
]

#: The name of an output that is no file.
STANDARD_OUTPUT = "-"

Scene = Annotated[str, typer.Argument(help="A built-in scene's name (see 'raytrace scenes') or a TOML file.")]
Size = Annotated[str, typer.Option(help="WIDTHxHEIGHT in pixels.")]
Changes = Annotated[list[str], typer.Option("--set", help="key=value, such as sun.direction=[0,1,0]; repeatable.")]

Require = Annotated[
    list[str],
    typer.Option(
        help="METRIC>=NUMBER or METRIC<=NUMBER, such as 'ssim>=0.9999', or exit code 1; repeatable. "
        "ssim, worst-ssim, psnr; rmse, difference, share, delta-e, delta-e-999, flip, flip-999."
    ),
]

Layer = Annotated[str | None, typer.Option(help="Which layer, or part, of an EXR with several is the picture.")]

#: Those of `Options` that a command line has to write otherwise: their type, their default, their flags.
_WRITTEN: dict[str, tuple[Any, Any, tuple[str, ...]]] = {
    "size": (str, "x".join(map(str, Options.size)), ("--size",)),
    "shader": (Path | None, None, ("--shader",)),
    "uniforms": (list[str], [], ("--uniform",)),
    "skip": (bool, True, ("--skip/--no-skip",)),
    "exact_inputs": (bool, False, ("--exact-inputs",)),
}


def taking_options(*names: str, **defaults: Any) -> Callable[[Callable], Callable]:
    """Decorate a command that has an argument `options`, an `Options`, so that it has a flag for each of those fields.

    names: the fields. defaults: of those that have another default in this command. The scene is left to the command.
    """
    hints = get_type_hints(Options, include_extras=True)
    usual = inspect.signature(Options).parameters

    def parameter(name: str) -> inspect.Parameter:
        kind, help_text = get_args(hints[name])
        kind, default, flags = _WRITTEN.get(name, (kind, usual[name].default, (f"--{name.replace('_', '-')}",)))
        default = defaults.get(name, default)
        annotation = Annotated[kind | None if default is None else kind, typer.Option(*flags, help=help_text)]
        return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)

    def decorated(command: Callable) -> Callable:
        @wraps(command)
        def with_flags(**given: Any) -> None:
            chosen = {name: given.pop(name) for name in names}
            read = {"size": size_of, "uniforms": _uniforms_of}
            return command(
                options=Options(**{name: read[name](text) if name in read else text for name, text in chosen.items()}),
                **given,
            )

        parameters = []
        for own in inspect.signature(command).parameters.values():
            flags = map(parameter, names) if own.name == "options" else [own]
            parameters += [flag.replace(kind=inspect.Parameter.KEYWORD_ONLY) for flag in flags]
        with_flags.__signature__ = inspect.Signature(parameters)  # pyright: ignore[reportAttributeAccessIssue]
        with_flags.__annotations__ = {each.name: each.annotation for each in parameters}
        return with_flags

    return decorated


def check_outputs(outputs: Iterable[Path | None], inputs: Iterable[str | Path | None]) -> None:
    """Check that no file that is to be written is one that is read.

    Raises:
        InputError: one is.
    """
    given = [path for path in inputs if path is not None and os.path.isfile(path)]
    for out in outputs:
        if out is not None and out.exists() and any(os.path.samefile(out, path) for path in given):
            raise InputError(f"{out}: is an input, too; give the output another name")


def _uniforms_of(texts: list[str]) -> dict[str, Any]:
    if not texts:
        return {}
    from raytrace.glsl.matching import parse_uniforms

    return parse_uniforms(texts)


def scene_if_given(scene: str | None, changes: list[str]) -> SceneOf | None:
    """Return the scene of an option, with changes; ``None`` where there is neither.

    Raises:
        InputError: there are changes and no scene; or the scene is wrong.
    """
    if changes and scene is None:
        raise InputError("--set: changes a scene; give one (--scene)")
    return None if scene is None else load_scene(scene, changes)


def size_of(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        size = int(width), int(height)
    except ValueError:
        raise InputError(f"size: must be WIDTHxHEIGHT, such as 1920x1080, found {text!r}") from None
    check_size(size)
    return size
