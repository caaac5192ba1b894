import numpy as np
import pytest

import raytrace
from raytrace.comparison import NotFinite
from raytrace.errors import InputError
from raytrace.rendering import Options, Rendering

SIZE = (32, 18)


def rendered(path, scene="checkerboard", output="display", bits=None, told=True):
    rendering = Rendering(Options(scene, SIZE, backend="numpy", dtype="float64", output=output))
    metadata = rendering.metadata() if told else None
    raytrace.write_image(path, rendering.whole(), output=output, bits=bits, metadata=metadata)
    return path


def compare(a, b, **options):
    return raytrace.compare(a, b, diagnose=False, size=SIZE, **options)


@pytest.mark.parametrize(
    ("name", "output", "bits", "most"),
    [
        ("b.png", "display", 16, 0.5 / 65535),
        ("b.tif", "display", 8, 0.5 / 255),
        ("b.tif", "display", 32, 0),
        ("b.exr", "display", 32, 0),
        ("b.exr", "linear", 32, 0),
        ("b.exr", "linear", 16, 2**-11),
        ("steps.exr", "steps", None, 0),
    ],
)
def test_depths_and_kinds_meet_in_display_values(name, output, bits, most):
    """Up to what the depth rounds, and float32."""
    found = compare("backend:numpy:float64", rendered(name, output=output, bits=bits), scene="checkerboard")
    assert found.largest.value <= most + 1e-6


def test_linear_light_is_developed_by_the_files_own_film():
    """Whatever scene is given for A: a file that tells its film is developed by it where no other is given."""
    rendered("own.exr", raytrace.load_scene("checkerboard", ["film.tone_mapper=reinhard"]), "linear")
    rendered("foreign.exr", "checkerboard", "linear", told=False)
    display = raytrace.render("checkerboard", SIZE, backend="numpy", dtype="float64")
    other = raytrace.load_scene("checkerboard", ["film.tone_mapper=reinhard"])
    assert compare(display, "own.exr").over > 300
    reinhard = raytrace.render(other, SIZE, backend="numpy", dtype="float64")
    assert compare(reinhard, "own.exr").largest.value < 1e-6
    assert compare(display, "foreign.exr", scene="checkerboard").largest.value < 1e-6
    assert compare(reinhard, "foreign.exr", scene=other).largest.value < 1e-6


def test_linear_light_without_a_scene_is_refused():
    rendered("a.exr", output="linear", told=False)
    with pytest.raises(InputError, match=r"a\.exr: holds linear light, and no scene is known"):
        compare("a.exr", "a.exr")
    assert compare("a.exr", "a.exr", kinds=("display", "display")).over == 0


def test_an_array_may_be_linear():
    linear, display = (
        raytrace.render("sphere", SIZE, backend="numpy", dtype="float64", output=output)
        for output in ("linear", "display")
    )
    assert compare(display, linear, scene="sphere", kinds=(None, "linear")).largest.value == 0


@pytest.mark.parametrize(("name", "alpha"), [("b.png", 1.0), ("b.exr", 0.5)])
def test_alpha_is_dropped(name, alpha):
    import OpenImageIO as oiio

    image = np.random.default_rng(0).uniform(0, 1, (5, 6, 3)).astype(np.float32)
    assert oiio.ImageBuf(np.dstack([image, np.full((5, 6), alpha, np.float32)])).write(name)
    assert compare(image, name, kinds=("display", "display")).largest.value < 0.51 / 255


def test_sizes_must_agree():
    rendered("a.png")
    with pytest.raises(InputError, match=r"a\.png of 32x18 and B of 4x7: images of different sizes"):
        compare("a.png", np.zeros((7, 4, 3)))


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(wrong):
    a = np.zeros((5, 6, 3))
    b = a.copy()
    b[2, 3, 1] = b[4, 5, 0] = wrong
    for pair in ((a, b), (b, a), (b, b)):
        with pytest.raises(NotFinite, match=r"2 of 30 pixels are not finite \(2 of 90 values\); .* x 3, y 2: 0\.0 "):
            compare(*pair)
    with pytest.raises(NotFinite):  # which the film would clamp to white
        compare(a, b, scene="sphere", kinds=(None, "linear"))


