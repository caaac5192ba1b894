"""Golden images: written whole and the same each time, and told from any other image."""

import html.parser
import json
import shutil
import signal
import subprocess
import time
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.comparison.metrics import pixels_over, similarity
from raytrace.errors import InputError
from raytrace.golden import BOUNDS, backend_source, folder_source, golden_folder, golden_scenes, write_goldens
from raytrace.image import read_metadata
from raytrace.rendering import Options
from raytrace.shader.specification import SPECIFICATION
from raytrace.testing import goldens
from tests.engines import need
from tests.processes import COMMAND, command, started
from tests.scenes import some

SIZE = (96, 54)
SCENES = ("checkerboard", "skybox")


def made(folder="G", names=SCENES, size=SIZE, certified=False):
    written = write_goldens(folder, golden_scenes(names), size, certified=certified)
    assert list(written) == [Path(name).stem for name in names]
    return Path(folder)


def test_what_is_written():
    folder = made()
    endings = (".display.exr", ".linear.exr", ".png", ".steps.exr", ".uniforms.json")
    assert {path.name for path in folder.iterdir()} == {
        "manifest.json",
        *(name + ending for name in SCENES for ending in endings),
    }
    steps = raytrace.render("checkerboard", SIZE, backend="numpy", dtype="float64", output="steps")
    for ending, name in ((".display.exr", "display"), (".linear.exr", "linear")):
        np.testing.assert_array_equal(raytrace.read_image(folder / f"checkerboard{ending}"), np.float32(steps[name]))
    png = raytrace.read_image(folder / "checkerboard.png")
    np.testing.assert_allclose(png, np.rint(steps["display"] * 255) / 255, atol=1e-7)
    np.testing.assert_array_equal(raytrace.read_image(folder / "checkerboard.steps.exr")["index"], steps["index"])
    assert len(json.loads((folder / "checkerboard.uniforms.json").read_text())["spheres"]) == 6
    assert read_metadata(folder / "checkerboard.linear.exr")["output"] == "linear"
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["size"] == [*SIZE]
    assert manifest["versions"].keys() == {"raytrace", "numpy"}
    assert manifest["scenes"]["skybox"]["about"].startswith("Figure 2")


def test_certificates_prove_the_images_and_bound_others():
    folder = made(certified=True)
    manifest = json.loads((folder / "manifest.json").read_text())
    assert {f"checkerboard.{kind}.exr" for kind in ("certificate", "bounds")} < set(
        manifest["scenes"]["checkerboard"]["files"]
    )
    assert all(entry["proven"] > 0.9999 for entry in manifest["scenes"].values())
    found = results(backend_source(Options(backend="numpy", dtype="float32")))
    assert all(result.verification.inside and not result.failed for result in found.values())
    assert "inside the bounds" in str(found["skybox"])
    # A mistake that SSIM's usual threshold passes: the sky's gradient.
    from raytrace.export import EXPORTS

    need("opengl")
    for name in SCENES:
        right = EXPORTS["glsl"](raytrace.load_scene(name), SIZE)
        Path(f"{name}.frag").write_text(right.replace("1./4.", "0.26"))
    wrong = results(backend_source(Options(backend="opengl", shader="skybox.frag")))["skybox"]
    assert wrong.comparison.ssim.mean > 0.99
    assert wrong.failed[0].startswith("outside at ")


def test_goldens_of_another_specification_are_refused_in_one_line():
    """Manifests of the first specification do not state it."""
    folder = made(names=("skybox",))
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    assert manifest.pop("specification") == SPECIFICATION == 2
    for stated, told in (
        ({}, "golden images of specification 1; this is specification 2 (components that a white point makes negative"),
        ({"specification": 1}, "golden images of specification 1; this is specification 2"),
        ({"specification": 3}, "golden images of specification 3, made by a newer raytrace"),
    ):
        path.write_text(json.dumps(manifest | stated))
        done = command("check", "G", "--backend", "numpy")
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith(f"raytrace: G/manifest.json: {told}")
        assert done.stderr.count("\n") == 1
        with pytest.raises(raytrace.InputError, match="golden images of specification"):
            goldens(folder)
    # An old folder can be made again in its place.
    made(names=("skybox",))
    assert command("check", "G", "--backend", "numpy", "--report", "r.html").returncode == 0


