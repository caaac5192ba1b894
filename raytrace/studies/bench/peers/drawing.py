"""The assignment's GLSL as a program that has its own OpenGL context draws it: to the end, and nothing read back."""

import atexit
from collections.abc import Callable
from dataclasses import replace
from itertools import cycle
from typing import Any, cast

from raytrace.backends.gpu.drawing import Unavailable
from raytrace.backends.gpu.opengl import OpenGL
from raytrace.errors import InputError
from raytrace.rendering import Options, Rendering
from raytrace.scene.data import Scene

__all__ = ["drawing"]


def drawing(scene: Scene, size: tuple[int, int]) -> Callable[[], None]:
    """Return a function that draws the picture once more, on OpenGL and in this process, and waits for its end.

    Raises:
        InputError: moderngl, or a driver, is not installed.
    """
    renderer = cast(Any, Rendering(Options(scene, size, backend="opengl")).renderer)
    asked = renderer.drawing(0, size[1])
    try:
        engine = OpenGL()
    except Unavailable as error:
        raise InputError(f"opengl: {error}") from None
    # One pass after the other, without an end.
    passes = engine.drawn(replace(asked, passes=cast(Any, cycle(asked.passes))))
    atexit.register(passes.close)

    def frame() -> None:
        next(passes)
        engine.finish()

    return frame
