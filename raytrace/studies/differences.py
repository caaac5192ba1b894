"""The derivative of an image by differences of images with very many samples: what others are held against."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from raytrace.rendering import render
from raytrace.scene.data import MatrixCamera, Scene
from raytrace.scene.to_uniforms import uniforms_of
from raytrace.studies.worlds import PARAMETERS

__all__ = ["Difference", "block_sums", "difference"]

#: Sides of the blocks of pixels whose sums are compared.
BLOCK = 12
#: A difference counts samples that an edge has passed; the mean over steps from this share of a parameter's step up to
#: the whole, each with its samples elsewhere in the pixel, counts them better.
LEAST = 0.25
#: Fractions whose multiples fill the unit square evenly: powers of the inverse of x**3 = x + 1.
EVENLY = np.array([0.7548776662466927, 0.5698402909980532])


class Difference(NamedTuple):
    """Sums over blocks of the derivative, (rows, columns), and their standard errors."""

    blocks: np.ndarray
    error: np.ndarray


def difference(scene: Scene, parameter: str, size: tuple[int, int], samples: int) -> Difference:
    """Central differences of float64 display images with samples x samples samples a pixel, by one of `PARAMETERS`."""
    _, moved, step, _, number = PARAMETERS[parameter]

    def slope(turn: int, h: float) -> np.ndarray:
        offset = (turn * EVENLY % 1 - 0.5) / samples
        ahead, back = (
            render(
                _shifted(moved(scene, sign * h), offset, size),
                size,
                dtype="float64",
                samples=samples,
                exact_inputs=True,
            )
            for sign in (1, -1)
        )
        return block_sums((np.asarray(ahead) - np.asarray(back)) / (2 * h))

    slopes = [slope(turn, h) for turn, h in enumerate(step * np.linspace(LEAST, 1, number))]
    return Difference(np.mean(slopes, 0), np.std(slopes, 0, ddof=1) / np.sqrt(number))


def block_sums(image: np.ndarray) -> np.ndarray:
    """The sums of the channels' mean over blocks of `BLOCK` x `BLOCK` pixels, without what is left at the borders."""
    height, width = (side // BLOCK * BLOCK for side in image.shape[:2])
    grey = image[:height, :width].mean(-1)
    return grey.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK).sum((1, 3))


def _shifted(scene: Scene, offset: np.ndarray, size: tuple[int, int]) -> Scene:
    """The scene, whose camera is a perspective one, with its samples `offset` away, in pixels."""
    width, height = size
    ndc_to_view, view_to_world = (np.array(columns).T for columns in uniforms_of(scene, width / height).camera)
    shift = np.eye(4)
    shift[:2, 3] = 2 * offset / size
    return replace(scene, camera=MatrixCamera(ndc_to_view @ shift, view_to_world))
