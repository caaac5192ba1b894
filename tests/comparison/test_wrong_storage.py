"""Values that are cut off, and values with another white: found, and not found where they are not."""

import numpy as np
import pytest

import raytrace
from raytrace.certificates import certify, verify
from raytrace.certificates.verify import proposal
from raytrace.image.depth import Depth

SIZE = (96, 54)
SCENES = ["checkerboard", "skybox", "shadows"]


@pytest.fixture(scope="module", params=SCENES)
def image(request):
    return raytrace.render(request.param, SIZE, backend="numpy", dtype="float64")


def mistake(a, b):
    found = raytrace.compare(a, b).diagnosis
    return "" if found is None else found.mistake


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_cut_off(image, kind):
    most = np.iinfo(kind).max
    cut = np.floor(image * most).astype(kind)
    assert mistake(image, cut).startswith(f"cut off to {8 * kind().itemsize} bits")
    assert mistake(np.rint(image * most).astype(kind), cut).startswith("cut off to")
    assert raytrace.compare(image, cut, diagnose=False).diagnosis is None


def test_what_is_rounded_is_not_cut_off(image):
    rounded = np.rint(image * 255).astype(np.uint8)
    assert mistake(image, rounded) == ""
    # Nor what is darker throughout.
    assert "cut off" not in mistake(image, np.rint(np.maximum(image * 255 - 1, 0)).astype(np.uint8))
    assert "cut off" not in mistake(image, np.rint(image * 254).astype(np.uint8))
    noise = np.random.default_rng(1).normal(0, 0.5, image.shape)
    assert "cut off" not in mistake(image, np.rint(np.clip(image * 255 + noise, 0, 255)).astype(np.uint8))


@pytest.mark.parametrize(
    ("white", "stored"),
    [
        *((white, stored) for white in (255, 65535, 1023) for stored in (np.asarray, np.rint, np.floor)),
        (100, np.asarray),
    ],
)
def test_another_white(image, white, stored):
    found = mistake(image, stored(white * image))
    assert found == f"stored with {white} for white, where 1 is meant"


def test_a_brighter_image_is_not_one_with_another_white(image):
    assert "white" not in mistake(image, 3 * image)
    assert "white" not in mistake(image, np.random.default_rng(1).uniform(0, 255, image.shape))


def test_verify_proposes_it():
    certificate = certify("checkerboard", SIZE, precision="glsl-highp")
    image = raytrace.render("checkerboard", SIZE, backend="numpy", dtype="float32")
    for values, depth, told in (
        (np.floor(255 * image) / 255, Depth(8), "cut off"),
        (np.floor(255 * image).astype(np.uint8), None, "cut off"),
        (255 * image, None, "255 for white"),
        (np.rint(255 * image), None, "255 for white"),
        (1023 * image, None, "1023 for white"),
    ):
        assert not verify(values, certificate, depth=depth).inside
        assert told in proposal(values, certificate, "display", depth)
    assert proposal(np.roll(image, 3, axis=0), certificate, "display", None) is None


def test_verify_counts_what_is_not_finite():
    certificate = certify("checkerboard", SIZE, precision="glsl-highp")
    image = raytrace.render("checkerboard", SIZE, backend="numpy", dtype="float32")
    image[3, 5, 1], image[4, 6] = np.nan, -np.inf
    found = verify(image, certificate)
    assert "4 of 15552 values are NaN or infinite; the first one is nan at x 5, y 3 in green" in str(found)
    marked = found.marked()
    assert np.isfinite(marked).all()
    blue = marked[..., 2] > marked[..., 0] + 0.5
    assert np.argwhere(blue).tolist() == [[3, 5], [4, 6]]
    assert found.to_dict()["not_finite"] == 4
    assert found.to_dict()["by"] == "inf"
