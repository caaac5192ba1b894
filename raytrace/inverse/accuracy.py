"""How right the derivatives of an image are: against differences of images with very many samples."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from raytrace.inverse.worlds import PARAMETERS, random_world
from raytrace.rendering import render
from raytrace.scene.data import Scene

__all__ = ["PARAMETERS", "Error", "errors", "random_world", "table"]

#: Sides of the blocks of pixels whose sums are compared.
BLOCK = 12
#: A difference counts samples that an edge has passed; the mean over several steps counts them better.
STEPS = (0.37, 0.46, 0.55, 0.64, 0.73, 0.82, 0.91, 1.0)


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
    """The errors of the derivative of the display image by a parameter, with ``antialias`` "edges" and "none".

    The reference are central differences of float64 images with samples x samples samples a pixel.
    """
    moved, step, _ = PARAMETERS[parameter]

    def difference(h: float) -> np.ndarray:
        ahead, back = (
            render(moved(scene, sign * h), size, dtype="float64", samples=samples, exact_inputs=True)
            for sign in (1, -1)
        )
        return _blocks((np.asarray(ahead) - np.asarray(back)) / (2 * h))

    differences = [difference(share * step) for share in STEPS]
    reference = np.mean(differences, 0)
    # A sphere that is not seen, nor its shadow, changes nothing.
    size_of = np.abs(reference).sum() or np.nan
    noise = np.std(differences, 0, ddof=1).sum() / np.sqrt(len(STEPS)) / size_of
    found = {}
    for antialias in ("edges", "none"):
        slope = _blocks(derivative(scene, parameter, size, antialias))
        found[antialias] = Error(
            abs(slope.sum() - reference.sum()) / (abs(reference.sum()) or np.nan),
            np.abs(slope - reference).sum() / size_of,
            abs(reference.sum()) / size_of,
            noise,
        )
    return found


def derivative(scene: Scene, parameter: str, size: tuple[int, int], antialias: str) -> np.ndarray:
    """The derivative of the float64 image by the parameter, by forward mode."""
    import jax

    with jax.enable_x64(True):
        return np.asarray(_derivative(parameter, size, antialias)(scene))


@lru_cache
def _derivative(parameter: str, size: tuple[int, int], antialias: str) -> Any:
    import jax

    moved = PARAMETERS[parameter].moved

    def image(scene: Scene, h: Any) -> Any:
        return render(moved(scene, h), size, dtype="float64", exact_inputs=True, antialias=antialias)

    return jax.jit(lambda scene: jax.jvp(lambda h: image(scene, h), (0.0,), (1.0,))[1])


def _blocks(image: np.ndarray) -> np.ndarray:
    """The sums over blocks of the channels' mean."""
    height, width = (side // BLOCK * BLOCK for side in image.shape[:2])
    grey = image[:height, :width].mean(-1)
    return grey.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK).sum((1, 3))


#: Where less than this share of the blocks' sums is left in the total, that is nearly a difference of equals.
LEFT = 0.25


def table(found: dict[str, list[dict[str, Error]]]) -> str:
    """The errors of several worlds for each parameter, as text, in percent: medians, and the worst.

    The total is told of those worlds where it is no difference of nearly equal sums.
    """
    lines = [
        "in percent: median (worst)      total      blocks   reference's own   without edges: total      blocks",
    ]
    for name, every in found.items():
        each = [of for of in every if not np.isnan(of["edges"].blocks)]
        whole = [of for of in each if of["edges"].cancelled >= LEFT]
        cells = []
        for antialias, fields in (("edges", ("total", "blocks", "noise")), ("none", ("total", "blocks"))):
            for field in fields:
                values = [100 * getattr(of[antialias], field) for of in (whole if field == "total" else each)]
                cells.append(f"{np.median(values):.1f} ({max(values):.1f})" if values else "-")
        lines.append(f"{name:20}" + "".join(f"{cell:>16}" for cell in cells) + f"   {len(whole)}/{len(each)} totals")
    return "\n".join(lines)
