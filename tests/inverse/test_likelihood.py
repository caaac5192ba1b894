"""The probability of a picture's values, and the noise in it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from raytrace.inverse.likelihood import LEAST_ROUNDED, WRONG, Noise, log_likelihood, noise_of
from raytrace.inverse.mismatch import Mismatch


@jax.jit
def chances(targets, value, sigma, half):
    """Of each target, in one channel of a pixel whose other two are certain."""

    def one(target):
        pixel = jnp.stack([target, jnp.zeros(()), jnp.ones(())])[None]
        triple = tuple(jnp.full(1, x) for x in (value, -9.0, 9.0))
        return jnp.exp(log_likelihood(pixel, triple, jnp.array([True]), sigma, half))

    return jax.vmap(one)(targets)


@pytest.mark.parametrize("sigma", [1e-4, 1e-3, 2.9e-3, 3e-3, 8e-3, 0.05])
@pytest.mark.parametrize("value", [0.0, 0.003, 0.4, 0.9985, 1.0])
def test_the_chances_of_all_levels_sum_to_one(value, sigma):
    levels = jnp.arange(256, dtype=jnp.float32) / 255
    found = chances(levels, np.float32(value), *Noise(sigma, 1 / 510).numbers())
    assert float(found.sum()) == pytest.approx(1 - WRONG, abs=2e-3)


def rounded(values, sigma, random):
    return np.round(255 * np.clip(values + random.normal(0, sigma, values.shape), 0, 1)) / 255


@pytest.mark.parametrize("levels", [0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0])
def test_the_noise_is_found_beside_wrong_pixels_and_equal_ones(levels):
    random = np.random.default_rng(0)
    values = random.uniform(0, 1, (6000, 3))
    values[:2000] = [0.2, 0.501, 0.7]  # equal values, which are rounded equally
    target = rounded(values, levels / 255, random)
    target[::50] = random.uniform(0, 1, (120, 3))
    found = noise_of(target, values, 1 / 510).sigma
    # Below a step it is one of a dozen.
    assert found == pytest.approx(levels / 255, rel=0.03 if levels > 1 else 0.35, abs=4 * LEAST_ROUNDED)


def left_over(change, sigma=2 / 255, seed=0):
    random = np.random.default_rng(seed)
    values = random.uniform(0.1, 0.9, (200, 64, 3))
    target = rounded(change(values, random), sigma, random)
    return Mismatch.of(target, values, np.ones((200, 64), bool), 1 / 510)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("levels", [0.0, 0.3, 2.0, 5.0])
def test_a_right_model_fits_whatever_the_noise(levels, seed):
    assert left_over(lambda values, random: values, levels / 255, seed).fits


@pytest.mark.parametrize("levels", [0.3, 1.0, 5.0])
def test_clipped_pixels_do_not_hide_the_noise_of_others(levels):
    random = np.random.default_rng(0)
    values = random.uniform(0.1, 0.9, (60, 64, 3))
    values[::2], values[::6] = 0.0, 1.0
    target = rounded(values, levels / 255, random)
    assert Mismatch.of(target, values, np.ones((60, 64), bool), 1 / 510).fits


@pytest.mark.parametrize("levels", [0.0, 2.0, 5.0])
@pytest.mark.parametrize(
    "change",
    [
        lambda values, random: values**1.05,
        lambda values, random: values + 0.01,
        lambda values, random: np.where(random.random((200, 64, 1)) < 0.03, 1 - values, values),
        lambda values, random: random.uniform(0, 1, values.shape),
    ],
    ids=["another curve", "brighter", "3 % wrong", "another picture"],
)
def test_what_is_left_over_is_told_from_noise(change, levels):
    found = left_over(change, levels / 255)
    assert not found.fits
    assert str(found) != "it explains the picture"
