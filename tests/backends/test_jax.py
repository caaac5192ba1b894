import subprocess
import sys
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import raytrace
from raytrace.backends.jax import OneProgram, Renderer, Staged
from raytrace.backends.job import Job
from raytrace.rendering import Options, Rendering
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.scene.toml import figures
from raytrace.shader.pixel import Frame
from tests.scenes import SEVERAL_SCENES, some
from tests.strategies import many


def numpy_steps(name, size):
    return raytrace.render(name, size, backend="numpy", dtype="float64", output="steps")


def assert_same_image(name, size, tolerance):
    reference = numpy_steps(name, size)
    steps = raytrace.render(name, size, dtype="float64", output="steps")
    np.testing.assert_array_equal(steps["index"], reference["index"])
    np.testing.assert_array_equal(steps["shadow"], reference["shadow"])
    np.testing.assert_allclose(steps["display"], reference["display"], rtol=0, atol=tolerance)


@SEVERAL_SCENES
def test_float64_is_numpys(name):
    assert_same_image(name, (480, 270), 5e-12 if name in figures() else 2e-11)


@pytest.mark.full
@pytest.mark.parametrize("name", ["checkerboard", "lit-sphere", "skybox"])
def test_float64_is_numpys_at_full_size(name):
    assert_same_image(name, (1920, 1080), 5e-11)


@pytest.mark.full
def test_float32_is_near_float64():
    """At most 20 pixels of the default scene at 1920x1080 are off by more than 1/255."""
    reference = raytrace.render("checkerboard", backend="numpy", dtype="float64")
    image = np.asarray(raytrace.render("checkerboard"))
    assert image.dtype == np.float32
    assert np.count_nonzero(np.abs(image - reference).max(axis=-1) > 1 / 255) <= 20


#: Programs of this size are shared by the tests.
SIZE = (32, 18)


def engine_image(scene, engine, size=SIZE, dtype="float32"):
    uniforms, program = uniforms_of(scene, size[0] / size[1]), program_of(scene, "robust")
    job = Job(program, Frame(*size), ("display",), dtype, engine=engine)
    return Renderer(uniforms, job).draw(0, size[1])["display"]


@pytest.mark.parametrize(
    "engine",
    some([Staged(block=160), Staged(few=2), OneProgram(), OneProgram(few=2)], Staged(block=160), OneProgram(few=2)),
    ids=str,
)
def test_the_engines_agree(engine):
    """Staged with one or many blocks, loops written out or not, and everything under one plain `jit`."""
    scene = raytrace.load_scene("checkerboard")
    staged = raytrace.render(scene, SIZE)
    np.testing.assert_allclose(engine_image(scene, engine), staged, rtol=0, atol=2e-5)


def test_eager_arrays_run_the_shader():
    """Without any backend: the shader's functions on concrete JAX arrays."""
    from raytrace.language.glsl import Vec3
    from raytrace.shader import sphere_intersect
    from raytrace.shader.uniforms import Sphere

    zero, one = jnp.zeros(3), jnp.ones(3)
    ball = Sphere(Vec3(*jnp.zeros(3)), jnp.float32(1), Vec3(*jnp.ones(3)))
    t = sphere_intersect(Vec3(zero, zero, 5 * one), Vec3(zero, zero, -one), ball)
    assert t.tolist() == [4, 4, 4]


def test_many_spheres():
    """More than are written out: the loop stays a loop and the items are gathered."""
    scene = replace(raytrace.load_scene("checkerboard"), spheres=many(50))
    reference = raytrace.render(scene, (64, 36), backend="numpy", dtype="float64", output="steps")
    steps = raytrace.render(scene, (64, 36), dtype="float64", output="steps")
    np.testing.assert_array_equal(steps["index"], reference["index"])
    np.testing.assert_allclose(steps["display"], reference["display"], rtol=0, atol=1e-11)


def test_bands_are_the_whole_image(monkeypatch):
    monkeypatch.setattr("raytrace.rendering.BAND", 96 * 10)
    rendering = Rendering(Options("lit-sphere", (96, 55), dtype="float64"))
    np.testing.assert_allclose(np.concatenate(list(rendering.bands())), rendering.whole(), rtol=0, atol=1e-12)


def test_types_of_the_results():
    image = raytrace.render("checkerboard", SIZE)
    assert isinstance(image, jax.Array)
    assert image.dtype == jnp.float32
    assert isinstance(raytrace.render("checkerboard", SIZE, dtype="float64"), np.ndarray)
    with jax.enable_x64(True):
        image = raytrace.render("checkerboard", SIZE, dtype="float64")
        assert isinstance(image, jax.Array)
        assert image.dtype == jnp.float64


def test_x64_mode_changes_no_bit():
    def images():
        return [np.asarray(raytrace.render("checkerboard", SIZE, dtype=dtype)) for dtype in ("float64", "float32")]

    without = images()
    with jax.enable_x64(True):
        with_x64 = images()
    for a, b in zip(without, with_x64, strict=True):
        np.testing.assert_array_equal(a, b)


