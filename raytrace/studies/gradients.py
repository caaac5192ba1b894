"""How right the derivatives of an image are: against references by boundary integrals."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from raytrace.rendering import render
from raytrace.scene.data import Scene
from raytrace.studies.differences import block_sums
from raytrace.studies.references import Held
from raytrace.studies.worlds import PARAMETERS

__all__ = ["CHOICES", "FINER", "Error", "derivative", "errors", "misses", "our_errors", "table"]

#: What is compared: ``antialias``, and samples along a side of a pixel. The last one takes longest.
CHOICES = {"edges": ("edges", 1), "none": ("none", 1), "edges, 4x4": ("edges", 4)}
FINER = "edges, 4x4"

#: Errors by the names of a parameter, a world, and what was compared.
Found = Mapping[str, Mapping[str, Mapping[str, "Error"]]]


class Error(NamedTuple):
    """Of a derivative, relative to the reference.

    total: of the sum over the image. blocks: of the sums over blocks, the sum of the absolute errors. cancelled: the
    share of the blocks' sums that is left in the total; the smaller, the harder the total is. noise: the reference's
    own error, as `blocks`. All are NaN where the parameter changes nothing that is seen.
    """

    total: float
    blocks: float
    cancelled: float
    noise: float


def errors(blocks: np.ndarray, reference: tuple[np.ndarray, np.ndarray]) -> Error:
    """Return the errors of a derivative.

    blocks: its sums over blocks, (rows, columns). reference: the sums that are right, and their own errors.
    """
    right, own = (np.asarray(each, np.float64) for each in reference)
    total = right.sum()
    # A sphere that is not seen, nor its shadow, changes nothing.
    size_of = np.abs(right).sum() or np.nan
    return Error(
        float(abs(blocks.sum() - total) / (abs(total) or np.nan)),
        float(np.abs(blocks - right).sum() / size_of),
        float(abs(total) / size_of),
        float(np.abs(own).sum() / size_of),
    )


def our_errors(held: Held, parameter: str, choices: tuple[str, ...]) -> dict[str, Error]:
    """Return the errors of the derivatives that `raytrace.render` has, for each of those `CHOICES`."""
    world = held.world
    return {
        name: errors(
            block_sums(derivative(world.scene, parameter, world.size, *CHOICES[name])), held.references[parameter]
        )
        for name in choices
    }


def derivative(scene: Scene, parameter: str, size: tuple[int, int], antialias: str, samples: int = 1) -> np.ndarray:
    """Return the derivative of the float64 image by the parameter, (height, width, 3), by forward mode.

    size: (width, height) in pixels.
    """
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


def table(found: Found) -> str:
    """Return the errors for each parameter, as text, in percent: medians, the worst, how many are within the limits.

    The total is told of those worlds where it is no difference of nearly equal sums.
    """
    heads = f"{'median':>9}{'worst':>8}{'within':>9}"
    lines = [f"{'in percent':14}{'total':>26}{'blocks':>29}", f"{'':14}{heads}   {heads}"]
    for name, worlds in found.items():
        limits = PARAMETERS[name].limits
        each = [of for of in worlds.values() if not np.isnan(_any(of).cancelled)]
        whole = [of for of in each if _any(of).cancelled >= LEFT]
        noise = 100 * np.median([_any(of).noise for of in each]) if each else np.nan
        told = " and ".join(f"{100 * limit:.0f}" for limit in limits)
        lines.append(f"{name}: within {told}; the reference's own {noise:.1f}")
        for choice in dict.fromkeys(choice for of in worlds.values() for choice in of):
            cells = (
                _cell([getattr(of[choice], field) for of in some if choice in of], limit)
                for field, some, limit in zip(("total", "blocks"), (whole, each), limits, strict=True)
            )
            lines.append(f"  {choice:12}" + "   ".join(cells))
    return "\n".join(lines)


def _any(of: Mapping[str, Error]) -> Error:
    """What every choice says alike: `cancelled` and `noise`."""
    return next(iter(of.values()))


def _cell(errors: list[float], limit: float) -> str:
    if not errors:
        return f"{'-':>9}{'-':>8}{'-':>9}"
    within = f"{np.count_nonzero(np.array(errors) <= limit)}/{len(errors)}"
    return f"{100 * np.median(errors):>9.1f}{100 * max(errors):>8.1f}{within:>9}"


def misses(found: Found) -> list[str]:
    """Return a line for each world, parameter and choice that is out of the limits, but for plain autodiff, "none"."""
    lines = []
    for parameter, worlds in found.items():
        for world, of in worlds.items():
            for choice, error in of.items():
                fields = ("total", "blocks") if error.cancelled >= LEFT else ("blocks",)
                limits = dict(zip(("total", "blocks"), PARAMETERS[parameter].limits, strict=True))
                said = [
                    f"{field} {100 * getattr(error, field):.1f}, limit {100 * limits[field]:.0f}"
                    for field in fields
                    if getattr(error, field) > limits[field]
                ]
                if said and choice != "none":
                    own = f"(the reference's own {100 * error.noise:.1f})"
                    lines.append(f"{world:24}{parameter:17}{choice:12}{'; '.join(said)} {own}")
    return lines
