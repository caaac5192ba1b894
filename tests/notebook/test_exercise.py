"""Exercises that are checked, and pictures."""

import numpy as np
import pytest

import raytrace
from raytrace.errors import InputError
from raytrace.notebook import check, pictures

SIZE = (96, 54)


def test_right_and_wrong_answers():
    image = raytrace.render("shadows", SIZE, backend="numpy", dtype="float64")
    assert check(image, "shadows").right
    wrong = check(image**2.2, "shadows")
    assert not wrong.right
    assert "without gamma" in wrong.hint
    assert "✘ wrong" in wrong._repr_html_()
    assert wrong.look()._repr_png_().startswith(b"\x89PNG")


def test_what_is_wrong_and_has_no_name_is_told_by_its_part():
    image = raytrace.render("shadows", SIZE, backend="numpy", dtype="float64")
    sky = np.asarray(raytrace.render("shadows", SIZE, output="steps", backend="numpy", dtype="float64")["index"]) < 0
    answer = check(np.where(sky[..., None], 0.5, image), "shadows")
    assert not answer.right
    assert "sky" in answer.hint


def test_answers_that_are_no_images():
    assert "shape" in check(np.zeros((4, 4)), "shadows").hint
    assert "no numbers" in check(np.full((20, 20, 3), np.nan), "shadows").hint
    with pytest.raises(InputError, match="no image to look at"):
        check(np.zeros((4, 4)), "shadows").look()


def test_where_only_the_similarity_fails_it_is_named():
    """As of an image that is cut to 8 bits instead of rounded."""
    image = raytrace.render("skybox", SIZE, backend="numpy", dtype="float64")
    answer = check(image + 0.9 / 255 * np.random.default_rng(0).uniform(-1, 1, image.shape), "skybox")
    assert not answer.right
    assert "SSIM" in answer.hint


def test_pictures_of_what_is_none():
    with pytest.raises(InputError, match="pictures: must have shape"):
        pictures(np.zeros(4))
    with pytest.raises(InputError, match="pictures: must be one at least"):
        pictures()
    assert pictures(np.array([[1.0, np.nan]]), titles=("t",))._repr_png_().startswith(b"\x89PNG")
