"""What is exact is exact, and errors are counted as they are defined."""

import numpy as np
import pytest

pytest.importorskip("flint")

from raytrace.arithmetic.exact import Exact, precision
from raytrace.studies.stress.measure import ulps
from raytrace.studies.stress.rays import answered, everywhere, given, towards


def test_answers_lie_on_the_sphere():
    """The residual of the quadratic equation at t, in exact arithmetic, and hits where rays pass within the radius."""
    random = np.random.default_rng(0)
    passing = random.uniform(0, 2, 200)
    rays = given(towards(random, np.array([0.1, 0.2, 0.3]), np.array([5.0, -2.0, 9.0]), 1.0, passing), np.float64)
    answer = answered(rays)
    np.testing.assert_array_equal(answer.hit, passing < 1)
    with precision():
        point = [Exact.of(o) + answer.t * Exact.of(d) for o, d in zip(rays.origin, rays.direction, strict=True)]
        off = [p - Exact.of(c) for p, c in zip(point, rays.center, strict=True)]
        residual = off[0] * off[0] + off[1] * off[1] + off[2] * off[2] - Exact.of(rays.radius) * Exact.of(rays.radius)
    assert np.abs(residual.floats()[answer.hit]).max() < 1e-100


def test_from_within_every_ray_leaves_ahead():
    rays = everywhere(np.random.default_rng(0), np.array([0.1, 0.2, 0.3]), np.zeros(3), 1.0, 100)
    answer = answered(given(rays, np.float32))
    assert answer.hit.all()
    assert (answer.other.floats() < 0).all()


def test_the_other_root_is_another_decision():
    rays = given(towards(np.random.default_rng(0), np.zeros(3), np.array([0, 0, 5.0]), 1.0, np.zeros(4)), np.float64)
    answer = answered(rays)  # 4 and 6
    np.testing.assert_array_equal(answer.decided(np.array([4.0, 6.0, -1.0, 4.9])), [True, False, False, True])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_units_in_the_last_place(dtype):
    one = np.array([1], dtype)
    above, below = np.nextafter(one, dtype(2)), np.nextafter(one, dtype(0))
    found = np.concatenate([one, above, below, np.array([np.nan, np.inf], dtype)])
    np.testing.assert_array_equal(ulps(found, Exact.of(np.ones(5)), dtype), [0, 1, 0.5, np.inf, np.inf])
    infinite = ulps(np.array([np.inf], dtype), Exact.of(np.array([np.inf])), dtype)
    np.testing.assert_array_equal(infinite, [0])


def test_the_condition_number_is_that_of_small_changes():
    """Changes of one part in 1e9 of each number, one after the other, add up to the condition number."""
    random = np.random.default_rng(3)
    rays = towards(random, np.array([0.4, 0.7, -0.3]), np.array([3.0, -2.0, 4.0]), 1.0, np.array([0.2, 0.6, 0.9]))
    rays = given(rays, np.longdouble)
    t, moved, small = answered(rays).t.floats(), 0.0, 1e-9
    for field in ("origin", "direction", "center"):
        for axis in range(3):
            vector = list(getattr(rays, field))
            vector[axis] = vector[axis] * np.longdouble(1 + small)
            changed = rays._replace(**{field: type(rays.origin)(*vector)})
            moved = moved + np.abs(answered(changed).t.floats() - t) / t / small
    changed = rays._replace(radius=rays.radius * np.longdouble(1 + small))
    moved = moved + np.abs(answered(changed).t.floats() - t) / t / small
    np.testing.assert_allclose(answered(rays).condition, moved, rtol=1e-5)