def test_a_file_of_nan_is_refused():
    import OpenImageIO as oiio

    image = oiio.ImageBuf(np.full((4, 4, 3), np.nan, np.float32))
    assert image.write("nan.exr")
    with pytest.raises(
        NotFinite, match=r"nan\.exr: 16 of 16 pixels are not finite \(48 of 48 values\); .* x 0, y 0: nan"
    ):
        compare("nan.exr", "nan.exr")


@pytest.mark.parametrize(
    ("a", "options", "told"),
    [
        (np.zeros((3, 3)), {}, r"A: an image is an array \(height, width, 3\), found \(3, 3\)"),
        (np.zeros((0, 3, 3)), {}, r"A: an image is an array"),
        (np.zeros((2, 2, 3), np.int64), {}, "A: an image's values are floats, with 1 for white, or unsigned integers"),
        ("nowhere.png", {}, r"nowhere\.png: no such file"),
        ("backend:numpy", {}, r"backend:numpy: needs a scene"),
        ("backend:nunpy", {"scene": "sphere"}, r"backend: unknown 'nunpy'; did you mean 'numpy'"),
        ("backend:numpy:half", {"scene": "sphere"}, r"dtype of backend numpy: unknown 'half'"),
        (np.zeros((2, 2, 3)), {"scene": "moon"}, "moon: no such scene"),
        (np.zeros((2, 2, 3)), {"kinds": ("log", None)}, "A: kind of values: unknown 'log'; there is: display, linear"),
    ],
)
def test_bad_input(a, options, told):
    with pytest.raises(InputError, match=told):
        compare(a, np.zeros((2, 2, 3)), **options)


def test_a_broken_scene_in_a_file_matters_only_where_none_is_given():
    image = np.zeros((4, 4, 3))
    raytrace.write_image("a.png", image, metadata={"scene": "sun = ["})
    with pytest.raises(InputError, match=r"a\.png: the scene in its metadata: not TOML"):
        compare("a.png", image)
    assert compare("a.png", image, scene="sphere").over == 0


@pytest.mark.parametrize(
    ("name", "bits", "depth"), [("b.png", 8, "8 bits"), ("b.png", 16, "16 bits"), ("b.exr", 16, "half float")]
)
def test_what_a_file_cannot_hold_is_no_difference(name, bits, depth):
    """Files say how finely they store, so the other image is rounded to the same, even one of 0 and 255 alone."""
    image = np.random.default_rng(0).uniform(0, 1, (12, 12, 3)).astype(np.float32)
    raytrace.write_image(name, image, bits=bits)
    found = compare(image, name, kinds=(None, "display"))
    assert (found.largest.value, found.to_dict()["depth"]) == (0, depth)
    assert f"12x12, {depth} a channel" in str(found)
    extremes = np.where(image < 0.5, 0.0004, 0.9999)
    raytrace.write_image("c.png", extremes)
    assert compare(extremes, "c.png").largest.value == 0
    # Of an array alone it is not known.
    assert compare(extremes, np.rint(extremes)).largest.value == 0.0004


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16])
def test_arrays_say_by_their_type_how_finely_they_store(dtype):
    image = np.random.default_rng(0).uniform(0, 1, (12, 12, 3)).astype(np.float32)
    most = 1 if dtype is np.float16 else np.iinfo(dtype).max
    stored = (image if most == 1 else np.rint(image.astype(float) * most)).astype(dtype)
    assert compare(image, stored).largest.value == 0
    assert compare(image + 2 / 255, stored).over == 144


def test_where_one_is_of_8_bits_the_other_is_rounded_to_them():
    exact = np.linspace(0.0, 1.0, 16 * 16 * 3).reshape(16, 16, 3)
    rounded = np.rint(exact * 255) / 255
    assert raytrace.compare(exact, rounded).largest.value == 0
    assert raytrace.compare(exact, rounded + 0.001).largest.value > 1e-3
    black = np.zeros((16, 16, 3))
    assert raytrace.compare(black, black + 0.001).largest.value == 0.001
