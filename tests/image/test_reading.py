"""Files that people have: layers, parts, windows, orientations, and damage."""

import zlib
from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.errors import InputError
from raytrace.image import largest_image, read_file, read_image
from raytrace.image.channels import picture_channels
from tests.processes import command

IMAGE = np.random.default_rng(0).random((6, 5, 3)).astype(np.float32)


def write(path, pixels, names, *, kind="float", parts=(), **attributes):
    """A file with those channels; attributes: of OpenImageIO's ImageSpec, or texts and numbers that it stores."""
    import OpenImageIO as oiio

    def spec_of(pixels, names, attributes):
        spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
        spec.channelnames = tuple(names)
        for name, value in attributes.items():
            if hasattr(spec, name):
                setattr(spec, name, value)
            else:
                spec.attribute(name, value)
        return spec

    every = [(pixels, spec_of(pixels, names, attributes)), *((p, spec_of(p, n, {"name": t})) for t, p, n in parts)]
    if parts:
        every[0][1].attribute("name", "first")
    file = oiio.ImageOutput.create(str(path))
    specs = tuple(spec for _, spec in every)
    assert file.open(str(path), specs) if parts else file.open(str(path), specs[0])
    for number, (part, spec) in enumerate(every):
        if number:
            assert file.open(str(path), spec, "AppendSubimage")
        assert file.write_image(np.ascontiguousarray(part, np.float32))
    assert file.close()


@pytest.mark.parametrize(
    ("names", "chosen"),
    [
        ("R G B", "R G B"),
        ("B G R A", "R G B"),
        ("r g b", "r g b"),
        ("red green blue", "red green blue"),
        ("A Z ViewLayer.Combined.R ViewLayer.Combined.G ViewLayer.Combined.B", None),
        ("Z beauty.B beauty.G beauty.R depth.Z", "beauty.R beauty.G beauty.B"),
        ("R G B light.R light.G light.B", "R G B"),
        ("Y", "Y"),
        ("Y A", "Y"),
        ("Z", "Z"),
    ],
)
def test_the_one_picture_is_found_whatever_its_channels_are_called(names, chosen):
    names = names.split()
    chosen = names[2:] if chosen is None else chosen.split()
    assert picture_channels("a.exr", names) == tuple(chosen)


@pytest.mark.parametrize(
    ("names", "layer", "told"),
    [
        ("X Y Z", None, "a.exr: has no red, green and blue; its channels are X, Y, Z"),
        ("N.x N.y", None, "its channels are N.x, N.y"),
        ("Y RY BY", None, "its channels are Y, RY, BY"),
        ("C M Y K", None, "its channels are C, M, Y, K"),
        ("Z A t", None, "its channels are Z, A, t"),
        ("a.R a.G a.B b.R b.G b.B", None, "name one (--layer); its layers are a, b"),
        ("a.R a.G a.B b.R b.G b.B", "c", "has no layer 'c' of red, green and blue; its layers are a, b"),
        ("R G", None, "its channels are R, G"),
    ],
)
def test_what_is_no_picture_or_may_be_several_is_refused_by_name(names, layer, told):
    with pytest.raises(InputError) as error:
        picture_channels("a.exr", names.split(), layer)
    assert told in str(error.value)


def test_a_layer_is_read_by_its_name_and_depth_is_not_taken_for_grey():
    other = 1 - IMAGE
    write("a.exr", np.concatenate([IMAGE[..., :1], IMAGE, other], -1), ["Z", "a.R", "a.G", "a.B", "b.R", "b.G", "b.B"])
    np.testing.assert_array_equal(read_image("a.exr", "a"), IMAGE)
    np.testing.assert_array_equal(read_image("a.exr", "b"), other)
    done = command("compare", "a.exr", "a.exr", "--scene", "sphere")
    assert done.returncode == 2
    assert "a.exr: has several layers" in done.stderr
    done = command("compare", "a.exr", "a.exr", "--scene", "sphere", "--layer", "b")
    assert done.returncode == 0, done.stderr


def test_parts_are_found_by_their_names():
    other = 1 - IMAGE
    write("a.exr", IMAGE[..., :1], ["Z"], parts=[("beauty", IMAGE, "RGB"), ("depth", IMAGE[..., :1], ["Z"])])
    np.testing.assert_array_equal(read_image("a.exr"), IMAGE)
    write("b.exr", IMAGE, "RGB", parts=[("second", other, "RGB")])
    np.testing.assert_array_equal(read_image("b.exr", "second"), other)
    with pytest.raises(InputError, match=r"several parts with a picture; name one \(--layer\): first, second"):
        read_image("b.exr")


