"""Shares of a pixel, against so many points of it that are counted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from raytrace.edges.coverage import disc_coverage, interval_coverage, positive_mean
from raytrace.language.glsl import Vec3, sqrt
from raytrace.language.jet import Jet

POINTS = 200
X, Y = np.meshgrid(*[(np.arange(POINTS) + 0.5) / POINTS - 0.5] * 2)
slopes = st.floats(-3, 3)
offsets = st.floats(-3, 3)


def line(value, dx, dy):
    return Jet(*map(np.float64, (value, dx, dy)))


@given(offsets, slopes, slopes)
def test_a_straight_edge(value, dx, dy):
    over = value + dx * X + dy * Y
    if abs(dx) + abs(dy) > 1e-3:
        assert line(value, dx, dy).share == pytest.approx(np.mean(over > 0), abs=1.5e-2)
        assert interval_coverage(line(value, dx, dy), -0.5, 0.7) == pytest.approx(
            np.mean((over > -0.5) & (over <= 0.7)), abs=3e-2
        )
    assert positive_mean(line(value, dx, dy)) == pytest.approx(np.maximum(over, 0).mean(), abs=1e-3)


@given(offsets, slopes, slopes)
def test_the_other_side_is_the_rest(value, dx, dy):
    edge = line(value, dx, dy)
    if value != 0 or dx != 0 or dy != 0:
        assert edge.share + (-edge).share == pytest.approx(1, abs=1e-12)
    assert positive_mean(edge) - positive_mean(-edge) == pytest.approx(value, abs=1e-9)


@given(offsets, slopes, slopes)
def test_neighbours_share_what_is_moved(value, dx, dy):
    """Over all pixels the shares change by the area that a moving edge sweeps, whatever its place and slope."""
    size, step = max(abs(dx), abs(dy)), 1e-4
    if size < 0.1:
        return
    along = np.arange(-100, 101)
    row = value + along * (dx if size == abs(dx) else dy)
    before, after = (Jet(row + h, np.full(201, dx), np.full(201, dy)).share.sum() for h in (0, step))
    assert after - before == pytest.approx(step / size, rel=1e-6)


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(0.05, 20), st.floats(0, 3))
def test_a_round_disc(x, y, radius, tilt):
    """In squares, seen upright or turned: chords are few, and a large disc's edge is a parabola."""
    x, y = x * (radius + 0.5), y * (radius + 0.5)
    c, s = np.cos(tilt), np.sin(tilt)
    offset = Vec3(line(c * x - s * y, c, -s), line(s * x + c * y, s, c), line(0, 0, 0))
    inside = np.mean((X + x) ** 2 + (Y + y) ** 2 <= radius**2)
    assert disc_coverage(offset, np.float64(radius)) == pytest.approx(inside, abs=0.07)


@pytest.mark.parametrize("radius", [0.01, 0.1, 0.3, 0.6, 1.0, 3.0, 7.0, 20.0])
@pytest.mark.parametrize("squeeze", [1.0, 0.2])
def test_a_discs_squares_are_its_area(radius, squeeze):
    """Summed over all squares, wherever the disc is, round or seen from the side."""
    n = int(radius + 3)
    for shift in (0.0, 0.13, 0.5):
        x, y = np.meshgrid(np.arange(-n, n + 1) + shift, np.arange(-n / squeeze - 2, n / squeeze + 3) - 0.7 * shift)
        zero = np.zeros_like(x)
        offset = Vec3(Jet(x, zero + 1, zero), Jet(y * squeeze, zero, zero + squeeze), Jet(zero, zero, zero))
        covered = disc_coverage(offset, np.float64(radius)).sum()
        assert covered == pytest.approx(np.pi * radius**2 / squeeze, rel=3e-3)


@given(offsets, slopes, slopes)
def test_a_jets_root_is_the_mean_of_the_root_where_it_is_positive(value, dx, dy):
    over = value + dx * X + dy * Y
    if abs(dx) + abs(dy) > 1e-2 and np.mean(over > 0) > 0.02:
        mean = np.sqrt(over[over > 0]).mean()
        assert sqrt(line(value, dx, dy)).value == pytest.approx(mean, rel=0.02)


def test_a_clearance_that_does_not_change_is_all_or_nothing():
    assert line(1e-9, 0, 0).share == 1
    assert line(-1e-9, 0, 0).share == 0
    assert positive_mean(line(2, 0, 0)) == 2
    assert positive_mean(line(-2, 0, 0)) == 0
