"""Into what squares a pixel is cut: no edge is missed, and the squares are the pixel."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import raytrace
from raytrace.backends.numpy import Masked
from raytrace.edges import pixel
from raytrace.edges.squares import Cut
from raytrace.language.control import running
from raytrace.language.tree import tree_map
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.pixel import Frame
from raytrace.studies.worlds import random_world

SIZE, FINE = (64, 36), 8


@given(st.integers(1, 24), st.integers(1, 32), *[st.floats(-1, 1)] * 2, st.floats(1e-4, 1))
def test_the_squares_are_the_pixel(columns, rows, x, y, half):
    """They do not overlap and leave nothing out, wherever most of them are."""
    k = np.arange(columns * rows, dtype=np.int32)
    numbers = (np.full(k.shape, n, np.int32) for n in (columns, rows))
    middle, size = Cut(*numbers, *(np.full(k.shape, z) for z in (x, y, half))).square(k)
    for place, side, axis in ((middle.x, size.x, 1), (middle.y, size.y, 0)):
        ends = np.stack([place - side / 2, place + side / 2]).reshape(2, rows, columns)
        low, high = np.moveaxis(ends, axis + 1, 1)[:, :, 0]
        assert low[0] == pytest.approx(-0.5, abs=1e-9)
        assert high[-1] == pytest.approx(0.5, abs=1e-9)
        np.testing.assert_allclose(low[1:], high[:-1], atol=1e-9)
    assert (size.x >= -1e-12).all()


def cut_pixels(scene, size):
    """How many columns each pixel is cut into."""
    frame = Frame(*size)
    uniforms, program = uniforms_of(scene, size[0] / size[1]), program_of(scene, "robust", "offset", "edges")
    uniforms = tree_map(np.asarray, uniforms)
    found, cuts = [], pixel.cuts
    columns, rows = np.arange(size[0], dtype=float)[None], np.arange(size[1], dtype=float)[:, None]

    def kept(*args):
        found.append(cuts(*args))
        return found[-1]

    with pytest.MonkeyPatch.context() as patch, running(Masked(uniforms, program)), np.errstate(all="ignore"):
        patch.setattr(pixel, "cuts", kept)
        patch.setattr(pixel, "summed", lambda number, term, start, *args: start)
        pixel.pixels(uniforms, program, columns, rows, frame, ("linear",))
    return np.asarray(found[0].columns)


@pytest.mark.parametrize("seed", range(4))
def test_no_edge_is_missed(seed):
    """Where the samples of a pixel see several surfaces, lit and dark, or several tiles, it is cut."""
    scene = random_world(seed)
    if seed == 3:
        camera = raytrace.OrthographicCamera(position=(0, 2, 3), target=(0, 0, -2), height=4.0)
        scene = replace(scene, camera=camera)
    cut = cut_pixels(scene, SIZE) > 0
    width, height = (side * FINE for side in SIZE)
    steps = raytrace.render(scene, (width, height), backend="numpy", dtype="float64", output="steps")
    index, lit = steps["index"], (steps["shadow"] > 0) | (steps["NdL"] <= 1e-2)
    tiles = np.floor(steps["hitPoint"][..., ::2] / scene.planes[0].pattern.tile_size + 0.5)
    plane = index == len(scene.spheres.radius)
    labels = np.stack([index, lit, *np.moveaxis(np.where(plane[..., None], tiles, 0), -1, 0)])
    blocks = labels.reshape(4, SIZE[1], FINE, SIZE[0], FINE)
    several = (blocks.max((2, 4)) != blocks.min((2, 4))).any(0)
    assert several.sum() > 100
    assert cut[several].all()
    # And many of the others are not.
    assert (~cut[~several]).mean() > 0.3


def test_where_there_is_no_edge_a_pixel_is_its_middle():
    scene = raytrace.load_scene("shadows")
    edges, one = (
        raytrace.render(scene, SIZE, backend="numpy", dtype="float64", output="linear", **choice)
        for choice in ({"antialias": "edges"}, {})
    )
    whole = cut_pixels(scene, SIZE) == 0
    assert whole.mean() > 0.7
    np.testing.assert_array_equal(edges[whole], one[whole])


@pytest.mark.parametrize("name", ["checkerboard", "shadows", "skybox"])
def test_light_is_never_negative(name):
    for dtype in ("float32", "float64"):
        image = raytrace.render(name, SIZE, backend="numpy", dtype=dtype, output="linear", antialias="edges")
        assert (image >= 0).all()
