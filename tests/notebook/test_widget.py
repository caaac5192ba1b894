"""What a view does without a browser: events come in, frames go out."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import raytrace
from raytrace.backends.jax.renderer import _compiled
from raytrace.errors import InputError
from raytrace.notebook.orbit import orbited, pivot_of, zoomed
from tests.engines import skip_unless_required

#: Seconds after which a view is sharp, and some.
REST = 0.3
CAMERAS = ["spheres", "orthographic", "shifted-lens"]


def position(camera):
    matrices = isinstance(camera, raytrace.MatrixCamera)
    return np.asarray(camera.view_to_world[:3, 3] if matrices else camera.position)


def ahead(camera):
    if isinstance(camera, raytrace.MatrixCamera):
        return -camera.view_to_world[:3, 2] / np.linalg.norm(camera.view_to_world[:3, 2])
    return (camera.target - camera.position) / np.linalg.norm(camera.target - camera.position)


@pytest.mark.parametrize("name", CAMERAS)
def test_a_camera_goes_around_at_its_distance(name):
    scene = raytrace.load_scene(name)
    pivot = pivot_of(scene)
    moved = orbited(scene.camera, pivot, 0.3, 0.1)
    assert np.linalg.norm(position(moved) - position(scene.camera)) > 0.1
    distances = [np.linalg.norm(position(camera) - pivot) for camera in (scene.camera, moved)]
    np.testing.assert_allclose(*distances)
    # The pivot stays in the middle of the picture.
    for camera in (scene.camera, moved):
        away = pivot - position(camera)
        np.testing.assert_allclose(away / np.linalg.norm(away), ahead(camera), atol=1e-9)


@pytest.mark.parametrize("name", CAMERAS)
def test_there_and_back(name):
    scene = raytrace.load_scene(name)
    pivot = pivot_of(scene)
    back = orbited(orbited(scene.camera, pivot, 0.4, 0.0), pivot, -0.4, 0.0)
    np.testing.assert_allclose(position(back), position(scene.camera), atol=1e-12)
    back = zoomed(zoomed(scene.camera, pivot, 0.5), pivot, 2.0)
    np.testing.assert_allclose(position(back), position(scene.camera), atol=1e-12)


def test_no_camera_looks_along_up():
    """However far one drags, the picture's up stays up."""
    scene = raytrace.load_scene("spheres")
    camera, pivot = scene.camera, pivot_of(scene)
    for _ in range(50):
        camera = orbited(camera, pivot, 0.1, 0.3)
        raytrace.check_scene(replace(scene, camera=camera))


@pytest.fixture
def seen():
    try:
        return raytrace.view("spheres", (96, 54), samples=2)
    except InputError as missing:
        skip_unless_required(missing)


def drag(view, right, down):
    for kind, x, y in (("pointer_down", 20, 20), ("pointer_move", 20 + right, 20 + down), ("pointer_up", 0, 0)):
        view.canvas.handle_event({"event_type": kind, "x": x, "y": y, "button": 1})


def as_reference(view, samples):
    image = raytrace.render(view.scene, view.size, samples=samples, backend="numpy", dtype="float64")
    return np.rint(image * 255)


def test_a_view_shows_its_scene(seen):
    before = seen.frame()
    assert before.shape == (54, 96, 3)
    assert before.dtype == np.uint8
    assert np.mean(np.abs(before - as_reference(seen, 2)).max(-1) > 1) < 0.01
    ThreadPoolExecutor().submit(drag, seen, 12, 4).result()
    assert not np.allclose(seen.scene.camera.position, raytrace.load_scene("spheres").camera.position)
    assert np.mean(np.abs(seen.frame() - as_reference(seen, 2)).max(-1) > 1) < 0.01
    assert np.mean(seen.frame() != before) > 0.1


def test_while_one_drags_frames_are_coarse_and_nothing_is_compiled(seen):
    async def dragged():
        for _ in range(20):
            drag(seen, 2, 1)
            seen.frame()
        seen.controls["azimuth"].value = 10.0
        coarse = seen.frame()
        await asyncio.sleep(2 * REST)
        return coarse, seen.frame()

    compiled = _compiled.cache_info().misses
    # In a thread, as Playwright has a loop running in this one once it has started.
    coarse, sharp = ThreadPoolExecutor().submit(asyncio.run, dragged()).result()
    assert _compiled.cache_info().misses == compiled
    assert np.mean(np.abs(sharp - as_reference(seen, 2)).max(-1) > 1) < 0.01
    assert np.mean(coarse != sharp) > 0.01
    one = raytrace.render(seen.scene, seen.coarse_size)
    assert coarse.shape == sharp.shape
    assert {*map(tuple, coarse.reshape(-1, 3))} <= {*map(tuple, np.rint(np.asarray(one) * 255).reshape(-1, 3))}


def test_the_wheel_goes_nearer(seen):
    distance = np.linalg.norm(seen.scene.camera.position - pivot_of(seen.scene))
    seen.canvas.handle_event({"event_type": "wheel", "dx": 0, "dy": -200, "x": 1, "y": 1})
    assert np.linalg.norm(seen.scene.camera.position - pivot_of(seen.scene)) < distance


def test_sliders_change_the_scene(seen):
    seen.controls["azimuth"].value = 20.0
    seen.controls["elevation"].value = 45.0
    seen.controls["exposure"].value = 1.0
    seen.controls["tone mapper"].value = "reinhard"
    np.testing.assert_allclose(seen.scene.sun.direction, raytrace.sun_direction(20.0, 45.0))
    assert seen.scene.film.exposure == 1.0
    assert seen.scene.film.tone_mapper == "reinhard"
    ThreadPoolExecutor().submit(setattr, seen.controls["samples"], "value", 1).result()
    assert np.mean(np.abs(seen.frame() - as_reference(seen, 1)).max(-1) > 1) < 0.01


def test_a_view_that_cannot_be(seen):
    with pytest.raises(InputError, match="samples: must be 1, 2, 4 or 8, found 3"):
        raytrace.view("spheres", samples=3)
    with pytest.raises(InputError, match="size"):
        raytrace.view("spheres", (0, 10))


def test_scenes_and_certificates_show_themselves(tmp_path):
    shown = raytrace.load_scene("sphere")._repr_png_()
    (tmp_path / "a.png").write_bytes(shown)
    assert raytrace.read_image(tmp_path / "a.png").shape == (270, 480, 3)
    certificate = raytrace.certify("sphere", (8, 8))
    assert "<th>8 bit values proven</th><td>" in certificate._repr_html_()
    assert "median width" in str(certificate)
