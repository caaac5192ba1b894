import json
from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.backends.jax.renderer import Renderer
from raytrace.cli.bench import bench
from raytrace.errors import InputError
from raytrace.scene.toml import DEFAULT_SCENE, load_scene
from raytrace.studies.bench.accuracy import Errors, reference
from raytrace.studies.bench.crowds import crowd, field
from raytrace.studies.bench.pareto import Row, front, plot
from raytrace.studies.bench.scaling import preparation
from raytrace.studies.bench.timing import Timing, in_turn


def row(name, milliseconds, rms):
    return Row(name, Timing(milliseconds, milliseconds, milliseconds), Errors(rms, rms, rms, rms, 0, 0))


def test_the_front_is_what_no_other_beats():
    rows = [row("a", 1, 1e-3), row("b", 2, 1e-3), row("c", 3, 1e-6), row("d", 2.5, 1e-5), row("e", 9, 1e-5)]
    assert [row.name for row in front(rows)] == ["a", "d", "c"]
    assert front([*rows, Row("queries", Timing(0.1, 0.1, 0.1), None)]) == front(rows)


def test_contenders_are_timed_in_turn():
    calls = []
    timings = in_turn({name: lambda name=name: calls.append(name) for name in "ab"}, runs=2)
    assert calls == ["a", "b"] * 3
    assert timings["a"].fastest <= timings["a"].median <= timings["a"].slowest


def test_errors_are_counted_on_and_off_discontinuities():
    exact = reference("checkerboard", (64, 36))
    assert exact.errors(exact.display) == Errors(0, 0, 0, 0, 0, 0)
    image = np.array(exact.display, np.float64)
    edge, inner = (tuple(np.argwhere(mask)[7]) for mask in (exact.edge, ~exact.edge))
    image[edge] += 0.5
    image[inner] += 0.25
    errors = exact.errors(image)
    assert (errors.over, errors.edge_over) == (1, 1)
    assert errors.largest == pytest.approx(0.25)
    image[inner] = np.nan
    assert exact.errors(image).over == 1


def test_every_surfaces_border_is_a_discontinuity():
    steps = raytrace.render("checkerboard", (64, 36), backend="numpy", dtype="float64", output="steps")
    edge = reference("checkerboard", (64, 36)).edge
    index = steps["index"]
    assert edge[:, 1:][index[:, 1:] != index[:, :-1]].all()
    assert edge[1:][index[1:] != index[:-1]].all()
    assert not reference("skybox", (64, 36)).edge.all()


def test_a_field_lies_on_the_ground():
    scene = field(500)
    ground = scene.planes[0].point[1]
    np.testing.assert_allclose(scene.spheres.center[:, 1] - scene.spheres.radius, ground)
    far = np.linalg.norm(scene.spheres.center - scene.camera.position, axis=1) > 20
    assert 0.9 < far.mean() < 1


def test_crowds_cover_alike():
    """The picture's share of spheres is about the same for any number of them."""
    shares = []
    for n in (200, 2000):
        scene = crowd(n)
        assert scene.spheres.radius.shape == (n,)
        index = raytrace.render(scene, (96, 54), backend="numpy", output="steps")["index"]
        shares.append(np.mean((index >= 0) & (index < n)))
    assert shares[0] == pytest.approx(shares[1], rel=0.25)


def test_the_plot_is_drawn(tmp_path):
    for name in ("a.svg", "a.png"):
        plot([row("a", 1, 1e-3), row("b", 2, 1e-5), row("c", 3, 1e-3)], "title", tmp_path / name)
        assert (tmp_path / name).stat().st_size > 1000


def test_scaling_over_pixels(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("raytrace.studies.bench.scaling.WIDTHS", (32, 64))
    bench(scaling="pixels", size="32x18", runs=1, as_json=True, plot=tmp_path / "p.png")
    points = json.loads(capsys.readouterr().out)
    assert [point["work"] for point in points if point["name"] == "jax float32"] == [32 * 18, 64 * 36]
    assert (tmp_path / "p.png").stat().st_size > 1000


def test_the_roofline_adds_up(capsys):
    bench(roofline=True, size="64x36", runs=1, as_json=True)
    found = json.loads(capsys.readouterr().out)
    assert found["operations"] > 64 * 36 * 100
    assert found["at_least"] == pytest.approx(1e3 * found["operations"] / found["peak_operations"])


def test_what_is_prepared_is_another_scene(monkeypatch):
    """The scene that is prepared between two measurements is not the one that is measured."""
    sun = load_scene(DEFAULT_SCENE).sun.direction
    prepared = []
    monkeypatch.setattr(Renderer, "prepare", lambda self: prepared.append(self.uniforms.sun.direction))
    preparation(crowd(300), (32, 18), runs=1)
    mine, others = (np.array(prepared[k], np.float32) for k in (1, 0))
    np.testing.assert_array_equal(mine, np.float32(sun))
    assert (mine != others).any()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scaling": "sphere"}, "spheres"),
        ({"scaling": "pixels", "figures": True}, "one at a time"),
        ({"plot": Path("a.gif")}, "svg or"),
        ({"figures": True, "plot": Path("a.svg")}, "none with --figures"),
    ],
)
def test_mistakes(options, message):
    with pytest.raises(InputError, match=message):
        bench(**options)