@pytest.mark.parametrize("x", [-3, 0, 2])
@pytest.mark.parametrize("y", [-2, 0, 4, 20])
def test_the_display_window_is_the_picture(x, y):
    """What the data window leaves out is black; what lies outside of the display window is not seen."""
    write("a.exr", IMAGE, "RGB", x=x, y=y, full_x=0, full_y=0, full_width=9, full_height=8)
    expected = np.zeros((8, 9, 3), np.float32)
    for row in range(6):
        for column in range(5):
            if 0 <= row + y < 8 and 0 <= column + x < 9:
                expected[row + y, column + x] = IMAGE[row, column]
    np.testing.assert_array_equal(read_image("a.exr"), expected)


def test_trimmed_rows_and_a_shifted_window_are_seen_by_compare():
    scene = raytrace.load_scene("sphere")
    whole = np.zeros((12, 12, 3), np.float32)
    whole[3:9] = 0.5
    raytrace.write_image("whole.exr", whole, output="display", metadata={"output": "display"})
    window = {"full_x": 0, "full_y": 0, "full_width": 12, "full_height": 12}
    write("trimmed.exr", whole[3:9], "RGB", y=3, **window)
    write("shifted.exr", whole[3:9], "RGB", y=4, **window)
    kinds = ("display", "display")
    assert raytrace.compare("whole.exr", "trimmed.exr", scene=scene, kinds=kinds).rmse == 0
    assert raytrace.compare("whole.exr", "shifted.exr", scene=scene, kinds=kinds).rmse > 0.1


@pytest.mark.parametrize("ending", [".tif", ".jpg"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_pictures_are_read_upright(ending, orientation):
    """As TIFF 6.0 states it: where the first row and the first column that are stored are to be seen."""
    stored = np.zeros((16, 24, 3), np.float32)
    stored[:8, :8] = 1  # the corner of the first row and column
    write(f"a{ending}", stored, "RGB", kind="uint8", Orientation=orientation, **{"jpeg:subsampling": "4:4:4"})
    seen = read_image(f"a{ending}")
    assert seen.shape == ((16, 24, 3) if orientation < 5 else (24, 16, 3))
    bottom, right = {1: (0, 0), 2: (0, 1), 3: (1, 1), 4: (1, 0), 5: (0, 0), 6: (0, 1), 7: (1, 1), 8: (1, 0)}[
        orientation
    ]
    corner = seen[-8:] if bottom else seen[:8]
    corner = corner[:, -8:] if right else corner[:, :8]
    assert corner.min() > 0.9
    assert seen.mean() == pytest.approx(64 / (16 * 24), abs=0.01)


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.exr", "a.jpg"])
@pytest.mark.parametrize("share", [0.0, 0.02, 0.3, 0.85, 0.99])
def test_a_file_that_is_cut_is_refused_in_one_line(name, share):
    write(name, np.random.default_rng(1).random((60, 70, 3)), "RGB", kind="float" if name.endswith("exr") else "uint8")
    content = Path(name).read_bytes()
    Path(name).write_bytes(content[: int(len(content) * share)])
    with pytest.raises(InputError, match=f"^{name}: is not a"):
        read_image(name)


@pytest.mark.parametrize(
    "description",
    ["raytrace:{{", "raytrace:[1]", "raytrace:" + "[" * 50_000, "raytrace:" + "9" * 10_000, 'raytrace:{"a": 1}'],
    ids=lambda text: text[:16],
)
def test_damaged_metadata_is_one_line(description):
    write("a.tif", IMAGE, "RGB", ImageDescription=description)
    with pytest.raises(InputError, match=r"^a\.tif: its metadata \(ImageDescription\) is damaged"):
        read_file("a.tif")


def test_a_size_is_looked_at_before_memory_is_asked_for():
    write("a.png", IMAGE, "RGB", kind="uint8")
    with largest_image(29), pytest.raises(InputError, match=r"^a\.png: 5x6 is over the limit of 29 pixels"):
        read_image("a.png")
    content = bytearray(Path("a.png").read_bytes())
    content[16:24] = (60_000).to_bytes(4, "big") * 2  # width and height, in the chunk IHDR
    content[29:33] = zlib.crc32(content[12:29]).to_bytes(4, "big")
    Path("a.png").write_bytes(content)
    with pytest.raises(InputError, match=r"60000x60000 is over the limit|is not an image: png header claims"):
        read_image("a.png")
    raytrace.write_image("a.png", IMAGE)
    done = command("--largest-image", "29", "compare", "a.png", "a.png")
    assert done.returncode == 2
    assert "over the limit of 29 pixels (--largest-image)" in done.stderr
