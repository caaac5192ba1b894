"""exp2 and log2 in float32, as array code that vectorizes.

XLA has neither: it goes by way of e, so that a large exponent's product with ln 2 is rounded. These are for what the
shader needs. log2, of positive normal numbers, errs by at most 1.5 units in the last place; exp2, from -126 to 128, by
at most 1. Below that exp2 is 0, as a subnormal number is in XLA on the CPU; above it is infinite.

Coefficients: the logarithm's are those of Cephes (S. L. Moshier, logf.c); exp2's are minimax for the relative error on
[-1/2, 1/2], by the exchange algorithm (tests/backends/test_elementary.py holds the bounds).
"""

import jax
import jax.numpy as jnp
from jax import lax

__all__ = ["exp2", "log2", "log2_double"]

_LOG2_E_LESS_1 = 0.44269504088896340736
_LN_2 = 0.69314718055994530942
#: (log(1 + f) - f + f^2 / 2) / f^3 for 1 + f from sqrt(1/2) to sqrt(2), highest power first.
_LOG = (
    7.0376836292e-2,
    -1.1514610310e-1,
    1.1676998740e-1,
    -1.2420140846e-1,
    1.4249322787e-1,
    -1.6668057665e-1,
    2.0000714765e-1,
    -2.4999993993e-1,
    3.3333331174e-1,
)
#: (2^f - 1) / f, highest power first.
_EXP2 = (
    0.00015353361883058356,
    0.0013398874422182714,
    0.009618437357837907,
    0.055503324711003374,
    0.24022647913626435,
    0.6931472028550814,
)
_MANTISSA_BITS = 23
_SQRT_HALF_BITS = 0x3F3504F3


def _bits(x: jax.Array) -> jax.Array:
    return lax.bitcast_convert_type(x, jnp.int32)


def _float(bits: jax.Array) -> jax.Array:
    return lax.bitcast_convert_type(bits, jnp.float32)


def _polynomial(coefficients: tuple[float, ...], x: jax.Array) -> jax.Array:
    value = jnp.float32(coefficients[0])
    for coefficient in coefficients[1:]:
        value = value * x + jnp.float32(coefficient)
    return value


@jax.custom_jvp
def log2(x: jax.Array) -> jax.Array:
    """The logarithm to base 2 of positive normal numbers of float32."""
    exponent = (_bits(x) - _SQRT_HALF_BITS) >> _MANTISSA_BITS
    f = _float(_bits(x) - (exponent << _MANTISSA_BITS)) - 1
    square = f * f
    # log(1 + f) = f + small; times log2(e) in two parts, the larger of which is 1 and needs no rounding.
    small = f * square * _polynomial(_LOG, f) - 0.5 * square
    rest = jnp.float32(_LOG2_E_LESS_1)
    return ((small * rest + f * rest) + small + f) + exponent.astype(jnp.float32)


@jax.custom_jvp
def exp2(x: jax.Array) -> jax.Array:
    """Two to the power `x`, float32."""
    nearest = jnp.round(jnp.clip(x, -127, 128))
    f = x - nearest
    value = 1 + f * _polynomial(_EXP2, f)
    # Times 2**nearest: from 0.7 to 1.5 the value's own exponent leaves room for all that are not decided below.
    scaled = _float(_bits(value) + (nearest.astype(jnp.int32) << _MANTISSA_BITS))
    return jnp.where(x < -126, 0, jnp.where(x >= 128, jnp.inf, scaled))


@log2.defjvp
def _(primals: tuple, tangents: tuple) -> tuple:
    (x,), (dx,) = primals, tangents
    return log2(x), _slope_of_log2(x, dx, 2.0**-48)


@jax.custom_jvp
def log2_double(x: jax.Array) -> jax.Array:
    """The logarithm to base 2 of positive normal numbers, XLA's, in float64."""
    return jnp.log2(x)


@log2_double.defjvp
def _(primals: tuple, tangents: tuple) -> tuple:
    (x,), (dx,) = primals, tangents
    return log2_double(x), _slope_of_log2(x, dx, 2.0**-450)


def _slope_of_log2(x: jax.Array, dx: jax.Array, least: float) -> jax.Array:
    """How the logarithm changes; as if `x` were no smaller than `least`.

    A compiler may divide an exponent, 2400, by `x` first, and for second derivatives square that: it must not overflow,
    as it is then multiplied by 0.
    """
    return dx / (jnp.maximum(x, least) * jnp.asarray(_LN_2, x.dtype))


@exp2.defjvp
def _(primals: tuple, tangents: tuple) -> tuple:
    (x,), (dx,) = primals, tangents
    value = exp2(x)
    return value, dx * (value * jnp.float32(_LN_2))
