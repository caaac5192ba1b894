"""The constant matrix that makes a white point white."""

from functools import lru_cache

import numpy as np

from raytrace.colour_science import colour_science

__all__ = ["adaptation_matrix"]


@lru_cache
def adaptation_matrix(white_point: float | tuple[float, float]) -> np.ndarray:
    """The 3 x 3 matrix for linear sRGB columns that takes the colour of `white_point` to neutral white (D65).

    white_point: a correlated colour temperature in kelvin, on the Planckian locus after Kang et al. (2002), or
        CIE 1931 chromaticity coordinates (x, y).

    Bradford's chromatic adaptation (Lam 1985), by colour-science.
    """
    colour = colour_science()
    given_xy = isinstance(white_point, tuple)
    xy = np.array(white_point) if given_xy else colour.temperature.CCT_to_xy_Kang2002(white_point)
    srgb = colour.RGB_COLOURSPACES["sRGB"]
    adaptation = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        colour.xy_to_XYZ(xy), colour.xy_to_XYZ(srgb.whitepoint), transform="Bradford"
    )
    return srgb.matrix_XYZ_to_RGB @ adaptation @ srgb.matrix_RGB_to_XYZ
