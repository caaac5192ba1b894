"""Second derivatives: right where no edge moves, refused where one does."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import raytrace
from raytrace.errors import InputError
from raytrace.scene.sun import sun_angles, sun_direction

SIZE = (32, 18)


def brightness(scene, **choices):
    """The image's mean by the sun's angles, in degrees."""

    def mean(angles):
        lit = scene.with_("sun.direction", sun_direction(angles[0], angles[1]))
        return raytrace.render(lit, SIZE, dtype="float64", output="linear", exact_inputs=True, **choices).mean()

    return mean


@pytest.fixture(autouse=True)
def x64():
    with jax.enable_x64(True):
        yield


@pytest.mark.full
def test_by_the_sun_s_elevation_it_is_that_of_supersampled_images():
    """Of the sky, a smooth scene: pixel by pixel, within 5 %."""
    scene = raytrace.load_scene("skybox")
    azimuth, elevation = jnp.array(sun_angles(scene.sun.direction))

    def image(elevation, **choices):
        lit = scene.with_("sun.direction", sun_direction(azimuth, elevation))
        return raytrace.render(lit, SIZE, dtype="float64", output="linear", exact_inputs=True, **choices)

    def slope(elevation):
        return jax.jvp(lambda angle: image(angle, antialias="edges"), (elevation,), (1.0,))[1]

    found = jax.jit(lambda angle: jax.jvp(slope, (angle,), (1.0,))[1])(elevation)
    step = 0.1
    supersampled = [image(float(elevation) + k * step, backend="numpy", samples=8) for k in (-1, 0, 1)]
    expected = (supersampled[0] - 2 * supersampled[1] + supersampled[2]) / step**2
    assert np.abs(found - expected).sum() < 0.05 * np.abs(expected).sum()


def test_where_an_edge_moves_they_are_refused():
    scene = raytrace.load_scene("shadows")
    at = jnp.array(sun_angles(scene.sun.direction))
    for twice in (jax.hessian, lambda f: jax.jacfwd(jax.jacfwd(f)), lambda f: jax.jacrev(jax.jacrev(f))):
        with pytest.raises(InputError, match="edges: no second derivative") as refused:
            jax.make_jaxpr(twice(brightness(scene, antialias="edges")))(at)
        assert "\n" not in str(refused.value)


#: A plain ground, whose horizon is an edge that the camera's height moves.
GROUND = raytrace.Scene(planes=[raytrace.Plane(pattern=raytrace.Plain([0.5, 0.4, 0.3]))], lighting="off")


def higher(scene, height):
    up = np.array([0.0, 1.0, 0.0])
    camera = scene.camera
    return replace(scene, camera=replace(camera, target=camera.target + up * height))


def larger(scene, radius):
    return replace(scene, spheres=replace(scene.spheres, radius=scene.spheres.radius + radius))


@pytest.mark.full
@pytest.mark.parametrize("name", ["ground", "sphere", "lit-sphere"])
def test_colours_bend_what_edges_do_not(name):
    """Once by what moves an edge and once by the colour of the sun and of the sky, in a scene without shadows."""
    scene, moved = (GROUND, higher) if name == "ground" else (raytrace.load_scene(name), larger)

    def mean(number, color):
        sun, sky = replace(scene.sun, color=color), replace(scene.sky, high=color)
        lit = replace(moved(scene, number), sun=sun, sky=sky)
        return raytrace.render(lit, SIZE, dtype="float64", antialias="edges", exact_inputs=True).mean()

    mixed = jax.jacfwd(jax.grad(mean), argnums=1)
    assert jax.eval_shape(mixed, jnp.float64(0), jnp.ones(3)).shape == (3,)
    with pytest.raises(InputError, match="edges: no second derivative"):
        jax.eval_shape(jax.hessian(mean), jnp.float64(0), jnp.ones(3))
