"""Certificates in files, and images beside them."""

import json

import numpy as np
import pytest

import raytrace
from raytrace.certificates import certify, read_certificate, verify
from raytrace.errors import InputError
from raytrace.image import read_depth, read_metadata, read_planes, write_planes
from raytrace.image.depth import FLOAT32
from tests.processes import command

SIZE = (96, 54)


@pytest.fixture(scope="module")
def certificate():
    return certify("checkerboard", SIZE, precision="glsl-highp")


@pytest.fixture(scope="module")
def image():
    return np.asarray(raytrace.render("checkerboard", SIZE, backend="numpy", dtype="float64"))


def test_a_file_keeps_the_bounds_outward(tmp_path, certificate):
    certificate.write(tmp_path / "c.exr")
    again = read_certificate(tmp_path / "c.exr")
    assert (again.size, again.precision, again.intersection) == (SIZE, "glsl-highp", "either")
    for values in ("display", "linear"):
        (low, high), (low_again, high_again) = getattr(certificate.bounds, values), getattr(again.bounds, values)
        assert (low_again <= low).all()
        assert (high_again >= high).all()
        np.testing.assert_allclose(low_again, low, rtol=2e-7, atol=1e-37)
    np.testing.assert_array_equal(again.bounds.reason, certificate.bounds.reason)


def test_an_ordinary_image_is_no_certificate(tmp_path, image):
    raytrace.write_image(tmp_path / "a.png", image)
    with pytest.raises(InputError, match="is no certificate; 'raytrace certify' makes one"):
        read_certificate(tmp_path / "a.png")


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        (None, "a certificate of specification 1"),
        ("1", "a certificate of specification 1"),
        ("3", "a certificate of specification 3"),
        ("two", "specification: must be a whole number, found 'two'"),
    ],
)
def test_a_certificate_of_another_specification_is_refused(tmp_path, certificate, stated, message):
    """Certificates of the first specification do not state it."""
    path = tmp_path / "c.exr"
    certificate.write(path)
    metadata, planes = read_metadata(path), read_planes(path)
    assert metadata.pop("specification") == "2"
    write_planes(path, planes, metadata=metadata | ({} if stated is None else {"specification": stated}))
    with pytest.raises(InputError, match=message):
        read_certificate(path)


def test_inside(certificate, image):
    found = verify(image, certificate)
    assert found.inside
    assert str(found).startswith("inside at every pixel (5184)")
    # Rounded to 8 bits too, by half a unit of them.
    rounded = np.rint(image * 255) / 255
    assert verify(rounded, certificate).inside
    assert verify(rounded, certificate).of_8_bits


def test_outside_by_how_much_and_where(certificate, image):
    wrong = image.copy()
    wrong[40:44, 10:20] += 0.25
    wrong[5, 80] -= 0.125
    found = verify(wrong, certificate)
    assert not found.inside
    assert [cluster.pixels for cluster in found.clusters] == [40, 1]
    first, second = found.clusters
    assert (first.first, first.last) == ((10, 40), (19, 43))
    assert first.by == pytest.approx(0.25, abs=1e-4)
    assert (second.first, second.step) == ((80, 5), "sky")
    marked = found.marked()
    assert (marked[40, 10] == [1.0, 0.1, 0.05]).all()
    assert not (marked[0, 0] == [1.0, 0.1, 0.05]).all()


def test_linear_light_has_bounds_of_its_own(tmp_path, certificate, image):
    linear = np.asarray(raytrace.render("checkerboard", SIZE, backend="numpy", dtype="float32", output="linear"))
    assert verify(linear, certificate, "linear").inside
    assert not verify(linear, certificate).inside
    assert not verify(image, certificate, "linear").inside
    raytrace.write_image(tmp_path / "l.exr", linear, output="linear")
    assert command("verify", str(tmp_path / "l.exr"), "--scene", "checkerboard").returncode == 0


