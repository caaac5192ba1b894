"""Derivatives by boundary integrals: laws, and what other ways come to."""

from dataclasses import replace

import numpy as np
import pytest

import raytrace
from raytrace.studies.boundaries import reference
from raytrace.studies.differences import block_sums, difference
from raytrace.studies.gradients import derivative
from raytrace.studies.worlds import PARAMETERS, random_world
from tests.scenes import some
from tests.studies.test_differences import SIZE, within_a_silhouette


def of(scene, *names, size=SIZE, scanlines=8):
    return reference(scene, {name: (PARAMETERS[name].moved, PARAMETERS[name].step) for name in names}, size, scanlines)


@pytest.mark.full
@pytest.mark.parametrize(
    ("seed", "parameter", "samples"), [(1, "sun azimuth", 12), (2, "sphere's radius", 24), (3, "camera's x", 32)]
)
def test_it_is_what_differences_come_to_within_the_errors_of_both(seed, parameter, samples):
    world = random_world(seed)
    found = of(world, parameter, scanlines=24)[parameter]
    checked = difference(world, parameter, SIZE, samples)
    size = np.abs(found.blocks).sum()
    apart = np.abs(found.blocks - checked.blocks).sum() / size
    noise = (np.abs(found.error).sum() + checked.error.sum()) / size
    assert apart < noise
    assert np.abs(found.error).sum() < checked.error.sum()
    assert found.lost < 0.02


@pytest.mark.full
def test_where_nothing_has_an_edge_it_is_the_usual_derivative():
    world = within_a_silhouette()
    found = of(world, "sun azimuth", "sphere's x")
    for name, each in found.items():
        exact = block_sums(derivative(world, name, SIZE, "none", 4))
        np.testing.assert_allclose(each.blocks, exact, rtol=0, atol=2e-3 * np.abs(exact).max())


def disc(radius):
    """A sphere on the camera's axis before one colour, of a radius in pixels, without light and film; and its area's
    derivative by the sphere's radius, in pixels."""
    size, distance = (48, 24), 3.0
    focal = size[1] / 2 / np.tan(np.radians(30))
    tangent = radius / focal
    r = distance * tangent / np.sqrt(1 + tangent**2)
    grey = np.full(3, 0.5)
    scene = raytrace.Scene(
        spheres=raytrace.Spheres([[0, 0, -distance]], [r], [[1.0, 0.25, 0.0]]),
        sky=raytrace.Sky(grey, grey, grey),
        sun=raytrace.Sun((0, 0, 1.0)),
        lighting="off",
        camera=raytrace.PerspectiveCamera((0, 0, 0), (0, 0, -1.0)),
        film=raytrace.Film(tone_mapper="none", transfer="none"),
    )
    return scene, size, 2 * np.pi * focal**2 * r * distance**2 / (distance**2 - r**2) ** 2


@pytest.mark.parametrize("radius", [0.03, 0.4, 5.0])
def test_a_disc_grows_by_its_rim(radius):
    scene, size, growth = disc(radius)
    found = of(scene, "first radius", size=size)["first radius"]
    jump = np.array([1.0, 0.25, 0.0]) - 0.5
    np.testing.assert_allclose(found.image.sum((0, 1)), growth * jump, rtol=0, atol=4e-3 * growth)
    assert found.lost < 1e-6


def test_a_disc_that_moves_gains_what_it_loses():
    scene, size, growth = disc(5.0)
    found = of(scene, "sphere's x", size=size)["sphere's x"]
    np.testing.assert_allclose(found.image.sum((0, 1)), 0, rtol=0, atol=4e-3 * growth)
    np.testing.assert_allclose(found.image, -found.image[:, ::-1], rtol=0, atol=0.05 * np.abs(found.image).max())


@pytest.mark.parametrize(
    ("world", "other", "factor"),
    some([("disc", "first radius", 0.5), ("random", "sun azimuth", 20)], ("disc", "first radius", 0.5)),
)
def test_two_changes_together_are_the_sum_of_both(world, other, factor):
    scene, size = (random_world(1), (36, 24)) if world == "random" else disc(5.0)[:2]

    def both(scene, h):
        return PARAMETERS["sphere's x"].moved(PARAMETERS[other].moved(scene, factor * h), h)

    one = of(scene, "sphere's x", other, size=size, scanlines=4)
    together = reference(scene, {"both": (both, PARAMETERS["sphere's x"].step)}, size, 4)["both"]
    expected = one["sphere's x"].blocks + factor * one[other].blocks
    assert np.abs(together.blocks - expected).sum() < 0.01 * np.abs(expected).sum()


@pytest.mark.full
def test_what_is_not_seen_changes_nothing():
    world = replace(random_world(0), lighting="on")
    center = world.spheres.center.copy()
    center[0] = world.camera.position + np.array([0, 0, 9.0])
    world = replace(world, spheres=replace(world.spheres, center=center))
    for each in of(world, "sphere's x", "first radius", scanlines=4).values():
        assert not each.image.any()
        assert not each.blocks.any()


def test_of_a_picture_of_one_colour():
    grey = np.full(3, 0.5)
    scene = raytrace.Scene(sky=raytrace.Sky(grey, grey, grey), sun=raytrace.Sun((0, 0, 1.0)))
    assert not of(scene, "camera's x", size=(24, 12), scanlines=2)["camera's x"].image.any()
