"""Derivatives of the image with respect to every float of the scene."""

from dataclasses import replace
from functools import partial
from itertools import product

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import raytrace
from raytrace.backends.jax import Renderer, Staged
from raytrace.backends.job import Job
from raytrace.language.glsl import Vec3
from raytrace.rendering import _hint_at_edges
from raytrace.scene import check_scene
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.film import TONE_MAPPERS, TRANSFERS, develop
from raytrace.shader.pixel import Frame
from raytrace.shader.uniforms import FilmUniforms
from tests.scenes import SEVERAL_SCENES, examples, filled, some
from tests.strategies import colors, directions, many, numbers, positions, spheres

#: An odd height: the default camera is level, and the middle row's rays are parallel to the ground.
SIZE = (48, 27)


def assert_finite(gradient):
    for path, leaf in jax.tree_util.tree_leaves_with_path(gradient):
        assert np.isfinite(leaf).all(), jax.tree_util.keystr(path)


@jax.jit
def gradient_of_any(scene):
    """The image is a leaf beside the gradient's own."""

    def brightness(scene):
        image = raytrace.render(scene, SIZE)
        return image.sum(), image

    return jax.grad(brightness, has_aux=True)(scene)


@pytest.mark.full
@SEVERAL_SCENES
def test_every_derivative_of_the_built_in_scenes_is_finite(name):
    scene = raytrace.load_scene(name)
    if name not in ("skybox-linear", "sphere"):
        image = raytrace.render(scene, SIZE, backend="numpy")
        scene = filled(scene)
        np.testing.assert_array_equal(raytrace.render(scene, SIZE, backend="numpy"), image)
    assert_finite(gradient_of_any(scene))


@st.composite
def worlds(draw):
    """Scenes of one structure, for which the gradient is compiled once: their numbers are anything."""
    spheres_ = draw(spheres(2, 2))
    board = raytrace.Plane(draw(positions), draw(directions), raytrace.Checkerboard(draw(numbers(0.125, 4))))
    slope = raytrace.Plane(draw(positions), draw(directions), raytrace.Plain(draw(colors)), casts_shadow=True)
    position, angle, rise = draw(positions), draw(st.sampled_from([0.0, 0.7, 3.1])), draw(numbers(-1, 1))
    return raytrace.Scene(
        spheres=spheres_,
        planes=(board, slope),
        sun=raytrace.Sun(draw(directions), draw(colors)),
        sky=raytrace.Sky(draw(colors), draw(colors), draw(colors)),
        camera=raytrace.PerspectiveCamera(position, position + np.array([np.sin(angle), rise, np.cos(angle)])),
    )


@examples(40, 200)
@given(worlds())
def test_every_derivative_of_any_scene_is_finite(scene):
    check_scene(scene)
    assert_finite(gradient_of_any(scene))


def scaled(size):
    """The last figure's world, of another size and with a plane more: its program is that of `worlds`."""
    scene = raytrace.load_scene("checkerboard")
    spheres_, plane, camera = scene.spheres, scene.planes[0], scene.camera
    return raytrace.Scene(
        spheres=raytrace.Spheres(spheres_.center[:2] * size, spheres_.radius[:2] * 5 * size, spheres_.color[:2]),
        planes=(
            raytrace.Plane(plane.point * size, plane.normal, raytrace.Checkerboard(2 * size)),
            raytrace.Plane(plane.point * size, plane.normal, raytrace.Plain([1, 1, 1]), casts_shadow=True),
        ),
        camera=raytrace.PerspectiveCamera(
            camera.position * size, camera.position * size - [0, 0, 2 * size], near=size, far=2 * size
        ),
    )


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1e6, 1e11])
def test_derivatives_are_finite_at_the_limits_of_size(size):
    """So small and so large that validation just admits it, in float32."""
    scene = scaled(size)
    check_scene(scene)
    assert_finite(gradient_of_any(scene))


