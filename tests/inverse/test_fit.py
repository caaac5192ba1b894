"""The sun from a picture."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import raytrace
from raytrace.errors import InputError
from raytrace.inverse.shrunk import coarse, shrunk
from raytrace.inverse.trials import Trial, told
from tests.processes import command

pytestmark = pytest.mark.unchecked

SIZE = (96, 54)


def picture(direction, size=SIZE, noise=2 / 255, **choices):
    """Of a lit sphere under another sun: 8 bits, and noisy."""
    scene = raytrace.load_scene("lit-sphere")
    scene = replace(scene, sun=replace(scene.sun, direction=direction))
    image = np.asarray(raytrace.render(scene, size, **choices), np.float64)
    image = image + np.random.default_rng(7).normal(0, noise, image.shape)
    return np.round(np.clip(image, 0, 1) * 255).astype(np.uint8)


def degrees_between(a, b):
    return np.degrees(np.arccos(min(1.0, float(a @ b))))


@pytest.mark.full
@pytest.mark.parametrize("choices", [{}, {"samples": 4}], ids=["one sample", "16 samples"])
def test_it_finds_the_sun(choices):
    direction = raytrace.sun_direction(-70.0, 35.0)
    fit = raytrace.fit_sun(picture(direction, **choices), "lit-sphere", starts=2)
    assert degrees_between(fit.direction, direction) < 0.1
    assert degrees_between(fit.direction, raytrace.sun_direction(fit.azimuth, fit.elevation)) < 1e-4
    assert 2 / 255 * 0.5 < fit.residual < 2 / 255 * 2
    assert 0 < fit.uncertainty < 0.1
    assert len(fit.history) == 2
    assert fit.history[0].loss[-1] < fit.history[0].loss[0]
    assert fit.history[0].loss[-1] <= fit.history[1].loss[-1]


@pytest.mark.full
def test_the_command(tmp_path):
    """Of a file, and with the exposure; the scene it writes is the scene of the picture."""
    direction = raytrace.sun_direction(120.0, 50.0)
    scene = raytrace.load_scene("lit-sphere", ["film.exposure=0.5"])
    scene = replace(scene, sun=replace(scene.sun, direction=direction))
    raytrace.write_image(tmp_path / "a.png", raytrace.render(scene, SIZE))
    done = command(
        "fit-sun", "a.png", "--scene", "lit-sphere", "--exposure", "--starts", "2", "--json",
        "-o", "found.toml", "--plot", "way.png",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert degrees_between(np.array(told["direction"]), direction) < 0.1
    assert told["exposure"] == pytest.approx(0.5, abs=0.02)
    found = raytrace.load_scene(tmp_path / "found.toml")
    np.testing.assert_allclose(found.sun.direction, told["direction"])
    assert float(found.film.exposure) == told["exposure"]
    assert raytrace.read_image(tmp_path / "way.png").shape[2] in (3, 4)


def test_trials_are_told():
    text = told([Trial(30.0, 0.01, 0.005, 20.0), Trial(50.0, 0.03, 0.005, 7.0), Trial(70.0, 0.5, 0.005, 8.0)])
    assert "3 suns: 67 % within 0.1 degrees, median 0.0300, worst 0.5000" in text
    assert "first, with compiling, 20.0" in text


def test_what_is_no_picture_is_refused():
    with pytest.raises(InputError, match="image: must be an array"):
        raytrace.fit_sun(np.zeros((8, 8, 3)), "lit-sphere")
    with pytest.raises(InputError, match="image: has values that are no numbers"):
        raytrace.fit_sun(np.full((20, 20, 3), np.nan), "lit-sphere")
    with pytest.raises(InputError, match="starts: must be a whole number from 1"):
        raytrace.fit_sun(np.zeros((20, 20, 3)), "lit-sphere", starts=0)


def test_where_nothing_depends_on_the_sun():
    """From inside an unlit sphere neither the sky nor a shadow is seen."""
    scene = raytrace.load_scene("sphere")
    spheres = raytrace.Spheres([scene.camera.position], [1.0], [[0.5, 0.5, 0.5]])
    with pytest.raises(InputError, match="nothing that is seen of it depends on the sun"):
        raytrace.fit_sun(np.zeros((20, 20, 3)), replace(scene, spheres=spheres))


@pytest.mark.parametrize("size", [(16, 16), (50, 31), (97, 54)])
def test_a_coarser_image_has_the_means(size):
    image = np.random.default_rng(0).random((54, 97, 3))
    small = shrunk(image, size)
    assert small.shape == (size[1], size[0], 3)
    np.testing.assert_allclose(small.mean((0, 1)), image.mean((0, 1)))
    assert small.min() >= image.min()
    assert small.max() <= image.max()


def test_a_coarser_image_of_twice_the_width():
    image = np.random.default_rng(0).random((4, 6, 3))
    np.testing.assert_allclose(shrunk(image, (3, 2)), image.reshape(2, 2, 3, 2, 3).mean((1, 3)))
    assert coarse((1920, 1080), 192 * 108) == (192, 108)
    assert coarse((64, 36), 192 * 108) == (64, 36)


def test_the_next_process_has_the_program_whatever_its_devices(tmp_path):
    """The program is kept; it runs on one device where there are several, and the slopes are the same."""
    code = (
        "import sys, jax\n"
        "jax.config.update('jax_num_cpu_devices', int(sys.argv[1]))\n"
        "import numpy as np, raytrace\n"
        "from raytrace.inverse.slopes import sun_slopes\n"
        "np.save(sys.argv[2], sun_slopes(raytrace.load_scene('sphere'), (16, 16), np.eye(3)[:2])[1])\n"
    )
    env = os.environ | {"RAYTRACE_CACHE": str(tmp_path / "kept")}
    found = []
    for devices in ("2", "1", "2"):
        path = str(tmp_path / "slopes.npy")
        subprocess.run([sys.executable, "-c", code, devices, path], check=True, env=env, timeout=200)
        found.append(np.load(path))
    assert len(list((tmp_path / "kept").glob("*.program"))) == 1
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])
