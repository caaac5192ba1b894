"""The page of a scene in a browser: what it shows is what its TOML says, whatever was done to it."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.cli.export import export
from raytrace.export import EXPORTS
from raytrace.glsl import values_of
from raytrace.scene.sun import sun_angles
from raytrace.scene.to_uniforms import uniforms_of
from raytrace.scene.toml import scene_toml
from tests.export.conftest import SIZE, SMALL, differing
from tests.scenes import some
from tests.strategies import many

BASE = raytrace.load_scene("checkerboard")
#: Pixels on edges, where float32 decides otherwise.
EDGES = 20


@pytest.mark.parametrize("name", some(raytrace.scenes(), "checkerboard", "orthographic", "inside-a-sphere"))
def test_at_first_it_is_the_scene(show, name):
    """Picture, camera and text; also where its numbers are none that a slider could have."""
    scene = raytrace.load_scene(name)
    page = show(scene, size=SMALL)
    assert page.copied() == (scene, SMALL)
    assert differing(page.pixels(), page.rendered()) <= EDGES
    matrices = page.page.evaluate("matrices(view.camera, canvas.width / canvas.height)")
    for uniform, value in values_of(uniforms_of(scene, SMALL[0] / SMALL[1])).items():
        if uniform in matrices:
            np.testing.assert_allclose(matrices[uniform], value, rtol=1e-14, atol=1e-15)


def test_unusual_numbers_come_back(show):
    scene = replace(
        BASE,
        sun=raytrace.Sun(direction=(1e-20, 3e-7, -0.0), color=(1e6, 1, 1 / 3)),
        film=raytrace.Film(exposure=1e-7, white_point=(1 / 3, 0.35)),
        camera=raytrace.PerspectiveCamera((1e11, 0.1, 2), (0, 0, 1 / 3), (0, 1e30, 0), 179.5),
    )
    page = show(scene)
    assert page.copied() == (scene, SIZE)
    page.page.focus("#canvas")
    page.page.keyboard.press("+")
    assert page.copied()[0].film == scene.film


def test_one_file_without_an_end_inside():
    for name in raytrace.scenes():
        text = EXPORTS["html"](raytrace.load_scene(name), SIZE)
        assert len(text.encode()) < 200_000
        assert text.count("</script>") == text.count("<script") == 7
        assert not re.search(r"(?:src|href)=\"(?!data:)", text)
        data = re.search(r'id="scene">(.*)</script>', text)[1]
        assert "<" not in data
        assert json.loads(data)["toml"] == scene_toml(raytrace.load_scene(name))


def test_the_command():
    export("sphere", to="html", size="320x180")
    assert Path("sphere.html").read_text(encoding="utf-8") == EXPORTS["html"](raytrace.load_scene("sphere"), SIZE)


def test_a_drag_turns_the_scene_with_the_pointer(show):
    page = show()
    page.drag(45, 0)
    page.page.mouse.move(10, 10)  # which is no drag
    scene, _ = page.copied()
    camera = scene.camera
    # To the right: the camera goes to the left, half a turn for the canvas's height.
    angle = math.pi * 45 / SIZE[1]
    np.testing.assert_allclose(camera.position, [-2 * math.sin(angle), 0.5, 2 * math.cos(angle)], atol=1e-12)
    assert replace(scene, camera=replace(camera, position=BASE.camera.position)) == BASE
    assert differing(page.pixels(), page.rendered()) <= EDGES
    page.drag(0, 10)
    tilted = page.copied()[0].camera.position
    assert tilted[1] == pytest.approx(0.5 + 2 * math.sin(math.pi * 10 / SIZE[1]))
    assert differing(page.pixels(), page.rendered()) <= EDGES


@pytest.mark.full
def test_it_stops_before_the_pole(show):
    """A TOML that looks along up could not be read."""
    page = show()
    for down in (80, -80):
        for _ in range(4):
            page.drag(0, down)
        x, y, z = page.copied()[0].camera.position - BASE.camera.target
        assert math.atan2(math.hypot(x, z), abs(y)) == pytest.approx(0.02)
        assert z > 0


@pytest.mark.parametrize("name", some(["checkerboard", "orthographic", "shifted-lens"], "orthographic"))
def test_every_camera_turns_and_zooms(show, name):
    page = show(name)
    before = page.copied()[0].camera
    page.drag(30, -20)
    page.page.mouse.wheel(0, -200)
    page.page.wait_for_function("view.zoom !== 1")
    scene, _ = page.copied()
    after = scene.camera
    nearer = math.exp(-200 / 800)
    if name == "checkerboard":
        distances = [np.linalg.norm(camera.position - camera.target) for camera in (before, after)]
        assert distances[1] == pytest.approx(nearer * distances[0])
    elif name == "orthographic":
        assert after.height == pytest.approx(nearer * before.height)
    else:
        axes = after.view_to_world[:3, :3]
        np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
        assert not np.allclose(axes, before.view_to_world[:3, :3])
    assert differing(page.pixels(), page.rendered()) <= EDGES
    page.page.click("button[type=reset]")
    assert page.copied()[0].camera == before


@pytest.mark.full
def test_two_fingers_zoom(show):
    page = show(has_touch=True)
    touch = page.page.context.new_cdp_session(page.page)

    def fingers(kind, *xs):
        points = [{"x": x, "y": 90, "id": i} for i, x in enumerate(xs)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    fingers("touchStart", 140)
    fingers("touchStart", 140, 180)
    fingers("touchMove", 130, 190)
    fingers("touchMove", 120, 200)
    fingers("touchEnd")
    scene, _ = page.copied()
    np.testing.assert_allclose(scene.camera.position, [0, 0.5, 1], atol=1e-12)
    assert differing(page.pixels(), page.rendered()) <= EDGES
    fingers("touchStart", 100)
    fingers("touchMove", 110)
    fingers("touchEnd")
    angle = math.pi * 10 / SIZE[1]
    np.testing.assert_allclose(page.copied()[0].camera.position, [-math.sin(angle), 0.5, math.cos(angle)], atol=1e-12)


def test_sliders(show):
    """Each changes its own value and the picture, and says its value."""
    page = show()
    elevation = sun_angles(BASE.sun.direction)[1]
    page.slide("azimuth", -30)
    sun = page.copied()[0].sun
    np.testing.assert_allclose(sun_angles(sun.direction), (-30, elevation))
    page.slide("elevation", 70.5)
    scene, _ = page.copied()
    np.testing.assert_allclose(sun_angles(scene.sun.direction), (-30, 70.5))
    np.testing.assert_array_equal(scene.sun.color, BASE.sun.color)
    assert differing(page.pixels(), page.rendered()) <= EDGES
    assert page.page.inner_text("output[for=elevation]") == "70.5°"

    page.page.focus("#exposure")
    for _ in range(3):
        page.page.keyboard.press("ArrowRight")
    page.slide("fov", 40)
    changed, _ = page.copied()
    assert changed == replace(
        scene, film=raytrace.Film(exposure=0.15), camera=replace(BASE.camera, field_of_view=np.array(40.0))
    )
    assert page.page.inner_text("output[for=exposure]") == "0.15 EV"
    assert differing(page.pixels(), page.rendered()) <= EDGES


def test_tone_mappers(show):
    """Beside an exposure, a white point and sRGB."""
    page = show("non-default-film", size=SMALL)
    film = page.copied()[0].film
    page.slide("exposure", 1)
    seen = []
    for mapper in ("reinhard", "hable", "none", "aces"):
        page.page.select_option("#mapper", mapper)
        scene, _ = page.copied()
        assert scene.film == replace(film, exposure=np.array(1.0), tone_mapper=mapper)
        seen.append(page.pixels())
        assert differing(seen[-1], page.rendered()) <= EDGES
    assert len({image.tobytes() for image in seen}) == 4


def coloured(steps):
    """Each step as the page says that it is shown."""
    hit = (steps["index"] >= 0)[..., None]
    turns = 0.618034 * steps["index"][..., None] + np.array([0, 1, 2]) / 3
    grey = {name: np.repeat(steps[name][..., None], 3, axis=-1) for name in ("t", "NdL", "NdSky", "shadow")}
    return steps | {
        "pixelNdc": np.pad(0.5 * steps["pixelNdc"] + 0.5, ((0, 0), (0, 0), (0, 1))),
        "rd": 0.5 * steps["rd"] + 0.5,
        "t": np.where(hit, 2 / (2 + grey.pop("t")), [0.1, 0.2, 0.5]),
        "index": np.where(hit, 0.5 + 0.5 * np.cos(2 * np.pi * turns), 0),
        "hitPoint": steps["hitPoint"] % 1,
        "N": 0.5 * steps["N"] + 0.5,
        **grey,
    }


def test_steps(show):
    page = show()
    page.drag(17, -11)  # or a whole row or column of pixels may lie on an edge
    steps = page.rendered("steps")
    # float32 has no fractions of the hit points at the horizon.
    near = (np.abs(steps["hitPoint"]).max(axis=-1) < 20)[..., None]
    for name, reference in coloured(steps).items():
        page.page.select_option("#step", name)
        page.settle()
        told = page.page.inner_text("#told")
        assert told.startswith(f"{name}: ")
        seen, reference = page.pixels(), np.clip(reference, 0, 1)
        if name == "hitPoint":
            seen, reference = seen * near, reference * near
        assert differing(seen, reference) <= EDGES, name


def test_spheres_in_a_texture(show):
    scene = replace(BASE, spheres=many(100))
    page = show(scene)
    assert page.copied()[0] == scene
    assert differing(page.pixels(), page.rendered()) <= EDGES


@pytest.mark.full
def test_pixels_of_the_screen(show):
    page = show(device_scale_factor=2)
    assert page.copied()[1] == (2 * SIZE[0], 2 * SIZE[1])
    assert page.pixels().shape == (2 * SIZE[1], 2 * SIZE[0], 3)
    assert differing(page.pixels(), page.rendered()) <= EDGES
    page.page.set_viewport_size({"width": 1000, "height": 600})
    page.settle()
    assert page.page.locator("canvas").bounding_box()["width"] == 1000 - 21 * 16
    assert page.copied()[1][0] == 2 * (1000 - 21 * 16)


def test_copy(show):
    page = show(permissions=["clipboard-read", "clipboard-write"])
    page.slide("azimuth", 10)
    page.page.click("#copy")
    page.page.wait_for_selector("text=Copied.")
    assert page.page.evaluate("navigator.clipboard.readText()") == page.toml()


@pytest.mark.full
def test_copy_where_the_clipboard_is_refused(show):
    page = show(script="navigator.clipboard.writeText = () => Promise.reject(new Error('refused'))")
    page.page.click("#copy")
    page.page.wait_for_selector("text=The clipboard is refused here")
    assert page.page.is_visible("#toml")
    assert page.page.evaluate("getSelection().toString()") == page.toml()


@pytest.mark.parametrize(
    ("script", "told"),
    [
        ("HTMLCanvasElement.prototype.getContext = () => null", "no WebGL2 context"),
        (
            "const real = WebGL2RenderingContext.prototype.shaderSource;"
            "WebGL2RenderingContext.prototype.shaderSource ="
            " function(shader, text) { real.call(this, shader, text + 'mistake'); }",
            "does not compile here: ERROR",
        ),
    ],
)
def test_without_a_picture_there_is_a_message(show, script, told):
    page = show(script=script)
    page.settle()
    assert told in page.page.inner_text("#message")
    assert not page.page.is_visible("canvas")
    # The scene is still there.
    assert page.copied()[0] == BASE


@pytest.mark.full
def test_a_lost_context(show):
    page = show()
    picture = page.pixels()
    page.page.evaluate("lose = canvas.getContext('webgl2').getExtension('WEBGL_lose_context'); lose.loseContext()")
    page.page.wait_for_selector("text=The graphics context was lost")
    assert not page.page.is_visible("canvas")
    page.page.evaluate("lose.restoreContext()")
    page.page.wait_for_selector("canvas")
    np.testing.assert_array_equal(page.pixels(), picture)


def test_a_tone_mapper_in_python():
    scene = replace(BASE, film=raytrace.Film(tone_mapper=lambda x: x))
    with pytest.raises(raytrace.InputError, match="Python function"):
        EXPORTS["html"](scene, SIZE)
