"""How far two images are apart: each function takes two float64 arrays (height, width, 3) of display values."""

from math import inf, log10
from typing import Any, NamedTuple

import numpy as np

from raytrace.colour_science import colour_science

__all__ = [
    "LEVEL",
    "WINDOW",
    "Flip",
    "Similarity",
    "Spot",
    "Spread",
    "delta_e",
    "flip",
    "largest_difference",
    "pixels_over",
    "psnr",
    "rmse",
    "similarity",
]

#: One step of 8 bits; and a little, so that two neighbouring values of an 8 bit file, read as float32, are not over it.
LEVEL = 1 / 255 + 2**-22

#: The side of SSIM's window in pixels: of a Gaussian of sigma 1.5, cut off at 3.5 sigma.
WINDOW = 11


class Similarity(NamedTuple):
    """SSIM: the mean, and the worst window with its centre's column and row. 1 where the images are equal."""

    mean: float
    worst: float
    x: int
    y: int


class Spot(NamedTuple):
    """The largest absolute difference: its value, column, row and channel ("red", "green" or "blue")."""

    value: float
    x: int
    y: int
    channel: str


class Spread(NamedTuple):
    """A measure of each pixel: the mean, and what 99.9 % of the pixels are not above."""

    mean: float
    p999: float


class Flip(NamedTuple):
    """FLIP, from 0 to 1: as `Spread`, for a viewer who sees so many pixels in one degree."""

    mean: float
    p999: float
    pixels_per_degree: float


def similarity(a: np.ndarray, b: np.ndarray) -> Similarity | None:
    """SSIM; ``None`` where an image is smaller than its window.

    Wang, Bovik, Sheikh, Simoncelli, 'Image Quality Assessment: From Error Visibility to Structural Similarity'
    (2004), with its parameters, a channel at a time; by scikit-image. The mean is of the windows that lie in the
    image, as there; the worst is of all, those around the pixels of the border, reflected, too.
    """
    from skimage.metrics import structural_similarity

    if min(a.shape[:2]) < WINDOW:
        return None
    found: Any = structural_similarity(
        a, b, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=-1, full=True
    )
    mean, windows = found
    y, x, channel = np.unravel_index(np.argmin(windows), windows.shape)
    return Similarity(float(mean), float(windows[y, x, channel]), int(x), int(y))


def rmse(a: np.ndarray, b: np.ndarray) -> float:
    """The root of the mean squared difference, of all pixels and channels."""
    return float(np.sqrt(np.mean(np.square(a - b))))


def psnr(a: np.ndarray, b: np.ndarray) -> float:
    """The peak signal-to-noise ratio of the peak 1, in decibels; infinite for equal images."""
    error = rmse(a, b)
    return inf if error == 0 else -20 * log10(error)


def largest_difference(a: np.ndarray, b: np.ndarray) -> Spot:
    """The largest absolute difference of a channel; the first one from the top left."""
    difference = np.abs(a - b)
    y, x, channel = np.unravel_index(np.argmax(difference), difference.shape)
    return Spot(float(difference[y, x, channel]), int(x), int(y), ("red", "green", "blue")[channel])


def pixels_over(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Which pixels differ by more than 1/255 in any channel: (height, width); NaN does."""
    return ~(np.abs(a - b) <= LEVEL).all(axis=-1)


def delta_e(a: np.ndarray, b: np.ndarray) -> Spread:
    """CIEDE2000 of what an sRGB display shows, values clamped to [0, 1]; by colour-science."""
    colour = colour_science()
    lab_a, lab_b = (colour.XYZ_to_Lab(colour.sRGB_to_XYZ(np.clip(image, 0, 1))) for image in (a, b))
    return _spread(colour.delta_E(lab_a, lab_b, method="CIE 2000"))


def flip(a: np.ndarray, b: np.ndarray) -> Flip:
    """FLIP of what an sRGB display shows, values clamped to [0, 1]; by NVIDIA's flip-evaluator.

    Andersson et al., 'FLIP: A Difference Evaluator for Alternating Images' (2020), with its viewing distance: 0.7 m
    from a display of 3840 pixels on 0.7 m.
    """
    import flip_evaluator

    shown_a, shown_b = (np.ascontiguousarray(np.clip(image, 0, 1), dtype=np.float32) for image in (a, b))
    differences, _, parameters = flip_evaluator.evaluate(
        shown_a, shown_b, "LDR", applyMagma=False, computeMeanError=False
    )
    return Flip(*_spread(differences.astype(np.float64)), float(parameters["ppd"]))


def _spread(values: np.ndarray) -> Spread:
    return Spread(float(np.mean(values)), float(np.percentile(values, 99.9)))
