"""The engines of JAX by name: those of accelerators, on a CPU."""

from contextlib import nullcontext
from dataclasses import replace
from itertools import product

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import raytrace
from raytrace.backends.jax.choice import _without_its_warning, engine_of, platform_of
from raytrace.backends.jax.kernel import Images, Kernels, Where, draw_by_kernel, prepared
from raytrace.backends.jax.packing import Parts
from raytrace.backends.jax.renderer import _compiled
from raytrace.backends.jax.staged import Staged
from raytrace.rendering import Options, Rendering
from raytrace.scene.toml import scenes
from raytrace.studies.bench.crowds import crowd
from tests.scenes import some

ACCELERATORS = ("fused", "kernel")
SIZE = (19, 11)
#: By default a scene of each kind, by either engine: a pattern, a parallel projection.
SOME = (("checkerboard", "kernel"), ("orthographic", "fused"))


def assert_nearly(image, reference, most=2e-5):
    """Equal but at pixels on an edge, of which rounding decides."""
    apart = np.abs(np.asarray(image, np.float64) - np.asarray(reference, np.float64)).max(axis=-1)
    assert np.median(apart) < 1e-6
    assert (apart > most).sum() <= 0.02 * apart.size


@pytest.mark.parametrize(("scene", "engine"), some(product(scenes(), ACCELERATORS), *SOME))
def test_every_engine_draws_what_numpy_draws(scene, engine):
    reference = raytrace.render(scene, SIZE, backend="numpy", output="linear", dtype="float32")
    assert_nearly(raytrace.render(scene, SIZE, output="linear", engine=engine), reference, 2e-5 * reference.max())


@pytest.mark.parametrize(
    ("scene", "engine"), some(product(("lit-sphere", "checkerboard"), ACCELERATORS), ("lit-sphere", "kernel"))
)
def test_every_step_is_drawn(scene, engine):
    ours = raytrace.render(scene, SIZE, output="steps", engine=engine)
    staged = raytrace.render(scene, SIZE, output="steps")
    assert list(ours) == list(staged)
    for name, step in staged.items():
        assert ours[name].shape == step.shape
        assert ours[name].dtype == step.dtype
        apart = np.abs(np.asarray(ours[name], np.float64) - np.asarray(step)).reshape(SIZE[1], SIZE[0], -1).max(axis=-1)
        assert (apart > 1e-4).sum() <= 0.02 * apart.size, name


@pytest.mark.parametrize("engine", some(ACCELERATORS, "kernel"))
def test_in_float64_engines_agree_closely(engine):
    ours = raytrace.render("two-tilted-planes", SIZE, dtype="float64", engine=engine)
    reference = raytrace.render("two-tilted-planes", SIZE, backend="numpy", dtype="float64")
    assert np.abs(ours - reference).max() < 1e-12


@pytest.mark.parametrize("engine", some(ACCELERATORS, "kernel"))
def test_samples(engine):
    ours = raytrace.render("sphere", SIZE, samples=3, engine=engine)
    assert_nearly(ours, raytrace.render("sphere", SIZE, samples=3, backend="numpy"))


@pytest.mark.parametrize("scene", some(["skybox", "sphere"], "skybox"))
def test_a_kernel_draws_any_part(scene):
    whole = np.asarray(raytrace.render(scene, SIZE, engine="kernel"))
    rendering = Rendering(Options(scene, SIZE, engine="kernel"))
    for x, y in ((0, 0), (18, 10), (9, 5)):
        np.testing.assert_array_equal(rendering.pixel(x, y), whole[y, x])


@pytest.mark.parametrize("scene", some(["checkerboard", "two-hundred-spheres"], "checkerboard"))
def test_skipping_changes_no_bit_of_a_kernel(scene):
    # Linear, as above: the program is the same.
    images = [raytrace.render(scene, SIZE, output="linear", engine="kernel", skip=skip) for skip in (True, False)]
    np.testing.assert_array_equal(*images)


