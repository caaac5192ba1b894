"""The ways to render a scene that are compared with each other."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from raytrace.errors import EngineFailure, InputError
from raytrace.rendering import Options, Rendering, render
from raytrace.scene.data import Scene
from raytrace.scene.toml import as_scene
from raytrace.studies.bench.peers import installed

__all__ = ["Contender", "contenders", "drawing_frame", "drjit_frame", "mitsuba_frame", "plain_jit"]

#: What Mitsuba is timed at: not an image. Planes are rectangles there, or are solved by hand.
QUERIES, BY_HAND = "mitsuba: hits and shadows only", "mitsuba: the same, planes by hand"
#: What a program takes that draws on OpenGL and shows the picture, instead of reading it back.
DRAWING = "opengl, drawing alone"


class Contender(NamedTuple):
    """A function that makes one frame.

    image: gives the image of what that returns, to be held against the exact one; ``None`` where there is none.
    """

    name: str
    frame: Callable[[], Any]
    image: Callable[[Any], Any] | None = lambda image: image


def contenders(scene: Scene | str, size: tuple[int, int]) -> tuple[list[Contender], list[str]]:
    """All that can run here, and for each that cannot a line that says why."""
    scene = as_scene(scene)

    def ours(name: str, **how: Any) -> Contender:
        return Contender(name, lambda: render(scene, size, **how))

    found = [ours(f"numpy {dtype}", backend="numpy", dtype=dtype) for dtype in ("float32", "float64", "longdouble")]
    for dtype in ("float32", "float64"):
        for intersection in ("textbook", "robust"):
            how = {"dtype": dtype, "intersection": intersection}
            found.append(ours(f"jax {dtype} {intersection}", **how))
            found.append(ours(f"jax {dtype} {intersection}, no skip", **how, skip=False))
    found.append(Contender("jax float32 in one plain jit", plain_jit(scene, size)))
    missing = []
    for name, make in (
        ("opengl", lambda: [Contender(DRAWING, drawing_frame(scene, size), image=None)]),
        ("opengl", lambda: [_engine(scene, size, "opengl")]),
        ("webgl", lambda: [_engine(scene, size, "webgl")]),
        ("drjit", lambda: [_drjit(scene, size)]),
        ("mitsuba", lambda: _mitsuba(scene, size)),
        ("numba", lambda: _numba(scene, size)),
    ):
        try:
            found += make()
        except (InputError, EngineFailure, ImportError) as error:
            missing.append(f"{name}: {error}")
    return found, missing


def plain_jit(scene: Scene | str, size: tuple[int, int]) -> Callable[[], Any]:
    """The default arithmetic with everything in one program, as `jax.jit` alone makes it."""
    from raytrace.backends.jax import OneProgram

    return Rendering(Options(scene, size, engine=OneProgram())).whole


def mitsuba_frame(scene: Scene, size: tuple[int, int], rectangles: bool = True) -> tuple[Callable[[], Any], float]:
    """Return Mitsuba's queries, and the milliseconds that it took to build its structures.

    rectangles: whether planes are shapes of its own, or are solved by hand.

    Raises:
        InputError: it is not installed.
    """
    _needs("mitsuba")
    from raytrace.studies.bench.peers.mitsuba_queries import built, queries

    world, milliseconds = built(scene, rectangles)
    return queries(scene, size, world, rectangles), milliseconds


def drjit_frame(scene: Scene, size: tuple[int, int]) -> Callable[[], Any]:
    """Return the whole picture as one kernel of Dr.Jit's.

    Raises:
        InputError: it is not installed, or the scene has too many spheres to write out.
    """
    _needs("drjit")
    from raytrace.studies.bench.peers.drjit_kernel import frame

    return frame(scene, size)


def drawing_frame(scene: Scene, size: tuple[int, int]) -> Callable[[], Any]:
    """Return the picture as a program with an OpenGL context draws it, without reading it back.

    Raises:
        InputError: moderngl or a driver is not installed.
    """
    _needs("moderngl", "gpu-backends")
    from raytrace.studies.bench.peers.drawing import drawing

    return drawing(scene, size)


def _needs(module: str, extra: str = "bench") -> None:
    if not installed(module):
        raise InputError(f"not installed: pip install '.[{extra}]'")


def _drjit(scene: Scene, size: tuple[int, int]) -> Contender:
    def image(planes: tuple) -> np.ndarray:
        return np.stack([np.array(plane) for plane in planes], axis=-1).reshape(*size[::-1], 3)

    return Contender("drjit, one kernel", drjit_frame(scene, size), image)


def _mitsuba(scene: Scene, size: tuple[int, int]) -> list[Contender]:
    return [
        Contender(name, mitsuba_frame(scene, size, rectangles)[0], image=None)
        for name, rectangles in ((QUERIES, True), (BY_HAND, False))
    ]


def _engine(scene: Scene, size: tuple[int, int], backend: str) -> Contender:
    _needs({"opengl": "moderngl", "webgl": "playwright"}[backend], "gpu-backends")
    render(scene, (8, 8), backend=backend)  # is the engine there?
    return Contender(f"{backend}, with reading back", lambda: render(scene, size, backend=backend))


def _numba(scene: Scene, size: tuple[int, int]) -> list[Contender]:
    _needs("numba")
    from raytrace.studies.bench.peers.numba_loop import frame

    return [
        Contender(f"numba loop{', fastmath' if fastmath else ''}", frame(scene, size, fastmath))
        for fastmath in (False, True)
    ]