def test_float64_in_a_32_bit_trace_is_an_error():
    scene = raytrace.load_scene("sphere")
    with pytest.raises(raytrace.InputError, match="enable_x64"):
        jax.jit(lambda scene: raytrace.render(scene, (8, 4), dtype="float64"))(scene)


def test_a_traced_scene_passes_through_jit_and_vmap():
    scene = raytrace.load_scene("checkerboard")

    def image(direction):
        return raytrace.render(replace(scene, sun=replace(scene.sun, direction=direction)), SIZE)

    directions = jnp.array([[1, 0.75, 1], [0, 1, 0.2], [-1, 0.3, 0.5]])
    expected = np.stack([image(direction) for direction in np.asarray(directions)])
    np.testing.assert_allclose(jax.jit(jax.vmap(image))(directions), expected, rtol=0, atol=2e-5)


@pytest.mark.full
def test_a_whole_scene_passes_through_jit():
    scene = raytrace.load_scene("checkerboard")
    jitted = jax.jit(lambda scene: raytrace.render(scene, SIZE))
    np.testing.assert_allclose(jitted(scene), raytrace.render(scene, SIZE), rtol=0, atol=2e-5)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_a_concrete_scene_renders_inside_a_trace(dtype):
    """As the fixed target of a loss does."""
    target = jax.jit(lambda x: x * raytrace.render("checkerboard", SIZE, dtype=dtype).mean())(1.0)
    assert float(target) == pytest.approx(float(raytrace.render("checkerboard", SIZE, dtype=dtype).mean()), rel=1e-6)


def test_a_traced_direction_may_have_any_length():
    scene = raytrace.load_scene("skybox")

    def image(direction):
        return raytrace.render(replace(scene, sun=replace(scene.sun, direction=direction)), SIZE)

    traced, gradient = jax.jit(image), jax.jit(jax.grad(lambda direction: image(direction).sum()))
    direction = np.array([1, 0.75, 1], np.float32)
    expected = traced(direction)
    for length in (1e-25, 1e20):
        np.testing.assert_allclose(traced(direction * np.float32(length)), expected, rtol=0, atol=2e-5)
        assert np.asarray(gradient(direction * np.float32(length))).any()


def test_only_what_is_traced_is_computed_in_its_precision():
    """With the sun traced, the camera's matrices are still computed in double: the same rays, bit for bit."""
    scene = raytrace.load_scene("skybox", ["camera.target=[0.3,0.1,-0.7]"])

    def rays(color):
        sunlit = replace(scene, sun=replace(scene.sun, color=color))
        return raytrace.render(sunlit, (33, 17), output="steps")["rd"]

    np.testing.assert_allclose(jax.jit(rays)(jnp.ones(3)), rays(np.ones(3)), rtol=0, atol=1.2e-7)


def test_what_is_known_of_a_traced_scene_is_checked():
    scene = raytrace.load_scene("checkerboard")
    for change, told in [
        (lambda s: replace(s, film=raytrace.Film(tone_mapper="acse")), "film.tone_mapper: must be"),
        (lambda s: replace(s, film=raytrace.Film(transfer="gama")), "film.transfer: must be"),
        (lambda s: replace(s, sun=replace(s.sun, direction=s.sun.direction[:2])), "sun.direction: must be of shape"),
        (lambda s: replace(s, spheres=replace(s.spheres, radius=s.spheres.radius[:2])), "spheres.center: must be of"),
    ]:
        with pytest.raises(raytrace.InputError, match=told):
            jax.jit(lambda s, change=change: raytrace.render(change(s), (8, 4)))(scene)


def test_a_scene_maps_over_axes():
    scene = raytrace.load_scene("sphere")
    batch = jax.tree.map(lambda leaf: jnp.stack([leaf, leaf]), scene)
    axes = jax.tree.map(lambda _: 0, scene)
    images = jax.jit(jax.vmap(lambda scene: raytrace.render(scene, (8, 4)), in_axes=(axes,)))(batch)
    assert images.shape == (2, 4, 8, 3)


def test_another_scenes_values_are_not_compiled_again():
    from raytrace.backends.jax.renderer import _compiled

    scene = raytrace.load_scene("checkerboard")
    raytrace.render(scene, SIZE)
    before = _compiled.cache_info().misses
    raytrace.render(replace(scene, sun=raytrace.Sun(direction=[0, 1, 0])), SIZE)
    raytrace.render(raytrace.load_scene("checkerboard", ["camera.position=[0,1,3]", "spheres[0].radius=1"]), SIZE)
    assert _compiled.cache_info().misses == before


def test_importing_raytrace_leaves_jax_alone():
    """Importing JAX afterwards still makes scenes pytrees."""
    subprocess.run(
        [
            sys.executable,
            "-c",
            "import raytrace\n"
            "scene = raytrace.load_scene('checkerboard')\n"
            "import jax\n"
            "assert len(jax.tree.leaves(scene)) > 20\n"
            "raytrace.render('skybox', (8, 4), dtype='float64')\n"
            "assert not jax.config.jax_enable_x64\n",
        ],
        check=True,
    )
