import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.files import whole_file
from raytrace.image import image_file, read_metadata


@pytest.fixture
def image():
    return np.random.default_rng(0).uniform(-0.1, 1.1, (7, 5, 3))


@pytest.mark.parametrize(("name", "bits"), [("a.png", 8), ("a.png", 16), ("a.tif", 8), ("a.tiff", 16)])
def test_integers_are_rounded(image, name, bits):
    most = 2**bits - 1
    raytrace.write_image(name, image, bits=bits)
    expected = np.round(np.clip(image, 0, 1) * most) / most
    np.testing.assert_allclose(raytrace.read_image(name), expected, rtol=1e-6)


def test_png_by_hand():
    """round(255 x): 0.5 is 127.5, to the even 128; 0.1 is 25.5, just above in binary, 26; no colour is converted."""
    raytrace.write_image("a.png", np.array([[[0.5, 0.1, 1.0]]]))
    assert (raytrace.read_image("a.png") * 255).round().tolist() == [[[128, 26, 255]]]


@pytest.mark.parametrize("name", ["a.exr", "a.tif"])
def test_float32_comes_back_bit_for_bit(image, name):
    values = (image * 1e10).astype(np.float32)
    raytrace.write_image(name, values, output="linear", bits=32)
    np.testing.assert_array_equal(raytrace.read_image(name), values)


def test_half_comes_back_as_half(image):
    raytrace.write_image("a.exr", image, output="linear", bits=16)
    np.testing.assert_array_equal(raytrace.read_image("a.exr"), image.astype(np.float32).astype(np.float16))


def test_steps_are_layers():
    steps = raytrace.render("checkerboard", (16, 9), backend="numpy", dtype="float64", output="steps")
    raytrace.write_image("steps.exr", steps)
    again = raytrace.read_image("steps.exr")
    assert again.keys() == steps.keys()
    for name, step in steps.items():
        np.testing.assert_array_equal(again[name], step.astype(np.float32), err_msg=name)
    assert again["index"].dtype == np.int32


def test_steps_have_channel_names_that_a_viewer_groups():
    import OpenImageIO as oiio

    raytrace.write_image("steps.exr", raytrace.render("sphere", (4, 4), output="steps"))
    file = oiio.ImageInput.open("steps.exr")
    names = file.spec().channelnames
    file.close()
    assert set(names) == {
        *("R", "G", "B", "t", "index", "NdL", "NdSky", "shadow"),
        *(f"{layer}.{axis}" for layer in ("rd", "hitPoint", "N") for axis in "XYZ"),
        *(f"{layer}.{channel}" for layer in ("albedo", "linear") for channel in "RGB"),
        *("pixelNdc.X", "pixelNdc.Y"),
    }


@pytest.mark.parametrize("name", ["a.png", "a.exr", "a.tif"])
def test_metadata_and_equal_bytes(image, name):
    metadata = {"scene": "a = 0.1\n[b]\nc = 'é'\n", "scene_sha256": "0" * 64}
    raytrace.write_image(name, image, metadata=metadata)
    once = Path(name).read_bytes()
    assert read_metadata(name) == metadata
    raytrace.write_image(name, image, metadata=metadata)
    assert Path(name).read_bytes() == once


def test_what_cannot_be_written(image):
    Path("folder.png").mkdir()
    Path("text").write_text("")
    for path, options, told in [
        ("a.jpg", {}, "unknown file ending '.jpg'"),
        ("a", {}, "unknown file ending ''"),
        ("nowhere/a.png", {}, "the folder nowhere does not exist"),
        ("text/a.png", {}, "the folder text does not exist"),
        ("folder.png", {}, "is a folder"),
        ("a.png", {"bits": 32}, "has no 32 bits a channel; there is: 8, 16"),
        ("a.png", {"bits": 0}, "has no 0 bits a channel"),
        ("a.png", {"output": "steps"}, "is 'display' or 'linear', found 'steps'"),
    ]:
        with pytest.raises(raytrace.InputError, match="^" + path.replace(".", r"\.")) as error:
            raytrace.write_image(path, image, **options)
        assert told in str(error.value)
    with pytest.raises(raytrace.InputError, match=r"array \(height, width, 3\), found \(7, 5\)"):
        raytrace.write_image("a.png", image[..., 0])
    assert {file.name for file in Path().iterdir()} == {"folder.png", "text"}


def test_what_is_no_image(image):
    steps = raytrace.render("sphere", (4, 4), output="steps")
    nan = np.where(image > 0.5, np.nan, image)
    for wrong, told in [
        ((image * 255).astype(np.uint8), "floats, with 1 for white, found uint8"),
        (image.astype(complex), "found complex128"),
        (nan, "not finite"),
        ({}, "steps are a dict of pixelNdc"),
        (steps | {"more": image}, "steps are a dict of pixelNdc"),
    ]:
        with pytest.raises(raytrace.InputError) as error:
            raytrace.write_image("a.exr", wrong)
        assert told in str(error.value)
    with pytest.raises(raytrace.InputError, match=r"only \.exr"):
        raytrace.write_image("a.png", steps)
    assert list(Path().iterdir()) == []


