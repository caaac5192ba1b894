"""The shader's own text on arrays of `arb`."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import raytrace

pytest.importorskip("flint")

from raytrace.arithmetic.exact import Exact, Undecided, precision
from raytrace.backends.exact import exact_steps
from raytrace.shader.main import COMPONENTS
from tests.scenes import SEVERAL_SCENES

floats = st.floats(allow_nan=False, allow_infinity=False)


@SEVERAL_SCENES
def test_the_picture_is_that_of_longdouble(name):
    """The same decisions at every pixel, and numbers that differ by longdouble's own rounding."""
    scene, (width, height) = raytrace.load_scene(name), (24, 13)
    steps = exact_steps(scene, (width, height), tuple(COMPONENTS))
    expected = raytrace.render(
        scene, (width, height), backend="numpy", dtype="longdouble", output="steps", intersection="robust"
    )
    np.testing.assert_array_equal(steps.index.floats(), expected["index"])
    np.testing.assert_array_equal(steps.shadow.floats(), expected["shadow"])
    for component, plane in enumerate(steps.display):
        np.testing.assert_allclose(plane.floats(), expected["display"][..., component], rtol=0, atol=1e-13)


@given(a=floats, b=floats, c=floats)
def test_sums_and_products_are_exact(a, b, c):
    with precision(20000):
        number = Exact.of(np.array([a])) * Exact.of(np.array([b])) + Exact.of(np.array([c]))
        mantissa, exponent = number.value[0].man_exp()
    value = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    assert value == Fraction(a) * Fraction(b) + Fraction(c)


@given(x=st.floats(width=64, allow_nan=False))
def test_a_longdouble_keeps_its_digits(x):
    wide = np.longdouble(x) * (1 + np.finfo(np.longdouble).eps)
    with precision():
        again = Exact.of(wide) - Exact.of(np.float64(wide))
    if np.isfinite(wide) and np.isfinite(np.float64(wide)):
        assert again.floats() == np.float64(wide - np.float64(wide))


def test_comparisons_that_the_bound_leaves_open_are_not_guessed():
    with precision(100):
        third = Exact.of(np.array([1.0])) / Exact.of(np.array([3.0]))
        almost = third * 3.0
        for undecided in (
            lambda: almost < 1.0,
            lambda: almost == 1.0,
            lambda: almost.__array_namespace__().floor(almost),
        ):
            with pytest.raises(Undecided):
                undecided()
        assert (third < 0.34).value.all()


def test_division_by_zero_is_ieees():
    one, zero = Exact.of(np.array([1.0, -1.0, 0.0])), Exact.of(np.array([0.0, 0.0, 0.0]))
    np.testing.assert_array_equal((one / zero).floats(), [np.inf, -np.inf, np.nan])
    # What is not a number is neither smaller nor larger nor equal.
    nan = (one / zero)[2:]
    assert not ((nan < 1.0).value | (nan >= 1.0).value | (nan == 1.0).value).any()
