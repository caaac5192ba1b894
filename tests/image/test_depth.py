"""What a file or an array stores a number as, and which numbers that may have been."""

import numpy as np
import pytest

import raytrace
from raytrace.errors import InputError
from raytrace.image import Depth, read_depth
from raytrace.image.depth import FLOAT32, coarsest_depth, depth_of_dtype, values_of

#: Every kind of file that is written: its name, bits, and depth.
FILES = [
    ("a.png", 8, Depth(8)),
    ("a.png", 16, Depth(16)),
    ("a.tif", 8, Depth(8)),
    ("a.tif", 16, Depth(16)),
    ("a.tiff", 32, FLOAT32),
    ("a.exr", 16, Depth(16, floating=True)),
    ("a.exr", 32, FLOAT32),
]
DEPTHS = [*map(Depth, (8, 10, 12, 16)), *(Depth(bits, floating=True) for bits in (16, 32, 64))]
#: Beyond what integers hold, and down to the subnormal numbers of half floats; not what a half float cannot hold.
ANYTHING = np.concatenate(
    [
        np.random.default_rng(0).uniform(-0.1, 1.1, 3000),
        np.random.default_rng(1).normal(size=3000) * np.geomspace(1e-9, 1e4, 3000),
        (np.arange(255) + 0.5) / 255,
        2.0 ** np.arange(-30, 16),
        [0, 1, -1, 65504, 0.5 / 255, 1 - 0.5 / 255],
    ]
)


def as_image(values):
    return np.resize(values, (len(values) // 3 + 1, 1, 3))


def assert_may_be(depth, stored, numbers):
    low, high = depth.numbers(stored)
    assert (low <= numbers).all()
    assert (numbers <= high).all()


@pytest.mark.parametrize(("name", "bits", "depth"), FILES)
def test_a_file_says_how_it_stores_and_holds_what_was_written(name, bits, depth):
    image = as_image(ANYTHING)
    raytrace.write_image(name, image, bits=bits)
    assert read_depth(name) == depth
    assert_may_be(depth, raytrace.read_image(name), image)


@pytest.mark.parametrize("name", ["a.tif", "a.dpx"])
@pytest.mark.parametrize("bits", [10, 12])
def test_files_of_10_and_12_bits(name, bits):
    """OpenImageIO gives such numbers as 16 bits, inexactly; they are read as what the file holds."""
    import OpenImageIO as oiio

    depth, image = Depth(bits), as_image(ANYTHING)
    spec = oiio.ImageSpec(1, len(image), 3, "uint16")
    spec.attribute("oiio:BitsPerSample", bits)
    file = oiio.ImageOutput.create(name)
    assert file.open(name, spec), file.geterror()
    file.write_image(depth.rounded(image).astype(np.float32))
    file.close()
    assert read_depth(name) == depth
    np.testing.assert_allclose(raytrace.read_image(name), depth.rounded(image), rtol=1e-7)
    assert_may_be(depth, raytrace.read_image(name), image)


def test_channels_of_different_depths_count_as_the_coarsest_colour():
    import OpenImageIO as oiio

    spec = oiio.ImageSpec(4, 4, 4, "float")
    spec.channelnames, spec.channelformats = ("R", "G", "B", "Z"), ("float", "half", "float", "float")
    file = oiio.ImageOutput.create("a.exr")
    assert file.open("a.exr", spec), file.geterror()
    file.write_image(np.full((4, 4, 4), 0.3, np.float32))
    file.close()
    assert read_depth("a.exr") == Depth(16, floating=True)


@pytest.mark.parametrize("depth", DEPTHS[:-1], ids=str)
def test_numbers_are_all_that_become_a_value_and_no_others(depth):
    """Rounding gives a value whose numbers hold it; a number two units away becomes another value."""
    stored = depth.rounded(ANYTHING)
    assert_may_be(depth, stored, ANYTHING)
    low, high = depth.numbers(stored)
    finite = np.isfinite(low) & np.isfinite(high)
    assert (high - low <= 2.1 * depth.half_unit(stored))[finite].all()
    # Halfway to the next value, and not as far as that.
    if depth.floating:
        digits = {16: np.float16, 32: np.float32, 64: np.float64}[depth.bits]
        unit = np.spacing(np.abs(stored[np.abs(stored) < 1e4]).astype(digits)).astype(np.float64)
        np.testing.assert_allclose(depth.half_unit(stored[np.abs(stored) < 1e4]), unit / 2, rtol=1e-3)
    else:
        assert depth.half_unit(np.zeros(1))[0] == pytest.approx(0.5 / (2**depth.bits - 1), rel=1e-6)


def test_what_a_depth_cannot_hold():
    """Integers stop at 0 and 1, half floats at 65504, beyond which they are infinite."""
    low, high = Depth(8).numbers(np.array([0.0, 1.0]))
    assert (low[0], high[1]) == (-np.inf, np.inf)
    half = Depth(16, floating=True)
    np.testing.assert_array_equal(half.rounded(np.array([65519, 65521, -1e30])), [65504, np.inf, -np.inf])
    low, high = half.numbers(np.array([np.inf, -np.inf, np.nan]))
    np.testing.assert_array_equal(high, [np.inf, -65504, np.nan])
    np.testing.assert_array_equal(low, [65504, -np.inf, np.nan])


def test_arrays_by_their_type():
    assert [depth_of_dtype(dtype) for dtype in (np.uint8, np.uint16, np.float16, np.float32, np.longdouble)] == [
        *(Depth(8), Depth(16), Depth(16, floating=True), FLOAT32, Depth(64, floating=True))
    ]
    np.testing.assert_array_equal(values_of(np.array([0, 255], np.uint8)), [0, 1])
    np.testing.assert_array_equal(values_of(np.array([0, 65535], np.uint16)), [0, 1])
    for wrong in (np.int32, np.complex128, bool):
        with pytest.raises(InputError, match="unsigned integers, with their largest for white, found"):
            values_of(np.zeros(1, wrong))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("depth", DEPTHS[:5], ids=str)
def test_floats_that_came_from_integers_or_half_floats_are_known_by_their_values(dtype, depth):
    values = depth.rounded(np.random.default_rng(0).uniform(0, 1, 999)).astype(dtype)
    assert coarsest_depth(values) == depth
    values[7] += dtype(1e-6)
    assert coarsest_depth(values) == depth_of_dtype(dtype)


def test_floats_of_only_0_and_1_may_be_of_8_bits():
    assert coarsest_depth(np.array([0.0, 1.0], np.float32)) == Depth(8)