def contents(folder):
    return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def test_twice_gives_equal_bytes_and_another_value_other_hashes():
    once = contents(made())
    assert contents(made()) == once
    raytrace.save_scene(raytrace.load_scene("skybox", ["sun.color=[1.64, 1.27, 0.9900001]"]), "skybox.toml")
    other = made("H", ("./skybox.toml",))
    hashes = [json.loads((folder / "manifest.json").read_text())["scenes"]["skybox"] for folder in (Path("G"), other)]
    assert hashes[0]["sha256"] != hashes[1]["sha256"]


def test_a_folder_of_something_else_is_left_alone():
    Path("mine").mkdir()
    Path("mine/thesis.tex").write_text("")
    with pytest.raises(raytrace.InputError, match=r"^mine: holds thesis\.tex, which is no golden image"):
        made("mine")
    made("G")
    Path("G/notes.txt").write_text("")
    with pytest.raises(raytrace.InputError, match=r"^G: holds notes\.txt"):
        made("G")
    with pytest.raises(raytrace.InputError, match=r"^nowhere/G: the folder nowhere does not exist"):
        made("nowhere/G")
    assert sorted(path.name for path in Path().iterdir()) == ["G", "mine"]


def test_an_interruption_leaves_the_old_folder():
    made("G", ("skybox",))
    before = contents("G")
    args = [*COMMAND, "golden", "G", "--size", "1920x1080"]
    with started(args, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60
        while len(list(Path().iterdir())) < 2 and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=60)
    assert (process.returncode, told) == (130, "raytrace: interrupted\n")
    assert [path.name for path in Path().iterdir()] == ["G"]
    assert contents("G") == before


def results(source, folder="G", **bounds):
    return {result.name: result for result in golden_folder(folder).check(source, bounds)}


@pytest.mark.parametrize("names", some([["checkerboard", "skybox"], ["spheres"]], ["checkerboard", "skybox"]), ids=str)
def test_other_arithmetics_pass(engine, names):
    made("G", names)
    for source in (
        backend_source(Options(backend=engine)),
        backend_source(Options(backend="jax")),
        backend_source(Options(backend="numpy", dtype="float64")),
    ):
        assert [result.failed for result in results(source).values()] == [()] * len(names)


def test_images_of_another_renderer_pass_in_any_format():
    made()
    Path("I").mkdir()
    for name, path in (("checkerboard", "checkerboard.png"), ("skybox", "skybox.exr")):
        output = "linear" if path.endswith("exr") else "display"
        raytrace.write_image(f"I/{path}", raytrace.render(name, SIZE, output=output), output=output)
    assert [result.failed for result in results(folder_source("I")).values()] == [(), ()]
    assert [result.failed for result in results(folder_source("G")).values()] == [(), ()]


def test_an_image_of_8_bits_is_held_against_8_bits():
    """In a dark sky rounding alone would take SSIM below the bound."""
    made("G", ("skybox-linear", "inside-a-sphere"), (480, 270))
    assert [result.failed for result in results(folder_source("G"), min_ssim=0.9999).values()] == [(), ()]
    Path("I").mkdir()
    for name in ("skybox-linear", "inside-a-sphere"):
        shutil.copy(f"G/{name}.png", "I")
    assert [result.failed for result in results(folder_source("I")).values()] == [(), ()]


