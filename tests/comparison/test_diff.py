from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.comparison import write_diff
from raytrace.comparison.diff import _worst
from raytrace.errors import InputError


def pair(size):
    a = np.random.default_rng(0).uniform(0, 0.5, (*size, 3))
    b = a.copy()
    b[size[0] // 2, size[1] // 2] += 0.4
    return a, b


@pytest.mark.parametrize("size", [(90, 160), (160, 30), (20, 300), (1, 1)])
def test_a_picture_of_any_shape(size):
    write_diff("d.png", raytrace.compare(*pair(size), names=("a_very_long_name_" * 4 + "$x$ $\\frac{$.png", "b.png")))
    picture = raytrace.read_image("d.png")
    assert min(picture.shape[:2]) > 200
    assert len(np.unique(picture)) > 10


def test_equal_images_have_a_picture_too():
    a, _ = pair((12, 16))
    write_diff("d.png", raytrace.compare(a, a))
    once = Path("d.png").read_bytes()
    write_diff("d.png", raytrace.compare(a, a))
    assert Path("d.png").read_bytes() == once


def test_the_worst_spots_are_apart_and_the_worst_is_first():
    steps = np.zeros((40, 60))
    steps[10, 20], steps[10, 21], steps[30, 50], steps[0, 0], steps[39, 0] = 90, 100, 200, 50, 0.5
    assert _worst(steps, 5) == [(50, 30), (21, 10), (0, 0)]


def test_what_cannot_be_written():
    comparison = raytrace.compare(*pair((4, 4)))
    for path, told in {"d.jpg": r"d\.jpg: a figure's file must be named \*\.png", "no/d.png": "the folder no"}.items():
        with pytest.raises(InputError, match=told):
            write_diff(path, comparison)
    assert list(Path().iterdir()) == []
