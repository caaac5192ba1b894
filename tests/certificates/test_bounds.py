"""Every engine's image, and the exact one, lies within the bounds."""

import numpy as np
import pytest

import raytrace
from raytrace.certificates import certify, verify
from raytrace.scene import scenes
from tests.engines import need
from tests.scenes import SEVERAL_SCENES, filled, some

SIZE = (96, 54)
SMALL = (48, 27)
#: To bound a larger image takes longer than to compile the engines' programs.
LARGER = (192, 108)
A_FEW = ("shadows", "inside-a-sphere", "orthographic", "overlapping-spheres", "sun-in-the-picture")
#: What is hardest to decide, among others.
DECIDED = (*A_FEW, "checkerboard", "tangent-rays", "two-hundred-spheres", "non-default-film")
SIZES = {name: SMALL if name == "two-hundred-spheres" else LARGER for name in scenes()}


@pytest.mark.parametrize("name", some(scenes(), *DECIDED))
def test_real_numbers_are_bounded_and_decided(name):
    """The bounds hold the image of longdouble, are narrow, and prove (nearly) all 8 bit values."""
    certificate = certify(name, SIZE)
    image = raytrace.render(name, SIZE, backend="numpy", dtype="longdouble", intersection="robust")
    assert verify(image, certificate).inside
    low, high = certificate.bounds.linear
    linear = raytrace.render(name, SIZE, backend="numpy", dtype="longdouble", intersection="robust", output="linear")
    assert ((low <= linear) & (linear <= high)).all()
    if name == "tangent-rays":  # whose rays touch spheres exactly: no bound, however narrow, decides a touch
        assert certificate.proven.mean() >= 0.99
        assert (certificate.proven.all(axis=-1) | (certificate.bounds.reason > 0)).all()
        return
    assert certificate.proven.mean() >= 0.9999
    assert np.median(certificate.width) < 1e-12
    np.testing.assert_array_equal(certificate.levels[0], np.floor(image.astype(float) * 255 + 0.5))


@SEVERAL_SCENES
def test_the_exact_image_is_within(name):
    pytest.importorskip("flint")
    from raytrace.arithmetic.exact import Exact, precision
    from raytrace.backends.exact import exact_steps

    scene, (width, height) = raytrace.load_scene(name), (24, 13)
    display = exact_steps(scene, (width, height), ("display",)).display
    with precision(400):
        for low, high, plane in zip(
            *(np.moveaxis(end, -1, 0) for end in certify(scene, (width, height)).bounds.display), display, strict=True
        ):
            shape = (height, width)
            exact = Exact(np.broadcast_to(plane.value, shape))
            assert (exact >= Exact.of(low)).value.all()
            assert (exact <= Exact.of(high)).value.all()


def of_a_few_structures(name, size):
    """The scene, filled where that keeps its picture: then it shares a program, which takes long to compile."""
    scene = raytrace.load_scene(name)
    perspective = isinstance(scene.camera, raytrace.PerspectiveCamera)
    casting = any(plane.casts_shadow for plane in scene.planes)
    if not perspective or casting or len(scene.spheres.radius) > 8 or scene.sun.direction[1] <= 0:
        return scene
    images = [raytrace.render(each, size, backend="numpy", dtype="float64") for each in (scene, filled(scene))]
    np.testing.assert_array_equal(*images)
    return filled(scene)


@pytest.mark.parametrize(
    ("name", "size"), some([("checkerboard", SMALL), *SIZES.items()], ("checkerboard", SMALL)), ids=str
)
def test_every_engine_is_within(name, size):
    certificate = certify(name, size, precision="glsl-highp")
    for backend, dtype in (
        ("numpy", "float32"),
        ("numpy", "float64"),
        ("jax", "float32"),
        ("jax", "float64"),
        ("opengl", "float32"),
        ("webgl", "float32"),
    ):
        if (backend, dtype) == ("jax", "float64") and name not in A_FEW:
            continue  # a program to compile for each
        if backend in ("opengl", "webgl"):
            need(backend)
        scene = of_a_few_structures(name, size) if backend == "jax" else name
        found = verify(np.asarray(raytrace.render(scene, size, backend=backend, dtype=dtype)), certificate)
        assert found.inside, f"{backend} {dtype}: {found}"


def test_the_formulas_are_bounded_apart_and_together():
    either, textbook, robust = (
        certify("checkerboard", SIZE, precision="glsl-highp", intersection=formula)
        for formula in ("either", "textbook", "robust")
    )
    for values in ("display", "linear"):
        low, high = getattr(either.bounds, values)
        for one in (textbook, robust):
            assert (low <= getattr(one.bounds, values)[0]).all()
            assert (high >= getattr(one.bounds, values)[1]).all()
    assert (robust.width > 1 / 255).sum() < (textbook.width > 1 / 255).sum()


@pytest.mark.parametrize("size", some([((24, 13),), (SMALL,)], ((24, 13),)))
def test_spheres_that_are_left_out_change_no_bound(size, monkeypatch):
    from raytrace.arithmetic.intervals import paths

    scene = "two-hundred-spheres"
    culled = certify(scene, size, precision="glsl-highp", intersection="textbook")
    monkeypatch.setattr(paths, "candidates", lambda body, start, spheres, rays: range(len(spheres.radius.low)))
    full = certify(scene, size, precision="glsl-highp", intersection="textbook")
    for values in ("display", "linear"):
        for a, b in zip(getattr(culled.bounds, values), getattr(full.bounds, values), strict=True):
            np.testing.assert_array_equal(a, b)


def test_an_undecided_edge_is_either_side_of_it():
    """At a silhouette the bounds hold the sphere's colour and the sky's, and the reason is named."""
    certificate = certify("sphere", (480, 270), precision="glsl-highp")
    edge = certificate.bounds.reason == 1
    assert certificate.reasons["silhouette"] == edge.sum()
    if edge.any():
        low, high = certificate.bounds.linear
        assert (low[edge] < high[edge]).any()
