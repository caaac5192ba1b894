"""The command as its users meet it: in a process of its own, by exit code, output and files."""

import json
import os
import pty
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.image import read_metadata
from raytrace.scene import scene_hash
from tests.processes import COMMAND, command, started
from tests.scenes import some

SMALL = ["--size", "32x18", "--backend", "numpy"]


def refused(*args, code=2):
    """What is said, in one line, on standard error; nothing else is printed and no file appears."""
    before = sorted(Path().iterdir())
    done = command(*args)
    assert done.returncode == code, done
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith("raytrace: ")
    assert sorted(Path().iterdir()) == before
    return line.removeprefix("raytrace: ")


def test_render_without_arguments_makes_the_final_picture():
    done = command("render")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert re.fullmatch(
        r"checkerboard\.png: 1920x1080, jax float32, rendered in [\d.]+ s, after compiling for [\d.]+ s\n", done.stdout
    )
    image = raytrace.read_image("checkerboard.png")
    assert image.shape == (1080, 1920, 3)
    reference = np.asarray(raytrace.render("checkerboard"))
    assert np.abs(image - reference).max() <= 0.5 / 255 + 1e-6


def test_files_say_where_they_come_from():
    changes = ["--set", "sun.direction=[0,1,0]", "--set", "film.exposure=1"]
    done = command("render", "shadows", "-o", "a.exr", *SMALL, "--dtype", "float64", *changes)
    assert done.returncode == 0, done.stderr
    scene = raytrace.load_scene("shadows", changes[1::2])
    metadata = read_metadata("a.exr")
    assert metadata["scene_sha256"] == scene_hash(scene)
    Path("again.toml").write_text(metadata["scene"])
    assert raytrace.load_scene("again.toml") == scene
    assert (metadata["backend"], metadata["dtype"], metadata["intersection"]) == ("numpy", "float64", "textbook")
    assert metadata["output"] == "linear"
    linear = raytrace.render(scene, (32, 18), backend="numpy", dtype="float64", output="linear")
    np.testing.assert_array_equal(raytrace.read_image("a.exr"), linear.astype(np.float32))


def test_outputs_and_formats():
    for args, check in [
        (["-o", "d.exr", "--output", "display"], lambda image: image.max() <= 1),
        (["-o", "s.exr", "--output", "steps"], lambda steps: set(steps) > {"hitPoint", "NdSky"}),
        (["-o", "a.tif", "--bits", "8"], lambda image: image.shape == (18, 32, 3)),
        (["-o", "b.png", "--bits", "16", "--samples", "3"], lambda image: image.shape == (18, 32, 3)),
    ]:
        done = command("render", *SMALL, *args)
        assert done.returncode == 0, done.stderr
        assert check(raytrace.read_image(args[1]))


def test_standard_output_is_an_output():
    """A PNG, and nothing else with it."""
    args = [*COMMAND, "render", "sphere", *SMALL, "-o", "-"]
    done = subprocess.run(args, capture_output=True, check=True)
    assert done.stderr == b""
    Path("a.png").write_bytes(done.stdout)
    assert raytrace.read_image("a.png").shape == (18, 32, 3)
    assert [file.name for file in Path().iterdir()] == ["a.png"]
    text = command("export", "sphere", "-o", "-").stdout
    assert text.startswith("#version 300 es\n")


def test_a_view_is_a_page():
    environment = os.environ | {"BROWSER": "true %s"}
    done = subprocess.run([*COMMAND, "view", "sphere", "-o", "a.html"], capture_output=True, text=True, env=environment)
    assert (done.returncode, done.stdout) == (0, "a.html: sphere\n")
    assert Path("a.html").read_text().lower().startswith("<!doctype html>")


@pytest.mark.parametrize("name", ["bench", "stress", "mutants", "gradients", "sun-trials"])
def test_measurements_are_commands_of_measure(name):
    alone, grouped = (command(*before, name, "--help") for before in ((), ("measure",)))
    assert (alone.returncode, grouped.returncode) == (0, 0)
    assert alone.stdout.splitlines()[1:] == grouped.stdout.splitlines()[1:]
    assert name in command("measure").stdout
    assert name in command("--help").stdout


def test_scene_files_are_named_after():
    raytrace.save_scene(raytrace.load_scene("sphere"), "mine.toml")
    assert command("render", "mine.toml", *SMALL).stdout.startswith("mine.png: 32x18, numpy float32, ")
    assert Path("mine.png").exists()


