"""`raytrace compare` as its users meet it: in a process of its own, by exit code, output and files."""

import json
from pathlib import Path

import numpy as np
import pytest

import raytrace
from tests.processes import command
from tests.test_cli import refused

SMALL = ["--size", "48x27"]


@pytest.fixture
def files():
    """a.png; b.png, flipped; linear.exr without a word of its scene; nan.exr; other.png of another size."""
    import OpenImageIO as oiio

    display, linear = (
        raytrace.render("spheres", (48, 27), backend="numpy", dtype="float64", output=output)
        for output in ("display", "linear")
    )
    raytrace.write_image("a.png", display)
    raytrace.write_image("b.png", display[::-1])
    raytrace.write_image("linear.exr", linear, output="linear")
    raytrace.write_image("other.png", display[1:])
    assert oiio.ImageBuf(np.full((27, 48, 3), np.nan, np.float32)).write("nan.exr")


def failed(*args):
    """The one line on standard error of a check that failed, and what was printed."""
    done = command("compare", *args)
    assert done.returncode == 1, done
    (line,) = done.stderr.splitlines()
    return line.removeprefix("raytrace: "), done.stdout


def test_a_comparison_is_a_table_and_a_picture(files):
    done = command("compare", "a.png", "b.png", "--diff", "d.png", "--scene", "spheres")
    assert (done.returncode, done.stderr) == (0, "")
    for text in ("SSIM", "worst window", "PSNR", "RMSE", "largest", "over 1/255", "CIEDE2000", "FLIP", "per degree"):
        assert text in done.stdout
    assert "b.png is flipped top to bottom (y)" in done.stdout
    assert "sphere 0 " in done.stdout
    assert raytrace.read_image("d.png").shape[1] > 1000


@pytest.mark.parametrize(
    "arguments",
    [
        ("b.png", "--against", "a.png"),
        ("b.png", "backend:numpy"),
        ("backend:numpy", "b.png"),
        ("b.png", "ours.exr"),
        ("ours.exr", "b.png"),
    ],
)
def test_the_reference_is_known(files, arguments):
    """The mistake is never that of what a backend renders, nor of a file of ours."""
    command("render", "spheres", *SMALL, "--backend", "numpy", "--output", "display", "-o", "ours.exr")
    done = command("compare", *arguments, "--scene", "spheres", *SMALL)
    assert (done.returncode, done.stderr) == (0, "")
    assert "b.png is flipped top to bottom (y)" in done.stdout
    (right,) = (line for line in done.stdout.splitlines() if line.endswith(", the reference"))
    assert "b.png" not in right


def test_json_and_bounds_that_hold(files):
    bounds = [
        word for each in ("ssim>=0.99", "flip<=0.05", "difference <= 0.01", "share<=0") for word in ("--require", each)
    ]
    done = command("compare", "a.png", "backend:numpy:float64", "--scene", "spheres", *SMALL, "--json", *bounds)
    assert (done.returncode, done.stderr) == (0, "")
    report = json.loads(done.stdout)
    assert (report["over"], report["size"]) == (0, [48, 27])


def test_a_failing_check_is_one_line_and_exit_code_1(files):
    told, printed = failed(
        "a.png", "b.png", "--require", "ssim>=0.99", "--require", "rmse<=1", "--require", "share<=0.1"
    )
    assert told.startswith("SSIM is 0.")
    assert "; share of pixels over 1/255 is " in told
    assert "RMSE" not in told
    assert printed.startswith("A ")


def test_nan_is_a_failing_check_even_against_itself(files):
    told, printed = failed("nan.exr", "nan.exr", "--a-is", "display", "--b-is", "display")
    said = "nan.exr: 1296 of 1296 pixels are not finite (3888 of 3888 values); the first one is at x 0, y 0: "
    assert told == f"{said}nan nan nan"
    assert printed == ""


def test_linear_light_against_display(files):
    done = command("compare", "linear.exr", "a.png", "--scene", "spheres", "--require", "share<=0")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.full
def test_matrix():
    done = command("compare", "--matrix", "--scene", "sphere", "--size", "24x16")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[2].startswith("numpy64  1.000000      0")
    assert max(map(len, done.stdout.splitlines()[:8])) <= 120


#: Arguments of the command, and what it says of them.
BAD_INPUT = [
    (["a.png"], "takes two images"),
    (["a.png", "other.png"], "a.png of 48x27 and other.png of 48x26: images of different sizes"),
    (["a.png", "nowhere.png"], "nowhere.png: no such file"),
    (["a.png", "linear.exr"], "linear.exr: holds linear light, and no scene is known"),
    (["a.png", "backend:numpy"], "backend:numpy: needs a scene"),
    (["a.png", "backend:nunpy", "--scene", "spheres"], "unknown 'nunpy'"),
    (["a.png", "b.png", "--scene", "moon"], "moon: no such scene"),
    (["a.png", "b.png", "--set", "lighting='on'"], "--set: changes a scene; give one (--scene)"),
    (["a.png", "b.png", "--a-is", "log"], "kind of values: unknown 'log'"),
    (["a.png", "b.png", "--require", "ssim>=high"], "require: ssim>=high: 'high' is not a number"),
    (["a.png", "b.png", "--require", "ssim<=1"], "require: ssim<=1: ssim is bounded by >="),
    (["a.png", "b.png", "--require", "sim>=1"], "require: sim>=1: unknown 'sim'; did you mean 'ssim'?"),
    (["a.png", "b.png", "--require", "ssim"], "require: must be like 'ssim>=0.9999'"),
    (["a.png", "b.png", "--against", "a.png"], "--against: takes the place of B"),
    (["--against", "a.png"], "takes two images"),
    (["a.png", "b.png", "--diff", "d.jpg"], "d.jpg: a figure's file must be named *.png"),
    (["a.png", "b.png", "--diff", "nowhere/d.png"], "the folder nowhere does not exist"),
    (["--matrix", "--size", "0x1"], "size: must be (width, height)"),
    (["a.png", "b.png", "--matrix"], "--matrix: takes a scene and a size"),
]


@pytest.mark.parametrize(("args", "told"), BAD_INPUT)
def test_bad_input_is_one_line_and_exit_code_2(files, args, told):
    assert told in refused("compare", *args)


def test_an_existing_picture_survives_a_failure(files):
    Path("d.png").write_text("mine")
    refused("compare", "a.png", "other.png", "--diff", "d.png")
    assert Path("d.png").read_text() == "mine"
