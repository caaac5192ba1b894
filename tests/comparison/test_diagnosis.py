"""Mistakes are planted by hand here, without the code that seeks them."""

import dataclasses
from functools import lru_cache

import numpy as np
import pytest

import raytrace
from raytrace.comparison.diagnosis import diagnosis
from raytrace.comparison.metrics import pixels_over
from raytrace.comparison.reference import Reference
from raytrace.rendering import Options, Rendering
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.camera import pixel_to_ndc
from raytrace.shader.main import main

SIZE = 160, 90
SCENE = "checkerboard"


def rendered(*changes, scene=SCENE, size=SIZE, output="display", dtype="float64"):
    return raytrace.render(
        raytrace.load_scene(scene, changes), size, backend="numpy", dtype=dtype, output=output, samples=1
    )


@pytest.fixture(scope="module")
def display():
    return rendered()


@pytest.fixture(scope="module")
def linear():
    return rendered(output="linear")


def quantized(image):
    """What a file of 8 bits keeps."""
    return np.rint(np.clip(image, 0, 1) * 255) / 255


@lru_cache
def reference(name, width, height):
    """Rendered once for all tests."""
    return Reference(raytrace.load_scene(name), width, height)


def said(a, b, scene=SCENE):
    height, width, _ = a.shape
    if isinstance(scene, raytrace.Scene):
        known = Reference(scene, width, height)
    else:
        known = None if scene is None else reference(scene, width, height)
    found = diagnosis(a, b, known)
    return None if found is None else found.mistake


def columns_and_rows(camera, size, across=0.0, along=0.0, by=(1.0, 1.0)):
    """The camera as matrices, its pixels moved by so many columns and rows, and farther apart by these factors."""
    uniforms = uniforms_of(raytrace.Scene(camera=camera), size[0] / size[1]).camera
    ndc_to_view, view_to_world = (np.array(matrix).T for matrix in uniforms)
    moved = np.array(
        [[by[0], 0, 0, 2 * across / size[0]], [0, by[1], 0, -2 * along / size[1]], [0, 0, 1, 0], [0, 0, 0, 1]]
    )
    return raytrace.MatrixCamera(ndc_to_view @ moved, view_to_world)


def through(camera, size=SIZE):
    scene = dataclasses.replace(raytrace.load_scene(SCENE), camera=camera)
    return raytrace.render(scene, size, backend="numpy", dtype="float64")


def aces(x):
    return np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1)


FILMS = {
    "without gamma (the transfer function is missing)": lambda x: aces(x),
    "with the transfer function twice (gamma twice)": lambda x: aces(x) ** (1 / 2.2**2),
    "without the tone mapper": lambda x: np.clip(x, 0, 1) ** (1 / 2.2),
    "linear light, not developed (linear for display)": lambda x: x,
    "exposed 0.5 times as much (-1.00 stops)": lambda x: aces(x / 2) ** (1 / 2.2),
    "exposed 2 times as much (+1.00 stops)": lambda x: aces(x * 2) ** (1 / 2.2),
    "with the tone mapper reinhard for aces": lambda x: (x / (1 + x)) ** (1 / 2.2),
    "developed twice (display for linear)": lambda x: aces(aces(x) ** (1 / 2.2)) ** (1 / 2.2),
}


@pytest.mark.parametrize(("scene", "depth"), [(SCENE, quantized), (None, np.asarray)])
@pytest.mark.parametrize("mistake", FILMS)
def test_films(display, linear, mistake, depth, scene):
    assert said(depth(display), depth(FILMS[mistake](linear)), scene) == mistake


@pytest.mark.parametrize("scene", [SCENE, None])
def test_srgb_for_the_power_and_the_power_for_srgb(display, scene):
    srgb = rendered("film.transfer=srgb")
    assert said(quantized(display), quantized(srgb), scene) == "with the transfer function srgb for gamma2.2"
    if scene is not None:
        scene = raytrace.load_scene(scene, ["film.transfer=srgb"])
        assert said(quantized(srgb), quantized(display), scene) == "with the transfer function gamma2.2 for srgb"


def test_mistakes_of_a_film_with_exposure_and_white_balance():
    changes = ["film.exposure=-0.5", "film.white_point=4500", "film.tone_mapper=hable"]
    scene = raytrace.load_scene(SCENE, changes)
    a = rendered(*changes)
    for change, mistake in {
        "film.tone_mapper=none": "without the tone mapper",
        "film.transfer=none": "without gamma (the transfer function is missing)",
        "film.exposure=0.5": "exposed 2 times as much (+1.00 stops)",
    }.items():
        assert said(a, rendered(*changes, change), scene) == mistake


@pytest.mark.parametrize(
    ("mistake", "plant"),
    [
        ("flipped top to bottom (y)", lambda a: a[::-1]),
        ("flipped left to right (x)", lambda a: a[:, ::-1]),
        ("turned by 180 degrees (flipped in x and y)", lambda a: a[::-1, ::-1]),
        ("shifted by one pixel right", lambda a: a[:, [0, *range(159)]]),
        ("shifted by one pixel left", lambda a: a[:, [*range(1, 160), 159]]),
        ("shifted by one pixel down", lambda a: a[[0, *range(89)]]),
        ("shifted by one pixel up", lambda a: a[[*range(1, 90), 89]]),
        ("shifted by one pixel right and down", lambda a: a[[0, *range(89)]][:, [0, *range(159)]]),
        ("swapped in its channels (BGR for RGB)", lambda a: a[..., ::-1]),
        ("swapped in its channels (GBR for RGB)", lambda a: a[..., [1, 2, 0]]),
    ],
)
def test_flips_shifts_and_channels(display, mistake, plant):
    assert said(quantized(display), quantized(plant(display)), scene=None) == mistake


