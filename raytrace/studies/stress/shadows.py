"""Shadows of a scene of any size: acne, and shadows that come loose ('peter-panning')."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from raytrace.arithmetic.exact import Exact
from raytrace.backends.exact import exact_steps
from raytrace.language.control import Engine, count
from raytrace.language.tree import tree_leaves, tree_map
from raytrace.rendering import render
from raytrace.scene.data import MatrixCamera, Scene
from raytrace.scene.toml import load_scene
from raytrace.shader.shadows import SHADOW_STARTS
from raytrace.studies.stress.effort import Effort
from raytrace.studies.stress.measure import Measurement

__all__ = ["ShadowStress", "scaled"]

#: What is asked for, of the steps of the shader.
KEEP = ("index", "NdL", "shadow")


def scaled(scene: Scene, factor: float) -> Scene:
    """The scene in another unit of length: everything `factor` times as large. By a power of two it is exact."""
    spheres, camera = scene.spheres, scene.camera
    assert not isinstance(camera, MatrixCamera)
    return replace(
        scene,
        spheres=replace(spheres, center=spheres.center * factor, radius=spheres.radius * factor),
        planes=tuple(replace(plane, point=plane.point * factor) for plane in scene.planes),
        camera=replace(camera, position=camera.position * factor, target=camera.target * factor),
    )


class _WithoutOneself(Engine):
    """Asks of each shadow ray the other spheres only: its own one it meets at t = 0 or nearly, which is undecidable."""

    def each(self, items: Any, body: Callable, start: Any, args: tuple, unroll: bool) -> Any:
        if len(args) != 3:
            return super().each(items, body, start, args, unroll)
        shape = np.broadcast_shapes(*(plane.shape for plane in tree_leaves(args)))
        # The directions are one for all.
        planes = tree_map(lambda plane: Exact(np.broadcast_to(plane.value, shape)), args)
        state = np.zeros(shape, bool)
        for i in range(count(items)):
            others = planes[2].value != i
            chosen = tree_map(lambda plane, others=others: plane[others], planes)
            item = tree_map(lambda leaf, i=i: leaf[i], items)
            state[others] = body(Exact(state[others]), i, item, *chosen).value
        return Exact(state)


class ShadowStress:
    """The assignment's scene at scales that are powers of two, so that its exact shadows are always the same."""

    def __init__(self, effort: Effort):
        self.scene, self.size = load_scene("shadows"), effort.size
        # About as far as from 1e-4 to 1e4.
        self.scales = 2.0 ** np.unique(np.round(np.linspace(-14, 14, 14 * effort.per_decade + 1)))
        self.exact = self._exactly(1.0, "surface")

    def points(self) -> Iterator[Measurement]:
        for scale in self.scales:
            yield from self._compared(scale, "exact, offset", self._exactly(scale, "offset"))
            for backend in ("numpy", "jax"):
                for dtype in ("float32", "float64"):
                    for start in SHADOW_STARTS:
                        steps = render(
                            scaled(self.scene, scale),
                            self.size,
                            backend=backend,
                            dtype=dtype,
                            intersection="robust",
                            shadow_start=start,
                            output="steps",
                        )
                        found = {name: np.asarray(steps[name]) for name in KEEP}
                        yield from self._compared(scale, f"{backend} {dtype} {start}", found)

    def _compared(self, scale: float, who: str, found: dict[str, np.ndarray]) -> Iterator[Measurement]:
        exact = self.exact
        counted = (found["index"] == exact["index"]) & (exact["index"] >= 0) & (exact["NdL"] > 0) & (found["NdL"] > 0)
        lit = exact["shadow"] == 1
        for axis, wrong in (("acne", lit & (found["shadow"] != 1)), ("peter_panning", ~lit & (found["shadow"] != 0))):
            yield Measurement(axis, scale, who, int(counted.sum()), float((wrong & counted).sum() / counted.sum()))

    def _exactly(self, scale: float, start: str) -> dict[str, np.ndarray]:
        """The shader's own text, in real numbers."""
        steps = exact_steps(scaled(self.scene, scale), self.size, KEEP, shadow_start=start, engine=_WithoutOneself())
        return {name: getattr(steps, name).floats() for name in KEEP}