def test_scenes_lists_the_built_in_ones():
    assert [line.split()[0] for line in command("scenes").stdout.splitlines()] == list(raytrace.scenes())


def test_show_is_a_scene_file():
    Path("shown.toml").write_text(command("show", "skybox", "--set", "film.exposure=2").stdout)
    assert raytrace.load_scene("shown.toml") == raytrace.load_scene("skybox", ["film.exposure=2"])


def test_show_json_has_the_assignments_uniforms():
    uniforms = json.loads(command("show", "checkerboard", "--json", "--size", "200x100").stdout)
    assert [x["value"] for x in uniforms["camPos"]] == [0, 0.5, 2]
    assert [x["value"] for x in uniforms["viewToWorld"]] == [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.5, 2, 1]
    tan = np.tan(np.radians(30))
    assert uniforms["ndcToView"][0]["value"] == pytest.approx(2 * tan)
    color = uniforms["sunColor"][0]
    assert color["value"] == 1.64
    assert float.fromhex(color["hex"]) == color["float32"] == float(np.float32(1.64))
    assert np.uint32(int(color["bits"], 16)).view(np.float32) == np.float32(1.64)
    assert len(uniforms["spheres"]) == 6
    assert uniforms["planes"][0]["tileSize"]["value"] == 0.5


def test_pixel_prints_every_step_with_its_glsl():
    printed = command("pixel", "checkerboard", "900", "700").stdout
    steps = raytrace.render("checkerboard", backend="numpy", dtype="float64", output="steps")
    for name, step in steps.items():
        assert re.search(rf"^{name} ", printed, re.MULTILINE)
        if name != "index":
            for number in np.atleast_1d(step[700, 900]):
                assert float(number).hex() in printed
    assert "spheres[sphereIndex].center" in printed
    sky = command("pixel", "checkerboard", "3", "3", *SMALL).stdout
    assert "backgroundColor(rd)" in sky
    assert "NdL" not in sky


@pytest.mark.parametrize("dtype", ["float32", "longdouble"])
def test_pixel_in_other_arithmetics(dtype):
    done = command("pixel", "checkerboard", "9", "15", *SMALL, "--dtype", dtype)
    assert done.returncode == 0, done.stderr
    assert f"numpy {dtype}: plane 0" in done.stdout
    assert (" + 0x" in done.stdout or " + -0x" in done.stdout) == (dtype == "longdouble")


#: Arguments of the command, and what it says of them.
BAD_INPUT = [
    (["rendre"], "No such command 'rendre'"),
    (["diff", "a.png", "b.png"], "No such command 'diff'; there is 'raytrace compare'"),
    (["measure", "bnch"], "No such command 'bnch'"),
    (["render", "--width", "100"], "No such option: --width; there is --size WIDTHxHEIGHT"),
    (["render", "--spp", "4"], "No such option: --spp; there is --samples N, for N x N samples a pixel"),
    (["render", "--output", "normals"], "output: unknown 'normals'; there is: display, linear, steps (steps: every"),
    (["render", "--shader", "nowhere.frag"], "nowhere.frag: no such file"),
    (["render", "moon"], "moon: no such scene; built in: "),
    (["render", "nowhere.toml"], "nowhere.toml: no such file"),
    (["render", "--nonsense"], "No such option: --nonsense"),
    (["render", "--size", "1920"], "size: must be WIDTHxHEIGHT"),
    (["show", "--json", "--size", "0x0"], "size: must be (width, height)"),
    (["bench", "--size", "0x0"], "size: must be (width, height)"),
    (["render", "--bits", "0", *SMALL], "has no 0 bits a channel"),
    (["render", "--size", "0x10"], "size: must be (width, height), each from 1 to 65536 pixels, found (0, 10)"),
    (["render", "--size=-3x10"], "size: must be (width, height)"),
    (["render", "--size", "70000x10"], "size: must be (width, height)"),
    (["render", "--backend", "cuda"], "backend: unknown 'cuda'; there is: jax, numpy"),
    (["render", "--dtype", "float16"], "dtype of backend jax: unknown 'float16'; did you mean 'float"),
    (["render", "--dtype", "longdouble"], "dtype of backend jax: unknown 'longdouble'"),
    (["render", "--output", "dispaly"], "output: unknown 'dispaly'; did you mean 'display'?"),
    (["render", "--intersection", "exact"], "intersection: unknown 'exact'; there is: textbook, robust"),
    (["render", "--samples", "0"], "samples: must be a whole number from 1 to 64, found 0"),
    (["render", "--samples", "two"], "'--samples'"),
    (["render", "-o", "a.exr", "--output", "steps", "--samples", "2"], "samples: output 'steps'"),
    (["render", "-o", "a.bmp"], "a.bmp: unknown file ending '.bmp'; there is: .png, .exr, .tif, .tiff"),
    (["render", "-o", "nowhere/a.png"], "nowhere/a.png: the folder nowhere does not exist"),
    (["render", "-o", "/proc/a.png", *SMALL], "/proc/a.png: cannot be written: "),
    (["render", "--output", "steps"], "checkerboard.png: output 'steps' has many layers, which only .exr can hold"),
    (["render", "--set", "sun.direction=[0,0,0]"], "sun.direction: must not be the zero vector"),
    (["render", "--set", "film.tone_mapper=acse"], "film.tone_mapper: must be "),
    (["show", "--set", "sun"], "--set sun: must be key=value"),
    (["pixel", "checkerboard", "1920", "0"], "pixel 1920 0: must be within 0 0 and 1919 1079"),
    (["pixel", "checkerboard", "1"], "Missing argument"),
]