@pytest.mark.parametrize(
    ("mistake", "across", "along"),
    [
        ("shifted by half a pixel right", -0.5, 0),
        ("shifted by half a pixel left", 0.5, 0),
        ("shifted by half a pixel down", 0, -0.5),
        ("shifted by half a pixel up", 0, 0.5),
        ("shifted by half a pixel right and down", -0.5, -0.5),
    ],
)
def test_half_a_pixel(display, mistake, across, along):
    """With the scene; without it no mistake is named, and no wrong one."""
    wrong = through(columns_and_rows(raytrace.PerspectiveCamera(), SIZE, across, along))
    assert said(quantized(display), quantized(wrong)) == mistake
    assert said(display, wrong, scene=None) in (None, mistake)


@pytest.mark.parametrize(
    ("scene", "size"), [(SCENE, SIZE), (SCENE, (640, 360)), ("sphere", SIZE), ("skybox", SIZE), ("spheres", (161, 91))]
)
def test_pixel_corners_for_centres(scene, size):
    """u = i / width, v = 1 - j / height: where the height is even, a row of pixels then looks along the horizon."""
    a, b = rendered(scene=scene, size=size), corners(scene, size)
    assert said(quantized(a), quantized(b), scene) == "shifted by half a pixel right and down"


def corners(name, size):
    scene = raytrace.load_scene(name)
    uniforms = uniforms_of(scene, size[0] / size[1])
    u, v = np.arange(size[0]) / size[0], 1 - np.arange(size[1]) / size[1]
    ndc = pixel_to_ndc(*np.meshgrid(u, v))
    with np.errstate(all="ignore"):
        return np.stack(main(uniforms, program_of(scene, "textbook"), ndc, ("display",)).display, axis=-1)


@pytest.mark.parametrize("size", [(160, 90), (90, 120)])
@pytest.mark.parametrize(
    ("mistake", "powers"),
    [
        ("drawn without the aspect ratio", (1, 0)),
        ("drawn with the aspect ratio upside down (height / width)", (2, 0)),
        ("drawn with the vertical field of view as the horizontal one", (1, 1)),
    ],
)
def test_aspect(mistake, powers, size):
    by = [(size[1] / size[0]) ** power for power in powers]
    a, b = rendered(size=size), through(columns_and_rows(raytrace.PerspectiveCamera(), size, by=by), size)
    assert said(quantized(a), quantized(b)) == mistake
    assert said(a, b, scene=None) in (None, mistake)


def test_the_aspect_is_told_without_a_scene(display):
    wrong = through(columns_and_rows(raytrace.PerspectiveCamera(), SIZE, by=(90 / 160, 1)))
    assert said(display, wrong, scene=None) == "drawn without the aspect ratio"


@pytest.mark.parametrize("scene", [SCENE, None])
@pytest.mark.parametrize(
    "other",
    [
        "spheres[1].center=[-0.45,0,-2]",
        "spheres[1].color=[0.3,0.3,0.8]",
        "sun.direction=[1,0.75,0.5]",
        "planes[0].pattern.tile_size=0.25",
        "lighting='on'",
    ],
)
def test_other_faults_are_none_of_them(display, other, scene):
    assert said(display, rendered(other), scene) is None


@pytest.mark.parametrize("scene", [SCENE, "spheres", "sphere", None])
def test_an_engines_own_pixels_are_no_mistake(scene):
    """Float32 against float64; then with pixels on edges that show their neighbour, as another engine's may."""
    name = scene or SCENE
    a, b = rendered(scene=name), rendered(scene=name, dtype="float32")
    assert said(a, b, scene) is None
    contrast = np.abs(np.diff(a, axis=1)).max(axis=-1)
    for count in (1, 3, 20):
        wrong = b.copy()
        for pixel in np.argsort(contrast, axis=None)[-count:]:
            y, x = np.unravel_index(pixel, contrast.shape)
            wrong[y, x] = a[y, x + 1]
        assert pixels_over(a, wrong).sum() >= count
        assert said(a, wrong, scene) is None


def test_equal_images_and_noise_under_a_level_are_not_searched(display):
    noise = np.random.default_rng(0).uniform(-1, 1, display.shape) / 256
    for b in (display, display + noise):
        found = raytrace.compare(display, b, scene=SCENE)
        assert (found.searched, found.diagnosis, found.regions) == (False, None, ())


def test_random_images_have_no_mistake_in_common():
    a, b = np.random.default_rng(0).uniform(0, 1, (2, 32, 40, 3))
    assert said(a, b, None) is None


def test_how_well_it_explains(display):
    found = raytrace.compare(display, display[::-1], scene=SCENE)
    assert found.diagnosis.explained == 1
    assert found.diagnosis.rmse == (found.rmse, 0)
    assert found.diagnosis.over == (found.over, 0)


def test_a_reference_that_is_not_the_scenes_image_is_taken_as_it_is():
    """A of another scene: the scene's own picture is not taken for it."""
    a = rendered(scene="shadows")
    assert said(a, a[:, ::-1], SCENE) == "flipped left to right (x)"
    assert said(a, rendered(), SCENE) is None


def test_the_scene_of_the_file_is_used(display):
    rendering = Rendering(Options(SCENE, SIZE, backend="numpy", dtype="float64"))
    raytrace.write_image("a.png", display, metadata=rendering.metadata())
    wrong = through(columns_and_rows(raytrace.PerspectiveCamera(), SIZE, -0.5, -0.5))
    raytrace.write_image("b.png", wrong)
    found = raytrace.compare("a.png", "b.png")
    assert found.diagnosis.mistake == "shifted by half a pixel right and down"
    assert found.regions
