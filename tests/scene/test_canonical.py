"""The scenes beyond the figures: each is what its first comment says, in NumPy float64 at the golden images' size."""

from functools import cache
from itertools import combinations, pairwise

import numpy as np
import pytest
from skimage.metrics import structural_similarity

import raytrace
from raytrace.scene.toml import figures
from tests.scenes import some

CANONICAL = [name for name in raytrace.scenes() if name not in figures()]
SIZE = (480, 270)


def render(name, size=SIZE, dtype="float64", **options):
    return raytrace.render(name, size, backend="numpy", dtype=dtype, **options)


@cache
def scene_of(name):
    return raytrace.load_scene(name)


@cache
def steps_of(name):
    return render(name, output="steps")


def similarity(a, b):
    return structural_similarity(
        a, b, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=2
    )


def dot(a, b):
    return np.sum(a * b, axis=-1)


def sun_of(name):
    direction = scene_of(name).sun.direction
    return direction / np.linalg.norm(direction)


def depths(name, number):
    """t1 and t2, by the textbook, of the sphere of that number for every ray of a perspective camera."""
    spheres, ro = scene_of(name).spheres, scene_of(name).camera.position - scene_of(name).spheres.center[number]
    b = dot(ro, steps_of(name)["rd"])
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - (dot(ro, ro) - spheres.radius[number] ** 2))
    return -b - root, -b + root


def test_there_are_twelve_and_more_each_with_its_reason():
    assert len(CANONICAL) >= 12
    reasons = [raytrace.scenes()[name] for name in CANONICAL]
    assert len(set(reasons)) == len(reasons)
    for reason in reasons:
        assert reason.endswith(".")
        assert 40 < len(reason) <= 118


def test_together_they_take_every_choice():
    scenes = [scene_of(name) for name in CANONICAL]
    planes = [plane for scene in scenes for plane in scene.planes]
    assert {scene.lighting for scene in scenes} == {"off", "on", "shadow"}
    assert {scene.film.tone_mapper for scene in scenes} == {"aces", "reinhard", "hable", "none"}
    assert {scene.film.transfer for scene in scenes} == {"gamma2.2", "srgb", "none"}
    assert {type(scene.film.white_point) for scene in scenes} == {type(None), float, tuple}
    assert any(scene.film.exposure for scene in scenes)
    assert {type(scene.camera).__name__ for scene in scenes} == {
        "PerspectiveCamera",
        "OrthographicCamera",
        "MatrixCamera",
    }
    assert {type(plane.pattern).__name__ for plane in planes} == {"Plain", "Checkerboard"}
    assert {plane.casts_shadow for plane in planes} == {False, True}
    assert {len(scene.planes) for scene in scenes} == {0, 1, 2}
    tiles = {float(plane.pattern.tile_size) for plane in planes if isinstance(plane.pattern, raytrace.Checkerboard)}
    assert len(tiles) >= 6


def test_no_picture_is_like_another():
    """In a third of the size, for speed."""
    pictures = {name: render(name, (160, 90)) for name in raytrace.scenes()}
    for a, b in combinations(pictures, 2):
        if a not in figures() or b not in figures():
            assert similarity(pictures[a], pictures[b]) < 0.95, (a, b)


@pytest.mark.parametrize("name", some(raytrace.scenes(), "checkerboard"))
def test_float32_is_enough(name):
    """A renderer in float32 can come near the golden image with the assignment's formula."""
    image = np.float64(render(name, dtype="float32", intersection="textbook"))
    golden = steps_of(name)["display"]
    assert similarity(image, golden) >= 0.9999
    assert np.count_nonzero(np.abs(image - golden).max(axis=-1) > 1 / 255) <= 5


def test_inside_a_sphere():
    spheres, steps = scene_of("inside-a-sphere").spheres, steps_of("inside-a-sphere")
    t1, t2 = depths("inside-a-sphere", 0)
    assert (t1 < 0).all()
    assert (t2 > 0).all()
    assert np.linalg.norm(scene_of("inside-a-sphere").camera.position - spheres.center[0]) < spheres.radius[0]
    wall = steps["index"] == 0
    assert wall.mean() > 0.5
    np.testing.assert_allclose(steps["t"][wall], t2[wall], rtol=1e-6)
    assert (steps["index"] >= 0).all()
    # The normal is the outer one. The wall is lit from outside, and what it holds is not.
    assert (dot(steps["rd"], steps["N"])[wall] > 0).all()
    assert (steps["shadow"][wall & (steps["NdL"] > 0)] == 1).mean() > 0.9
    assert (steps["shadow"][np.isin(steps["index"], [1, 2, 3, 5])] == 0).all()