def test_a_derivative_without_edges_is_told_once(caplog):
    """Of a scene that has any; a picture that is not traced says nothing."""
    scene = raytrace.load_scene("sphere")

    def traced(scene, **choices):
        jax.make_jaxpr(lambda scene: raytrace.render(scene, (8, 4), **choices))(scene)

    with caplog.at_level("WARNING", "raytrace"):
        _hint_at_edges.cache_clear()
        raytrace.render(scene, (8, 4), backend="numpy")
        traced(raytrace.load_scene("skybox"))
        traced(scene, antialias="edges")
        assert "antialias" not in caplog.text
        traced(scene)
        traced(scene)
    assert caplog.text.count("antialias='edges' sees them move") == 1


FILMS = list(product(TONE_MAPPERS, TRANSFERS))
WHITE = [("aces", "gamma2.2"), ("reinhard", "srgb"), ("hable", "none"), ("none", "gamma2.2")]


@pytest.mark.parametrize(("tone_mapper", "transfer"), some(WHITE, WHITE[1]))
def test_white_is_white_at_the_limits_of_brightness(tone_mapper, transfer):
    """The brightest colours that validation admits, in float32: nothing overflows on the way, to black or below 0."""
    scene = raytrace.Scene(
        spheres=raytrace.Spheres([[0, 0, 0]], [1.0], [[1e6, 1e6, 1e6]]),
        sun=raytrace.Sun(color=[1e6, 1e6, 1e6]),
        sky=raytrace.Sky(low=[1e6, 1e6, 1e6], high=[1e6, 1e6, 1e6], void=[1e6, 1e6, 1e6]),
        film=raytrace.Film(exposure=16, tone_mapper=tone_mapper, transfer=transfer, white_point=3000.0),
        lighting="on",
    )

    def brightness(sun, sky, film):
        image = raytrace.render(replace(scene, sun=sun, sky=sky, film=film), SIZE)
        return image.sum(), image

    if transfer == "gamma2.2":
        by_light = jax.jit(jax.value_and_grad(brightness, (0, 1, 2), has_aux=True))
        (_, image), gradient = by_light(scene.sun, scene.sky, scene.film)
        assert_finite(gradient)
    else:
        image = raytrace.render(scene, SIZE)
    np.testing.assert_allclose(image, 1, atol=2e-6)


@pytest.mark.parametrize(("tone_mapper", "transfer"), some(FILMS, *WHITE))
def test_black_and_nearly_black_have_a_finite_derivative(tone_mapper, transfer):
    """The power's derivative at 0 would be infinite, and is defined as 0; towards 0 it is large."""
    program = program_of(raytrace.Scene(film=raytrace.Film(tone_mapper=tone_mapper, transfer=transfer)), "robust")
    x = jnp.array([0, 1e-45, 1.2e-38, 3e-38, 1e-37, 1e-20, 1, 1e4], jnp.float32)

    def red(x):
        return develop(Vec3(x, x, x), FilmUniforms(None, None), program).x

    slope = jax.jit(jax.vmap(jax.grad(red)))(x)
    assert np.isfinite(slope).all()
    if transfer == "gamma2.2":
        assert slope[0] == 0


def test_a_black_image_has_finite_derivatives():
    black = raytrace.Sky(low=[0, 0, 0], high=[0, 0, 0], void=[0, 0, 0])
    assert_finite(gradient_of_any(replace(scaled(1.0), sky=black, sun=raytrace.Sun(color=[0, 0, 0]))))


def lit_ball(x):
    """Mean brightness of one lit sphere without shadow, silhouette and ground out of the way: it is smooth in `x`."""
    direction, color, height = x
    scene = raytrace.Scene(
        spheres=raytrace.Spheres(jnp.array([[0.0, 0.0, 0.0]]), jnp.array([1.0]), color[None]),
        sun=raytrace.Sun(direction=direction),
        lighting="on",
        camera=raytrace.PerspectiveCamera(position=jnp.array([0.0, 0.0, 3.0]).at[1].set(height), field_of_view=20.0),
        film=raytrace.Film(exposure=color[0]),
    )
    return raytrace.render(scene, (16, 9), dtype="float64").mean()


