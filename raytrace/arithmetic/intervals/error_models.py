"""What each operation may err: of an ideal machine whose only rounding is our own, and of a GPU.

Bounds are float64 and computed with NumPy. What that rounds is always added, outward:

- NumPy's + - * / and sqrt are correctly rounded (IEEE 754);
- its exp2 and log2 err by at most `LIBM` units in the last place (NumPy documents 4 for its vector versions;
  tests/arithmetic/intervals/test_operations.py holds them to that against exact arithmetic).
"""

from math import inf
from typing import NamedTuple

__all__ = ["BUILT_INS", "GLSL_HIGHP", "LIBM", "REAL", "ErrorModel"]

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
    largest_divisor: a quotient by a larger number may be 0, as the reciprocal of that is subnormal.
    exp2, exp2_slope: 2**x may err by `exp2` + `exp2_slope` * abs(x) such units.
    log2, log2_absolute: a logarithm by `log2` such units or, near 1, by that much.
    interpolation: by how much a texture coordinate, from 0 to 1, may err.
    quotient_literals: a decimal in the program's text is either neighbour of its value; a quotient of two of them errs
        by so many units.
    """

    name: str
    float32: bool
    smallest: float
    divide: float = 0.0
    root: float = 0.0
    largest_divisor: float = inf
    exp2: float = 0.0
    exp2_slope: float = 0.0
    log2: float = 0.0
    log2_absolute: float = 0.0
    interpolation: float = 0.0
    quotient_literals: float = 0.0


REAL = ErrorModel("real", float32=False, smallest=2.0**-500)

#: What WGSL ('Floating Point Accuracy'), Vulkan ('Precision and Operation of SPIR-V Instructions') and GLSL ES 3.00
#: (4.5.1) promise of highp. `BUILT_INS` says which forms of each built-in the bounds hold, and why these numbers do.
GLSL_HIGHP = ErrorModel(
    "glsl-highp",
    float32=True,
    smallest=2.0**-126,
    divide=2.5,
    root=5.0,
    largest_divisor=2.0**126,
    exp2=3.0,
    exp2_slope=2.0,
    log2=3.0,
    log2_absolute=2.0**-21,
    interpolation=2.5 * 2.0**-24,
    quotient_literals=4.0,
)

#: What a conforming implementation may do inside each built-in of GLSL that the shader uses. The order of operations
#: there is the implementation's choice, not the shader's: the bounds hold every form that is listed, and each product
#: in a form may be fused with the sum that it is a term of. `raytrace.arithmetic.intervals.built_ins` computes them;
#: tests/arithmetic/intervals/test_machines.py draws each of them at random. Units are those in the last place of the
#: result.
BUILT_INS = {
    "x + y, x - y, x * y": "either neighbour of the exact result; a product may be fused with a sum",
    "x / y": "2.5 units, as one division or as x times a reciprocal; exact by a power of two; 0 where y is over 2^126",
    "dot(x, y)": "the sum of the products in any order and grouping",
    "mat3 * vec3, mat4 * vec4": "each component a sum of products in any order and grouping, by rows or by columns",
    "mix(x, y, a)": "x*(1 - a) + y*a, x + (y - x)*a or (x - x*a) + y*a",
    "mod(x, y)": "x - y*floor(x/y) or y*fract(x/y)",
    "sqrt(x)": "1/inversesqrt(x), x*inversesqrt(x) or a root within 5 units",
    "inversesqrt(x)": "2 units",
    "normalize(v)": "v/sqrt(dot(v, v)) or v*inversesqrt(dot(v, v)); length(v) is that root",
    "exp2(x), log2(x)": "3 + 2*abs(x) units; 3 units, or 2^-21 where x is from 0.5 to 2",
    "pow(x, y)": "exp2(y*log2(x)), where x below 2^-126 is taken for any number from 0 to that; for y = 1/4 also "
    "sqrt(sqrt(x))",
    "min, max, clamp, floor, step, abs": "exact; clamp is min(max(x, a), b) or max(min(x, b), a)",
    "numbers below 2^-126": "as they are or 0, as operands and as results",
    "texture coordinates": "interpolated to within 2^-23, or gl_FragCoord/resolution at 2.5 units",
    "decimals": "either neighbour; a quotient of two decimals within 4 units",
}