def tangent_pixels():
    """(column, row, sphere) where the discriminant is 0: in units of 1/960 everything is an integer."""
    spheres = scene_of("tangent-rays").spheres
    x, y = 16 * (2 * np.arange(480) - 479), 16 * (269 - 2 * np.arange(270))[:, None]
    for number, (center, radius) in enumerate(zip(spheres.center, spheres.radius, strict=True)):
        cx, cy, r = (int(v * 960) for v in (center[0], center[1], radius))
        assert (cx / 960, cy / 960, r / 960) == (center[0], center[1], radius)
        discriminant = r**2 - (x - cx) ** 2 - (y - cy) ** 2
        # All others are clear of 0.
        assert np.abs(discriminant[discriminant != 0]).min() > 2e-4 * 960**2
        yield from ((column, row, number) for row, column in np.argwhere(discriminant == 0))


def test_tangent_rays():
    spheres, pixels = scene_of("tangent-rays").spheres, list(tangent_pixels())
    columns, rows, _ = np.transpose(pixels)
    assert len(pixels) == 2 * len(spheres.radius)
    assert set(rows) == {67, 202}
    assert set(columns % 15) == {7}
    kisses = [a[:2] for a, b in pairwise(sorted(pixels, key=lambda pixel: (pixel[1], pixel[0]))) if a[:2] == b[:2]]
    assert len(kisses) == len(spheres.radius) - 2
    # Both arithmetics and both formulas hit, at the same t, and of two the later.
    for dtype in ("float32", "float64"):
        for intersection in ("textbook", "robust"):
            steps = render("tangent-rays", dtype=dtype, intersection=intersection, output="steps")
            for column, row, number in pixels:
                latest = max(n for c, r, n in pixels if (c, r) == (column, row))
                assert steps["index"][row, column] == latest
                assert steps["t"][row, column] == 7.5 - spheres.center[number, 2]
                assert steps["N"][row, column, 2] == 0


def test_cut_by_the_plane():
    spheres, steps = scene_of("cut-by-the-plane").spheres, steps_of("cut-by-the-plane")
    height, radius = spheres.center[:, 1], spheres.radius
    half, cap, most, touching, flat, sunk = range(6)
    assert height[half] == 0
    assert -radius[cap] < height[cap] < 0 < height[most] < radius[most]
    assert height[touching] == radius[touching]
    assert -1 < height[flat] / radius[flat] < -0.95
    assert height[sunk] < -radius[sunk]
    assert set(np.unique(steps["index"])) == {half, cap, most, touching, flat, 6}
    assert (steps["hitPoint"][..., 1] > -1e-12).all()
    for number in (half, cap):
        # The plane hides the lower part.
        t1, _ = depths("cut-by-the-plane", number)
        assert ((steps["index"] == 6) & (t1 > steps["t"])).sum() > 100


def test_sun_below_the_horizon():
    steps = steps_of("sun-below-the-horizon")
    assert sun_of("sun-below-the-horizon")[1] < 0
    ground = steps["index"] == len(scene_of("sun-below-the-horizon").spheres.radius)
    spheres = (steps["index"] >= 0) & ~ground
    assert (steps["NdL"][ground] == 0).all()
    assert (steps["NdL"][spheres & (steps["N"][..., 1] > 0.9)] == 0).all()
    # The ground is between the undersides and the sun, and does not matter.
    lit = spheres & (steps["NdL"] > 0) & (steps["shadow"] == 1)
    assert lit.sum() > 1000
    assert (steps["hitPoint"][lit][:, 1] > 0).all()
    # Shadows are cast upwards, by a lower sphere on a higher one.
    assert (spheres & (steps["NdL"] > 0) & (steps["shadow"] == 0)).sum() > 500


def test_sun_in_the_picture():
    steps = steps_of("sun-in-the-picture")
    towards = dot(steps["rd"], sun_of("sun-in-the-picture"))
    disc = towards**2400 > 0.5
    assert disc[1:-1, 1:-1].sum() == disc.sum()
    assert (disc & (steps["index"] == -1)).sum() > 50
    assert (disc & (steps["index"] == 0)).sum() > 50
    assert (steps["linear"][disc & (steps["index"] == -1)] > 1).all(axis=-1).any()
    facing = np.isin(steps["index"], range(5))
    assert (steps["NdL"][facing] == 0).mean() > 0.9


