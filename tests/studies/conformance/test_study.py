"""Real engines are within the bounds on random scenes, and one that errs is named."""

import importlib

import numpy as np
import pytest
import typer

from raytrace.cli.conformance import conformance
from raytrace.errors import InputError
from raytrace.scene import check_scene
from raytrace.shader.film import TONE_MAPPERS, TRANSFERS
from raytrace.shader.sphere import INTERSECTIONS
from raytrace.studies.conformance import ENGINES, STRUCTURES, random_scene, study
from tests.engines import need
from tests.scenes import some


def test_structures_have_every_choice():
    def chosen(field):
        return {getattr(structure, field) for structure in STRUCTURES}

    assert chosen("lighting") == {"off", "on", "shadow"}
    assert chosen("camera") == {"perspective", "orthographic", "matrix"}
    assert chosen("tone_mapper") == set(TONE_MAPPERS)
    assert chosen("transfer") == set(TRANSFERS)
    assert chosen("intersection") == {None, *INTERSECTIONS}
    assert chosen("exposure") == chosen("white_point") == {True, False}
    assert {plane for structure in STRUCTURES for plane in structure.planes} == {
        ("checkered", False),
        ("checkered", True),
        ("plain", True),
    }
    assert min(chosen("spheres")) == 0
    assert max(chosen("spheres")) > 3


def test_random_scenes_are_valid_and_each_its_own():
    seen = []
    for i in range(120):
        scene = random_scene(np.random.default_rng([3, i]), STRUCTURES[i % len(STRUCTURES)])
        check_scene(scene)
        assert scene not in seen
        seen.append(scene)
    again = random_scene(np.random.default_rng([3, 5]), STRUCTURES[5])
    assert again == seen[5]
    colors = np.concatenate([scene.spheres.color.ravel() for scene in seen])
    assert colors.min() == 0
    assert colors[colors > 0].min() < 1e-5
    assert colors.max() > 1e5


@pytest.mark.parametrize("engine", some([name for name in ENGINES if name != "jax"], "numpy", "opengl"))
def test_engines_are_within(engine):
    if engine != "numpy":
        need(engine)
    result = study(24, 1, engines=(engine,))
    assert result.outside == ()
    assert (result.images, result.missing) == (48, {})


@pytest.mark.full
def test_jax_is_within():
    """Of two structures, as each is a program to compile."""
    result = study(24, 2, engines=("jax",), structures=(STRUCTURES[0], STRUCTURES[8]))
    assert result.outside == ()
    assert result.images == 48


def test_an_engine_that_errs_is_named(monkeypatch, capsys):
    """By a hundredth at one pixel: a line for each image, and exit code 1."""
    module = importlib.import_module("raytrace.studies.conformance.study")

    def wrong(scene, size, **options):
        image = np.array(render(scene, size, **options))
        image[3, 4, 1] = 1.01 * image[3, 4, 1] + 1e-3
        return image

    render = module.render
    monkeypatch.setattr(module, "render", wrong)
    with pytest.raises(typer.Exit) as ended:
        conformance(scenes=2, seed=7, engine=["numpy"])
    assert ended.value.exit_code == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    assert lines[0].startswith("scene 0 of seed 7, numpy, display: outside at 1 of 360 pixels, by up to ")
    assert lines[-1].startswith("2 scenes, 4 images, 1440 pixels: 4 images have pixels outside; ")


def test_an_unknown_engine_is_told():
    with pytest.raises(InputError, match="--engine: unknown 'opengles'; did you mean 'opengl'"):
        conformance(engine=["opengles"])


def test_an_engine_that_has_drawn_is_not_missing(monkeypatch):
    """What it refuses later is a fault, not a lack of it."""
    module = importlib.import_module("raytrace.studies.conformance.study")
    drawn = []

    def refuses_the_second(scene, *args, **options):
        drawn.append(scene)
        if len(drawn) > len(module.KINDS):
            raise InputError("no such scene")
        return render(scene, *args, **options)

    render = module.render
    monkeypatch.setattr(module, "render", refuses_the_second)
    with pytest.raises(InputError, match="no such scene"):
        study(2, 1, engines=("numpy",))
