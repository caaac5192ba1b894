"""Many scenes at once."""

from dataclasses import replace

import numpy as np
import pytest

import raytrace
from raytrace import batches
from raytrace.studies.bench.crowds import crowd
from tests.scenes import some

SIZE = (19, 11)


@pytest.mark.parametrize("engine", some((None, "fused", "kernel"), "fused"))
def test_each_is_the_scene_s_own_picture(engine, monkeypatch):
    monkeypatch.setattr(batches, "PIXELS", 2 * SIZE[0] * SIZE[1])
    lit = raytrace.load_scene("lit-sphere")
    scenes = [lit, "skybox", replace(lit, spheres=crowd(3).spheres), crowd(2), replace(lit, spheres=crowd(5).spheres)]
    images = raytrace.render_each(scenes, SIZE, engine=engine, output="linear")
    assert len(images) == len(scenes)
    assert_each(images, scenes, output="linear")


def assert_each(images, scenes, **choices):
    for scene, image in zip(scenes, images, strict=True):
        alone = raytrace.render(scene, SIZE, backend="numpy", **choices)
        apart = np.abs(image - alone).max(axis=-1)
        # A pixel of an edge may be another's in JAX.
        assert (apart > 1e-5 * alone.max()).sum() <= 0.02 * apart.size


@pytest.mark.parametrize("choices", some([{"shadow_start": "surface"}, {"dtype": "float64"}], {"dtype": "float64"}))
def test_choices_of_each(choices):
    scenes = [crowd(2), crowd(3)]
    images = raytrace.render_each(scenes, SIZE, engine="fused", **choices)
    assert images[0].dtype == choices.get("dtype", "float32")
    assert_each(images, scenes, **choices)


def test_none_and_what_cannot_be():
    assert raytrace.render_each([], SIZE) == []
    with pytest.raises(raytrace.InputError, match=r"^output: "):
        raytrace.render_each(["sphere"], SIZE, output="steps")
    with pytest.raises(raytrace.InputError, match=r"^size: "):
        raytrace.render_each(["sphere"], (0, 1))
