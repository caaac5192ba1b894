"""What each operation may err: of an ideal machine whose only rounding is our own, and of a GPU.

Bounds are float64 and computed with NumPy. What that rounds is always added, outward:

- NumPy's + - * / and sqrt are correctly rounded (IEEE 754);
- its exp2 and log2 err by at most `LIBM` units in the last place (NumPy documents 4 for its vector versions;
  tests/intervals/test_operations.py holds them to that against exact arithmetic).
"""

from typing import NamedTuple

__all__ = ["GLSL_HIGHP", "LIBM", "REAL", "ErrorModel"]

#: Units in the last place by which NumPy's exp2 and log2 may err in float64.
LIBM = 4
#: One unit in the last place is at most this much of a number: in float64, in float32.
ULP64, ULP32 = 2.0**-52, 2.0**-23


class ErrorModel(NamedTuple):
    """The errors that the arithmetic whose results are bounded may make.

    name: as in the command's ``--precision``.
    float32: every result is a float32: the exact one's neighbour on either side. Otherwise a real number.
    smallest: a smaller number may be taken for 0: in float32 a GPU's flush of subnormal numbers, otherwise ours.
    divide, root: how many units in the last place of float32 a quotient and a square root may err.
    exp2, exp2_slope: 2**x may err by `exp2` + `exp2_slope` * abs(x) such units.
    log2, log2_absolute: a logarithm by `log2` such units or, near 1, by that much.
    interpolation: by how much a texture coordinate, which the rasterizer interpolates, may err.
    quotient_literals: a decimal in the program's text is either neighbour of its value; a quotient of two of them errs
        by so many units.
    powers_by_logarithm: x to the power 1/4 is exp2(log2(x) / 4), too, and not two square roots.
    """

    name: str
    float32: bool
    smallest: float
    divide: float = 0.0
    root: float = 0.0
    exp2: float = 0.0
    exp2_slope: float = 0.0
    log2: float = 0.0
    log2_absolute: float = 0.0
    interpolation: float = 0.0
    quotient_literals: float = 0.0
    powers_by_logarithm: bool = False


REAL = ErrorModel("real", float32=False, smallest=2.0**-500)

#: What WGSL ('Floating Point Accuracy'), Vulkan ('Precision and Operation of SPIR-V Instructions') and GLSL ES 3.00
#: (4.5.1) promise of highp. A square root is taken as 1 / inverseSqrt: 2 and 2.5 units, and a rounding of the product.
#: The interpolation of a varying is promised by nobody; twice a float32's last digit at 1 is assumed.
GLSL_HIGHP = ErrorModel(
    "glsl-highp",
    float32=True,
    smallest=2.0**-126,
    divide=2.5,
    root=5.0,
    exp2=3.0,
    exp2_slope=2.0,
    log2=3.0,
    log2_absolute=2.0**-21,
    interpolation=2.0**-23,
    quotient_literals=4.0,
    powers_by_logarithm=True,
)
