"""Errors of derivatives, their table, and the command."""

import json

import numpy as np
import pytest

from raytrace.studies.boundaries import reference
from raytrace.studies.gradients import Error, derivative, errors, misses, table
from raytrace.studies.references import read_benchmark
from raytrace.studies.worlds import PARAMETERS
from tests.processes import command
from tests.studies.test_differences import SIZE, block_sums, within_a_silhouette


def entry(error, left):
    edges = Error(error, error / 2, left, 0.01)
    return {"edges": edges, "edges, 4x4": edges, "none": Error(1.0, 0.5, left, 0.01)}


FOUND = {"sun azimuth": {"one": entry(0.01, 0.9), "two": entry(0.03, 0.9), "three": entry(0.5, 0.1)}}


def test_the_table_has_medians_the_worst_and_how_many_are_within_the_limits():
    head, edges, finer, none = table(FOUND).splitlines()[2:]
    assert head == "sun azimuth: within 2 and 5; the reference's own 1.0"
    # The total of the third world is a difference of nearly equal sums.
    assert edges.split() == ["edges", "2.0", "3.0", "1/2", "1.5", "25.0", "2/3"]
    assert finer.split()[2:] == edges.split()[1:]
    assert none.split() == ["none", "100.0", "100.0", "0/2", "50.0", "50.0", "0/3"]


def test_each_world_out_of_the_limits_has_a_line():
    lines = misses({"sun azimuth": {name: {"edges": of["edges"]} for name, of in FOUND["sun azimuth"].items()}})
    assert [" ".join(line.split()) for line in lines] == [
        "two sun azimuth edges total 3.0, limit 2 (the reference's own 1.0)",
        "three sun azimuth edges blocks 25.0, limit 5 (the reference's own 1.0)",
    ]


def test_of_what_changes_nothing_there_is_no_error():
    nothing = errors(np.zeros((2, 3)), (np.zeros((2, 3)), np.zeros((2, 3))))
    assert np.isnan(nothing).all()
    found = {"camera's x": {"world": {"edges": nothing}}}
    assert "-" in table(found)
    assert misses(found) == []


def test_errors_are_relative_to_the_reference():
    right = np.array([[1.0, -0.5], [0.5, 1.0]])
    found = errors(right * 1.1, (right, np.full((2, 2), 0.03)))
    assert found == pytest.approx((0.1, 0.1, 2 / 3, 0.04))


def test_without_edges_the_usual_derivative_is_right():
    world, first = within_a_silhouette(), PARAMETERS["sun azimuth"]
    right = reference(world, {"": (first.moved, first.step)}, SIZE, 8)[""]
    found = errors(block_sums(derivative(world, "sun azimuth", SIZE, "none", 4)), (right.blocks, right.error))
    assert found.blocks < 5e-3
    assert found.total < 5e-3
    assert found.cancelled <= 1
    assert found.noise < 5e-3


def theirs(path, factor):
    """The stored references of a few small worlds, times a factor, as another program's."""
    held = [each for each in read_benchmark() if each.world.name.startswith("small")]
    arrays = {f"{each.world.name}/{name}": factor * of[0] for each in held for name, of in each.references.items()}
    np.savez(path, **arrays)
    return len(arrays)


def test_the_command_compares_other_programs(tmp_path):
    number = theirs(tmp_path / "theirs.npz", 1.2)
    done = command("gradients", "--theirs", str(tmp_path / "theirs.npz"))
    assert done.returncode == 0, done.stderr
    head, out = done.stdout.split("out of the limits, in percent:\n")
    assert len(out.splitlines()) == number
    assert "total 20.0, limit 2; blocks 20.0, limit 5" in out
    assert "theirs" in head
    done = command(
        "gradients",
        "--theirs",
        str(tmp_path / "theirs.npz"),
        "--world",
        "small-lit",
        "--parameter",
        "sun azimuth",
        "--json",
    )
    found = json.loads(done.stdout)
    assert found["sun azimuth"]["small-lit"]["theirs"]["blocks"] == pytest.approx(0.2, rel=1e-4)
    assert len(found) == len(found["sun azimuth"]) == 1


def test_the_command_says_nothing_of_what_is_within_the_limits(tmp_path):
    theirs(tmp_path / "theirs.npz", 1.001)
    assert "out of" not in command("gradients", "--theirs", str(tmp_path / "theirs.npz")).stdout


def test_the_command_writes_and_reads_a_folder(tmp_path):
    done = command("gradients", "--write", str(tmp_path / "made"), "--world", "small-red-0.03")
    assert done.returncode == 0, done.stderr
    assert {file.name for file in (tmp_path / "made").iterdir()} == {
        "worlds.toml",
        "references.npz",
        "small-red-0.03.toml",
    }
    (held,) = read_benchmark(tmp_path / "made")
    np.savez(tmp_path / "a.npz", **{"small-red-0.03/first radius": held.references["first radius"][0]})
    done = command("gradients", "--references", str(tmp_path / "made"), "--theirs", str(tmp_path / "a.npz"))
    assert "1/1" in done.stdout


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (["--world", "moon"], "world: unknown 'moon'"),
        (["--parameter", "moon"], "parameter: unknown 'moon'"),
        (["--theirs", "nowhere.npz"], "nowhere.npz: no such file"),
        (["--references", "nowhere"], "nowhere/worlds.toml: no such file"),
        (["--write", "a", "--finer"], "write: goes with --world only"),
        (["--theirs", "a.npz", "--finer"], "finer: is a choice of ours"),
        (["--world", "small-lit", "--parameter", "plane's height"], "none of those worlds"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(args, told):
    done = command("gradients", *args)
    assert done.returncode == 2
    assert told in done.stderr
    assert len(done.stderr.splitlines()) == 1
