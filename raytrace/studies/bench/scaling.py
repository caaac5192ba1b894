"""Run time against work: more spheres, more pixels, more devices."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from raytrace.cores import cores
from raytrace.errors import EngineFailure, InputError
from raytrace.files import save_figure
from raytrace.rendering import Options, Rendering, render
from raytrace.scene.data import Scene
from raytrace.scene.toml import DEFAULT_SCENE
from raytrace.studies.bench.contenders import mitsuba_frame
from raytrace.studies.bench.crowds import crowd
from raytrace.studies.bench.timing import Timing, in_turn

__all__ = ["KINDS", "Point", "plot", "scaling"]

SPHERES = (1, 6, 200, 1_000, 10_000, 100_000)
WIDTHS = (240, 480, 960, 1920, 3840)


class Point(NamedTuple):
    """`work` spheres, pixels or devices. `preparation`: what comes once for a scene, in milliseconds."""

    work: int
    name: str
    timing: Timing
    preparation: float | None = None


def by_spheres(size: tuple[int, int], runs: int) -> Iterator[Point]:
    """Frames with more and more spheres, and Mitsuba's queries beside them."""
    for n in SPHERES:
        scene = crowd(n)
        # As `render` does it when a scene is new.
        frames: dict[str, Any] = {"jax float32": lambda scene=scene: render(scene, size)}
        prepared: dict[str, float] = {}
        with suppress(InputError):
            frames["mitsuba queries"], prepared["mitsuba queries"] = mitsuba_frame(scene, size)
        timings = in_turn(frames, runs)
        prepared["jax float32"] = preparation(scene, size)
        for name, timing in timings.items():
            yield Point(n, name, timing, prepared[name])


def preparation(scene: Scene, size: tuple[int, int], runs: int = 3) -> float:
    """Return the median milliseconds of preparing a scene that was not the last one; compiled before."""
    other = replace(scene, sun=replace(scene.sun, direction=scene.sun.direction + np.array([0.1, 0, 0])))
    mine, others = (cast(Any, Rendering(Options(one, size)).renderer) for one in (scene, other))
    times = []
    for _ in range(runs + 1):
        others.prepare()
        start = time.perf_counter()
        mine.prepare()
        times.append(1e3 * (time.perf_counter() - start))
    return sorted(times[1:])[runs // 2]


def by_pixels(size: tuple[int, int], runs: int) -> Iterator[Point]:
    """Larger and larger images of the default scene, of the aspect of `size`."""
    for width in WIDTHS:
        shape = width, round(width * size[1] / size[0])
        frames = {
            "jax float32": lambda shape=shape: render(DEFAULT_SCENE, shape),
            "numpy float64": lambda shape=shape: render(DEFAULT_SCENE, shape, backend="numpy", dtype="float64"),
        }
        for name, timing in in_turn(frames, runs).items():
            yield Point(shape[0] * shape[1], name, timing)


def by_devices(size: tuple[int, int], runs: int) -> Iterator[Point]:
    """The default scene on 1, 2, ... devices, up to twice as many as there are cores, each in a process of its own."""
    code = (
        "import json, sys, jax; n, width, height, runs = map(int, sys.argv[1:])\n"
        "jax.config.update('jax_num_cpu_devices', n)\n"
        "from raytrace.studies.bench.timing import in_turn; from raytrace.rendering import render\n"
        f"timing = in_turn({{'jax': lambda: render({DEFAULT_SCENE!r}, (width, height))}}, runs)['jax']\n"
        "print(json.dumps(timing))"
    )
    for n in sorted({2**k for k in range(8) if 2**k <= 2 * cores()} | {cores()}):
        command = [sys.executable, "-P", "-c", code, *map(str, (n, *size, runs))]
        ended = subprocess.run(command, capture_output=True, text=True, env=os.environ)
        if ended.returncode:
            raise EngineFailure(f"{n} devices: {ended.stderr.strip().splitlines()[-1]}")
        yield Point(n, "jax float32", Timing(*json.loads(ended.stdout)))


KINDS = {"spheres": by_spheres, "pixels": by_pixels, "devices": by_devices}


def scaling(kind: str, size: tuple[int, int], runs: int) -> Iterator[Point]:
    """The points of one kind, as they are measured."""
    return KINDS[kind](size, runs)


def plot(points: list[Point], kind: str, path: Path) -> None:
    """Writes time against work, both scales logarithmic; what is prepared once as dashes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.subplots()
    for color, name in enumerate(dict.fromkeys(point.name for point in points)):
        mine = [point for point in points if point.name == name]
        work = [point.work for point in mine]
        medians = [point.timing.median for point in mine]
        spread = [
            [point.timing.median - point.timing.fastest for point in mine],
            [point.timing.slowest - point.timing.median for point in mine],
        ]
        axes.errorbar(work, medians, yerr=spread, fmt="o-", color=f"C{color}", capsize=2, label=f"{name}, a frame")
        if mine[0].preparation is not None:
            once = [point.preparation or 0.0 for point in mine]
            axes.plot(work, once, "o--", color=f"C{color}", markersize=3, label=f"{name}, once for a scene")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(kind)
    axes.set_ylabel("milliseconds (median; bars: fastest and slowest)")
    axes.grid(which="major", color="0.9")
    axes.legend()
    save_figure(figure, path, 120)