def test_what_is_wrong_with_files_is_named():
    made("G", ("checkerboard", "skybox", "sphere", "spheres", "shadows"))
    shutil.copytree("G", "I")
    for path in Path("I").glob("*.exr"):
        path.unlink()
    whole = Path("G/skybox.display.exr").read_bytes()
    Path("G/skybox.display.exr").write_bytes(whole[: len(whole) // 2])
    Path("G/sphere.png").unlink()
    Path("G/extra.png").write_text("")
    Path("I/spheres.png").unlink()
    Path("I/shadows.png").write_bytes(Path("I/shadows.png").read_bytes()[:500])
    done = command("check", "G", "--images", "I")
    assert (done.returncode, done.stderr) == (1, "")
    lines = done.stdout.splitlines()
    assert [line.split()[:2] for line in lines[:5]] == [
        ["ok", "checkerboard"],
        ["FAIL", "skybox"],
        ["FAIL", "sphere"],
        ["FAIL", "spheres"],
        ["FAIL", "shadows"],
    ]
    assert "G/skybox.display.exr: truncated or changed" in lines[1]
    assert "G/sphere.png: missing" in lines[2]
    assert "I: missing: spheres with one of" in lines[3]
    assert "I/shadows.png: is not a" in lines[4]
    assert "G/extra.png: extra" in lines[5]
    assert "1 of 5 pass" in lines[6]


#: Arguments of the command, and what it says of them.
BAD_INPUT = [
    (["check", "nowhere", "--backend", "numpy"], "nowhere: holds no golden images (no manifest.json)"),
    (["check", "G"], "check: give one of --images, --backend and --shader"),
    (["check", "G", "--backend", "numpy", "--images", "G"], "check: give one of --images, --backend and --shader"),
    (["check", "G", "--images", "nowhere"], "nowhere: no such folder"),
    (["check", "G", "--images", "G", "--shader", "a.frag"], "check: give one of --images, --backend and --shader"),
    (["check", "broken", "--backend", "numpy"], "broken/manifest.json: broken"),
    (["golden", "new", "--scenes", "nowhere"], "nowhere: no such scene"),
    (["golden", "new", "--scenes", "sphere,sphere"], "scenes: two are called 'sphere'"),
    (["golden", "new", "--scenes", ","], "scenes: none is given"),
    (["golden", "new", "--size", "0x9"], "size: must be"),
    (["golden", "G/manifest.json"], "G/manifest.json: is not a folder"),
]


@pytest.mark.parametrize(("args", "told"), BAD_INPUT)
def test_bad_input_is_one_line(args, told):
    made("G", ("skybox",))
    Path("broken").mkdir()
    Path("broken/manifest.json").write_text('{"format": 2}')
    done = command(*args)
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"raytrace: {told}")
    assert not Path("new").exists()


def test_the_command_makes_and_checks():
    assert command("golden", "G", "--scenes", "checkerboard,skybox", "--size", "96x54").returncode == 0
    done = command("check", "G", "--backend", "numpy", "--dtype", "float32")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-1] == "2 of 2 pass; report.html"
    assert "<table>" in Path("report.html").read_text()
    found = command("check", "G", "--backend", "numpy", "--dtype", "float32", "--require", "ssim>=1.01", "--json")
    assert found.returncode == 1
    first = json.loads(found.stdout)["results"][0]
    assert first["name"] == "checkerboard"
    assert "must be at least 1.01" in first["failed"][0]


def test_a_wrong_shader_is_diagnosed(engine):
    made("G", ("checkerboard",))
    Path("a.frag").write_text("")
    scene = raytrace.load_scene("checkerboard")
    from raytrace.export import EXPORTS

    right = EXPORTS["glsl"](scene, SIZE)
    Path("a.frag").write_text(
        right.replace("2. * fragmentTextureCoordinates - 1.", "1. - 2. * fragmentTextureCoordinates")
    )
    wrong = results(backend_source(Options(backend=engine, shader="a.frag")))["checkerboard"]
    assert wrong.failed
    assert "flipped" in str(wrong)
    Path("a.frag").write_text(right.replace("2.51", "2.51 +"))
    assert "a.frag:" in results(backend_source(Options(backend=engine, shader="a.frag")))["checkerboard"].failed[0]


