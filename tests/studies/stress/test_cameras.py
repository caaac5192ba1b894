"""Errors of primary rays over the condition number of the camera's matrices."""

import numpy as np
import pytest

pytest.importorskip("flint")

from raytrace.language.glsl import Vec2
from raytrace.language.tree import tree_leaves, tree_map
from raytrace.shader.camera import primary_ray
from raytrace.studies.stress import QUICK, stress, verdicts
from raytrace.studies.stress.cameras import CameraStress, _direction_condition, _perspective

AXES = ["narrow_view", "wide_view", "near_far", "camera_matrix"]


def test_every_camera_keeps_the_bound_and_a_sloppier_one_does_not():
    points = list(stress(QUICK._replace(cases=200), AXES))
    (verdict,) = verdicts(points)
    assert verdict.holds
    assert {point.axis for point in points} == set(AXES)
    worst = max(points, key=lambda point: point.conditioned or 0)
    (broken,) = verdicts([worst._replace(conditioned=10 * worst.conditioned)])
    assert not broken.holds


def test_ill_conditioned_matrices_lose_digits_as_the_condition_number_says():
    """At 1e7 a direction has lost digits that the bound allows, and no promise without the number would hold."""
    points = [p for p in stress(QUICK._replace(cases=200), ["camera_matrix"]) if p.who == "numpy float32 direction"]
    errors = {round(np.log10(point.x)): point.ulp for point in points}
    assert errors[0] < 5
    assert max(error for place, error in errors.items() if place >= 5) > 20


@pytest.mark.parametrize("camera", [_perspective(field_of_view=1e-3), _perspective(field_of_view=179.999), None])
def test_the_condition_number_bounds_small_changes(camera):
    """A change of each number by one part in 1e9, in turn: the direction's changes add up to no more, nor far less."""
    stress_ = CameraStress(QUICK)
    if camera is None:
        camera = type(_perspective())(stress_._ill_conditioned(1e3), stress_._ill_conditioned(1e3))
    camera = tree_map(lambda x: np.longdouble(x), camera)
    place = Vec2(*(np.array([x], np.longdouble) for x in (0.3, -0.8)))
    leaves, small = [*tree_leaves(camera), *place], np.longdouble(1e-9)

    def direction(numbers):
        numbers = iter(numbers)
        return np.array(
            [float(x[0]) for x in primary_ray(tree_map(lambda _: next(numbers), camera), Vec2(*numbers))[1]]
        )

    def changed(i):
        return [x * (1 + small) if k == i else x for k, x in enumerate(leaves)]

    moved = sum(np.abs(direction(changed(i)) - direction(leaves)).max() for i in range(len(leaves))) / 1e-9
    condition = float(_direction_condition(camera, place)[0])
    assert moved <= 1.01 * 3**0.5 * condition
    assert condition >= 3
