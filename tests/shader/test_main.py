import numpy as np
import pytest
from hypothesis import given

import raytrace
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.main import closest_hit
from tests.scenes import some
from tests.strategies import directions, positions, scenes, unit, vec3

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")


def seen(scene, ro, rd):
    return closest_hit(vec3(ro), vec3(rd), uniforms_of(scene, 1.0), program_of(scene, "textbook"))


BALL = raytrace.Spheres(center=[[0, 0, 0]], radius=[1.0], color=[[1, 0, 0]])


def test_a_plane_wins_only_if_strictly_nearer():
    """The ball's front and the plane z = 1 are both at distance 4 from z = 5; z = 1.5 is nearer."""
    touching, nearer = (raytrace.Plane(point=[0, 0, z], normal=[0, 0, 1]) for z in (1, 1.5))
    view = [0, 0, 5], [0, 0, -1]
    assert seen(raytrace.Scene(spheres=BALL, planes=(touching,)), *view) == (4, 0)
    assert seen(raytrace.Scene(spheres=BALL, planes=(nearer,)), *view) == (3.5, 1)


def test_a_sphere_at_zero_is_not_seen_but_what_is_behind_it():
    """At the ball's front, looking in: closestSphereIntersect gives t = 0 and main wants t > 0."""
    view = [0, 0, 1], [0, 0, -1]
    assert seen(raytrace.Scene(spheres=BALL), *view) == (-1, -1)
    wall = raytrace.Plane(point=[0, 0, -3], normal=[0, 0, 1])
    assert seen(raytrace.Scene(spheres=BALL, planes=(wall,)), *view) == (4, 1)


def test_an_empty_world_is_sky():
    assert seen(raytrace.Scene(), [0, 0, 0], [0, 1, 0]) == (-1, -1)


def alone(scene):
    """Scenes of one object each, in the order of the index."""
    arrays = [vars(scene.spheres)[name] for name in ("center", "radius", "color")]
    for i in range(len(scene.spheres.radius)):
        yield raytrace.Scene(spheres=raytrace.Spheres(*(array[i : i + 1] for array in arrays)))
    for plane in scene.planes:
        yield raytrace.Scene(planes=(plane,))


@given(scenes(), positions, directions)
def test_what_is_seen_is_the_nearest_of_all(scene, ro, rd):
    t, index = seen(scene, ro, unit(rd))
    hits = [seen(one, ro, unit(rd)) for one in alone(scene)]
    if any(hit.index >= 0 for hit in hits):
        assert t == min(hit.t for hit in hits if hit.index >= 0)
        assert t == hits[index].t
    else:
        assert (t, index) == (-1, -1)


def steps(scene, **options):
    return raytrace.render(scene, (48, 27), backend="numpy", dtype="float64", output="steps", **options)


def dot(a, b):
    return (a * b).sum(axis=-1)


