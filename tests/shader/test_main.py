import numpy as np
import pytest
from hypothesis import given

import raytrace
from raytrace.shader.main import closest_hit
from raytrace.uniforms import program_of, uniforms_of
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


@given(scenes(), positions, directions)
def test_nothing_is_nearer_than_what_is_seen(scene, ro, rd):
    t, index = seen(scene, ro, unit(rd))
    spheres = len(scene.spheres.radius)
    for i in range(spheres):
        alone = raytrace.Scene(spheres=raytrace.Spheres(*(x[i : i + 1] for x in vars(scene.spheres).values())))
        other, hit = seen(alone, ro, unit(rd))
        assert hit < 0 or (0 < t <= other)
    for plane in scene.planes:
        other, hit = seen(raytrace.Scene(planes=(plane,)), ro, unit(rd))
        assert hit < 0 or (0 < t <= other)
    assert -1 <= index < spheres + len(scene.planes)
    assert (index == -1) == (t == -1)


def steps(scene, **options):
    return raytrace.render(scene, (48, 27), backend="numpy", dtype="float64", output="steps", **options)


@given(scenes())
def test_the_steps_hang_together(scene):
    """hitPoint = ro + t rd lies on what was hit, N is unit, lights are shares; a miss is -1 and zero."""
    all_steps = steps(scene)
    hit = all_steps["index"] >= 0
    np.testing.assert_array_equal(all_steps["t"] > 0, hit)
    np.testing.assert_array_equal(all_steps["t"][~hit], -1)
    for name in ("hitPoint", "N", "NdL", "NdSky", "shadow", "albedo"):
        assert not all_steps[name][~hit].any()
    np.testing.assert_allclose(np.linalg.norm(all_steps["rd"], axis=-1), 1, atol=1e-14)
    if scene.lighting == "off":
        np.testing.assert_array_equal(all_steps["linear"][hit], all_steps["albedo"][hit])
    else:
        np.testing.assert_allclose(np.linalg.norm(all_steps["N"][hit], axis=-1), 1, atol=1e-7)
        assert ((all_steps["NdL"] >= 0) & (all_steps["NdL"] <= 1 + 1e-7)).all()
        assert np.isin(all_steps["shadow"], [0, 1]).all()
    assert (all_steps["display"] >= 0).all()
    assert (all_steps["display"] <= 1).all()


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
@pytest.mark.parametrize("backend", ["numpy", "jax"])
@pytest.mark.parametrize("dtype", ["float32", "float64"])
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
