import dataclasses

import numpy as np
import pytest

import raytrace
from raytrace.comparison import BOUNDS, failures
from raytrace.errors import InputError


@pytest.fixture(scope="module")
def found():
    a = np.random.default_rng(0).uniform(0, 0.9, (16, 16, 3))
    return raytrace.compare(a, a + 0.05)


@pytest.mark.parametrize("name", BOUNDS)
def test_every_bound_holds_at_the_value_and_fails_beyond_it(found, name):
    value = BOUNDS[name].value(found)
    beyond = np.nextafter(value, np.inf if name.startswith("min_") else -np.inf)
    assert failures(found, {name: value}) == []
    (told,) = failures(found, {name: float(beyond)})
    assert told.startswith(BOUNDS[name].what)


@pytest.mark.parametrize("name", BOUNDS)
def test_a_bound_that_is_nan_is_never_kept(found, name):
    assert len(failures(found, {name: float("nan")})) == 1


def test_a_value_that_is_nan_passes_nothing(found):
    nan = float("nan")
    broken = dataclasses.replace(
        found,
        ssim=found.ssim._replace(mean=nan, worst=nan),
        psnr=nan,
        rmse=nan,
        largest=found.largest._replace(value=nan),
        delta_e=found.delta_e._replace(mean=nan, p999=nan),
        flip=found.flip._replace(mean=nan, p999=nan),
    )
    for name in BOUNDS.keys() - {"max_share"}:  # a count, which is no NaN
        (told,) = failures(broken, {name: -1e9 if name.startswith("min_") else 1e9})
        assert " is nan, must be " in told


def test_all_that_fails_is_told(found):
    assert failures(found, {"max_share": 0.5, "min_psnr": 20, "max_rmse": 0.01}) == [
        "share of pixels over 1/255 is 1, must be at most 0.5",
        "RMSE is 0.05, must be at most 0.01",
    ]


def test_an_unknown_bound(found):
    with pytest.raises(InputError, match="bound: unknown 'min_sim'; did you mean 'min_ssim'"):
        failures(found, {"min_sim": 1})
