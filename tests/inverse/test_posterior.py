"""Importance sampling of a posterior, where it is known."""

import numpy as np
import pytest

from raytrace.inverse.likelihood import Noise
from raytrace.inverse.posterior import Chart, Stage, approach, degrees_between, quantile, sampled

NOISE = Noise(0.01, 0.0)


def found(log_likelihood, start, seed=0):
    random = np.random.default_rng(seed)
    stage, *_ = approach(lambda changes, noise: log_likelihood(changes), lambda change: NOISE, start, random)
    return sampled(log_likelihood, stage, random)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("size", [2, 3])
def test_of_a_normal_likelihood_it_is_that_distribution(size, seed):
    random = np.random.default_rng(seed)
    mean = random.normal(0, 0.005, size)
    axes = np.linalg.qr(random.normal(size=(size, size)))[0]
    deviations = 10.0 ** random.uniform(-5, -3, size)
    covariance = (axes * deviations**2) @ axes.T
    inverse = np.linalg.inv(covariance)

    def log_likelihood(changes):
        away = changes - mean
        return -0.5 * np.einsum("ni,ij,nj->n", away, inverse, away)

    posterior = found(log_likelihood, Stage(np.zeros(size), 1e-4 * np.eye(size)), seed)
    stage = posterior.stage()
    assert posterior.effective > 200
    whitened = axes.T @ (stage.mean - mean) / deviations
    assert np.abs(whitened).max() < 0.4
    np.testing.assert_allclose(np.diag(axes.T @ stage.covariance @ axes) / deviations**2, 1, atol=0.4)


def test_a_cell_that_jumps_bound_is_filled():
    """Equally likely within a small box and far less outside: what the samples of a picture leave open."""
    box = np.array([3e-4, 5e-5])

    def log_likelihood(changes):
        beyond = np.maximum(np.abs(changes - 0.004) / box - 1, 0).sum(-1)
        return -20 * np.ceil(np.minimum(beyond, 200))

    posterior = found(log_likelihood, Stage(np.zeros(2), 1e-4 * np.eye(2)))
    deviations = np.sqrt(np.diag(posterior.stage().covariance))
    np.testing.assert_allclose(deviations, box / np.sqrt(3), rtol=0.15)


def test_a_flat_likelihood_leads_nowhere():
    stage, *_ = approach(
        lambda changes, noise: np.zeros(len(changes)), lambda change: NOISE, Stage(np.zeros(2), 1e-4 * np.eye(2)),
        np.random.default_rng(0),
    )  # fmt: skip
    assert np.sqrt(np.diag(stage.covariance)).max() > 0.1


def test_a_chart_keeps_lengths_near_its_middle():
    random = np.random.default_rng(0)
    for _ in range(20):
        direction = random.normal(size=3)
        chart = Chart.around(direction / np.linalg.norm(direction), 1.0)
        change = random.normal(0, 1e-3, (5, 2))
        suns, stops = chart.suns(change)
        np.testing.assert_allclose(np.linalg.norm(suns, axis=-1), 1)
        lengths = np.degrees(np.linalg.norm(change, axis=-1))
        np.testing.assert_allclose(degrees_between(suns, chart.direction), lengths, rtol=1e-4)
        assert (stops == 1.0).all()


def test_weighted_quantiles():
    values, weights = np.arange(1000.0), np.full(1000, 1e-3)
    assert quantile(values, weights, 0.68) == pytest.approx(679.5)
    assert quantile(values[::-1], weights, 0.95) == pytest.approx(949.5)