@given(scenes())
def test_the_steps_hang_together(scene):
    """Each step follows from those before it, by the assignment's formulas, and lies where it must."""
    s = steps(scene)
    hit = s["index"] >= 0
    np.testing.assert_array_equal(s["t"] > 0, hit)
    np.testing.assert_array_equal(s["t"][~hit], -1)
    for name in ("hitPoint", "N", "NdL", "NdSky", "shadow", "albedo"):
        assert not s[name][~hit].any()
    np.testing.assert_allclose(np.linalg.norm(s["rd"], axis=-1), 1, atol=1e-14)
    if not isinstance(scene.camera, raytrace.OrthographicCamera):
        far = np.abs(s["t"])[..., None] + 1
        away = np.where(hit[..., None], s["hitPoint"] - scene.camera.position - s["t"][..., None] * s["rd"], 0)
        assert (np.abs(away) < 1e-12 * far).all()

    for i in range(len(scene.spheres.radius)):
        on = s["index"] == i
        center, radius = scene.spheres.center[i], scene.spheres.radius[i]
        outward = (s["hitPoint"][on] - center) / radius
        # Textbook: the discriminant's rounding, of some 600 * 1e-16, is all of it at a silhouette.
        np.testing.assert_allclose(np.linalg.norm(outward, axis=-1), 1, atol=1e-12 / radius**2)
        np.testing.assert_array_equal(s["albedo"][on], np.broadcast_to(scene.spheres.color[i], outward.shape))
        if scene.lighting != "off":
            np.testing.assert_allclose(s["N"][on], outward, atol=1e-12 / radius**2)
    for i, plane in enumerate(scene.planes, len(scene.spheres.radius)):
        on = s["index"] == i
        normal = plane.normal / np.linalg.norm(plane.normal)
        above = dot(s["hitPoint"][on] - plane.point, normal)
        # The uniform normal is rounded to float32, which tilts the plane.
        assert (np.abs(above) < 2e-7 * (1 + np.linalg.norm(s["hitPoint"][on] - plane.point, axis=-1))).all()
        pattern = plane.pattern
        colors = [pattern.color] if isinstance(pattern, raytrace.Plain) else [pattern.even, pattern.odd, pattern.line]
        assert np.any([(s["albedo"][on] == np.float32(color)).all(axis=-1) for color in colors], axis=0).all()
        if scene.lighting != "off":
            np.testing.assert_allclose(s["N"][on], np.broadcast_to(normal, s["N"][on].shape), atol=1e-7)

    if scene.lighting == "off":
        np.testing.assert_array_equal(s["linear"][hit], s["albedo"][hit])
    else:
        L = scene.sun.direction / np.linalg.norm(scene.sun.direction)
        np.testing.assert_allclose(s["NdL"][hit], np.maximum(dot(s["N"][hit], L), 0), atol=2e-7)
        np.testing.assert_allclose(s["NdSky"][hit], 0.5 * s["N"][hit][:, 1] + 0.5, atol=1e-15)
        assert np.isin(s["shadow"][hit], [0, 1]).all()
        direct = np.float32(scene.sun.color) * (s["NdL"] * s["shadow"])[..., None]
        sky = np.float32(scene.sky.high) * s["NdSky"][..., None]
        np.testing.assert_allclose(s["linear"][hit], ((direct + sky) * s["albedo"])[hit], atol=1e-14)
    assert (s["display"] >= 0).all()
    assert (s["display"] <= 1).all()


def test_a_plane_is_not_flipped_towards_the_viewer():
    """Seen from below, the ground's N points up, away from the viewer; its patches have its own colours."""
    ground = raytrace.Plane(pattern=raytrace.Plain([0.25, 0.5, 0.75]))
    camera = raytrace.PerspectiveCamera(position=[0, -3, 0], target=[0, 0, -0.1])
    s = steps(raytrace.Scene(planes=(ground,), camera=camera))
    assert (s["index"] == 0).all()
    assert (s["N"] == [0, 1, 0]).all()
    assert (s["albedo"] == [0.25, 0.5, 0.75]).all()


def test_a_shadowed_pixel_of_the_ground_by_hand():
    """Looking straight down from y = 2 at the ground y = -0.5, a small sphere between the ground and an oblique sun.

    The ray (0,-1,0) from (1,2,1) meets the ground at t = 2.5 in (1,-0.5,1), which is tile floor(2.5) = 2 twice: even.
    L = (0.6, 0.8, 0): the shadow ray passes (1,-0.5,1) + 2 L = (2.2, 1.1, 1), where the sphere is: shadow = 0.
    NdL = 0.8, NdSky = 1: linear is skyColorHigh * 1.
    """
    scene = raytrace.Scene(
        spheres=raytrace.Spheres([[2.2, 1.1, 1.0]], [0.125], [[1, 1, 1]]),
        planes=(raytrace.Plane(),),
        sun=raytrace.Sun(direction=[3, 4, 0]),
        camera=raytrace.PerspectiveCamera(position=[1, 2, 1], target=[1, 0, 1], up=[0, 0, -1]),
    )
    s = raytrace.render(scene, (1, 1), backend="numpy", dtype="float64", output="steps", exact_inputs=True)
    pixel = {name: step[0, 0].tolist() for name, step in s.items()}
    assert pixel["rd"] == [0, -1, 0]
    assert (pixel["t"], pixel["index"]) == (2.5, 1)
    assert pixel["hitPoint"] == [1, -0.5, 1]
    assert pixel["N"] == [0, 1, 0]
    assert (pixel["NdL"], pixel["NdSky"], pixel["shadow"]) == pytest.approx((0.8, 1, 0), abs=1e-15)
    assert pixel["albedo"] == [1, 1, 1]
    assert pixel["linear"] == pytest.approx([0.14, 0.21, 0.49], abs=1e-15)


