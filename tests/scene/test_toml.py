import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

import raytrace
from raytrace.errors import InputError
from raytrace.scene import scene_hash, scene_toml
from raytrace.scene.toml import figures, scene_from_toml
from tests.strategies import scenes

BUILT_IN = list(raytrace.scenes())


def test_there_is_a_scene_for_every_figure():
    assert figures() == ["skybox-linear", "skybox", "sphere", "lit-sphere", "spheres", "shadows", "checkerboard"]
    for number, name in enumerate(figures(), 1):
        assert raytrace.scenes()[name].startswith(f"Figure {number}: ")
    assert BUILT_IN[:7] == figures()


@pytest.mark.parametrize("name", figures())
def test_the_figures_have_the_assignments_values(name):
    scene = raytrace.load_scene(name)
    assert scene.sun == raytrace.Sun(direction=[1, 0.75, 1], color=[1.64, 1.27, 0.99])
    assert scene.sky == raytrace.Sky(low=[0.36, 0.45, 0.57], high=[0.14, 0.21, 0.49], void=[0.025, 0.05, 0.075])
    camera = scene.camera
    assert (camera.field_of_view, camera.near, camera.far) == (60, 0.1, 100)
    centred = name in ("sphere", "lit-sphere")
    assert camera.position.tolist() == ([0, 0, 4] if centred else [0, 0.5, 2])
    if name != "skybox":
        assert camera.target.tolist() == ([0, 0, 0] if centred else [0, 0.5, 0])
    lighting = {"sphere": "off", "lit-sphere": "on", "spheres": "on"}
    assert scene.lighting == lighting.get(name, "shadow")


def test_the_skybox_looks_towards_the_sun_above_a_horizon():
    steps = raytrace.render("skybox", (192, 108), backend="numpy", dtype="float64", output="steps")
    sun = np.array([1, 0.75, 1]) / np.linalg.norm([1, 0.75, 1])
    assert (steps["rd"] @ sun).max() > math.cos(math.radians(0.5))
    below = steps["rd"][..., 1] < 0
    assert 0.05 < below.mean() < 0.5


@pytest.mark.parametrize("name", BUILT_IN)
def test_round_trip_of_the_built_in_scenes(name):
    scene = raytrace.load_scene(name)
    raytrace.save_scene(scene, "saved.toml")
    assert raytrace.load_scene("saved.toml") == scene


@given(scenes())
def test_round_trip_of_any_scene(scene):
    raytrace.save_scene(scene, "saved.toml")
    again = raytrace.load_scene("saved.toml")
    assert again == scene
    assert scene_toml(again) == scene_toml(scene)


def test_round_trip_of_matrices():
    camera = raytrace.MatrixCamera(
        ndc_to_view=[[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, -1], [0, 0, -5, 5]],
        view_to_world=[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9], [0, 0, 0, 1]],
    )
    scene = raytrace.Scene(camera=camera)
    raytrace.save_scene(scene, "saved.toml")
    assert raytrace.load_scene("saved.toml") == scene


def test_another_value_is_another_hash():
    scene = raytrace.load_scene("checkerboard")
    same = raytrace.load_scene("checkerboard")
    other = raytrace.load_scene("checkerboard", ["spheres[5].color[2]=0.8000000001"])
    assert scene_hash(scene) == scene_hash(same) != scene_hash(other)
    assert scene != other


def test_lists_of_numbers_are_written_in_a_line():
    assert "direction = [1.0, 0.75, 1.0]" in scene_toml(raytrace.load_scene("checkerboard"))


def refused(scene, *changes):
    with pytest.raises(raytrace.InputError) as error:
        raytrace.load_scene(scene, changes)
    message = str(error.value)
    assert "\n" not in message
    return message


def test_files_that_cannot_be_read():
    assert refused("nowhere.toml") == "nowhere.toml: no such file"
    assert "did you mean 'checkerboard'?" in refused("chekerboard")
    Path("folder.toml").mkdir()
    assert refused("folder.toml") == "folder.toml: cannot be read: is not a regular file"
    Path("latin.toml").write_bytes(b"# caf\xe9")
    assert "not a text in UTF-8" in refused("latin.toml")


def test_toml_errors_name_the_line():
    Path("broken.toml").write_text("[sun]\ndirection = [1, 2,\ncolor = 3\n")
    assert refused("broken.toml").startswith("broken.toml: not TOML: ")
    assert "line 3" in refused("broken.toml")


