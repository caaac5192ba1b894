"""Many scenes in blocks: one program draws a block of pictures at a time."""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.rendering import Options, render
from raytrace.scene.data import Scene
from raytrace.scene.toml import as_scene

__all__ = ["render_each"]

#: Pixels of a block, at most, but for a single larger picture.
PIXELS = 1 << 24


def render_each(scenes: Iterable[Scene | str], size: tuple[int, int], **choices: Any) -> list[np.ndarray]:
    """Render concrete scenes, each to an image of shape (height, width, 3), in their order, as NumPy arrays.

    On an accelerator those of one structure are drawn together, whatever their numbers of spheres: the last sphere of a
    scene with fewer is there several times, which no picture shows. On a CPU one is drawn after the other, since there
    each skips what it does not need.

    size: (width, height) in pixels. choices: those of `raytrace.render`, but for output "steps".

    Raises:
        InputError: as `raytrace.render`; or the output is "steps".
    """
    options = Options(size=size, **choices)
    options.check()
    if options.output == "steps":
        raise InputError("output: of many scenes there are 'display' and 'linear', found 'steps'")
    given = [as_scene(scene) for scene in scenes]
    if options.backend != "jax" or not _together(options):
        return [np.asarray(render(scene, size, **choices)) for scene in given]
    import jax

    groups: dict[Any, list[int]] = {}
    for i, scene in enumerate(given):
        key = jax.tree.structure(scene), len(scene.spheres.radius) > 0
        groups.setdefault(key, []).append(i)
    images: dict[int, np.ndarray] = {}
    block = max(1, PIXELS // (size[0] * size[1]))
    for members in groups.values():
        most = max(len(given[i].spheres.radius) for i in members)
        padded = [_padded(given[i], most) for i in members]
        height = min(block, len(members))
        program = _program(tuple(sorted(choices.items())), tuple(size))
        for start in range(0, len(members), height):
            some = padded[start : start + height]
            # The last block has the others' shape, so that it needs no program of its own.
            some += some[-1:] * (height - len(some))
            stacked = jax.tree.map(lambda *leaves: np.stack([np.asarray(leaf) for leaf in leaves]), *some)
            drawn = np.asarray(program(stacked))
            images.update(zip(members[start : start + height], drawn, strict=False))
    return [images[i] for i in range(len(given))]


def _together(options: Options) -> bool:
    """Whether pictures are drawn together: by the engines of accelerators."""
    from raytrace.backends.jax.devices import one_device

    if options.engine is not None:
        return options.engine in ("fused", "kernel")
    return one_device().devices.flat[0].platform != "cpu"


@lru_cache(maxsize=8)
def _program(choices: tuple, size: tuple[int, int]) -> Any:
    import jax

    return jax.jit(jax.vmap(lambda scene: render(scene, size, **dict(choices))))


def _padded(scene: Scene, most: int) -> Scene:
    """The scene with its last sphere as often as makes that number."""
    spheres = scene.spheres
    missing = most - len(spheres.radius)
    if not missing:
        return scene
    more = {
        name: np.concatenate([array, np.repeat(array[-1:], missing, axis=0)])
        for name, array in ((name, np.asarray(getattr(spheres, name))) for name in ("center", "radius", "color"))
    }
    return replace(scene, spheres=replace(spheres, **more))
