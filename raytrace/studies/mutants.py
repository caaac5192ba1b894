"""A mutation study: which mistakes do certified bounds find, and which do metrics with a threshold?

Every mistake is drawn in every scene, beside what correct engines print.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from raytrace.certificates import certify, verify
from raytrace.comparison.metrics import flip, largest_difference, pixels_over, psnr, similarity
from raytrace.errors import EngineFailure, InputError
from raytrace.export.shaders import glsl
from raytrace.files import temporary_folder
from raytrace.mistakes.mutations import MUTATIONS, Mutation
from raytrace.rendering import render
from raytrace.scene import Scene, load_scene

__all__ = ["DETECTORS", "SCENES", "Study", "study"]

#: Some mistakes show only with the camera inside a sphere, the sun in the picture, or coincident spheres.
SCENES = (
    "checkerboard",
    "sun-in-the-picture",
    "inside-a-sphere",
    "overlapping-spheres",
    "level-camera",
    "sun-below-the-horizon",
    "cut-by-the-plane",
    "skybox",
)
SIZE = (240, 135)
CORRECT = (("numpy", "float32"), ("jax", "float32"), ("jax", "float64"), ("opengl", "float32"), ("webgl", "float32"))

#: What each detector measures of an image and the reference; more is worse.
METRICS: dict[str, Callable[[np.ndarray, np.ndarray], float]] = {
    "SSIM": lambda a, b: 1 - _similarity(a, b),
    "FLIP": lambda a, b: flip(a, b).mean,
    "PSNR": lambda a, b: -psnr(a, b),
    "largest": lambda a, b: largest_difference(a, b).value,
    "share over 1/255": lambda a, b: float(pixels_over(a, b).mean()),
}
BOUNDS = "bounds"
DETECTORS = (BOUNDS, *METRICS)


def _similarity(a: np.ndarray, b: np.ndarray) -> float:
    found = similarity(a, b)
    return 1.0 if found is None else found.mean


class Study(NamedTuple):
    """limits: by metric the worst that a correct engine gives in any scene: the strictest threshold that flags none.
    false_alarms: correct engines outside the bounds, as "engine, scene".
    found: by mistake, in how many scenes each detector finds it. tried: in how many scenes it could be made.
    """

    limits: dict[str, float]
    false_alarms: tuple[str, ...]
    found: dict[str, dict[str, int]]
    tried: dict[str, int]

    def caught(self, detector: str) -> float:
        """The share of the mistakes that a detector finds in any scene."""
        return sum(found[detector] > 0 for found in self.found.values()) / len(self.found)


class _Case(NamedTuple):
    name: str
    scene: Scene
    reference: np.ndarray
    certificate: Any

    def measured(self, image: np.ndarray) -> dict[str, float]:
        if not np.isfinite(image).all():
            return dict.fromkeys(METRICS, float("inf"))
        return {name: metric(self.reference, image) for name, metric in METRICS.items()}

    def outside(self, image: np.ndarray) -> bool:
        return not verify(image, self.certificate).inside


def study(
    size: tuple[int, int] = SIZE,
    scenes: tuple[str, ...] = SCENES,
    mutations: tuple[Mutation, ...] = MUTATIONS,
    done: Callable[[int], None] = lambda steps: None,
) -> Study:
    """Renders every mistake on OpenGL in every scene; `done` is told of each mistake and of each scene.

    Raises:
        InputError: OpenGL is not installed.
    """
    cases, limits, alarms = [], dict.fromkeys(METRICS, -float("inf")), []
    for name in scenes:
        scene = load_scene(name)
        reference = np.asarray(render(scene, size, backend="numpy", dtype="float64"))
        case = _Case(name, scene, reference, certify(scene, size, precision="glsl-highp"))
        for engine, image in _correct(scene, size):
            if case.outside(image):
                alarms.append(f"{engine}, {name}")
            limits = {metric: max(limits[metric], value) for metric, value in case.measured(image).items()}
        cases.append(case)
        done(1)
    found, tried = {}, {}
    for mutation in mutations:
        images = list(_mutants(mutation, cases, size))
        tried[mutation.name] = len(images)
        counts = dict.fromkeys(DETECTORS, 0)
        for case, image in images:
            counts[BOUNDS] += image is None or case.outside(image)
            measured = dict.fromkeys(METRICS, float("inf")) if image is None else case.measured(image)
            for metric, value in measured.items():
                counts[metric] += value > limits[metric]
        found[mutation.name] = counts
        done(1)
    return Study(limits, tuple(alarms), found, tried)


def _correct(scene: Scene, size: tuple[int, int]) -> Iterator[tuple[str, np.ndarray]]:
    for backend, dtype in CORRECT:
        try:
            yield f"{backend} {dtype}", np.asarray(render(scene, size, backend=backend, dtype=dtype), np.float64)
        except InputError:
            if backend != "webgl":  # Chromium is not everywhere
                raise


def _mutants(mutation: Mutation, cases: list[_Case], size: tuple[int, int]) -> Iterator[tuple[_Case, Any]]:
    """The mistake's image in each scene that it can be made in; ``None`` where the shader does not run."""
    with temporary_folder() as folder:
        for case in cases:
            text = mutation.applied(glsl(case.scene, size, data="uniforms"))
            if text is None:
                continue
            path = folder / f"{case.name}.frag"
            path.write_text(text, encoding="utf-8")
            try:
                yield case, np.asarray(render(case.scene, size, backend="opengl", shader=path), np.float64)
            except (InputError, EngineFailure):
                yield case, None