def test_errors_name_file_path_found_and_allowed():
    Path("bad.toml").write_text("[[spheres]]\ncenter = [0, 0, 0]\nradius = -2\ncolor = [1, 1, 1]\n")
    assert refused("bad.toml") == "bad.toml: spheres[0].radius: must be greater than 0, found -2"


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("spheres[3].radius=0", "spheres[3].radius: must be greater than 0, found 0"),
        ("spheres[3].radius=1e-13", "spheres[3].radius: must be at least 1e-12"),
        ("spheres[3].center[0]=1e13", "spheres[3].center[0]: must be at most 1e+12 in size"),
        ("spheres[3].radius=true", "spheres[3].radius: must be a valid number, found True"),
        ("spheres[3].radus=1", "spheres[3].radus: unknown key; did you mean 'radius'? allowed: center, radius, color"),
        ("spheres[0].center=[1,2]", "spheres[0].center: must be a list of 3 numbers, found [1, 2]"),
        ("spheres[0].center=[1,2,inf]", "spheres[0].center[2]: must be a finite number, found inf"),
        ("spheres[0].center[1]=nan", "spheres[0].center[1]: must be a finite number, found nan"),
        ("spheres[0]=3", "spheres[0]: must be a table, found 3"),
        ("spheres=3", "spheres: must be a valid list, found 3"),
        ("sun=3", "sun: must be a table, found 3"),
        ("sun.direction=[0,0,0]", "sun.direction: must not be the zero vector"),
        ("sun.direction=up", "sun.direction: must be a list of 3 numbers, found 'up'"),
        ("sun.direction=[1e39,0,0]", "sun.direction[0]: must be at most 3.4e+38 in size"),
        ("sun.color=[1,-1,0]", "sun.color[1]: must not be negative, found -1"),
        ("sky.hi=[1,1,1]", "sky.hi: unknown key; did you mean 'high'?"),
        ("sun.azimut=3", "sun.azimut: unknown key; did you mean 'azimuth'?"),
        ("sun.azimuth=x", "sun.azimuth: must be a finite number of degrees, found 'x'"),
        ("sun.elevation=95", "sun.elevation: must be from -90 to 90 degrees, found 95"),
        ("camera.fov=500", "camera.field_of_view: must be greater than 0 and less than 180 degrees, found 500"),
        ("planes[0].normal=[0,0,0]", "planes[0].normal: must not be the zero vector"),
        ("planes[0].pattern.tile_size=-1", "planes[0].pattern.tile_size: must be greater than 0"),
        ("planes[0].pattern.type=stripes", "planes[0].pattern.type: unknown 'stripes'; there is: checkerboard, plain"),
        ("planes[0].casts_shadow=1", "planes[0].casts_shadow: must be a valid boolean, found 1"),
        ("camera.target=[0,0.5,2]", "camera: position and target must not be the same point"),
        ("camera.target=[0,9,2]", "camera: must not look along up"),
        ("camera.field_of_view=0", "camera.field_of_view: must be greater than 0 and less than 180 degrees, found 0"),
        ("camera.field_of_view=180", "camera.field_of_view: must be greater than 0 and less than 180 degrees"),
        ("camera.near=100", "camera: near must be less than far, found 100.0 and 100.0"),
        ("camera.near=0", "camera.near: must be greater than 0"),
        ("camera.projection=fish", "camera.projection: unknown 'fish'; there is: perspective, orthographic, matrices"),
        (
            'camera={projection="ortographic", height=3}',
            "camera.projection: unknown 'ortographic'; did you mean 'orthographic'?",
        ),
        ('planes[0].pattern="plain"', "planes[0].pattern: must be a table, found 'plain'"),
        ('camera={projection="matrices"}', "camera.ndc_to_view: missing"),
        ("film.tone_mapper=acse", "film.tone_mapper: must be 'aces', 'reinhard', 'hable' or 'none', found 'acse'"),
        ("film.transfer=gamma", "film.transfer: must be 'gamma2.2', 'srgb' or 'none'"),
        ("film.white_point=100", "film.white_point: must be a temperature from 1667 to 25000 kelvin"),
        ("film.exposure=1000", "film.exposure: must be at most 16 in size, found 1000"),
        ("sun.color=[1e7,0,0]", "sun.color[0]: must be at most 1e+06 in size"),
        ("camera.target=[0,0.5,1.9999999999999]", "camera: position and target must be at least 1e-12 apart"),
        ("lighting=dark", "lighting: must be 'off', 'on' or 'shadow', found 'dark'"),
        ("fog=1", "fog: unknown key; allowed: spheres, planes, sun, sky, lighting, camera, film"),
    ],
)
def test_mistakes(change, told):
    message = refused("checkerboard", change)
    assert message.startswith(f"checkerboard with {change}: ")
    assert told in message


