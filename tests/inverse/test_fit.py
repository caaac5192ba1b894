"""The sun from a picture: right within what is reported, or called undetermined or not explained."""

import json
from dataclasses import replace

import numpy as np
import pytest

import raytrace
from raytrace.errors import InputError
from raytrace.inverse.fit import DoesNotFit, NotDetermined, fit_sun, fitted_scene
from raytrace.studies.trials import Trial, summary, trials
from tests.inverse.worlds import SIZE, drawn, noisy, off, under, world
from tests.processes import command
from tests.scenes import some

SCENE = under(world(), -70.0, 35.0)


@pytest.fixture(scope="module", autouse=True)
def small_chunks():
    """A chunk is one of these pictures: most of a larger one would be computed for nothing. The command has its own."""
    with pytest.MonkeyPatch.context() as patch:
        for module in ("relit", "descent", "likelihood"):
            patch.setattr(f"raytrace.inverse.{module}.CHUNK", SIZE[0] * SIZE[1])
        yield


@pytest.fixture(scope="module")
def image():
    return drawn(SCENE)


@pytest.mark.parametrize("levels", some([0, 0.4, 5], 0, 5))
def test_the_sun_is_in_the_region_whatever_the_noise(image, levels):
    fit = fit_sun(noisy(image, levels), SCENE)
    assert off(fit, SCENE) <= 1.5 * fit.within_95
    assert 0 < fit.within_68 < fit.within_95 < 0.3
    assert fit.sampling == 1
    assert fit.noise == pytest.approx(levels / 255, rel=0.1, abs=1e-3)


def test_more_noise_makes_it_less_certain(image):
    few, many = (fit_sun(noisy(image, levels), SCENE).within_68 for levels in (2, 10))
    assert many > few


@pytest.mark.parametrize("elevation", [-25.0, 3.0, 88.0])
def test_the_whole_sphere_is_searched(elevation):
    scene = under(SCENE, 130.0, elevation)
    fit = fit_sun(noisy(drawn(scene), 1), scene)
    assert off(fit, scene) <= 1.5 * fit.within_95 < 10


def without_spheres(*changes):
    """The same program as all others here: the spheres are behind the camera, and so are their shadows."""
    scene = world(*changes)
    return replace(scene, spheres=replace(scene.spheres, center=scene.spheres.center + np.array([0, 0, 1e6])))


def sky(azimuth, elevation, target="[0,1.9,0]"):
    """Only sky, or sky above a plain dark ground, and a camera that looks to azimuth 0."""
    dark = 'planes[0].pattern={type="checkerboard",tile_size=0.5,even=[0,0,0],odd=[0,0,0],line=[0,0,0]}'
    return under(without_spheres(f"camera.target={target}", dark), azimuth, elevation)


@pytest.mark.parametrize(("azimuth", "elevation"), [(10.0, 20.0), (5.0, -1.0)])
def test_in_the_sky_the_lobe_shows_the_sun(azimuth, elevation):
    scene = sky(azimuth, elevation, "[0,0.85,0]")
    fit = fit_sun(noisy(drawn(scene), 1), scene)
    assert off(fit, scene) <= 1.5 * fit.within_95 < 2


@pytest.mark.parametrize(("azimuth", "elevation"), [(150.0, 40.0), (0.0, -60.0)])
def test_a_sun_out_of_view_is_called_undetermined(azimuth, elevation):
    scene = sky(azimuth, elevation)
    for image in (noisy(drawn(scene), 2), drawn(scene)):
        with pytest.raises(NotDetermined, match="does not determine the sun"):
            fit_sun(image, scene)


def test_a_plain_ground_without_shadows_leaves_the_azimuth_open():
    scene = under(without_spheres("camera.position=[0,2,0]", "camera.target=[0.1,0,0]"), 30.0, 50.0)
    with pytest.raises(NotDetermined):
        fit_sun(noisy(drawn(scene), 1), scene)


@pytest.mark.full
def test_where_nothing_depends_on_the_sun():
    """From inside an unlit sphere neither the sky nor a shadow is seen."""
    scene = replace(
        SCENE, lighting="off", spheres=raytrace.Spheres([SCENE.camera.position] * 3, [9.0] * 3, [[0.5] * 3] * 3)
    )
    with pytest.raises(NotDetermined):
        fit_sun(drawn(scene), scene)