def test_one_pixel_by_hand():
    """A 1x1 image of `lit-sphere`: the only ray goes from (0,0,4) along -z and meets the unit sphere at t = 3.

    There N = (0,0,1). With L = (1, 0.75, 1) / sqrt(2.5625): NdL = 1 / sqrt(2.5625) = 0.62470; NdSky = 0.5.
    Linear red is (1.64 * 0.62470 + 0.14 * 0.5) * 1 = 1.09450, green (1.27 * 0.62470 + 0.21 * 0.5) * 0.1 = 0.08984.
    Display red: 1.09450 * (2.51 * 1.09450 + 0.03) / (1.09450 * (2.43 * 1.09450 + 0.59) + 0.14) = 0.82225,
    to the power 1/2.2: 0.91488.
    """
    pixel = {
        name: step[0, 0].tolist()
        for name, step in raytrace.render(
            "lit-sphere", (1, 1), backend="numpy", dtype="float64", output="steps", exact_inputs=True
        ).items()
    }
    NdL = 1 / np.sqrt(2.5625)
    assert pixel["pixelNdc"] == [0, 0]
    assert pixel["rd"] == [0, 0, -1]
    assert (pixel["t"], pixel["index"]) == (3, 0)
    assert pixel["hitPoint"] == [0, 0, 1]
    assert pixel["N"] == [0, 0, 1]
    assert (pixel["NdL"], pixel["NdSky"], pixel["shadow"]) == pytest.approx((NdL, 0.5, 1), abs=1e-15)
    assert pixel["albedo"] == [1, 0.1, 0.1]
    assert pixel["linear"][:2] == pytest.approx([1.64 * NdL + 0.07, 0.127 * NdL + 0.0105], abs=1e-15)
    assert pixel["display"][0] == pytest.approx(0.91488, abs=5e-6)


def test_lighting_changes_what_it_is_named_for():
    off, on, shadow = (
        steps(raytrace.Scene(spheres=BALL, planes=(raytrace.Plane(point=[0, -1, 0]),), lighting=lighting))
        for lighting in ("off", "on", "shadow")
    )
    assert not off["NdL"].any()
    assert on["shadow"][on["index"] >= 0].all()
    assert (shadow["shadow"][shadow["index"] >= 0] == 0).any()
    lit = shadow["shadow"] == 1
    np.testing.assert_array_equal(on["linear"][lit], shadow["linear"][lit])


@pytest.mark.parametrize("height", [0.3, -3])
@pytest.mark.parametrize(
    ("backend", "dtype"),
    some(
        [("numpy", "float32"), ("numpy", "float64"), ("jax", "float32"), ("jax", "float64")],
        ("numpy", "float32"),
        ("jax", "float32"),
    ),
)
def test_a_level_camera_at_odd_height_has_a_finite_horizon(height, backend, dtype):
    """The middle row's rays are parallel to the ground: no plane there, from above it or below."""
    camera = raytrace.PerspectiveCamera(position=[0, height, 2], target=[0, height, 0])
    scene = raytrace.Scene(spheres=BALL, planes=(raytrace.Plane(),), camera=camera)
    all_steps = raytrace.render(scene, (33, 17), backend=backend, dtype=dtype, output="steps")
    horizon = np.asarray(all_steps["index"])[8]
    assert set(horizon.tolist()) <= {-1, 0}
    assert all(np.isfinite(np.asarray(step)).all() for step in all_steps.values())
    # From above the ground is below the horizon, from below above it.
    ground = np.asarray(all_steps["index"])[:, 0] == 1
    assert ground[9:].all() == (height > 0)
    assert ground[:8].all() == (height < 0)