def test_an_srgb_framebuffer_is_another_film(tmp_path):
    """What such a framebuffer stores of the tone-mapped light is the scene's with that transfer function."""
    picture = str(tmp_path / "s.png")
    srgb = ("--set", "film.transfer=srgb")
    command("render", "shadows", "--size", "96x54", "--backend", "numpy", "-o", picture, *srgb)
    assert command("verify", picture, "--scene", "shadows", *srgb).returncode == 0
    assert command("verify", picture, "--scene", "shadows").returncode == 1


def test_what_is_no_number_is_outside(certificate, image):
    wrong = image.copy()
    wrong[0, 0, 1] = np.nan
    found = verify(wrong, certificate)
    assert (found.by > 0).sum() == 1
    assert found.by.max() == np.inf


def test_another_size_is_told(certificate):
    with pytest.raises(InputError, match=r"must be of shape \(54, 96, 3\), as the certificate is, found \(2, 2, 3\)"):
        verify(np.zeros((2, 2, 3)), certificate)


def test_the_commands(tmp_path):
    out, picture, marked = (str(tmp_path / name) for name in ("c.exr", "p.png", "m.png"))
    made = command("certify", "shadows", "--size", "96x54", "--precision", "glsl-highp", "-o", out, "--json")
    assert made.returncode == 0, made.stderr
    assert json.loads(made.stdout)["precision"] == "glsl-highp"
    command("render", "shadows", "--backend", "numpy", "--size", "96x54", "-o", picture)
    assert command("verify", picture, "--certificate", out).returncode == 0
    # The ground of another scene.
    other = command("verify", "backend:numpy", "--scene", "checkerboard", "--size", "96x54", "--json")
    assert json.loads(other.stdout)["inside"]
    command("render", "checkerboard", "--backend", "numpy", "--size", "96x54", "-o", picture)
    wrong = command("verify", picture, "--certificate", out, "--marked", marked)
    assert wrong.returncode == 1
    assert wrong.stdout.startswith("outside at ")
    assert raytrace.read_image(marked).shape == (54, 96, 3)


#: Arguments of the command, and what it says of them.
BAD_INPUT = [
    (("certify", "--precision", "reel"), "raytrace: precision: unknown 'reel'; did you mean 'real'? there is: "),
    (("certify", "-o", "c.png"), "raytrace: c.png: a certificate must be named *.exr"),
    (("verify", "a.png"), "raytrace: verify: needs the image's scene (--scene), or a certificate"),
    (("verify", "--scene", "sphere"), "raytrace: verify: give an image, or a shader with --shader"),
]


