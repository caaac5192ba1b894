from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

import raytrace
from raytrace.backends.job import Job
from raytrace.backends.numpy import Renderer
from raytrace.language.control import Engine
from raytrace.rendering import Options, Rendering
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.scene.toml import figures
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import Frame
from raytrace.studies.stress.shadows import scaled
from tests.processes import peak_memory
from tests.scenes import SEVERAL_SCENES, some
from tests.strategies import scenes

SIZE = (96, 55)


def draw(scene, dtype, engine=None, intersection="textbook"):
    uniforms, program = uniforms_of(scene, SIZE[0] / SIZE[1]), program_of(scene, intersection)
    job = Job(program, Frame(*SIZE), tuple(COMPONENTS), dtype, engine=engine)
    return Renderer(uniforms, job).draw(0, SIZE[1])


def assert_same_bits(a, b):
    assert a.keys() == b.keys()
    for name in a:
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)


@SEVERAL_SCENES
@pytest.mark.parametrize("dtype", ["float32", "float64", "longdouble"])
@pytest.mark.parametrize("intersection", ["textbook", "robust"])
def test_skipping_changes_no_bit(name, dtype, intersection):
    """Only the pixels that take a branch, against both sides of every branch for every pixel."""
    scene = raytrace.load_scene(name)
    assert_same_bits(draw(scene, dtype, None, intersection), draw(scene, dtype, Engine(), intersection))


@settings(max_examples=50)
@given(scenes())
def test_skipping_changes_no_bit_of_any_scene(scene):
    assert_same_bits(draw(scene, "float64"), draw(scene, "float64", Engine()))


def test_without_the_steps_that_skip_shadows_the_image_is_the_same():
    """Where nobody asks for the shadow, no ray is sent from surfaces that face away from the sun."""
    options = {"size": SIZE, "backend": "numpy", "dtype": "float64"}
    linear = raytrace.render("checkerboard", output="linear", **options)
    np.testing.assert_array_equal(linear, raytrace.render("checkerboard", output="steps", **options)["linear"])


@SEVERAL_SCENES
def test_float64_is_longdouble_but_for_rounding(name):
    """At most 1e-11 apart, and no branch taken otherwise."""
    options = {"size": (480, 270), "backend": "numpy", "output": "steps"}
    double, wide = (raytrace.render(name, dtype=dtype, **options) for dtype in ("float64", "longdouble"))
    np.testing.assert_array_equal(double["index"], wide["index"])
    np.testing.assert_array_equal(double["shadow"], wide["shadow"])
    np.testing.assert_allclose(double["display"], wide["display"], rtol=0, atol=1e-11)
    assert wide["display"].dtype == np.longdouble


@SEVERAL_SCENES
def test_the_formulas_agree(name):
    """Textbook and robust, float64: 1e-12 in t on the figures; the others are larger worlds and look closer."""
    options = {"size": (480, 270), "backend": "numpy", "dtype": "float64", "output": "steps"}
    textbook, robust = (raytrace.render(name, intersection=formula, **options) for formula in ("textbook", "robust"))
    np.testing.assert_array_equal(textbook["index"], robust["index"])
    # At a silhouette t is ill-conditioned: its error is that of the root of a discriminant near 0.
    np.testing.assert_allclose(textbook["t"], robust["t"], rtol=0, atol=1e-12 if name in figures() else 1e-9)


def test_bands_are_the_whole(monkeypatch):
    monkeypatch.setattr("raytrace.rendering.BAND", 96 * 10)
    rendering = Rendering(Options("checkerboard", SIZE, backend="numpy", dtype="float64"))
    bands = list(rendering.bands())
    assert [len(band) for band in bands] == [10, 10, 10, 10, 10, 5]
    np.testing.assert_array_equal(np.concatenate(bands), rendering.whole())