@pytest.mark.parametrize("golden", goldens(scenes=["checkerboard", "shadows"], size=(240, 136)), ids=str)
def test_opengl_by_the_helper_for_other_projects(golden):
    need("opengl")
    image = raytrace.render(golden.scene, golden.size, backend="opengl")
    golden.check(image)
    with pytest.raises(AssertionError, match=f"^{golden}: SSIM is "):
        golden.check(image[::-1])


def test_goldens_of_a_folder():
    folder = made()
    assert [golden.name for golden in goldens(folder)] == [*SCENES]
    (golden,) = goldens(folder, scenes=["skybox"])
    assert golden.size == SIZE
    golden.check(raytrace.render(golden.scene, golden.size))
    with pytest.raises(raytrace.InputError, match="holds no golden image 'sphere'"):
        goldens(folder, scenes=["sphere"])
    (folder / "skybox.png").unlink()
    with pytest.raises(raytrace.InputError, match=r"skybox\.png: missing"):
        goldens(folder)


@pytest.mark.full
def test_every_golden_fails_against_every_other():
    """By both bounds of `raytrace check`."""
    for a, b in combinations(goldens(size=(160, 90)), 2):
        assert not similarity(a.image, b.image).mean >= BOUNDS["min_ssim"], (a.name, b.name)
        assert not pixels_over(a.image, b.image).mean() <= BOUNDS["max_share"], (a.name, b.name)


def test_goldens_smaller_than_the_window_of_ssim_pass_against_themselves():
    list(write_goldens("small", golden_scenes(["sphere"]), (8, 8)))
    (checked,) = golden_folder("small").check(backend_source(Options(backend="numpy", dtype="float64")))
    assert not checked.failed
    (other,) = golden_folder("small").check(lambda golden: np.zeros((8, 8, 3)))
    assert other.failed


@pytest.mark.parametrize("name", ["a[b]", "a*", "a?b"])
def test_names_with_letters_that_mean_something_to_a_shell(name):
    raytrace.save_scene(raytrace.load_scene("sphere"), f"{name}.toml")
    list(write_goldens("g", golden_scenes([f"{name}.toml"]), (16, 16)))
    (checked,) = golden_folder("g").check(folder_source("g"))
    assert not checked.failed
    list(write_goldens("g", golden_scenes([f"{name}.toml"]), (16, 16)))


