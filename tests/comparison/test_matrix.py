import json

import pytest

from raytrace.backends import BACKENDS, Backend
from raytrace.comparison import matrix
from raytrace.errors import InputError

SIZE = 48, 27


@pytest.fixture
def two_backends(monkeypatch):
    """NumPy and JAX, and one that is not there."""
    for name in BACKENDS.keys() - {"numpy", "jax"}:
        monkeypatch.delitem(BACKENDS, name)
    monkeypatch.setitem(BACKENDS, "elsewhere", Backend("tests.comparison.elsewhere", ("float32",)))


def test_every_backend_against_every_other(two_backends):
    table = matrix("sphere", SIZE)
    assert table.labels == ("numpy64", "numpy32", "jax64", "jax32")
    assert table.missing == {"elsewhere": "elsewhere: there is no such engine here"}
    for i, row in enumerate(table.labels):
        for j, column in enumerate(table.labels):
            assert table.ssim[i][j] == table.ssim[j][i] > 0.95, (row, column)
            assert table.over[i][j] == table.over[j][i] < 20
        assert (table.ssim[i][i], table.over[i][i]) == (pytest.approx(1), 0)
    assert table.over[0][2] == 0


def test_it_prints_as_a_table_of_fixed_width(two_backends):
    lines = str(matrix("sphere", SIZE)).splitlines()
    assert lines[0] == "SSIM, and pixels over 1/255 of 1296 (48x27)"
    assert lines[1].split() == ["numpy64", "numpy32", "jax64", "jax32"]
    assert len({len(line) for line in lines[1:6]}) == 1
    assert lines[2].startswith("numpy64  1.000000      0  ")
    assert lines[6] == "without elsewhere: elsewhere: there is no such engine here"


def test_json_is_strict_where_ssim_is_undefined(two_backends):
    table = matrix("skybox", (4, 4))
    report = json.loads(table.to_json(), parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert report["ssim"] == [[None] * 4] * 4
    assert report["over"] == [[0] * 4] * 4
    assert "undefined" in str(table)


@pytest.mark.parametrize(("scene", "size"), [("moon", SIZE), ("sphere", (0, 4))])
def test_bad_input_is_no_missing_backend(scene, size):
    with pytest.raises(InputError):
        matrix(scene, size)
