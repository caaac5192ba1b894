import numpy as np
import pytest
from hypothesis import given

from raytrace.shader.checkerboard import checkerboard
from tests.strategies import numbers, vec3

EVEN, ODD, LINE = vec3([1, 1, 1]), vec3([0.1, 0.1, 0.1]), vec3([1, 0.8, 0.4])


def color(x, z, tile_size=1.0, dtype=np.float64):
    tile_size = np.asarray(tile_size, dtype)
    return checkerboard(vec3([x, 123, z], dtype), tile_size, *(vec3(c, dtype) for c in (EVEN, ODD, LINE)))


@pytest.mark.parametrize(
    ("x", "z", "expected"),
    [
        # floor(p + 0.5) is (1, 1): even. (1, 2): odd. (-1, 2): odd, for mod(1, 2). (-3, -1): even.
        (1.0, 1.2, EVEN),
        (1.4, 2.0, ODD),
        (-1.0, 2.0, ODD),
        (-3.3, -0.6, EVEN),
        # floor(0.49 + 0.5) = 0 is the middle line; floor(0.5 + 0.5) = 1 is not; floor(-0.5 + 0.5) = 0 is.
        (0.49, 7.0, LINE),
        (0.5, 1.0, EVEN),
        (-0.5, 1.0, LINE),
        (3.0, 0.0, LINE),
    ],
)
def test_by_hand(x, z, expected):
    assert color(x, z) == expected


def test_tile_size_by_hand():
    """x = 0.7 is tile floor(1.4 + 0.5) = 1 at size 0.5, and the line at size 2: floor(0.35 + 0.5) = 0."""
    assert color(0.7, 0.5, 0.5) == EVEN
    assert color(0.7, 2.0, 2.0) == LINE


@given(numbers(1, 1000), numbers(1, 1000))
def test_two_tiles_further_the_colour_is_the_same(x, z):
    assert color(x, z) == color(x + 2, z) == color(x, z + 2)
    if abs(x + 0.5 - round(x + 0.5)) > 1e-6:
        assert color(x, z) != color(x + 1, z)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("x", [1e10, 1e30, -1e38, np.inf])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_far_out_there_is_a_colour(x, dtype):
    assert all(map(np.isfinite, color(x, 3.0, 0.01, dtype)))
    assert all(map(np.isfinite, color(x, -x, 0.01, dtype)))
