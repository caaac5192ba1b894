"""The command `stress` and what it promises."""

import json

import pytest

pytest.importorskip("flint")

from raytrace.studies.stress import QUICK, stress, verdicts
from raytrace.studies.stress.measure import Measurement
from raytrace.studies.stress.spheres import COMPARED
from tests.processes import command


def test_an_axis_in_json_and_as_a_figure(tmp_path):
    done = command("stress", "checkerboard", "--json", "--plot", str(tmp_path))
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert {point["axis"] for point in told["points"]} == {"checkerboard"}
    assert {point["who"].split()[0] for point in told["points"]} == {"numpy", "jax", "rounding"}
    assert [bound["holds"] for bound in told["bounds"]] == [True]
    assert [path.name for path in tmp_path.iterdir()] == ["checkerboard.png"]


#: Arguments of the command, and what it says of them.
BAD_INPUT = [
    (("distanze",), "raytrace: axis: unknown 'distanze'; did you mean 'distance'? there is: "),
    (("distance", "--plot", "nowhere"), "raytrace: nowhere: there is no such folder"),
]


@pytest.mark.parametrize(("arguments", "line"), BAD_INPUT)
def test_bad_input_is_one_line(arguments, line):
    done = command("stress", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(line)
    assert done.stderr.count("\n") == 1


def test_the_textbook_breaks_where_it_should_and_the_bounds_see_it():
    """What robust promises, asked of textbook's answers, does not hold."""
    points = list(stress(QUICK, ["distance"]))
    assert all(verdict.holds for verdict in verdicts(points))
    swapped = [
        point._replace(who=point.who.replace("textbook", "robust")) for point in points if "textbook" in point.who
    ]
    broken = [verdict for verdict in verdicts(swapped) if not verdict.holds]
    assert len(broken) >= 3


def test_a_bound_is_not_given_for_what_was_not_tried():
    assert verdicts([]) == []
    one = Measurement("distance", COMPARED, "numpy float32 robust", 10, 0.5)
    assert [verdict.holds for verdict in verdicts([one])] == [False]
