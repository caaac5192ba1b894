from fractions import Fraction

import numpy as np
import pytest

from raytrace.language.glsl import Vec3
from raytrace.language.literal import literal


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.longdouble])
@pytest.mark.parametrize("text", ["2.51", "5/11", "1e-3", "2400", "0.0031308"])
def test_is_the_number_of_the_arithmetic_nearest_to_the_decimal(dtype, text):
    x = literal(text).like(dtype(1))
    assert x.dtype == dtype
    exact = Fraction(text)

    def error(y):
        numerator, denominator = y.as_integer_ratio()
        return abs(Fraction(int(numerator), int(denominator)) - exact)

    assert error(x) <= min(error(np.nextafter(x, dtype(-np.inf))), error(np.nextafter(x, dtype(np.inf))))


def test_longdouble_is_not_the_double_nearest_to_the_decimal():
    """2.51 has no finite binary expansion, so its longdouble differs from the double widened."""
    assert literal("2.51").like(np.longdouble(1)) != np.longdouble(2.51)


def test_arithmetic_among_literals_is_exact():
    a, b = literal("0.1"), literal("0.2")
    assert (a + b).value == Fraction(3, 10)
    assert (1 - a * b / 3).value == 1 - Fraction(2, 300)
    assert (2 - a).value == Fraction(19, 10)


def test_operators_with_arrays_and_vectors_keep_the_order():
    x = np.array([1.0, 2.0])
    two = literal("2")
    assert (two - x).tolist() == [1.0, 0.0]
    assert (x - two).tolist() == [-1.0, 0.0]
    assert (x / two).tolist() == [0.5, 1.0]
    assert (two / Vec3(x, x, x)).z.tolist() == [2.0, 1.0]
    assert (Vec3(x, x, x) - two).y.tolist() == [-1.0, 0.0]
