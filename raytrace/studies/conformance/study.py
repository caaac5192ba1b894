"""The study: random scenes, drawn by every engine and held against the bounds."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from raytrace.certificates import certify, verify
from raytrace.errors import InputError
from raytrace.rendering import render
from raytrace.scene import Scene, load_scene
from raytrace.scene import scenes as built_in_scenes
from raytrace.studies.conformance.scenes import STRUCTURES, Structure, random_scene

__all__ = ["ENGINES", "Result", "study"]

#: What draws, in float32.
ENGINES = ("opengl", "webgl", "numpy", "jax")
#: One of the sides is odd, and few pixels are enough: the numbers are random.
SIZE, BUILT_IN_SIZE = (24, 15), (48, 27)
KINDS = ("display", "linear")


class Result(NamedTuple):
    """scenes, images, pixels: how many were drawn and verified.
    outside: a line for each image that has pixels outside its bounds. wide: the share of pixels whose bounds are wider
    than 1/255 in some channel. missing: engines that are not installed, and what they need.
    """

    scenes: int
    images: int
    pixels: int
    outside: tuple[str, ...]
    wide: float
    missing: dict[str, str]


class _Case(NamedTuple):
    name: str
    scene: Scene
    intersection: str | None
    size: tuple[int, int]


def study(
    scenes: int = 200,
    seed: int = 0,
    *,
    built_in: bool = False,
    engines: tuple[str, ...] = ENGINES,
    structures: tuple[Structure, ...] = STRUCTURES,
    done: Callable[[int], None] = lambda scenes: None,
) -> Result:
    """Draw random scenes with each engine in float32, as display and as linear values, and verify the images.

    seed: scene i of a seed is always the same. built_in: whether the built-in scenes are drawn, too. structures: random
    scene i has number i of them, counted round and round. done: is told of each scene.
    """
    images, pixels, outside, wide, missing = 0, 0, [], [], {}
    drew: set[str] = set()
    cases = [*_random(scenes, seed, structures), *(_built_in() if built_in else ())]
    for case in cases:
        certificate = certify(case.scene, case.size, precision="glsl-highp", intersection=case.intersection or "either")
        wide.append((certificate.width > 1 / 255).mean())
        for engine in engines:
            if engine in missing:
                continue
            try:
                drawn = list(_drawn(case, engine))
            except InputError as error:
                if engine in drew:
                    raise
                missing[engine] = str(error)
                continue
            drew.add(engine)
            for kind, image in drawn:
                found = verify(image, certificate, kind)
                images, pixels = images + 1, pixels + found.by.size
                if not found.inside:
                    outside.append(f"{case.name}, {engine}, {kind}: {str(found).splitlines()[0]}")
        done(1)
    return Result(len(cases), images, pixels, tuple(outside), float(np.mean(wide)), missing)


def _random(scenes: int, seed: int, structures: tuple[Structure, ...]) -> Iterator[_Case]:
    for i in range(scenes):
        structure = structures[i % len(structures)]
        scene = random_scene(np.random.default_rng([seed, i]), structure)
        yield _Case(f"scene {i} of seed {seed}", scene, structure.intersection, SIZE)


def _built_in() -> Iterator[_Case]:
    return (_Case(name, load_scene(name), None, BUILT_IN_SIZE) for name in built_in_scenes())


def _drawn(case: _Case, engine: str) -> Iterator[tuple[str, np.ndarray]]:
    """Yield display and linear values; where a program is compiled for seconds, both of one program."""
    options = {"backend": engine, "dtype": "float32", "intersection": case.intersection}
    if engine == "jax":
        steps = render(case.scene, case.size, output="steps", **options)
        yield from ((kind, np.asarray(steps[kind], np.float64)) for kind in KINDS)
    else:
        for kind in KINDS:
            yield kind, np.asarray(render(case.scene, case.size, output=kind, **options), np.float64)
