"""Pixels as means over their squares: the image, and the derivatives of edges that move."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import raytrace
from raytrace.backends.jax.forward import forward_mode_only
from raytrace.errors import InputError
from raytrace.studies.differences import block_sums, difference
from raytrace.studies.worlds import PARAMETERS, random_world
from tests.scenes import some

SIZE = (64, 36)
EXACT = {"backend": "numpy", "dtype": "float64"}


def rms(image, reference):
    return np.sqrt(np.mean((np.asarray(image) - np.asarray(reference)) ** 2))


@pytest.mark.parametrize(
    "name",
    some(
        sorted({*raytrace.scenes()} - {"skybox-linear", "two-hundred-spheres"}), "checkerboard", "overlapping-spheres"
    ),
)
def test_it_is_nearer_to_the_supersampled_image(name):
    """A tenth of the error of one sample. (The sky alone has no edge; two hundred spheres take long.)"""
    scene = raytrace.load_scene(name)
    reference = raytrace.render(scene, SIZE, samples=16, **EXACT)
    edges, one = (
        rms(raytrace.render(scene, SIZE, **choice, **EXACT), reference) for choice in ({"antialias": "edges"}, {})
    )
    assert edges <= 0.1 * one


@pytest.mark.parametrize(("name", "samples"), some([("spheres", 32), ("checkerboard", 64)], ("spheres", 32)))
def test_more_samples_come_nearer(name, samples):
    scene = raytrace.load_scene(name)
    reference = raytrace.render(scene, (32, 18), samples=samples, **EXACT)
    one, two = (rms(raytrace.render(scene, (32, 18), antialias="edges", samples=n, **EXACT), reference) for n in (1, 2))
    assert two <= one


@pytest.mark.parametrize("name", some(["sphere", "lit-sphere", "two-tilted-planes"], "sphere"))
def test_jax_is_numpy(name):
    scene = raytrace.load_scene(name)
    fast = raytrace.render(scene, SIZE, antialias="edges")
    slow = raytrace.render(scene, SIZE, antialias="edges", intersection="robust", **EXACT)
    assert np.mean(np.abs(np.asarray(fast) - slow).max(-1) > 1 / 255) < 0.002


def test_linear_and_display_alone_are_means():
    with pytest.raises(InputError, match="antialias: output 'steps'"):
        raytrace.render("sphere", SIZE, output="steps", antialias="edges")
    with pytest.raises(InputError, match="antialias: backend opengl has none"):
        raytrace.render("sphere", SIZE, backend="opengl", antialias="edges")
    with pytest.raises(InputError, match="antialias: unknown 'edge'; did you mean 'edges'"):
        raytrace.render("sphere", SIZE, antialias="edge")


def ground():
    """A plain ground alone: its horizon is an edge, which the camera moves."""
    return raytrace.Scene(planes=[raytrace.Plane(pattern=raytrace.Plain([0.5, 0.4, 0.3]))], lighting="off")


def with_sun_and_radius(scene, direction, radius):
    bodies = replace(scene.spheres, radius=scene.spheres.radius + radius)
    return replace(scene, sun=replace(scene.sun, direction=direction), spheres=bodies)


def with_target_and_distance(scene, target, distance):
    camera = replace(scene.camera, target=target, near=scene.camera.near + distance)
    return replace(scene, camera=camera)


BY = {
    "skybox": (with_target_and_distance, [0.0, 0.5, 0.0]),
    "ground": (with_target_and_distance, [0.0, 0.5, 0.0]),
    "sphere": (with_sun_and_radius, [1.0, 0.75, 1.0]),
    "lit-sphere": (with_sun_and_radius, [1.0, 0.75, 1.0]),
}


def by_vector_and_number(name):
    """The brightness of a scene by a vector and a number of several leaves, and where."""
    scene = ground() if name == "ground" else raytrace.load_scene(name)
    changed, vector = BY[name]

    def brightness(vector, number):
        return raytrace.render(changed(scene, vector, number), (32, 18), antialias="edges").mean()

    return brightness, (jnp.array(vector), jnp.float32(0))


@pytest.mark.full
@pytest.mark.parametrize("name", BY)
def test_both_modes_agree(name):
    """Reverse mode is made of forward mode."""
    brightness, at = by_vector_and_number(name)
    along = jnp.array([0.3, -0.2, 0.5]), jnp.float32(0.1)
    # One program, in which what both compute is compiled once.
    (_, forward), reverse = jax.jit(
        lambda *at: (jax.jvp(brightness, at, along), jax.grad(brightness, argnums=(0, 1))(*at))
    )(*at)
    expected = sum(np.sum(slope * part) for slope, part in zip(reverse, along, strict=True))
    np.testing.assert_allclose(forward, expected, rtol=2e-3, atol=1e-6)
    # The sun changes nothing of an unlit sphere.
    assert np.abs(reverse[name == "sphere"]).max() > 1e-3


def test_an_edge_that_moves_has_the_derivative_of_its_coverage():
    """The slanting horizon of a plain ground: the mean's derivative is nearly what NumPy's images differ by.

    Not exactly: the sky's colour changes within a pixel, of which there are few here.
    """
    scene = ground()
    scene = replace(scene, camera=replace(scene.camera, up=[0.3, 1, 0]))

    def brightness(height, **choices):
        raised = with_target_and_distance(scene, scene.camera.target + np.array([0, 1, 0]) * height, 0)
        return raytrace.render(raised, (32, 18), antialias="edges", **choices).mean()

    expected = (brightness(0.01, **EXACT) - brightness(-0.01, **EXACT)) / 0.02
    assert jax.jit(jax.grad(brightness))(0.0) == pytest.approx(expected, rel=0.1)


@pytest.mark.full
@pytest.mark.parametrize("name", BY)
def test_a_batch_of_directions_is_each_of_them(name):
    brightness, at = by_vector_and_number(name)
    both = [mode(brightness, argnums=(0, 1)) for mode in (jax.grad, jax.jacfwd)]
    for a, b in zip(*jax.jit(lambda *at: [slopes(*at) for slopes in both])(*at), strict=True):
        assert np.isfinite(a).all()
        np.testing.assert_allclose(a, b, rtol=2e-3, atol=1e-6)


@pytest.mark.full
def test_the_derivative_is_that_of_the_supersampled_image():
    """By the sun's azimuth, where the usual derivative is far off: `raytrace gradients` has more."""
    world, size = random_world(1), (192, 108)
    few = raytrace.Spheres(world.spheres.center[:2], world.spheres.radius[:2], world.spheres.color[:2])
    world = replace(world, spheres=few)
    reference = difference(world, "sun azimuth", size, 16).blocks

    def turned(angle, antialias):
        direction = PARAMETERS["sun azimuth"].moved(world, angle).sun.direction
        lit = replace(world, sun=replace(world.sun, direction=direction))
        return raytrace.render(lit, size, antialias=antialias)

    def slopes(antialias):
        """In float32 and by nothing but the sun: other programs take far longer to compile."""
        with forward_mode_only():
            return jax.jit(lambda angle: jax.jvp(partial(turned, antialias=antialias), (angle,), (1.0,))[1])(0.0)

    edges, none = (block_sums(np.asarray(slopes(antialias), np.float64)) for antialias in ("edges", "none"))
    assert abs(edges.sum() / reference.sum() - 1) < 0.02
    assert np.abs(edges - reference).sum() < 0.05 * np.abs(reference).sum()
    assert np.abs(none - reference).sum() > 0.25 * np.abs(reference).sum()
