import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from raytrace.language.glsl import Mat3, Mat4, Vec2, Vec3, Vec4
from raytrace.language.literal import literal
from raytrace.shader import glsl
from tests.strategies import numbers, positions, vec3


def test_vectors_are_componentwise_and_scalars_are_broadcast():
    a, b = Vec3(np.array(1.0), np.array(2.0), np.array(3.0)), Vec3(np.array(4.0), np.array(5.0), np.array(7.0))
    assert a + b == (5, 7, 10)
    assert b - a == (3, 3, 4)
    assert a * b == (4, 10, 21)
    assert 2 * a == (2, 4, 6)
    assert 1 - a == (0, -1, -2)
    assert 6 / a == (6, 3, 2)
    assert -a == (-1, -2, -3)


def test_an_array_times_a_vector_is_a_vector():
    plane = np.ones((2, 2))
    assert isinstance(plane * Vec3(plane, plane, plane), Vec3)
    assert isinstance(plane[0, 0] * Vec2(plane, plane), Vec2)


def test_matrix_times_vector_sums_columns():
    """Columns (1,0,2), (0,3,0), (5,0,1) times (1,2,3): row 0 is 1 + 15 = 16, row 1 is 6, row 2 is 2 + 3 = 5."""
    m = Mat3(vec3([1, 0, 2]), vec3([0, 3, 0]), vec3([5, 0, 1]))
    assert m * vec3([1, 2, 3]) == (16, 6, 5)


def test_mat3_is_the_upper_left_part():
    m = Mat4(*(Vec4(*(np.float64(4 * column + row) for row in range(4))) for column in range(4)))
    assert m.mat3 == ((0, 1, 2), (4, 5, 6), (8, 9, 10))


def test_dot_and_cross_by_hand():
    """(1,2,3).(4,-5,6) = 4 - 10 + 18 = 12; the cross product is (2*6+3*5, 3*4-1*6, -5-8) = (27, 6, -13)."""
    a, b = vec3([1, 2, 3]), vec3([4, -5, 6])
    assert glsl.dot(a, b) == 12
    assert glsl.cross(a, b) == (27, 6, -13)


def test_normalize_by_hand_and_of_zero():
    """(3,0,4) has length 5."""
    assert glsl.normalize(vec3([3, 0, 4])) == (0.6, 0, 0.8)
    assert glsl.normalize(vec3([0, 0, 0])) == (0, 0, 0)


@given(positions, positions)
def test_the_cross_product_is_across_both(a, b):
    a, b = vec3(a), vec3(b)
    assert abs(glsl.dot(glsl.cross(a, b), a)) < 1e-11
    assert abs(glsl.dot(glsl.cross(a, b), b)) < 1e-11


def test_mod_has_the_sign_of_the_divisor():
    """-3 - 2*floor(-1.5) = -3 + 4 = 1."""
    assert glsl.mod(np.array([-3.0, -2.0, 5.0, 4.0]), 2).tolist() == [1, 0, 1, 0]


def test_mix_and_clamp_by_hand():
    """A quarter of the way from 2 to 6 is 3."""
    assert glsl.mix(np.float64(2), np.float64(6), 0.25) == 3
    assert glsl.clamp(vec3([-1, 0.5, 7]), 0, 1) == (0, 0.5, 1)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.longdouble])
def test_select_keeps_the_arithmetic(dtype):
    x = np.ones(3, dtype)
    assert glsl.select(x > 0, x, 0).dtype == dtype
    assert glsl.select(x > 0, 1, x).dtype == dtype


def test_sqrt_and_pow_of_nothing_and_less_are_zero():
    x = np.array([0.0, -1.0, -np.inf])
    assert glsl.sqrt(x).tolist() == [0, 0, 0]
    assert glsl.pow(x, literal("5/11")).tolist() == [0, 0, 0]
    assert glsl.pow(x, literal("1/4")).tolist() == [0, 0, 0]


@given(numbers(0, 1000), st.sampled_from(["1/2", "1/4", "5/11", "2400", "5/12"]))
def test_pow_is_the_power(x, exponent):
    y = literal(exponent)
    x = np.float64(min(x, 1) if exponent == "2400" else x)
    assert glsl.pow(x, y) == pytest.approx(float(x) ** float(y.value), rel=1e-12, abs=1e-300)