@pytest.mark.parametrize("engine", some(ACCELERATORS, "kernel"))
@pytest.mark.parametrize("spheres", some((1, 2, 6, 60), 1))
def test_derivatives_are_the_staged_engine_s(spheres, engine):
    scene = crowd(spheres)
    weights = jnp.asarray(np.random.default_rng(3).normal(size=(SIZE[1], SIZE[0], 3)), jnp.float32)
    suns = jnp.asarray([[1, 1.5, 0.3], [0.2, 0.7, 1]], jnp.float32)

    def loss(engine):
        return lambda sun: jnp.sum(
            raytrace.render(scene.with_("sun.direction", sun), SIZE, output="linear", engine=engine) * weights
        )

    value, slope = jax.jit(jax.vmap(jax.value_and_grad(loss(engine))))(suns)
    staged = jax.jit(jax.value_and_grad(loss(None)))
    for i, sun in enumerate(suns):
        expected = staged(sun)
        # A pixel of an edge may be another's in this arithmetic.
        np.testing.assert_allclose(value[i], expected[0], rtol=2e-2, atol=2e-2)
        np.testing.assert_allclose(slope[i], expected[1], rtol=2e-2, atol=2e-2)


@pytest.mark.parametrize(
    ("name", "engine"), some(product(("skybox", "checkerboard"), ACCELERATORS), ("skybox", "kernel"))
)
def test_derivatives_of_each_channel_and_second_ones_are_finite(name, engine):
    """A compiler may multiply by an exponent, 2400, before the zero of a channel that nobody asks for."""
    scene = raytrace.load_scene(name)

    def channels(sun):
        return raytrace.render(scene.with_("sun.direction", sun), SIZE, engine=engine).mean((0, 1))

    sun = jnp.asarray(scene.sun.direction, jnp.float32)
    slopes, bend = jax.jit(lambda sun: (jax.jacrev(channels)(sun), jax.hessian(lambda sun: channels(sun)[0])(sun)))(sun)
    assert np.isfinite(slopes).all()
    assert np.isfinite(bend).all()
    np.testing.assert_allclose(bend, bend.T, atol=1e-3)


def test_a_batch_of_batches_is_all_pairs():
    scene = raytrace.load_scene("skybox")
    suns = jnp.asarray([[1, 1.5, 0.3], [0.2, 0.7, 1]], jnp.float32)
    colours = jnp.asarray([[1, 1, 1], [2, 1, 0.5], [0, 0.1, 0.2]], jnp.float32)

    @jax.jit
    def picture(sun, colour):
        changed = replace(scene, sun=replace(scene.sun, direction=sun, color=colour))
        return raytrace.render(changed, (6, 4), output="linear", engine="kernel")

    pairs = jax.vmap(jax.vmap(picture, (None, 0)), (0, None))(suns, colours)
    assert pairs.shape == (2, 3, 4, 6, 3)
    for i, sun in enumerate(suns):
        for j, colour in enumerate(colours):
            np.testing.assert_allclose(pairs[i, j], picture(sun, colour), rtol=1e-5, atol=1e-6)


def test_edges_and_functions_of_a_user_s_have_no_kernel():
    edges = Rendering(Options("checkerboard", SIZE, antialias="edges", engine="kernel")).renderer
    assert isinstance(edges.engine, Staged)
    scene = raytrace.load_scene("sphere")
    own = replace(scene, film=replace(scene.film, tone_mapper=lambda x: x / (1 + x)))
    assert not isinstance(Rendering(Options(own, SIZE, engine="kernel")).renderer.engine, Kernels)
    assert_nearly(raytrace.render(own, SIZE, engine="kernel"), raytrace.render(own, SIZE))


def test_the_platform_chooses():
    renderer = Rendering(Options("checkerboard", SIZE)).renderer
    assert platform_of(jax.devices("cpu")[0]) == "cpu"
    assert isinstance(engine_of(renderer.job, "cpu", 6), Staged)
    assert engine_of(renderer.job, "cuda", 6) == Kernels()
    assert engine_of(renderer.job, "tpu", 6) != Kernels()
    assert isinstance(engine_of(renderer.job, "tpu", 1000), Staged)


def test_an_unknown_engine_is_one_line():
    with pytest.raises(raytrace.InputError, match=r"^engine: .*'quick'"):
        raytrace.render("sphere", SIZE, engine="quick")
    with pytest.raises(raytrace.InputError, match=r"^engine: backend numpy"):
        raytrace.render("sphere", SIZE, backend="numpy", engine="kernel")


@pytest.mark.parametrize("scene", some(scenes(), "two-tilted-planes"))
def test_the_kernel_can_be_lowered_for_a_gpu(scene):
    """Pallas knows every operation of the text: what it does not know fails here and not on a GPU."""
    renderer = Rendering(Options(scene, SIZE, output="steps")).renderer
    images = Images(renderer.job, SIZE[1], SIZE[0], Kernels())
    layout, numbers, _ = renderer.prepared()

    def drawn(numbers):
        uniforms, _ = Parts(layout, numbers).structure
        return draw_by_kernel(images, uniforms, prepared(uniforms, renderer.job.program), Where(0, 0, 0))

    with _without_its_warning(), a_gpu():
        lowered = jax.jit(drawn).trace(numbers).lower(lowering_platforms=("cuda",))
    assert "triton" in lowered.as_text()