def blurred(image):
    padded = np.pad(image, ((1, 1), (1, 1), (0, 0)), "edge")
    rows = (padded[:-2] + 2 * padded[1:-1] + padded[2:]) / 4
    return (rows[:, :-2] + 2 * rows[:, 1:-1] + rows[:, 2:]) / 4


MISFITS = {
    "exposure": (lambda: drawn(under(world("film.exposure=1"), -70.0, 35.0)), ("--exposure",)),
    "transfer": (lambda: drawn(under(world("film.transfer=srgb"), -70.0, 35.0)), ("--set film.transfer=srgb",)),
    "blurred": (lambda: blurred(drawn(SCENE)), ()),
    "cropped": (lambda: drawn(SCENE)[:, 12:], ()),
    "another camera": (lambda: drawn(under(world("camera.position=[0.3,0.5,2]"), -70.0, 35.0)), ()),
    "noise alone": (lambda: np.random.default_rng(0).random((*SIZE[::-1], 3)), ()),
}


@pytest.mark.parametrize(
    ("misfit", "levels"),
    some([("exposure", 2), *zip(MISFITS, [0, 0, 2, 2, 0, 2], strict=True)], ("exposure", 2)),
)
def test_what_the_scene_does_not_explain_is_said(misfit, levels):
    change, proposals = MISFITS[misfit]
    with pytest.raises(DoesNotFit, match="does not explain the picture") as error:
        fit_sun(noisy(change(), levels), SCENE, samples=1, starts=1)
    assert error.value.proposals == proposals
    assert all(flag in str(error.value) for flag in proposals)


def test_samples_on_edges_count_for_nothing():
    """At an odd height a level camera puts whole rows of samples on edges, where any engine's last bit decides."""
    scene, size = under(world("camera.target=[0,0.5,0]"), -70.0, 35.0), (65, 37)
    fits = [fit_sun(noisy(drawn(scene, size, dtype=dtype), 0), scene) for dtype in ("float32", "float64")]
    assert all(off(fit, scene) <= 1.5 * fit.within_95 for fit in fits)


@pytest.mark.full
def test_the_exposure_is_found_as_well():
    scene = under(world("film.exposure=0.7"), -70.0, 35.0)
    fit = fit_sun(noisy(drawn(scene), 2), world(), exposure=True)
    assert fit.exposure == pytest.approx(0.7, abs=0.02)
    assert off(fit, scene) <= 1.5 * fit.within_95
    assert fitted_scene(scene, fit).film.exposure == fit.exposure


def test_every_kind_of_array_gives_the_same_sun(image):
    eight = noisy(image, 0)
    kinds = eight, eight / 255, eight.astype(np.float32) / np.float32(255), eight.astype(float), eight.astype(int)
    found = [fit_sun(array, SCENE) for array in kinds]
    for other in found[1:]:
        np.testing.assert_allclose(other.direction, found[0].direction, rtol=0, atol=1e-6)
    sixteen = fit_sun(np.round(65535 * image).astype(np.uint16), SCENE)
    assert off(sixteen, SCENE) <= 1.5 * sixteen.within_95 < found[0].within_95 * 3


def test_files_say_what_they_hold():
    """Linear light, steps, and the scene: nothing of it has to be told."""
    steps = raytrace.render(SCENE, SIZE, backend="numpy", output="steps")
    metadata = {"scene": raytrace.scene.toml.scene_toml(SCENE), "samples": "1", "antialias": "none"}
    raytrace.write_image("linear.exr", steps["linear"], output="linear", metadata=metadata)
    raytrace.write_image("plain.exr", steps["linear"], output="linear")
    raytrace.write_image("steps.exr", steps, metadata=metadata)
    for name, scene in (("linear.exr", None), ("plain.exr", SCENE), ("steps.exr", None)):
        fit = fit_sun(name, scene)
        assert off(fit, SCENE) <= 1.5 * fit.within_95 < 0.1


