"""The figures that this project set itself: ratios of medians, measured in turn in one run, and errors."""

from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from typing import Any, NamedTuple

from raytrace.errors import EngineFailure, InputError
from raytrace.notebook import view
from raytrace.rendering import render
from raytrace.scene.sun import lit_from
from raytrace.scene.toml import DEFAULT_SCENE, load_scene
from raytrace.studies.bench.accuracy import reference
from raytrace.studies.bench.contenders import mitsuba_frame, plain_jit
from raytrace.studies.bench.crowds import crowd
from raytrace.studies.bench.scaling import preparation
from raytrace.studies.bench.timing import in_turn

__all__ = ["Figure", "figures"]


class Figure(NamedTuple):
    """What is measured, what was reached and what was to be reached at most; `detail` says of what the ratio is."""

    name: str
    reached: float
    at_most: float
    detail: str


Frames = dict[str, Callable[[], Any]]


def figures(size: tuple[int, int], runs: int) -> Iterator[Figure | str]:
    """The figures, and for those that cannot be had here a line that says why."""
    for part in (_default_scene, _crowds, _gradient, _skybox, _numpy, _view, _errors):
        try:
            yield from part(size, runs)
        except (InputError, EngineFailure, ImportError) as error:
            yield f"{part.__doc__} {error}"


def _ratios(frames: Frames, runs: int, asked: list[tuple[str, str, str, float]]) -> Iterator[Figure]:
    """The ratios asked for as (name, numerator, denominator, at most)."""
    timings = in_turn(frames, runs)
    for name, a, b, at_most in asked:
        over, under = timings[a].median, timings[b].median
        yield Figure(name, over / under, at_most, f"{over:.1f} / {under:.1f} ms")


def _default_scene(size: tuple[int, int], runs: int) -> Iterator[Figure]:
    """The default scene:"""
    scene = load_scene(DEFAULT_SCENE)
    frames: Frames = {
        "jax32": lambda: render(scene, size),
        "jax64": lambda: render(scene, size, dtype="float64"),
        "plain": plain_jit(scene, size),
    }
    asked = [("JAX float32 / the same text under one plain jit", "jax32", "plain", 1 / 12)]
    missing = []
    try:
        render(scene, (8, 8), backend="opengl")
        frames["opengl"] = lambda: render(scene, size, backend="opengl")
        asked += [
            ("JAX float32 / opengl", "jax32", "opengl", 0.25),
            ("JAX float64 / opengl", "jax64", "opengl", 1.0),
        ]
    except (InputError, EngineFailure) as error:
        missing.append(f"opengl: {error}")
    try:
        frames["mitsuba"], _ = mitsuba_frame(scene, size)
        asked.append(("JAX float32, whole frame / Mitsuba's queries alone", "jax32", "mitsuba", 1.2))
    except InputError as error:
        missing.append(f"mitsuba: {error}")
    yield from _ratios(frames, runs, asked)
    yield from missing


def _crowds(size: tuple[int, int], runs: int) -> Iterator[Figure]:
    """Many spheres:"""
    for n, at_most in ((1_000, 1.2), (100_000, 0.8)):
        scene = crowd(n)
        queries, building = mitsuba_frame(scene, size)
        frames: Frames = {"jax32": lambda scene=scene: render(scene, size), "mitsuba": queries}
        name = f"{n:,} spheres: whole frame / Mitsuba's queries alone"
        yield from _ratios(frames, runs, [(name, "jax32", "mitsuba", at_most)])
        if n == 100_000:
            ours = preparation(scene, size)
            detail = f"{ours:.0f} / {building:.0f} ms"
            yield Figure(f"{n:,} spheres: preparation / Mitsuba's build", ours / building, 0.02, detail)


def _gradient(size: tuple[int, int], runs: int) -> Iterator[Figure]:
    """The gradient:"""
    import jax

    scene = load_scene(DEFAULT_SCENE)

    def brightness(direction: jax.Array) -> jax.Array:
        return render(lit_from(scene, direction), size).mean()

    direction = jax.numpy.array(scene.sun.direction, "float32")
    both, forward = jax.jit(jax.value_and_grad(brightness)), jax.jit(brightness)
    frames: Frames = {
        "both": lambda: both(direction)[1],
        "forward": lambda: forward(direction),
        "render": lambda: render(scene, size),
    }
    asked = [
        ("value and gradient for the sun / forward, both of a traced scene", "both", "forward", 2.5),
        ("value and gradient for the sun / raytrace.render", "both", "render", 2.5),
    ]
    yield from _ratios(frames, runs, asked)


def _skybox(size: tuple[int, int], runs: int) -> Iterator[Figure]:
    """The sky:"""
    frames: Frames = {name: lambda name=name: render(name, size) for name in ("skybox", "checkerboard")}
    yield from _ratios(frames, runs, [("skybox / checkerboard", "skybox", "checkerboard", 0.35)])


def _numpy(size: tuple[int, int], runs: int) -> Iterator[Figure]:
    """NumPy:"""
    frames: Frames = {
        "numpy": lambda: render(DEFAULT_SCENE, size, backend="numpy", dtype="float64"),
        "jax64": lambda: render(DEFAULT_SCENE, size, dtype="float64"),
    }
    yield from _ratios(frames, runs, [("NumPy float64 / JAX float64", "numpy", "jax64", 6.0)])


def _view(size: tuple[int, int], runs: int) -> Iterator[Figure]:
    """The view:"""
    # Outside a notebook jupyter_rfb prints what would be shown.
    with redirect_stdout(None):
        seen = view(DEFAULT_SCENE, samples=1)

    def dragged() -> Any:
        seen.orbit(0.01, 0.0)
        return seen.frame()

    median = in_turn({"view": dragged}, runs)["view"].median
    yield Figure("raytrace.view, 640x360: ms from a drag to its picture", median, 50, f"{1e3 / median:.0f} a second")


def _errors(size: tuple[int, int], runs: int) -> Iterator[Figure]:
    """Errors:"""
    exact = reference(DEFAULT_SCENE, size)
    errors = exact.errors(render(DEFAULT_SCENE, size, intersection="robust"))
    detail = f"against NumPy {exact.dtype}, off discontinuities"
    yield Figure("JAX float32 robust, 99.9th percentile of the error", errors.percentile_999, 2e-6, detail)
    yield Figure("JAX float32 robust, largest error", errors.largest, 5e-5, detail)
