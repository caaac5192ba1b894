"""The figures that this project set itself: ratios of medians, measured in turn in one run, and errors."""

from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from typing import Any, NamedTuple

from raytrace.errors import EngineFailure, InputError
from raytrace.notebook import view
from raytrace.rendering import render
from raytrace.scene.toml import DEFAULT_SCENE, load_scene
from raytrace.studies.bench.accuracy import reference
from raytrace.studies.bench.contenders import drawing_frame, drjit_frame, mitsuba_frame, plain_jit
from raytrace.studies.bench.crowds import crowd, field
from raytrace.studies.bench.scaling import preparation
from raytrace.studies.bench.timing import REST, in_turn

__all__ = ["Figure", "figures"]


class Figure(NamedTuple):
    """What is measured, what was reached and what was to be reached at most; `detail` says of what the ratio is."""

    name: str
    reached: float
    at_most: float
    detail: str


Frames = dict[str, Callable[[], Any]]


class Run(NamedTuple):
    """How everything is timed: the pictures' size, how many frames, and the seconds of rest before each."""

    size: tuple[int, int]
    runs: int
    rest: float

    def ratios(self, frames: Frames, asked: list[tuple[str, str, str, float]]) -> Iterator[Figure]:
        """Return the ratios asked for as (name, numerator, denominator, at most)."""
        timings = in_turn(frames, self.runs, rest=self.rest)
        for name, a, b, at_most in asked:
            over, under = timings[a].median, timings[b].median
            yield Figure(name, over / under, at_most, f"{over:.1f} / {under:.1f} ms")


def figures(size: tuple[int, int], runs: int, rest: float = REST) -> Iterator[Figure | str]:
    """Return the figures, and for those that cannot be had here a line that says why."""
    run = Run(size, runs, rest)
    for part in (_default_scene, _many_spheres, _gradient, _numpy, _view, _errors):
        try:
            yield from part(run)
        except (InputError, EngineFailure, ImportError) as error:
            yield f"{part.__doc__} {error}"


def _default_scene(run: Run) -> Iterator[Figure | str]:
    """The default scene:"""
    scene, size = load_scene(DEFAULT_SCENE), run.size
    frames: Frames = {
        "jax32": lambda: render(scene, size),
        "jax64": lambda: render(scene, size, dtype="float64"),
        "skybox": lambda: render("skybox", size),
        "plain": plain_jit(scene, size),
    }
    asked = [
        ("JAX float32 / the same text under one plain jit", "jax32", "plain", 1 / 12),
        ("skybox / default scene", "skybox", "jax32", 0.35),
    ]
    peers: list[tuple[str, Callable[[], Callable], list[tuple[str, str, float]]]] = [
        (
            "drjit",
            lambda: drjit_frame(scene, size),
            [
                ("JAX float32 / one kernel of Dr.Jit's", "jax32", 1.8),
                ("skybox / one kernel of Dr.Jit's of the default scene", "skybox", 1.0),
            ],
        ),
        (
            "drawing",
            lambda: drawing_frame(scene, size),
            [("JAX float32 / OpenGL's drawing alone", "jax32", 0.65), ("JAX float64 / the same", "jax64", 1.5)],
        ),
        (
            "mitsuba",
            lambda: mitsuba_frame(scene, size)[0],
            [("JAX float32, whole frame / Mitsuba's queries, a rectangle for the plane", "jax32", 1.2)],
        ),
    ]
    missing = []
    for peer, make, ratios in peers:
        try:
            frames[peer] = make()
        except (InputError, EngineFailure, ImportError) as error:
            missing.append(f"{peer}: {error}")
            continue
        asked += [(name, ours, peer, at_most) for name, ours, at_most in ratios]
    yield from run.ratios(frames, asked)
    yield from missing


def _many_spheres(run: Run) -> Iterator[Figure]:
    """Many spheres:"""
    for name, world, n, rectangles, at_most in (
        ("a crowd", crowd, 1_000, True, 1.2),
        ("a crowd", crowd, 100_000, True, 0.8),
        ("a field", field, 1_000, False, 2.5),
        ("a field", field, 100_000, False, 1.2),
    ):
        scene = world(n)
        queries, building = mitsuba_frame(scene, run.size, rectangles)
        frames: Frames = {"jax32": lambda scene=scene: render(scene, run.size), "mitsuba": queries}
        planes = "a rectangle for the plane" if rectangles else "the plane by hand"
        asked = [(f"{name} of {n:,}: whole frame / Mitsuba's queries, {planes}", "jax32", "mitsuba", at_most)]
        yield from run.ratios(frames, asked)
        if world is crowd and n == 100_000:
            ours = preparation(scene, run.size)
            detail = f"{ours:.0f} / {building:.0f} ms"
            yield Figure(f"{name} of {n:,}: preparation / Mitsuba's build", ours / building, 0.02, detail)


def _gradient(run: Run) -> Iterator[Figure]:
    """The gradient:"""
    import jax

    scene = load_scene(DEFAULT_SCENE)

    def brightness(direction: jax.Array) -> jax.Array:
        return render(scene.with_("sun.direction", direction), run.size).mean()

    direction = jax.numpy.array(scene.sun.direction, "float32")
    both, forward = jax.jit(jax.value_and_grad(brightness)), jax.jit(brightness)
    frames: Frames = {
        "both": lambda: both(direction)[1],
        "forward": lambda: forward(direction),
        "render": lambda: render(scene, run.size),
    }
    asked = [
        ("value and gradient for the sun / forward, both of a traced scene", "both", "forward", 2.5),
        ("forward of a traced scene / raytrace.render", "forward", "render", 1.3),
    ]
    yield from run.ratios(frames, asked)


def _numpy(run: Run) -> Iterator[Figure]:
    """NumPy:"""
    frames: Frames = {
        "numpy": lambda: render(DEFAULT_SCENE, run.size, backend="numpy", dtype="float64"),
        "jax64": lambda: render(DEFAULT_SCENE, run.size, dtype="float64"),
    }
    yield from run.ratios(frames, [("NumPy float64 / JAX float64", "numpy", "jax64", 6.0)])


def _view(run: Run) -> Iterator[Figure]:
    """The view:"""
    # Outside a notebook jupyter_rfb prints what would be shown.
    with redirect_stdout(None):
        seen = view(DEFAULT_SCENE, samples=1)

    def dragged() -> Any:
        seen.orbit(0.01, 0.0)
        return seen.frame()

    median = in_turn({"view": dragged}, run.runs, rest=run.rest)["view"].median
    yield Figure("raytrace.view, 640x360: ms from a drag to its picture", median, 50, f"{1e3 / median:.0f} a second")


def _errors(run: Run) -> Iterator[Figure]:
    """Errors:"""
    exact = reference(DEFAULT_SCENE, run.size)
    errors = exact.errors(render(DEFAULT_SCENE, run.size, intersection="robust"))
    detail = f"against NumPy {exact.dtype}, off discontinuities"
    yield Figure("JAX float32 robust, 99.9th percentile of the error", errors.percentile_999, 2e-6, detail)
    yield Figure("JAX float32 robust, largest error", errors.largest, 5e-5, detail)
