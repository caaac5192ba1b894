import numpy as np
import pytest

import raytrace
from raytrace.comparison.reference import Reference
from raytrace.comparison.wrong_views import WrongView, resampled, views

IMAGE = np.random.default_rng(0).uniform(0, 1, (7, 8, 3))


def test_a_view_without_a_mistake():
    columns, rows = WrongView().pixels(8, 7)
    assert columns.tolist() == list(range(8))
    assert rows.tolist() == list(range(7))
    np.testing.assert_array_equal(resampled(IMAGE, WrongView()), IMAGE)


def test_half_a_pixel_by_hand():
    """Of neighbours it is the mean; the column that nothing is known of is NaN."""
    moved = resampled(IMAGE, WrongView(right=0.5))
    np.testing.assert_allclose(moved[:, 1:], (IMAGE[:, :-1] + IMAGE[:, 1:]) / 2)
    assert np.isnan(moved[:, 0]).all()


def test_what_is_whole():
    whole = {name for name, view in views(16, 9).items() if view.whole}
    assert all(("one pixel" in name or "flipped" in name) == (name in whole) for name in views(16, 9))


def test_a_square_image_has_no_aspect():
    assert not any("aspect" in name for name in views(9, 9))


@pytest.mark.parametrize("view", [WrongView(), *views(33, 20).values()])
def test_the_scene_is_drawn_as_the_image_is_resampled(view):
    """Where a view shows whole pixels: the same image, but for those that lie outside; and thinned out, its pixels."""
    reference = Reference(raytrace.load_scene("spheres"), 33, 20)
    drawn = reference.through(view)
    np.testing.assert_array_equal(reference.through(view, 3), drawn[::3, ::3])
    if view.whole:
        again = resampled(reference.steps["display"], view)
        inside = ~np.isnan(again)
        assert inside.mean() > 0.85
        np.testing.assert_allclose(drawn[inside], again[inside], atol=1e-9)