@pytest.mark.parametrize(("args", "told"), BAD_INPUT)
def test_bad_input_is_one_line_and_exit_code_2(args, told):
    assert told in refused(*args)


def test_an_existing_output_survives_a_failure():
    Path("checkerboard.png").write_text("mine")
    for args in (["--samples", "99"], ["--set", "sun.color=3"], ["--dtype", "half"], ["--bits", "7"]):
        refused("render", *args)
    assert Path("checkerboard.png").read_text() == "mine"


def test_a_full_disk_is_one_line():
    """A limit on the size of files stands in for a full disk."""
    limited = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000));" + COMMAND[-1]
    )
    args = [*COMMAND[:-1], limited, "render", "--backend", "numpy", "-o", "a.exr"]
    done = subprocess.run(args, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("raytrace: a.exr: cannot be written: ")
    assert len(done.stderr.splitlines()) == 1
    assert list(Path().iterdir()) == []


def test_standard_output_may_be_full_or_closed():
    with Path("/dev/full").open("w") as full:
        done = subprocess.run([*COMMAND, "scenes"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (
        2,
        "raytrace: standard output: cannot be written: no space left on device\n",
    )
    shell = f'"{sys.executable}" -c "{COMMAND[-1]}"'
    assert subprocess.run(f"{shell} scenes >&-", shell=True, check=False).returncode == 0
    assert subprocess.run(f"{shell} render nowhere 2>&-", shell=True, check=False).returncode == 2
    done = subprocess.run(f"{shell} show --json | head -1", shell=True, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("{\n", "")


@pytest.mark.parametrize(
    ("backend", "number", "code", "told"),
    [
        ("numpy", signal.SIGINT, 130, "raytrace: interrupted\n"),
        ("jax", signal.SIGINT, 130, "raytrace: interrupted\n"),
        ("numpy", signal.SIGTERM, 143, ""),
    ],
)
def test_an_interruption_leaves_nothing(backend, number, code, told):
    Path("checkerboard.png").write_text("mine")
    args = ["render", "--size", "16384x16384", "--backend", backend, "--samples", "4"]
    with started([*COMMAND, *args], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60
        while len(list(Path().iterdir())) < 2 and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(2)
        process.send_signal(number)
        stdout, stderr = process.communicate(timeout=60)
    assert (process.returncode, stdout, stderr) == (code, "", told)
    assert [file.name for file in Path().iterdir()] == ["checkerboard.png"]
    assert Path("checkerboard.png").read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "number"), some([("INT", signal.SIGINT), ("TERM", signal.SIGTERM)], ("INT", signal.SIGINT))
)
def test_an_ignored_signal_stays_ignored(name, number):
    """As in a background job or under `nohup`: whoever started the command wants it to go on."""
    code = f"import signal; signal.signal(signal.SIG{name}, signal.SIG_IGN); from raytrace.cli import run; run()"
    args = [sys.executable, "-c", code, "render", "--size", "2000x1500", "--backend", "numpy"]
    with started(args, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60
        while not list(Path().iterdir()) and time.monotonic() < deadline:
            time.sleep(0.02)
        assert process.poll() is None
        process.send_signal(number)
        _, stderr = process.communicate(timeout=60)
    assert (process.returncode, stderr) == (0, "")
    assert [file.name for file in Path().iterdir()] == ["checkerboard.png"]


def on_a_terminal(args, interrupted_at=None, **environment):
    """What a command shows on a terminal, as standard error, and what it prints.

    interrupted_at: what it has shown when it gets SIGINT.
    """
    terminal, child = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "120"} | environment
    with started(args, stdout=subprocess.PIPE, stderr=child, text=True, env=environment) as process:
        os.close(child)
        shown, interrupted = b"", interrupted_at
        while True:
            try:
                part = os.read(terminal, 4096)
            except OSError:
                break
            shown += part
            if interrupted_at is not None and interrupted_at in shown:
                interrupted_at = process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == (0 if interrupted is None else 130)
        return shown.decode(), process.stdout.read()


def test_a_terminal_sees_progress_and_a_pipe_does_not():
    args = [*COMMAND, "render", "--size", "2000x1500", "--backend", "numpy", "-o", "a.png"]
    shown, printed = on_a_terminal(args)
    assert printed.count("\n") == 1
    assert "rendering" in shown
    assert "compiling" not in shown
    assert subprocess.run(args, capture_output=True, check=True).stderr == b""


def test_a_terminal_sees_that_something_compiles():
    shown, printed = on_a_terminal(
        [*COMMAND, "render", "skybox", "--size", "16x9", "-o", "a.png"], RAYTRACE_CACHE="off"
    )
    assert printed.count("\n") == 1
    assert "compiling for this machine" in shown
    # No bar that stands at its beginning.
    assert "  0%" not in shown
    # Without a bar a spinner says it.
    shown, printed = on_a_terminal(
        [*COMMAND, "compare", "a.png", "backend:jax", "--size", "16x9", "--no-diagnose", "--json"], RAYTRACE_CACHE="off"
    )
    assert json.loads(printed)
    assert "compiling for this machine" in shown


@pytest.mark.parametrize("backend", some(["jax", "numpy"], "jax"))
def test_an_interruption_gives_the_terminal_back(backend):
    """While XLA compiles, too, which takes longer than anybody waits after Ctrl-C."""
    args = [*COMMAND, "render", "--size", "8000x8000", "--backend", backend, "-o", "a.png"]
    shown, printed = on_a_terminal(args, b"compiling" if backend == "jax" else b"rendering", RAYTRACE_CACHE="off")
    shows, hides = "\x1b[?25h", "\x1b[?25l"
    assert shown.count(hides) == shown.count(shows) > 0
    assert shown.endswith("raytrace: interrupted\r\n")
    assert hides not in shown.rpartition(shows)[2]
    assert (printed, list(Path().iterdir())) == ("", [])


def test_an_output_that_is_an_input_is_refused():
    raytrace.write_image("a.png", np.zeros((16, 16, 3)))
    raytrace.save_scene(raytrace.load_scene("sphere"), "scene.toml")
    before = {path: path.read_bytes() for path in Path().iterdir()}
    for arguments in (
        ("render", "scene.toml", "-o", "scene.toml"),
        ("export", "scene.toml", "-o", "./scene.toml"),
        ("compare", "a.png", "a.png", "--diff", "a.png"),
        ("verify", "a.png", "--scene", "sphere", "--marked", "a.png"),
        ("fit-sun", "a.png", "--plot", "a.png"),
    ):
        done = command(*arguments)
        assert done.returncode == 2
        assert "is an input, too" in done.stderr or "ending" in done.stderr
    assert {path: path.read_bytes() for path in Path().iterdir()} == before


@pytest.mark.skipif(os.name != "posix", reason="needs a POSIX shell")
@pytest.mark.parametrize("closed", some(["2>&-", ">&-", "<&- >&- 2>&-"], "2>&-"))
def test_a_closed_stream_is_no_file(closed, tmp_path):
    """The lowest free number is that of the next file that is opened: messages would be written into it."""
    image = tmp_path / "a.png"
    raytrace.write_image(image, np.full((16, 16, 3), 0.5))
    before = image.read_bytes()
    line = shlex.join([sys.executable, "-m", "raytrace", "compare", str(image), str(image)])
    assert subprocess.run(f"{line} {closed}", shell=True, capture_output=True).returncode == 0
    (tmp_path / "b.png").write_bytes(before[:200])
    line = shlex.join([sys.executable, "-m", "raytrace", "compare", str(image), str(tmp_path / "b.png")])
    assert subprocess.run(f"{line} {closed}", shell=True, capture_output=True).returncode == 2
    assert image.read_bytes() == before
    assert (tmp_path / "b.png").read_bytes() == before[:200]