def test_overlapping_spheres():
    spheres, steps = scene_of("overlapping-spheres").spheres, steps_of("overlapping-spheres")
    distances = np.linalg.norm(spheres.center[:, None] - spheres.center, axis=-1)
    through = distances < spheres.radius[:, None] + spheres.radius
    assert (through.sum(axis=1) >= 3).all()
    inner, first, second = 10, 11, 12
    assert distances[inner, 3] + spheres.radius[inner] < spheres.radius[3]
    assert distances[first, second] == 0
    assert spheres.radius[first] == spheres.radius[second]
    assert set(np.unique(steps["index"])) == {-1, *range(15)} - {inner, first}


def test_tiny_far_sphere():
    spheres, steps = scene_of("tiny-far-sphere").spheres, steps_of("tiny-far-sphere")
    last = len(spheres.radius) - 1
    distances = np.linalg.norm(spheres.center, axis=1)
    assert (spheres.radius == 1).all()
    assert (np.diff(distances) > 0).all()
    assert distances[last] == pytest.approx(1024, abs=1e-3)
    seen = np.bincount(steps["index"][steps["index"] >= 0])
    assert (np.diff(seen) <= 0).all()
    assert seen[last] == 1
    # A pixel is a good deal larger than the sphere.
    row, column = np.argwhere(steps["index"] == last)[0]
    assert np.linalg.norm(steps["rd"][row, column + 1] - steps["rd"][row, column]) * distances[last] > 3
    np.testing.assert_array_equal(steps["display"][row, column], np.float32(spheres.color[last]))


def test_huge_sphere_as_ground():
    spheres, steps = scene_of("huge-sphere-as-ground").spheres, steps_of("huge-sphere-as-ground")
    assert spheres.radius[0] == 1000
    ground = steps["index"] == 0
    assert ground.mean() > 0.3
    # It ends below the level of the eye, and what is seen in between is the void.
    assert steps["rd"][..., 1][ground].max() < -0.04
    assert ((steps["index"] == -1) & (steps["rd"][..., 1] < 0)).sum() > 1000
    # No point of it shadows itself: the light returns where the other spheres are gone.
    bare = raytrace.load_scene("huge-sphere-as-ground", [f"spheres[{i}].center=[0,-2000,0]" for i in range(1, 8)])
    for dtype in ("float32", "float64"):
        for intersection in ("textbook", "robust"):
            alone = render(bare, dtype=dtype, intersection=intersection, output="steps")
            assert (alone["shadow"][alone["index"] == 0] == 1).all()
    # A far sphere stands on the ground with its foot behind the horizon.
    far = 6
    t1, _ = depths("huge-sphere-as-ground", far)
    hidden = ~np.isnan(t1) & ground
    assert (steps["index"] == far).sum() > 100
    assert hidden.sum() > 100
    assert (steps["t"][hidden] < t1[hidden]).all()


def test_grazing_horizon():
    scene, steps = scene_of("grazing-horizon"), steps_of("grazing-horizon")
    assert scene.camera.position[1] < scene.planes[0].pattern.tile_size / 2
    assert (steps["rd"][:180, :, 1] > 0).all()
    assert (steps["rd"][180:, :, 1] < 0).all()
    ground = steps["index"] == len(scene.spheres.radius)
    nearest, next_row = (steps["t"][row][ground[row]].min() for row in (180, 181))
    assert nearest > 500 * scene.camera.position[1]
    assert nearest > 2.9 * next_row
    assert 0 < sun_of("grazing-horizon")[1] < 0.15


def test_level_camera():
    """Of an even number of rows none is level, of an odd one the middle, to the last bit in every arithmetic."""
    assert (steps_of("level-camera")["rd"][..., 1] != 0).all()
    scene = scene_of("level-camera")
    for dtype in ("float32", "float64", "longdouble"):
        steps = render("level-camera", (480, 271), dtype=dtype, output="steps")
        index, linear = steps["index"][135], steps["linear"][135]
        assert (steps["rd"][135, :, 1] == 0).all()
        assert len(scene.spheres.radius) not in index
        np.testing.assert_allclose(linear[index == -1], np.broadcast_to(scene.sky.low, linear.shape)[index == -1], 1e-6)
        assert (index == -1).sum() > 50
        # Through the spheres' centres: the normal has no height.
        assert (steps["hitPoint"][135, :, 1][index >= 0] == np.float32(0.37)).all()
        assert (steps["N"][135, :, 1] == 0).all()


