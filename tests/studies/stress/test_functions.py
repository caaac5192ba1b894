"""Powers at the end of float32's range."""

import numpy as np
import pytest

pytest.importorskip("flint")

from raytrace.language.glsl import pow
from raytrace.shader.sky import SUN_GRADIENT
from raytrace.studies.stress import QUICK, stress, verdicts
from raytrace.studies.stress.arithmetics import of_floats
from raytrace.studies.stress.functions import LAST_OF_THE_LOBE, NORMAL

SMALLEST = 2.0**-126


@pytest.mark.parametrize("arithmetic", [a for a in of_floats() if a.dtype is np.float32], ids=lambda a: a.name)
def test_the_suns_lobe_at_every_float32(arithmetic):
    """All 600,000 numbers below 1 whose power 2400 is a normal number, and those just beyond."""
    first, last = (np.float32(x).view(np.int32) for x in (1 - LAST_OF_THE_LOBE - 2e-5, 1))
    x = np.arange(first, last + 1, dtype=np.int32).view(np.float32)
    exact = x.astype(np.longdouble) ** 2400
    found = arithmetic.of(lambda x: pow(x, SUN_GRADIENT))(x).astype(np.longdouble)
    normal = exact >= NORMAL * SMALLEST
    errors = np.abs(found - exact)[normal] / np.spacing(exact[normal].astype(np.float32))
    assert normal.sum() > 500_000
    assert errors.max() <= 160
    assert np.abs(found - exact)[~normal].max() <= SMALLEST


def test_both_promises_are_measured():
    points = list(stress(QUICK, ["sun_lobe", "lobe_vanishes"]))
    found = {verdict.statement: verdict for verdict in verdicts(points)}
    assert len(found) == 2
    assert all(verdict.holds for verdict in found.values())
    # At the last normal result, where nothing subnormal is charged.
    at_the_end = [point for point in points if point.axis == "sun_lobe" and point.x == LAST_OF_THE_LOBE]
    assert {point.who for point in at_the_end} == {a.name for a in of_floats()}
    # A result that is flushed to 0 is no normal result's error: it would break that promise.
    moved = [point._replace(axis="sun_lobe") for point in points if point.axis == "lobe_vanishes"]
    jax = [point for point in moved if point.who == "jax float32"]
    assert not any(verdict.holds for verdict in verdicts(jax))