@pytest.mark.parametrize(
    "change",
    [
        "sun",
        "=3",
        "sun..x=1",
        "spheres[9].radius=1",
        "lighting.on=1",
        "sun.direction[7]=1",
        "sun.direction=[0,1",
        "sun.color=1\nfilm=3",
    ],
)
def test_settings_that_lead_nowhere(change):
    with pytest.raises(raytrace.InputError) as error:
        raytrace.load_scene("checkerboard", [change])
    assert str(error.value).startswith(f"--set {change}: ")


def test_changes_are_made_in_order():
    scene = raytrace.load_scene(
        "checkerboard",
        ["film.tone_mapper=reinhard", "sun.direction=[0, 1, 0]", "sun.direction[0]=2", "film.white_point=[0.3, 0.3]"],
    )
    assert scene.film.tone_mapper == "reinhard"
    assert scene.sun.direction.tolist() == [2, 1, 0]
    assert scene.film.white_point == (0.3, 0.3)


def test_an_existing_file_survives_a_scene_that_cannot_be_saved():
    Path("kept.toml").write_text("# mine\n")
    bad = raytrace.Scene(sun=raytrace.Sun(direction=[0, 0, 0]))
    with pytest.raises(raytrace.InputError, match="zero vector"):
        raytrace.save_scene(bad, "kept.toml")
    with pytest.raises(raytrace.InputError, match="Python function"):
        raytrace.save_scene(raytrace.Scene(film=raytrace.Film(tone_mapper=abs)), "kept.toml")
    assert Path("kept.toml").read_text() == "# mine\n"
    assert [file.name for file in Path().iterdir()] == ["kept.toml"]


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 20_000,
        "a = " + "9" * 20_000,
        "a" + ".a" * 4_000 + " = 1",
        "a = " + "{a=" * 20_000,
        "[" + "a." * 4_000,
    ],
    ids=lambda text: text[:8],
)
def test_hostile_texts_are_one_line(text):
    Path("a.toml").write_text(text)
    told = refused("a.toml")
    assert told.startswith("a.toml")
    with pytest.raises(raytrace.InputError):
        raytrace.load_scene("sphere", [text.replace("a = ", "sun.color=", 1)])


def test_only_regular_files_are_read():
    import os

    os.mkfifo("pipe.toml")
    for name in ("pipe.toml", "/dev/zero", "."):
        with pytest.raises(raytrace.InputError, match="is not a regular file"):
            raytrace.load_scene(name)
    with pytest.raises(raytrace.InputError, match="no such"):
        raytrace.load_scene("a\0b.toml")


@pytest.mark.parametrize(
    ("text", "changes", "direction"),
    [
        ("sun = {azimuth = 90, elevation = 0}", [], [1, 0, 0]),
        ("sun = {azimuth = 90, elevation = 0}", ["sun.elevation=90"], [0, 1, 0]),
        ("sun = {azimuth = 90, elevation = 0}", ["sun.direction=[0,1,0]"], [0, 1, 0]),
        ("sun = {direction = [0, 0, -2]}", ["sun.azimuth=90"], [1, 0, 0]),
        ("", ["sun.azimuth=90", "sun.elevation=0"], [1, 0, 0]),
    ],
)
def test_the_sun_by_its_angles(text, changes, direction):
    scene = scene_from_toml(text, "a.toml", changes)
    np.testing.assert_allclose(scene.sun.direction, direction, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("sun = {azimuth = 90}", "sun.elevation: missing; azimuth and elevation go together"),
        ("sun = {azimuth = 1, elevation = 2, direction = [0, 1, 0]}", "sun.azimuth: goes in place of direction"),
        ("sun = {azimuth = true, elevation = 2}", "sun.azimuth: must be a finite number of degrees, found True"),
        ("sun = {azimuth = 1, elevation = nan}", "sun.elevation: must be a finite number of degrees, found nan"),
        ("camera = {fov = 3, field_of_view = 4}", "camera.fov: is another name of field_of_view, which is there, too"),
    ],
)
def test_what_is_said_twice_or_by_half(text, told):
    with pytest.raises(InputError, match=told.replace("(", r"\(")):
        scene_from_toml(text, "a.toml")


def test_the_field_of_view_has_a_short_name():
    assert scene_from_toml("camera = {fov = 30}", "a.toml").camera.field_of_view == 30
    assert scene_from_toml("camera = {field_of_view = 3}", "a.toml", ["camera.fov=31"]).camera.field_of_view == 31