def a_gpu():
    """A GPU that JAX lowers for without having one; older JAX does not ask which it is."""
    if not hasattr(jax.sharding, "AbstractDevice"):
        return nullcontext()
    device = jax.sharding.AbstractDevice(device_kind="NVIDIA H100", num_cores=132, platform="gpu")
    return jax.sharding.use_abstract_mesh(jax.sharding.AbstractMesh((), (), abstract_device=device))


@pytest.mark.full
def test_on_a_machine_with_a_gpu_the_platform_is_known_where_it_is_lowered(monkeypatch):
    """There the program of a `jit` holds what each platform draws; a CPU is one of them."""
    monkeypatch.setattr("raytrace.backends.jax.renderer.backends", lambda: {"cpu": None, "cuda": None})
    scene = raytrace.load_scene("lit-sphere")
    size = (13, 8)  # not a traced program of another test

    def loss(sun):
        return raytrace.render(scene.with_("sun.direction", sun), size, output="linear").mean()

    sun = jnp.asarray([0.3, 1, 0.2], jnp.float32)
    traced = jax.jit(jax.value_and_grad(loss)).trace(sun)
    assert "raytrace_picture" in str(jax.make_jaxpr(loss)(sun))
    value, slope = traced.lower().compile()(sun)
    steps = [(loss(sun.at[k].add(h)) - loss(sun.at[k].add(-h))) / (2 * h) for k in range(3) for h in (0.05,)]
    drawn = raytrace.render(scene.with_("sun.direction", np.asarray(sun)), size, output="linear")
    np.testing.assert_allclose(value, drawn.mean(), rtol=1e-5)
    np.testing.assert_allclose(slope, steps, atol=2e-3)


def test_where_pallas_cannot_xla_draws(monkeypatch, caplog):
    def cannot(*_, **__):
        raise RuntimeError("No supported GPU devices found")

    expected = raytrace.render("sphere", SIZE, engine="fused")
    renderer = Rendering(Options("sphere", SIZE)).renderer
    renderer.engine = replace(Kernels(), tile_height=4)
    monkeypatch.setattr("raytrace.backends.jax.kernel._Given.called", cannot)
    with caplog.at_level("WARNING", "raytrace"):
        np.testing.assert_array_equal(renderer.draw(0, SIZE[1])["display"], expected)
    assert "Pallas" in caplog.text


def test_arrays_that_are_changed_in_place_are_seen():
    scene = raytrace.load_scene("spheres")
    before = np.asarray(raytrace.render(scene, SIZE))
    np.testing.assert_array_equal(raytrace.render(scene, SIZE), before)
    scene.spheres.color[:] = 0.5 * scene.spheres.color
    after = np.asarray(raytrace.render(scene, SIZE))
    assert (after != before).any()
    assert_nearly(after, raytrace.render(scene, SIZE, backend="numpy"))


def test_a_prepared_renderer_is_render():
    scene = raytrace.load_scene("spheres")
    renderer = raytrace.prepare(scene, SIZE, output="linear")
    np.testing.assert_array_equal(renderer(), raytrace.render(scene, SIZE, output="linear"))
    other = scene.with_("sun.direction", np.array([0.3, 1, 0.2]))
    programs = _compiled.cache_info().misses
    drawn = np.asarray(renderer(other))
    assert _compiled.cache_info().misses == programs
    assert_nearly(drawn, raytrace.render(other, SIZE, output="linear", backend="numpy"))
    sun = jnp.asarray([0.3, 1, 0.2], jnp.float32)
    traced = jax.jit(lambda sun: renderer(scene.with_("sun.direction", sun)))(sun)
    np.testing.assert_allclose(traced, renderer(other), rtol=1e-5, atol=1e-6)
    with pytest.raises(raytrace.InputError, match=r"^size: "):
        raytrace.prepare(scene, (0, 5))


def test_what_is_kept_does_not_hide_a_mistake():
    scene = raytrace.load_scene("spheres")
    raytrace.render(scene, SIZE, samples=1)
    for wrong in ({"samples": True}, {"size": (19.0, 11.0)}):
        with pytest.raises(raytrace.InputError):
            raytrace.render(scene, **{"size": SIZE, **wrong})