def mirrored(record):
    """The record with x turned round in every place and direction."""
    mirror = np.array([-1, 1, 1])
    places = {"center", "point", "normal", "direction", "position", "target", "up"}
    return replace(record, **{name: value * mirror for name, value in vars(record).items() if name in places})


@settings(max_examples=50)
@given(scenes())
def test_mirroring_the_scene_mirrors_the_image(scene):
    """Width and height are powers of two, so that u and 1 - u are exact: columns are reversed, bit for bit.

    But for the checkerboard, whose tiles are half open: tile floor(p + 0.5) of -p is another one on borders only.
    """
    size = (64, 32)
    other = replace(
        scene,
        spheres=mirrored(scene.spheres),
        planes=tuple(map(mirrored, scene.planes)),
        sun=mirrored(scene.sun),
        camera=mirrored(scene.camera),
    )
    a, b = (raytrace.render(s, size, backend="numpy", dtype="float64", output="steps") for s in (scene, other))
    for name in ("index", "t", "NdL", "NdSky", "shadow"):
        np.testing.assert_array_equal(a[name][:, ::-1], b[name], err_msg=name)
    np.testing.assert_array_equal(a["N"][:, ::-1] * [-1, 1, 1], b["N"])
    same = (a["albedo"][:, ::-1] == b["albedo"]).all(axis=-1)
    np.testing.assert_array_equal(a["display"][:, ::-1][same], b["display"][same])
    assert same.mean() > 0.9


@pytest.mark.parametrize("k", [-3, 5])
def test_scaling_the_world_scales_t_exactly(k):
    """Spheres, plane and camera by 2**k: the same rays, and every t times 2**k, bit for bit."""
    scale = 2.0**k
    scene = raytrace.load_scene("checkerboard")
    a, b = (draw(s, "float64") for s in (scene, scaled(scene, scale)))
    np.testing.assert_array_equal(a["index"], b["index"])
    hit = a["index"] >= 0
    np.testing.assert_array_equal(a["t"][hit] * scale, b["t"][hit])
    np.testing.assert_array_equal(a["N"], b["N"])


EVERYWHERE = [("numpy", "float32"), ("numpy", "float64"), ("jax", "float32")]


@pytest.mark.parametrize(("backend", "dtype"), some(EVERYWHERE, *EVERYWHERE[:2]))
def test_shadows_that_start_on_the_surface_have_no_scale(backend, dtype):
    """Scaled by a power of two the scene has the same shadows, bit for bit; not so with the assignment's offset."""
    scene = raytrace.load_scene("shadows")

    def shadow(scale, start):
        steps = raytrace.render(
            scaled(scene, scale),
            SIZE,
            backend=backend,
            dtype=dtype,
            intersection="robust",
            output="steps",
            shadow_start=start,
        )
        # On the side away from the sun a surface's own shadow is no matter.
        return np.where(np.asarray(steps["NdL"]) > 0, np.asarray(steps["shadow"]), 0)

    for scale in (2.0**-20, 2.0**20):
        np.testing.assert_array_equal(shadow(scale, "surface"), shadow(1.0, "surface"))
    usual = shadow(1.0, "offset")
    assert np.mean(usual == shadow(1.0, "surface")) > 0.995
    assert np.sum(usual != shadow(2.0**-20, "offset")) > 10


@pytest.mark.parametrize(("height", "gib"), some([(256, 0.45), (4096, 1.2)], (256, 0.45)))
def test_memory_is_bounded(height, gib):
    """8192x4096 in float64 to a file and as an array (of 0.75 GiB by itself): under 1.2 GiB at the peak."""
    to_a_file = ["render", "--backend", "numpy", "--dtype", "float64", "--size", f"8192x{height}", "-o", "large.png"]
    as_an_array = f"import raytrace; raytrace.render('sphere', (8192, {height}), backend='numpy', dtype='float64')"
    assert peak_memory("-c", as_an_array) < gib * 2**30
    if height == 4096:
        assert peak_memory("-m", "raytrace", *to_a_file) < gib * 2**30
