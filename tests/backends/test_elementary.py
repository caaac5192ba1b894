"""The float32 functions against float64's."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from raytrace.backends.jax import elementary


def in_last_place(found, exact):
    return np.abs(np.asarray(found, np.float64) - exact) / np.spacing(np.abs(exact).astype(np.float32))


def test_log2():
    random = np.random.default_rng(0)
    x = np.concatenate(
        [
            np.exp2(random.uniform(-126, 127.9, 500_000)),
            1 + random.uniform(-0.3, 0.42, 500_000),
            1 - np.exp2(random.uniform(-24, -1, 500_000)),
            1 + np.exp2(random.uniform(-23, -1, 500_000)),
        ]
    ).astype(np.float32)
    x = x[x != 1]
    assert in_last_place(jax.jit(elementary.log2)(x), np.log2(x.astype(np.float64))).max() <= 1.5
    assert elementary.log2(jnp.float32(1)) == 0


def test_exp2():
    random = np.random.default_rng(0)
    x = np.concatenate([random.uniform(-126, 128, 500_000), random.uniform(-1, 1, 500_000)]).astype(np.float32)
    x = x[x < 128]
    assert in_last_place(jax.jit(elementary.exp2)(x), np.exp2(x.astype(np.float64))).max() <= 1


def test_exp2_of_whole_numbers_is_exact():
    x = np.arange(-126, 128, dtype=np.float32)
    np.testing.assert_array_equal(jax.jit(elementary.exp2)(x), np.ldexp(np.float32(1), x.astype(int)))


@pytest.mark.parametrize(
    ("x", "value"),
    [(-126.01, 0), (-1e30, 0), (-np.inf, 0), (128, np.inf), (1e30, np.inf), (np.inf, np.inf), (np.nan, np.nan)],
)
def test_exp2_beyond_the_range(x, value):
    np.testing.assert_array_equal(jax.jit(elementary.exp2)(np.float32(x)), np.float32(value))


def test_derivatives():
    for function, derivative in ((elementary.log2, 1 / (0.7 * np.log(2))), (elementary.exp2, 2**0.7 * np.log(2))):
        for way in (jax.grad, jax.jacfwd):
            assert way(function)(jnp.float32(0.7)) == pytest.approx(derivative, rel=1e-6)
