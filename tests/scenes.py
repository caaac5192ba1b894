"""Which examples of a law are run by default, all of which belong to the full set; and scenes that share a program."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

import raytrace
from raytrace.scene.toml import figures

__all__ = ["SEVERAL_SCENES", "examples", "filled", "some"]

#: Of those that are no figures, the ones that ask most of the arithmetic.
_HARD = ["inside-a-sphere", "huge-sphere-as-ground", "two-tilted-planes"]


def some(parameters: Iterable[Any], *default: Any) -> list:
    """Return all parameters of a test; those that are not among `default` belong to the full set alone."""

    def with_mark(each: Any) -> Any:
        values = each if isinstance(each, tuple) else (each,)
        return pytest.param(*values, marks=() if each in default else pytest.mark.full)

    return [with_mark(each) for each in parameters]


def examples(few: int, full: int) -> settings:
    """Return Hypothesis' settings for `few` random examples by default and `full` ones in the full set."""
    return settings(max_examples=full if settings.get_current_profile_name() == "full" else few)


#: Built-in scenes for tests that take seconds for each.
SEVERAL_SCENES = pytest.mark.parametrize("name", some([*figures(), *_HARD], "checkerboard"))


def filled(scene: raytrace.Scene) -> raytrace.Scene:
    """Return the scene with eight spheres and two boards, as one program serves all such scenes.

    The picture stays the same. The new spheres are behind the camera and far below, where no ray to the sun passes. The
    new boards are behind it.
    """
    center, radius, color = scene.spheres.center, scene.spheres.radius, scene.spheres.color
    ahead = scene.camera.target - scene.camera.position
    ahead = ahead / np.linalg.norm(ahead)
    new = 8 - len(radius)
    behind = scene.camera.position - 50 * ahead
    spheres = raytrace.Spheres(
        np.concatenate([center, [behind - [2.0 * k, 100.0, 0.0] for k in range(new)]]) if new else center,
        np.concatenate([radius, np.ones(new)]),
        np.concatenate([color, np.ones((new, 3))]),
    )
    boards = [raytrace.Plane(behind, ahead)] * (2 - len(scene.planes))
    return replace(scene, spheres=spheres, planes=(*scene.planes, *boards))
