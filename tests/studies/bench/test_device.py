"""What a device takes and keeps, on a CPU and tiny."""

import json

import pytest
from typer.testing import CliRunner

from raytrace.cli import app
from raytrace.studies.bench import device

SIZE = (32, 18)


@pytest.mark.full
def test_every_row_has_a_time_and_the_pictures_an_error(monkeypatch):
    monkeypatch.setattr(device, "SIDE", 8)
    rows = list(device.rows(SIZE, 1, crowds=(40,), batch=2, in_flight=2))
    assert len({row.name for row in rows}) == len(rows)
    assert all(row.milliseconds > 0 for row in rows)
    assert all(row.errors.over == 0 and row.errors.largest < 1e-3 for row in rows if row.errors)
    assert sum(row.errors is not None for row in rows) >= 5


@pytest.mark.full
@pytest.mark.parametrize("scene", ["sphere", "spheres", "orthographic"])
def test_a_cpu_keeps_every_promise(scene):
    found = list(device.checks(SIZE, [scene]))
    assert len(found) == 4
    assert all(check.kept for check in found), [check for check in found if not check.kept]


def test_a_promise_that_is_not_kept_is_told(monkeypatch):
    missed = [device.Check("sphere: skipping changes no bit", False, "3 pixels")]
    monkeypatch.setattr(device, "checks", lambda size: iter(missed))
    run = CliRunner().invoke(app, ["bench", "--device-accuracy"])
    assert run.exit_code == 1
    assert "MISSED sphere: skipping changes no bit: 3 pixels" in run.stdout
    assert json.loads(run.stdout.splitlines()[-1])["checks"] == [missed[0]._asdict()]
