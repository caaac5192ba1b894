from math import inf, log10

import numpy as np
import pytest

from raytrace.comparison import metrics

RANDOM = np.random.default_rng(0)


def grey(value, size=(16, 16)):
    return np.full((*size, 3), value)


def noise(size=(24, 32)):
    return RANDOM.uniform(0, 1, (*size, 3))


def test_rmse_and_psnr_by_hand():
    """Differences of 0.3 and 0.4 in two of six values: sqrt(0.25 / 6); in decibels -10 log10 of its square."""
    a = np.zeros((1, 2, 3))
    b = a.copy()
    b[0, 0, 1], b[0, 1, 2] = 0.3, -0.4
    assert metrics.rmse(a, b) == pytest.approx(np.sqrt(0.25 / 6), rel=1e-15)
    assert metrics.psnr(a, b) == pytest.approx(-10 * log10(0.25 / 6), rel=1e-15)
    assert metrics.largest_difference(a, b) == (0.4, 1, 0, "blue")


def test_ssim_of_constant_images_by_hand():
    """Without variance it is (2 ab + c) / (a^2 + b^2 + c), c = 0.01^2: of 0.2 and 0.6 it is 0.2401 / 0.4001."""
    found = metrics.similarity(grey(0.2), grey(0.6))
    assert found[:2] == pytest.approx((0.2401 / 0.4001,) * 2, abs=1e-12)


def test_ssim_is_that_of_wang_et_al_in_the_middle_window():
    """One window of 11 x 11, written out: the weighted means, variances and covariance of its one channel."""
    a, b = noise((11, 11)), noise((11, 11))
    offsets = np.arange(-5, 6)
    weights = np.exp(-(offsets[:, None] ** 2 + offsets**2) / (2 * 1.5**2))
    weights /= weights.sum()

    def mean(image):
        return (weights[..., None] * image).sum(axis=(0, 1))

    ma, mb = mean(a), mean(b)
    va, vb, cov = mean(a * a) - ma**2, mean(b * b) - mb**2, mean(a * b) - ma * mb
    c1, c2 = 0.01**2, 0.03**2
    expected = (2 * ma * mb + c1) * (2 * cov + c2) / ((ma**2 + mb**2 + c1) * (va + vb + c2))
    assert metrics.similarity(a, b).mean == pytest.approx(expected.mean(), abs=1e-12)


def test_the_worst_window_sees_what_the_mean_hides():
    a = noise((512, 512))
    b = a.copy()
    b[100:116, 300:316] = 1 - b[100:116, 300:316]
    found = metrics.similarity(a, b)
    assert found.mean > 0.998
    assert found.worst < 0
    assert 300 <= found.x < 316
    assert 100 <= found.y < 116


def test_a_wrong_corner_is_seen():
    a = noise()
    b = a.copy()
    b[:3, :3] = 1 - b[:3, :3]
    assert metrics.similarity(a, b).worst < 0.5


@pytest.mark.parametrize("size", [(1, 1), (10, 40), (40, 10)])
def test_ssim_is_undefined_under_its_window(size):
    assert metrics.similarity(noise(size), noise(size)) is None


def test_pixels_over_a_level():
    """Every two neighbours of 8 bits, as float32 tells them, are not over; two levels apart all are."""
    levels = (np.arange(256, dtype=np.float32) / np.float32(255)).astype(np.float64)
    image = np.repeat(levels[None, :, None], 3, axis=-1)
    assert not metrics.pixels_over(image[:, :-1], image[:, 1:]).any()
    assert metrics.pixels_over(image[:, :-2], image[:, 2:]).all()


def test_nan_is_over():
    a = grey(0.5, (2, 2))
    b = a.copy()
    b[1, 0, 2] = np.nan
    assert metrics.pixels_over(a, b).tolist() == [[False, False], [True, False]]


def test_delta_e_by_hand():
    """Black and white differ in lightness alone, L 0 and 100: 100 / (1 + 0.015 * 0 / sqrt(20)) = 100."""
    assert metrics.delta_e(grey(0.0), grey(1.0)) == pytest.approx((100, 100), abs=1e-3)


def test_flip_of_black_and_white_is_one():
    """Its authors normalise it so that the largest difference of colour, green to blue, is 1."""
    green, blue = np.zeros((8, 8, 3)), np.zeros((8, 8, 3))
    green[..., 1], blue[..., 2] = 1, 1
    mean, p999, pixels_per_degree = metrics.flip(green, blue)
    assert mean == pytest.approx(1, abs=1e-5)
    assert p999 == pytest.approx(1, abs=1e-5)
    # 0.7 m of distance times 3840 pixels on 0.7 m, times a degree.
    assert pixels_per_degree == pytest.approx(3840 * np.pi / 180, abs=1e-4)


def test_the_percentile_sees_one_pixel_in_five_hundred():
    a = grey(0.5, (20, 50))
    b = a.copy()
    b[3, 4] = b[9, 40] = 1
    assert metrics.delta_e(a, b).p999 > 20 * metrics.delta_e(a, b).mean


def test_equal_images():
    a = noise()
    assert metrics.similarity(a, a)[:2] == (pytest.approx(1), pytest.approx(1))
    assert (metrics.rmse(a, a), metrics.psnr(a, a)) == (0, inf)
    assert metrics.largest_difference(a, a) == (0, 0, 0, "red")
    assert metrics.delta_e(a, a) == (0, 0)
    assert metrics.flip(a, a)[:2] == (0, 0)


def test_everything_is_symmetric():
    a, b = noise(), noise()
    for metric in (metrics.rmse, metrics.psnr, metrics.largest_difference, metrics.similarity):
        assert metric(a, b) == metric(b, a)
    assert metrics.delta_e(a, b) == pytest.approx(metrics.delta_e(b, a), rel=1e-9)
    assert metrics.flip(a, b) == pytest.approx(metrics.flip(b, a), rel=1e-6)