def test_nothing_but_what_was_written_is_replaced():
    """A manifest can name any file: it is there, and stays, unless it is as it was written."""
    list(write_goldens("g", golden_scenes(["sphere"]), (16, 16)))
    Path("g/thesis.txt").write_text("mine")
    manifest = json.loads(Path("g/manifest.json").read_text())
    manifest["scenes"]["sphere"]["files"]["thesis.txt"] = "0" * 64
    Path("g/manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(InputError, match=r"holds thesis\.txt"):
        list(write_goldens("g", golden_scenes(["sphere"]), (16, 16)))
    assert Path("g/thesis.txt").read_text() == "mine"
    Path("g/thesis.txt").unlink()
    Path("g/sphere.png").unlink()
    Path("g/sphere.png").mkdir()
    with pytest.raises(InputError, match=r"holds sphere\.png"):
        list(write_goldens("g", golden_scenes(["sphere"]), (16, 16)))
    with pytest.raises(InputError, match="is the current folder"):
        list(write_goldens(".", golden_scenes(["sphere"]), (16, 16)))


def test_the_report_closes_what_it_opens():
    class Balanced(html.parser.HTMLParser):
        def __init__(self):
            super().__init__()
            self.opened = []

        def handle_starttag(self, tag, attributes):
            if tag not in ("img", "meta", "br", "link"):
                self.opened.append(tag)

        def handle_endtag(self, tag):
            assert self.opened.pop() == tag

    list(write_goldens("g", golden_scenes(["sphere", "skybox"]), (16, 16)))
    Path("mine").mkdir()
    raytrace.write_image("mine/sphere.png", np.zeros((16, 16, 3)))
    done = command("check", "g", "--images", "mine")
    assert done.returncode == 1
    parser = Balanced()
    parser.feed(Path("report.html").read_text())
    assert parser.opened == ["html"]  # whose end HTML leaves to the file's


def test_endings_in_capitals_are_found_and_exr_may_hold_display_values():
    list(write_goldens("g", golden_scenes(["sphere"]), (48, 27)))
    Path("mine").mkdir()
    shutil.copy("g/sphere.png", "mine/sphere.PNG")
    assert command("check", "g", "--images", "mine").returncode == 0
    Path("mine/sphere.PNG").unlink()
    raytrace.write_image("mine/sphere.exr", raytrace.read_image("g/sphere.display.exr"), output="linear")
    done = command("check", "g", "--images", "mine")
    assert done.returncode == 1
    assert "give --display" in done.stdout
    assert command("check", "g", "--images", "mine", "--display").returncode == 0


def test_a_source_may_give_files():
    list(write_goldens("g", golden_scenes(["sphere"]), (48, 27)))
    (checked,) = golden_folder("g").check(lambda golden: Path("g/sphere.png"))
    assert not checked.failed
    assert checked.verification.inside


def test_an_image_of_no_golden_one_is_named():
    made("G", ("skybox",))
    Path("I").mkdir()
    shutil.copy("G/skybox.png", "I/skybox.png")
    shutil.copy("G/skybox.png", "I/skibox.png")
    Path("I/notes.txt").write_text("")
    done = command("check", "G", "--images", "I")
    assert done.returncode == 0
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("note"))
    assert line == "note  I/skibox.png: is no golden image's; did you mean 'skybox'? there is: skybox"
    assert "note" not in command("check", "G", "--images", "G").stdout


def test_one_image_is_checked_in_one_step():
    """Its difference, the bounds and the mistake; no golden folder, and the size is its own."""
    image = raytrace.render("skybox", (48, 27), backend="numpy", dtype="float64")
    raytrace.write_image("right.png", image)
    raytrace.write_image("wrong.png", image**2.2)
    done = command("check", "right.png", "--scene", "skybox")
    assert (done.returncode, done.stderr) == (0, "")
    assert "inside the bounds" in done.stdout
    assert "1 of 1 pass; report.html" in done.stdout
    done = command("check", "wrong.png", "--scene", "skybox", "--report", "wrong.html")
    assert (done.returncode, done.stderr) == (1, "")
    assert "wrong.png has no gamma (the transfer function is missing)" in done.stdout
    assert "has no gamma" in Path("wrong.html").read_text()
    # A file of ours says what it shows.
    command("render", "skybox", "--size", "48x27", "-o", "ours.exr", "--backend", "numpy")
    assert command("check", "ours.exr").returncode == 0


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (["a.png"], "a.png: does not say which scene it shows; give one (--scene)"),
        (["a.png", "--scene", "moon"], "moon: no such scene"),
        (["a.png", "--scene", "skybox", "--backend", "numpy"], "one IMAGE is checked by itself"),
        (["a.png", "--set", "lighting=on"], "--set: changes a scene; give one (--scene)"),
        (["a.png", "--scene", "skybox", "--report", "a.png"], "is an input, too"),
        (["nowhere.png", "--scene", "skybox"], "nowhere.png: no such image"),
    ],
)
def test_one_image_that_cannot_be_checked(args, told):
    raytrace.write_image("a.png", np.zeros((16, 16, 3)))
    done = command("check", *args)
    assert (done.returncode, done.stdout) == (2, "")
    assert told in done.stderr
    assert done.stderr.count("\n") == 1
    assert [path.name for path in Path().iterdir()] == ["a.png"]
