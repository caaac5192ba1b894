"""Many scenes in blocks: one program draws a block of pictures at a time."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.errors import InputError
from raytrace.rendering import Options, render
from raytrace.scene.check import is_traced
from raytrace.scene.data import Scene, Spheres
from raytrace.scene.toml import as_scene

__all__ = ["render_each"]

#: Pixels of a block, at most, but for a single larger picture.
PIXELS = 1 << 24


def render_each(scenes: Iterable[Scene | str | Path], size: tuple[int, int], **choices: Any) -> list[np.ndarray]:
    """Render concrete scenes, each to an image of shape (height, width, 3), in their order, as NumPy arrays.

    On an accelerator those of one structure are drawn together, by one device, whatever their numbers of spheres: the
    last sphere of a scene with fewer is there several times, which changes no picture. On a CPU one is drawn after the
    other, since there each skips what it does not need.

    size: (width, height) in pixels. choices: those of `raytrace.render`, but for output "steps".

    Raises:
        InputError: as `raytrace.render`; or the output is "steps", or a scene is traced.
    """
    options = Options(size=size, **choices)
    options.check()
    if options.output == "steps":
        raise InputError("output: of many scenes there are 'display' and 'linear', found 'steps'")
    given = [as_scene(scene) for scene in scenes]
    if any(map(is_traced, given)):
        raise InputError("scenes: must be concrete; jax.vmap renders traced ones")
    if options.backend != "jax" or not _together(options):
        return [np.asarray(render(scene, size, **choices)) for scene in given]
    import jax

    groups: dict[Any, list[int]] = {}
    for i, scene in enumerate(given):
        groups.setdefault((jax.tree.structure(scene), _number(scene, options)), []).append(i)
    images: dict[int, np.ndarray] = {}
    block = max(1, PIXELS // (size[0] * size[1]))
    program = _program(tuple(map(int, size)), tuple(sorted(choices.items())))
    for (_, spheres), members in groups.items():
        # Powers of two, so that few numbers of scenes have programs of their own.
        height = min(block, _power_of_two(len(members)))
        for start in range(0, len(members), height):
            now = members[start : start + height]
            some = [_padded(given[i], spheres) for i in now]
            some += some[-1:] * (height - len(some))
            stacked = jax.tree.map(lambda *leaves: np.stack([np.asarray(leaf) for leaf in leaves]), *some)
            # In double until the numbers are rounded to float32, as each is for `render`.
            with jax.enable_x64(True):
                images.update(zip(now, np.asarray(program(stacked)), strict=False))
    return [images[i] for i in range(len(given))]


def _number(scene: Scene, options: Options) -> int:
    """How many spheres the scene is drawn with: its own or, where copies change nothing, the next power of two."""
    number = len(scene.spheres.radius)
    # A copy shadows the surface that a ray starts on, and its edges are counted again.
    copies = number > 0 and options.shadow_start == "offset" and options.antialias == "none"
    return _power_of_two(number) if copies else number


def _power_of_two(n: int) -> int:
    """Return the smallest power of two that is not below `n`."""
    return 1 << (n - 1).bit_length()


def _together(options: Options) -> bool:
    """Whether pictures are drawn together: by the engines of accelerators."""
    from raytrace.backends.jax.devices import check_devices, one_device

    check_devices()
    if options.engine is not None:
        return options.engine in ("fused", "kernel")
    return one_device().devices.flat[0].platform != "cpu"


@lru_cache(maxsize=8)
def _program(size: tuple[int, int], choices: tuple[tuple[str, Any], ...]) -> Callable:
    """The program for a stack of scenes, which the next call finds again."""
    import jax

    return jax.jit(jax.vmap(lambda scene: render(scene, size, **dict(choices))))


def _padded(scene: Scene, most: int) -> Scene:
    """The scene with its last sphere as often as makes that number."""
    spheres = scene.spheres
    missing = most - len(spheres.radius)
    if not missing:
        return scene
    center, radius, color = (
        np.concatenate([part, np.repeat(part[-1:], missing, axis=0)])
        for part in map(np.asarray, (spheres.center, spheres.radius, spheres.color))
    )
    return replace(scene, spheres=Spheres(center, radius, color))
