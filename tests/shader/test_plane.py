import numpy as np
import pytest
from hypothesis import assume, given

from raytrace.language.glsl import dot
from raytrace.shader.plane import any_plane_intersect, closest_plane_intersect, plane_intersect
from raytrace.shader.uniforms import Plane
from tests.strategies import directions, positions, unit, vec3

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")


def planes(points, normals):
    zero = np.zeros(len(points))
    color = vec3(np.zeros((len(points), 3)))
    return Plane(vec3(points), vec3(normals), zero, color, color, color)


def test_by_hand():
    """From y = 2 down at 45 degrees to y = -0.5: 2.5 * sqrt(2); upwards it is behind."""
    down, up = unit([0, -1, -1]), unit([0, 1, -1])
    n, p = vec3([0, 1, 0]), vec3([7, -0.5, 9])
    assert plane_intersect(vec3([0, 2, 0]), vec3(down), n, p) == pytest.approx(2.5 * np.sqrt(2), abs=1e-15)
    assert plane_intersect(vec3([0, 2, 0]), vec3(up), n, p) == pytest.approx(-2.5 * np.sqrt(2), abs=1e-15)


def test_parallel_is_infinite_and_no_hit():
    """dot(p - ro, n) / 0: -2.5 / 0 is -infinity; from below it is +infinity; within the plane it is 0 / 0."""
    level, n, p = vec3([0, 0, -1]), vec3([0, 1, 0]), vec3([0, -0.5, 0])
    ground = planes([[0, -0.5, 0]], [[0, 1, 0]])
    for height, expected in ((2, -np.inf), (-2, np.inf), (-0.5, np.nan)):
        ro = vec3([0, height, 0])
        np.testing.assert_equal(plane_intersect(ro, level, n, p), expected)
        assert closest_plane_intersect(ro, level, ground) == (np.inf, -1)
        assert not any_plane_intersect(ro, level, ground)


def test_a_plane_is_met_from_both_sides_and_not_from_within():
    ground = planes([[0, -0.5, 0]], [[0, 1, 0]])
    assert closest_plane_intersect(vec3([0, 0.5, 0]), vec3([0, -1, 0]), ground) == (1, 0)
    assert closest_plane_intersect(vec3([0, -1.5, 0]), vec3([0, 1, 0]), ground) == (1, 0)
    assert closest_plane_intersect(vec3([0, -0.5, 0]), vec3([0, -1, 0]), ground) == (np.inf, -1)


def test_of_planes_at_equal_t_the_first_wins():
    """Ground and a slope that both hold (0, -1, 0), looked down upon from the origin."""
    both = planes([[5, -1, 5], [0, -1, 0]], [[0, 1, 0], [1, 1, 0]])
    assert closest_plane_intersect(vec3([0, 0, 0]), vec3([0, -1, 0]), both) == (1, 0)


@given(positions, directions, positions, directions)
def test_a_hit_lies_on_the_plane(ro, rd, point, normal):
    rd, normal = unit(rd), unit(normal)
    t, index = closest_plane_intersect(vec3(ro), vec3(rd), planes([point], [normal]))
    if index == 0:
        assert 0 < t < np.inf
        assert np.dot(ro + t * rd - point, normal) == pytest.approx(0, abs=1e-13 * max(t, 1))


@given(positions, directions, positions, directions)
def test_a_ray_reversed_is_met_behind(ro, rd, point, normal):
    rd, normal = vec3(unit(rd)), vec3(unit(normal))
    assume(dot(rd, normal) != 0)  # a ray along the plane meets it at infinity, on the side of a zero's sign
    t = plane_intersect(vec3(ro), rd, normal, vec3(point))
    np.testing.assert_equal(plane_intersect(vec3(ro), -rd, normal, vec3(point)), -t)