def test_a_half_precision_array_is_rounded_like_any_other(image):
    raytrace.write_image("a.png", image.astype(np.float16), bits=16)
    np.testing.assert_allclose(raytrace.read_image("a.png"), np.clip(image, 0, 1), atol=1e-3)


def test_a_link_stays_a_link(image):
    Path("real.png").write_text("old")
    Path("link.png").symlink_to("real.png")
    raytrace.write_image("link.png", image)
    assert Path("link.png").is_symlink()
    assert raytrace.read_image("real.png").shape == image.shape


def begin(image, end=None):
    with image_file("a.exr", (5, 7)) as file:
        file.write(image[:3])
        if end is not None:
            raise end


def test_an_interrupted_file_does_not_appear(image):
    Path("a.exr").write_text("mine")
    with pytest.raises(KeyboardInterrupt):
        begin(image, KeyboardInterrupt)
    with pytest.raises(raytrace.InputError, match="incomplete"):
        begin(image)
    assert [file.name for file in Path().iterdir()] == ["a.exr"]
    assert Path("a.exr").read_text() == "mine"


@pytest.mark.parametrize("name", ["a.png", "a.exr", "a.tif"])
def test_a_full_disk_leaves_nothing(name):
    """A limit on the size of files stands in for a full disk."""
    code = (
        "import resource, signal, sys, numpy as np, raytrace\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))\n"
        "image = np.random.default_rng(0).random((500, 500, 3))\n"
        "try:\n"
        f"    raytrace.write_image({name!r}, image)\n"
        "except raytrace.InputError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(f"{name}: cannot be written: ")
    assert len(done.stdout.splitlines()) == 1
    assert list(Path().iterdir()) == []


@pytest.mark.parametrize("name", ["a.png", "a.exr", "a.tif"])
@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.95])
def test_broken_files_are_refused(name, share):
    raytrace.write_image(name, np.random.default_rng(0).random((64, 64, 3)))
    whole = Path(name).read_bytes()
    Path(name).write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(raytrace.InputError, match=name):
        raytrace.read_image(name)


def test_missing_files_are_refused():
    with pytest.raises(raytrace.InputError, match=r"nowhere\.png: no such file"):
        raytrace.read_image("nowhere.png")


@pytest.mark.parametrize("name", ["a.png", "a.tif"])
def test_alpha_is_left_out(name):
    """The colour as it is stored, not multiplied by it."""
    import OpenImageIO as oiio

    spec = oiio.ImageSpec(1, 1, 4, "uint8")
    spec.attribute("oiio:UnassociatedAlpha", 1)
    file = oiio.ImageOutput.create(name)
    file.open(name, spec)
    file.write_image(np.array([[[128, 64, 255, 128]]], np.uint8))
    file.close()
    assert (raytrace.read_image(name) * 255).round().tolist() == [[[128, 64, 255]]]


@pytest.fixture
def tiny_disk(tmp_path):
    """A disk of one page, where this process may mount one."""
    folder = tmp_path / "disk"
    folder.mkdir()
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4k", "tmpfs", folder], capture_output=True, check=False)
    if made.returncode:
        pytest.skip("needs the right to mount a file system")
    yield folder
    subprocess.run(["umount", folder], check=True)


@pytest.mark.parametrize("name", ["a.png", "a.exr", "a.tif"])
def test_a_disk_that_is_full_is_noticed(tiny_disk, name):
    with pytest.raises(raytrace.InputError, match="cannot be written"):
        raytrace.write_image(tiny_disk / name, np.random.default_rng(0).random((40, 40, 3)))
    assert list(tiny_disk.iterdir()) == []
    raytrace.write_image(tiny_disk / name, np.zeros((4, 4, 3)))


def test_only_regular_files_are_replaced(image):
    import os

    os.mkfifo("pipe.png")
    for name in ("pipe.png", "/dev/null"):
        with pytest.raises(raytrace.InputError, match="is not a regular file"), whole_file(Path(name)):
            pass
    assert not Path("/dev/null").is_file()


@pytest.mark.parametrize("write", [lambda path: raytrace.write_image(path, np.zeros((2, 2, 3))),
                                   lambda path: raytrace.save_scene(raytrace.Scene(), path)])  # fmt: skip
def test_no_name_holds_nul(write):
    with pytest.raises(raytrace.InputError, match="cannot hold NUL"):
        write("a\0b.png")


def test_a_link_keeps_its_targets_format():
    Path("b.png").symlink_to("a.exr")
    with pytest.raises(raytrace.InputError, match=r"^b\.png: is a link to .*a\.exr, whose ending is another"):
        raytrace.write_image("b.png", np.zeros((2, 2, 3)))
    Path("c.png").symlink_to("d.png")
    raytrace.write_image("c.png", np.zeros((2, 2, 3)))
    assert Path("c.png").is_symlink()
    assert Path("d.png").is_file()
    assert not Path("a.exr").exists()