def test_two_tilted_planes():
    scene, steps = scene_of("two-tilted-planes"), steps_of("two-tilted-planes")
    normals = np.array([plane.normal for plane in scene.planes])
    lengths = np.linalg.norm(normals, axis=1)
    assert (np.abs(lengths - 1) > 0.1).all()
    assert (np.abs(normals / lengths[:, None])[:, 1] < 0.95).all()
    assert np.linalg.norm(np.cross(*normals)) > 0.1
    first = len(scene.spheres.radius)
    for number in (first, first + 1):
        assert (steps["index"] == number).mean() > 0.2
    # They meet within the picture, in one line: each row has one border of the two, or something stands before it.
    on_planes = steps["index"] >= first
    borders = (np.diff(steps["index"], axis=1) == 1) & on_planes[:, :-1] & on_planes[:, 1:]
    assert set(borders.sum(axis=1)) <= {0, 1}
    assert borders.sum() > 150


def test_orthographic():
    scene, steps = scene_of("orthographic"), steps_of("orthographic")
    assert isinstance(scene.camera, raytrace.OrthographicCamera)
    assert (steps["rd"] == steps["rd"][0, 0]).all()
    np.testing.assert_allclose(np.abs(steps["rd"][0, 0]), 3**-0.5, rtol=1e-7)
    # The top and the nearest sphere hide behind nothing, and are of one size though not of one distance.
    seen = np.bincount(steps["index"].ravel())
    disc = np.pi * (0.5 * 270 / scene.camera.height) ** 2
    nearest = np.argmax(scene.spheres.center @ [1, 0, 1])
    top = np.argmax(scene.spheres.center[:, 1])
    assert nearest != top
    np.testing.assert_allclose(seen[[nearest, top]], disc, rtol=0.01)
    assert (steps["index"] >= 0).all()


def test_shifted_lens():
    scene, steps = scene_of("shifted-lens"), steps_of("shifted-lens")
    assert isinstance(scene.camera, raytrace.MatrixCamera)
    # The camera is level, and yet the horizon is above the picture; what is vertical is a column.
    assert scene.camera.view_to_world[1].tolist() == [0, 1, 0, scene.camera.view_to_world[1, 3]]
    assert steps["rd"][..., 1].max() < 0
    azimuth = np.arctan2(steps["rd"][..., 0], -steps["rd"][..., 2])
    np.testing.assert_allclose(azimuth, np.broadcast_to(azimuth[0], azimuth.shape), rtol=0, atol=1e-12)


def test_non_default_film():
    film, default, steps = scene_of("non-default-film").film, raytrace.Film(), steps_of("non-default-film")
    assert film.exposure != default.exposure
    assert film.white_point != default.white_point
    assert film.tone_mapper != default.tone_mapper
    assert film.transfer != default.transfer
    # Greys, the wall among them, are orange in linear light and grey on the film.
    grey = steps["index"] >= 18
    red, green, blue = np.moveaxis(steps["linear"][grey], -1, 0)
    assert (red > 2 * green).all()
    assert (green > 3 * blue).all()
    assert np.ptp(steps["display"][grey], axis=-1).max() < 0.5 / 255
    # No adapted colour is negative: hable is a quotient, and has a pole below 0.
    assert steps["display"].min() > 0


def test_shadow_of_a_plane():
    scene, steps = scene_of("shadow-of-a-plane"), steps_of("shadow-of-a-plane")
    wall, plane = scene.planes
    assert (wall.casts_shadow, plane.casts_shadow) == (False, True)
    seen = np.unique(steps["index"])
    assert len(scene.spheres.radius) in seen
    assert len(scene.spheres.radius) + 1 not in seen
    assert (dot(steps["rd"], plane.normal) == 0).all()
    above = dot(steps["hitPoint"] - plane.point, plane.normal)
    lit = steps["NdL"] > 0
    assert (steps["shadow"][(above < -0.01) & lit] == 0).all()
    # Above it only spheres cast shadows: as without it.
    without = render(raytrace.load_scene("shadow-of-a-plane", ["planes[1].casts_shadow=false"]), SIZE, output="steps")
    np.testing.assert_array_equal(steps["shadow"][above > 0.01], without["shadow"][above > 0.01])
    assert (steps["display"] != without["display"]).any(axis=-1).mean() > 0.25


def test_two_hundred_spheres():
    spheres, steps = scene_of("two-hundred-spheres").spheres, steps_of("two-hundred-spheres")
    assert len(spheres.radius) == 200
    distances = np.linalg.norm(spheres.center[:, None] - spheres.center, axis=-1)
    apart = distances - spheres.radius[:, None] - spheres.radius
    assert apart[~np.eye(200, dtype=bool)].min() > 0
    assert (spheres.center[:, 1] >= spheres.radius).all()
    assert len(np.unique(spheres.color, axis=0)) == 200
    assert len(np.unique(steps["index"])) > 150
    assert ((steps["index"] == 200) & (steps["shadow"] == 0)).mean() > 0.05
