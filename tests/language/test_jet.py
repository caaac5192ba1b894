"""A jet's derivatives are those that JAX finds."""

from functools import cache

import jax
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from raytrace.language.glsl import Vec3, cross, dot, maximum, minimum, normalize, select, sqrt
from raytrace.language.jet import Jet, jet, values
from raytrace.language.literal import literal

numbers = st.floats(-4, 4).filter(lambda x: abs(x) > 0.1)
FUNCTIONS = {
    "sum": lambda x, y: 1 + x - y + 2 - x * 3,
    "product": lambda x, y: x * y * literal("1e-1"),
    "quotient": lambda x, y: x / y + 1 / x + y / 3,
    "root": lambda x, y: sqrt(x * x + y * y + 50),
    "extremes": lambda x, y: maximum(x, y) + minimum(x * y, 1.5) + maximum(y, -1.0),
    "choice": lambda x, y: select(x < y, x, select(y > 0, 2.0, y)),
    "size": lambda x, y: abs(x) + abs(-y),
    "vectors": lambda x, y: dot(normalize(cross(Vec3(x, y, 1 + 0 * x), Vec3(y, 2 * x, x))), Vec3(x, 1 + 0 * y, y)),
}


@cache
def by_jax(name):
    return jax.jit(lambda primals, tangents: jax.jvp(FUNCTIONS[name], primals, tangents))


@pytest.mark.parametrize("name", FUNCTIONS)
@settings(max_examples=30)
@given(numbers, numbers, numbers, numbers)
def test_derivatives(name, x, y, along_x, along_y):
    """A pixel is small, so that no root in it is near 0; of equal numbers neither is the larger."""
    assume(x != y and x * y != 1.5 and y != -1)
    with jax.enable_x64(True):
        primals, tangents = tuple(map(np.float64, (x, y))), tuple(map(np.float64, (along_x * 1e-6, along_y * 1e-6)))
        expected, slope = map(float, by_jax(name)(primals, tangents))
    found = FUNCTIONS[name](*(Jet(*map(np.asarray, (v, d, 2 * d))) for v, d in zip(primals, tangents, strict=True)))
    np.testing.assert_allclose(found.value, expected, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(found.dx, slope, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.dy, 2 * slope, rtol=1e-9, atol=1e-12)


def test_a_root_near_0_does_not_reach_infinitely_far():
    """Of x over the pixel from -1/2 to 1/2: the mean is that over the right half, the slope that at its end."""
    root = sqrt(Jet(np.float64(1e-30), np.float64(1), np.float64(0)))
    assert root.value == pytest.approx(0.5**0.5 * 2 / 3, rel=1e-3)
    assert root.dx == pytest.approx(0.5**0.5)


def test_what_is_no_jet_does_not_change():
    x = jet(np.float64(2))
    assert (x.dx, x.dy, jet(x)) == (0, 0, x)
    assert values((x, Vec3(x, 1, x))) == (2, Vec3(2, 1, 2))


def test_comparisons_compare_values():
    x, y = jet(np.float64(1)), Jet(np.float64(2), np.float64(-9), np.float64(9))
    assert [x < y, x <= y, x > y, x >= y, x == y, x != y] == [True, True, False, False, False, True]
    assert x < 1.5
    assert np.float64(1.5) > x