def test_the_command(image):
    """Writes the scene and the plot."""
    raytrace.save_scene(SCENE, "scene.toml")
    raytrace.write_image("a.png", noisy(image, 1) / 255)
    done = command("fit-sun", "a.png", "--scene", "scene.toml", "--json", "-o", "found.toml", "--plot", "way.png")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["within_68"] < found["within_95"]
    np.testing.assert_allclose(raytrace.load_scene("found.toml").sun.direction, found["direction"])
    assert raytrace.read_image("way.png").shape[2] in (3, 4)


@pytest.mark.full
def test_a_sun_that_is_not_determined_is_one_line():
    scene = sky(150.0, 40.0)
    raytrace.save_scene(scene, "sky.toml")
    raytrace.write_image("sky.png", drawn(scene))
    done = command("fit-sun", "sky.png", "--scene", "sky.toml", "-o", "none.toml")
    assert done.returncode == 1
    assert done.stderr.startswith("raytrace: sky.png: the picture does not determine the sun")
    assert done.stderr.count("\n") == 1
    assert not done.stdout


def test_trials_are_told():
    found = [Trial(30.0, 0.01, 0.02, 0.04, 20.0), Trial(50.0, 0.03, 0.02, 0.04, 7.0), Trial(70.0, 0.5, 0.02, 0.04, 8.0)]
    text = summary([*found, Trial(2.0, np.nan, np.nan, np.nan, 1.0)])
    assert "4 suns, of which 1 are called undetermined or not explained" in text
    assert "of 3: 33.3 % in the 68 % region, 66.7 % in the 95 % region" in text
    assert "first, with compiling, 20.0" in text


def test_a_seed_makes_the_trials():
    one, again = (next(trials(world(), 1, SIZE, 1, seed)) for seed in (1, 1))
    assert one[:-1] == again[:-1]


@pytest.mark.full
def test_the_regions_hold_as_many_suns_as_they_say():
    found = list(trials(world(), 40, SIZE, 1, seed=3))
    errors, of_68, of_95 = np.array([trial[1:4] for trial in found]).T
    # Three standard deviations of the binomial distribution.
    assert 0.46 <= np.mean(errors <= of_68) <= 0.90
    assert np.mean(errors <= of_95) >= 0.85


@pytest.mark.full
@pytest.mark.parametrize("levels", [0, 1, 4])
@pytest.mark.parametrize("choices", [{"samples": 2}, {"samples": 4}, {"antialias": "edges"}], ids=str)
def test_how_pixels_were_made_is_found(choices, levels):
    fit = fit_sun(noisy(drawn(SCENE, **choices), levels), SCENE)
    assert fit.sampling == next(iter(choices.values()))
    assert off(fit, SCENE) <= 1.5 * fit.within_95


@pytest.mark.full
def test_other_pictures_are_explained_by_no_sampling():
    with pytest.raises(DoesNotFit):
        fit_sun(noisy(MISFITS["another camera"][0](), 1), SCENE)


@pytest.mark.full
def test_what_explains_it_is_proposed_whatever_the_sampling():
    bright = drawn(under(world("film.exposure=1"), -70.0, 35.0), samples=4)
    with pytest.raises(DoesNotFit) as error:
        fit_sun(noisy(bright, 1), SCENE)
    assert error.value.proposals == ("--exposure",)


def test_what_is_no_picture_is_refused():
    with pytest.raises(InputError, match="must have 16 x 16 pixels at least"):
        fit_sun(np.zeros((8, 8, 3)), SCENE)
    with pytest.raises(InputError, match="an image is an array"):
        fit_sun(np.zeros((20, 20)), SCENE)
    with pytest.raises(InputError, match="not finite"):
        fit_sun(np.full((20, 20, 3), np.nan), SCENE)
    with pytest.raises(InputError, match="display values lie from 0 to 1"):
        fit_sun(np.full((20, 20, 3), 1.5), SCENE)
    with pytest.raises(InputError, match="integers must be uint8"):
        fit_sun(np.full((20, 20, 3), 1000), SCENE)
    with pytest.raises(InputError, match="starts: must be a whole number from 1"):
        fit_sun(np.zeros((20, 20, 3)), SCENE, starts=0)
    with pytest.raises(InputError, match="samples: must be a whole number"):
        fit_sun(np.zeros((20, 20, 3)), SCENE, samples=0)
    with pytest.raises(InputError, match="antialias: unknown 'edge'"):
        fit_sun(np.zeros((20, 20, 3)), SCENE, antialias="edge")
