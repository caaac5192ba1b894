"""How right the derivatives of an image are: against differences of images with very many samples."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from raytrace.rendering import render
from raytrace.scene.data import Scene
from raytrace.studies.differences import block_sums, difference
from raytrace.studies.worlds import PARAMETERS, random_world

__all__ = ["PARAMETERS", "Error", "errors", "random_world", "table"]

#: What is compared: ``antialias``, and samples along a side of a pixel.
CHOICES = {"edges": ("edges", 1), "edges, 4x4": ("edges", 4), "none": ("none", 1)}


class Error(NamedTuple):
    """Of a derivative, relative to the reference.

    total: of the sum over the image. blocks: of the sums over blocks, the sum of the absolute errors. cancelled: the
    share of the blocks' sums that is left in the total; the smaller, the harder the total is. noise: the standard error
    of the reference's blocks, as `blocks`.
    """

    total: float
    blocks: float
    cancelled: float
    noise: float


def errors(scene: Scene, parameter: str, size: tuple[int, int] = (192, 108), samples: int = 32) -> dict[str, Error]:
    """The errors of the derivative of the display image by a parameter, for each of `CHOICES`.

    The reference are central differences of float64 images with samples x samples samples a pixel.
    """
    reference = difference(scene, parameter, size, samples)
    total = reference.blocks.sum()
    # A sphere that is not seen, nor its shadow, changes nothing.
    size_of = np.abs(reference.blocks).sum() or np.nan
    found = {}
    for name, (antialias, squares) in CHOICES.items():
        slope = block_sums(derivative(scene, parameter, size, antialias, squares))
        found[name] = Error(
            abs(slope.sum() - total) / (abs(total) or np.nan),
            np.abs(slope - reference.blocks).sum() / size_of,
            abs(total) / size_of,
            reference.error.sum() / size_of,
        )
    return found


def derivative(scene: Scene, parameter: str, size: tuple[int, int], antialias: str, samples: int = 1) -> np.ndarray:
    """The derivative of the float64 image by the parameter, by forward mode."""
    import jax

    with jax.enable_x64(True):
        moved = PARAMETERS[parameter].moved
        here, along = jax.jvp(lambda h: jax.tree.map(jax.numpy.asarray, moved(scene, h)), (0.0,), (1.0,))
        return np.asarray(_derivative(size, antialias, samples)(here, along))


@lru_cache
def _derivative(size: tuple[int, int], antialias: str, samples: int) -> Any:
    """One program for all parameters: the derivative along a direction in the space of scenes."""
    import jax

    def image(scene: Scene) -> Any:
        return render(scene, size, dtype="float64", exact_inputs=True, antialias=antialias, samples=samples)

    return jax.jit(lambda scene, along: jax.jvp(image, (scene,), (along,))[1])


#: Where less than this share of the blocks' sums is left in the total, that is nearly a difference of equals.
LEFT = 0.25


def table(found: dict[str, list[dict[str, Error]]]) -> str:
    """The errors of several worlds for each parameter, as text, in percent: medians, the worst, how many in the limits.

    The total is told of those worlds where it is no difference of nearly equal sums.
    """
    heads = f"{'median':>9}{'worst':>8}{'within':>9}"
    lines = [f"{'in percent':14}{'total':>26}{'blocks':>29}", f"{'':14}{heads}   {heads}"]
    for name, every in found.items():
        parameter = PARAMETERS[name]
        each = [of for of in every if not np.isnan(of["edges"].blocks)]
        whole = [of for of in each if of["edges"].cancelled >= LEFT]
        noise = 100 * np.median([of["edges"].noise for of in each]) if each else np.nan
        limits = " and ".join(f"{100 * limit:.0f}" for limit in parameter.limits)
        lines.append(f"{name}: within {limits}; the reference's own {noise:.1f}")
        for choice in CHOICES:
            cells = (
                _cell([getattr(of[choice], field) for of in worlds], limit)
                for field, worlds, limit in zip(("total", "blocks"), (whole, each), parameter.limits, strict=True)
            )
            lines.append(f"  {choice:12}" + "   ".join(cells))
    return "\n".join(lines)


def _cell(errors: list[float], limit: float) -> str:
    if not errors:
        return f"{'-':>9}{'-':>8}{'-':>9}"
    within = f"{np.count_nonzero(np.array(errors) <= limit)}/{len(errors)}"
    return f"{100 * np.median(errors):>9.1f}{100 * max(errors):>8.1f}{within:>9}"
