"""The ways to render a scene that are compared with each other."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, NamedTuple

from raytrace.errors import EngineFailure, InputError
from raytrace.rendering import Options, Rendering, render
from raytrace.scene.data import Scene
from raytrace.scene.toml import as_scene
from raytrace.studies.bench.peers import installed

__all__ = ["QUERIES", "Contender", "contenders", "mitsuba_frame", "plain_jit"]

#: What Mitsuba is timed at: not an image.
QUERIES = "mitsuba: hits and shadows only"


class Contender(NamedTuple):
    """A function that makes one frame; `image` says whether it gives the image, to be held against the exact one."""

    name: str
    frame: Callable[[], Any]
    image: bool = True


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
        ("opengl", lambda: [_engine(scene, size, "opengl")]),
        ("webgl", lambda: [_engine(scene, size, "webgl")]),
        ("mitsuba", lambda: [Contender(QUERIES, mitsuba_frame(scene, size)[0], image=False)]),
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


def mitsuba_frame(scene: Scene, size: tuple[int, int]) -> tuple[Callable[[], Any], float]:
    """Mitsuba's queries, and the milliseconds that it took to build its structures.

    Raises:
        InputError: it is not installed.
    """
    if not installed("mitsuba"):
        raise InputError("not installed: pip install '.[bench]'")
    from raytrace.studies.bench.peers.mitsuba_queries import built, queries

    world, milliseconds = built(scene)
    return queries(scene, size, world), milliseconds


def _engine(scene: Scene, size: tuple[int, int], backend: str) -> Contender:
    if find_spec({"opengl": "moderngl", "webgl": "playwright"}[backend]) is None:
        raise InputError("not installed: pip install '.[gpu-backends]'")
    render(scene, (8, 8), backend=backend)  # is the engine there?
    return Contender(backend, lambda: render(scene, size, backend=backend))


def _numba(scene: Scene, size: tuple[int, int]) -> list[Contender]:
    if not installed("numba"):
        raise InputError("not installed: pip install '.[bench]'")
    from raytrace.studies.bench.peers.numba_loop import frame

    return [
        Contender(f"numba loop{', fastmath' if fastmath else ''}", frame(scene, size, fastmath))
        for fastmath in (False, True)
    ]