def test_derivatives_are_those_of_finite_differences():
    with jax.enable_x64(True):
        x = np.array([0.3, 0.5, 0.8]), np.array([0.5, 0.6, 0.7]), np.array(0.2)
        # One program for both.
        both = jax.jit(jax.value_and_grad(lit_ball))
        _, gradient = both(x)
        for k, part in enumerate(x):
            for i in np.ndindex(part.shape):

                def shifted(h, k=k, i=i):
                    moved = [p.copy() for p in x]
                    moved[k][i] += h
                    return both(tuple(moved))[0]

                # A step that the rounding of uniforms to float32 does not swallow.
                difference = (shifted(2**-9) - shifted(-(2**-9))) / 2**-8
                assert float(gradient[k][i]) == pytest.approx(float(difference), rel=2e-3, abs=2e-5)


@pytest.mark.parametrize("name", some(["skybox", "checkerboard"], "skybox"))
def test_forward_mode_is_reverse_mode(name):
    scene = raytrace.load_scene(name)
    if name == "checkerboard":
        # Of its loops over spheres, two rounds.
        scene = replace(scene, spheres=raytrace.Spheres(*(part[:2] for part in jax.tree.leaves(scene.spheres))))

    def brightness(direction):
        sunlit = replace(scene, sun=replace(scene.sun, direction=direction))
        return raytrace.render(sunlit, SIZE, dtype="float64").mean()

    with jax.enable_x64(True):
        direction = jnp.array([1.0, 0.75, 1.0])
        forward, reverse = (np.asarray(jax.jit(mode(brightness))(direction)) for mode in (jax.jacfwd, jax.grad))
    np.testing.assert_allclose(forward, reverse, rtol=1e-9)


@pytest.mark.parametrize("lighting", some(["off", "on", "shadow"], "off"))
def test_loops_that_stay_loops_have_the_same_derivatives(lighting):
    """With many spheres the winner's body is run again for the derivative; with few, the loop is written out."""
    scene = replace(raytrace.load_scene("checkerboard"), spheres=many(2), lighting=lighting)
    if lighting != "shadow":
        scene = replace(scene, planes=())

    program = program_of(scene, "robust")

    def brightness(uniforms, engine):
        job = Job(program, Frame(*SIZE), ("linear",), "float32", engine=engine)
        return Renderer(uniforms, job).draw(0, SIZE[1])["linear"].mean()

    uniforms = jax.tree.map(np.float32, uniforms_of(scene, SIZE[0] / SIZE[1]))

    def of_spheres(spheres, engine):
        return brightness(uniforms._replace(spheres=spheres), engine)

    written_out, looped = (
        jax.jit(jax.grad(partial(of_spheres, engine=Staged(few=few))))(uniforms.spheres) for few in (16, 1)
    )
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-3, atol=1e-6), written_out, looped)


def test_gradients_pass_the_rounding_to_float32():
    """In float64 the uniforms are rounded, and yet the derivative by the sun's colour is that without rounding."""
    with jax.enable_x64(True):
        scene = raytrace.load_scene("skybox")
        rounded, exact = (
            jax.grad(
                lambda color, exact=exact: raytrace.render(
                    replace(scene, sun=replace(scene.sun, color=color)), SIZE, dtype="float64", exact_inputs=exact
                ).mean()
            )(jnp.array([1.64, 1.27, 0.99]))
            for exact in (False, True)
        )
        rounded, exact = np.asarray(rounded), np.asarray(exact)
    assert (rounded > 0).all()
    np.testing.assert_allclose(rounded, exact, rtol=1e-6)
    assert not np.array_equal(rounded, exact)


@pytest.mark.full
@pytest.mark.parametrize("name", ["skybox", "sphere"])
def test_samples_are_differentiable(name):
    scene = raytrace.load_scene(name)

    def brightness(sun, camera):
        return raytrace.render(replace(scene, sun=sun, camera=camera), SIZE, samples=2).sum()

    assert_finite(jax.jit(jax.grad(brightness, (0, 1)))(scene.sun, scene.camera))