@pytest.mark.parametrize(("arguments", "line"), BAD_INPUT)
def test_bad_input_is_one_line(arguments, line):
    done = command(*arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(line)
    assert done.stderr.count("\n") == 1


#: Every file that is written, its bits, and what it holds; integers clip linear light.
FILES = [
    *((name, bits, output) for output in ("display", "linear") for name, bits in (("p.png", 8), ("p.png", 16))),
    *((name, bits, output) for output in ("display", "linear") for name, bits in (("p.tif", 8), ("p.tif", 16))),
    *((name, bits, output) for output in ("display", "linear") for name, bits in (("p.tif", 32), ("p.exr", 32))),
    *(("p.exr", 16, output) for output in ("display", "linear")),
]


@pytest.fixture(scope="module")
def exact():
    return certify("checkerboard", SIZE)


@pytest.fixture(scope="module")
def rendered():
    return {
        output: np.asarray(raytrace.render("checkerboard", SIZE, backend="numpy", dtype="float64", output=output))
        for output in ("display", "linear")
    }


@pytest.mark.parametrize("precision", ["real", "glsl-highp"])
@pytest.mark.parametrize(("name", "bits", "output"), FILES)
def test_a_file_of_any_depth_keeps_the_bounds_and_one_other_value_does_not(
    name, bits, output, precision, rendered, certificate, exact
):
    """Rounded as the file stores it, a right image is inside; one channel two units further is found."""
    bounds, image = {"real": exact, "glsl-highp": certificate}[precision], rendered[output]
    raytrace.write_image(name, image, output=output, bits=bits)
    depth, stored = read_depth(name), raytrace.read_image(name)
    assert verify(stored, bounds, output, depth).inside
    low, high = getattr(bounds.bounds, output)
    unit = 2 * depth.half_unit(stored)
    # Where an integer is not clipped, and bounds are narrow.
    y, x, channel = np.argwhere((high - low < 1e-4) & (stored > 0.1) & (stored < 0.9))[7]
    for other in ((high + 2 * unit)[y, x, channel], (low - 2 * unit)[y, x, channel]):
        wrong = stored.astype(np.float64)
        wrong[y, x, channel] = other
        raytrace.write_image(name, wrong, output=output, bits=bits)
        found = verify(raytrace.read_image(name), bounds, output, depth)
        assert np.argwhere(found.by > 0).tolist() == [[y, x]]


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
def test_an_array_says_its_depth_by_its_type(dtype, rendered, certificate):
    most = np.iinfo(dtype).max if np.dtype(dtype).kind == "u" else 1
    image = rendered["display"]
    assert verify(np.rint(image * most).astype(dtype) if most > 1 else image.astype(dtype), certificate).inside


@pytest.mark.parametrize("kind", ["file", "uint8", "float"])
def test_an_image_of_only_0_and_255_is_of_8_bits(kind, tmp_path):
    """Nearly black and nearly white: rounded to 8 bits only 0 and 255 are left."""
    scene = raytrace.Scene(
        spheres=raytrace.Spheres([[0, 0, 0]], [1.0], [[0.001, 0.999, 0.0015]]),
        sky=raytrace.Sky([0.999] * 3, [0.999] * 3, [0.0012] * 3),
        lighting="off",
        sun=raytrace.Sun(color=[0.999] * 3),
        film=raytrace.Film(tone_mapper="none", transfer="none"),
    )
    image = np.asarray(raytrace.render(scene, (16, 9), backend="numpy", dtype="float64"))
    levels = np.rint(image * 255).astype(np.uint8)
    assert set(np.unique(levels)) == {0, 255}
    bounds = certify(scene, (16, 9))
    given, depth = {"uint8": (levels, None), "float": (levels / 255, None), "file": (None, None)}[kind]
    if kind == "file":
        raytrace.write_image(tmp_path / "e.png", image)
        given, depth = raytrace.read_image(tmp_path / "e.png"), read_depth(tmp_path / "e.png")
    found = verify(given, bounds, depth=depth)
    assert (found.inside, found.of_8_bits) == (True, True)
    # Its float32 image is no image of 8 bits, and one of 8 bits stored as a float is not right.
    assert not verify(levels / 255, bounds, depth=FLOAT32).inside


def test_half_floats_that_overflow_are_as_bright_as_they_can_be(tmp_path):
    scene = raytrace.Scene(
        sky=raytrace.Sky([1e5, 2, 1], [1e5, 2, 1], [3e5, 0, 1]), sun=raytrace.Sun(direction=[0, -1, 0])
    )
    linear = np.asarray(raytrace.render(scene, (16, 9), backend="numpy", dtype="float64", output="linear"))
    bounds = certify(scene, (16, 9))
    with np.errstate(over="ignore"):
        infinite = linear.astype(np.float32).astype(np.float16)
    assert np.isinf(infinite[..., 0]).all()
    assert verify(infinite, bounds, "linear").inside
    wrong = infinite.copy()
    wrong[3, 4, 1] = np.inf
    assert (verify(wrong, bounds, "linear").by > 0).sum() == 1


@pytest.mark.parametrize(("name", "bits", "output"), [("h.png", 16, "display"), ("h.exr", 16, "linear")])
def test_our_own_files_are_inside_by_the_commands(tmp_path, name, bits, output):
    picture, size = str(tmp_path / name), ("--size", "48x27")
    options = ("--backend", "numpy", "--dtype", "float64", "--bits", str(bits), "--output", output)
    assert command("render", "checkerboard", *size, *options, "-o", picture).returncode == 0
    told = command("verify", picture, "--scene", "checkerboard", "--json")
    assert told.returncode == 0, told.stdout + told.stderr
    assert json.loads(told.stdout)["depth"] == {"h.png": "16 bits", "h.exr": "half float"}[name]
