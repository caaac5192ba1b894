import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import raytrace
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.light import light_at_point, shadow_ray
from raytrace.shader.shadows import footprint_of
from tests.strategies import directions, positions, unit, vec3


def shader(scene):
    return uniforms_of(scene, 1.0), program_of(scene, "textbook")


def light(scene, point, N, index=-1, shadow_start="offset"):
    uniforms, program = uniforms_of(scene, 1.0), program_of(scene, "textbook", shadow_start)
    footprint = footprint_of(uniforms, program)
    return light_at_point(vec3(point), vec3(N), np.asarray(index, np.int32), uniforms, program, False, footprint)


def test_by_hand():
    """Sun overhead, N = (0, 0.6, 0.8): NdL = 0.6, NdSky = 0.5 * 0.6 + 0.5 = 0.8.

    Red: 1.64 * 0.6 + 0.14 * 0.8 = 1.096.
    """
    scene = raytrace.Scene(sun=raytrace.Sun(direction=[0, 5, 0]), lighting="on")
    seen = light(scene, [0, 0, 0], [0, 0.6, 0.8])
    assert (seen.NdL, seen.NdSky, seen.shadow) == pytest.approx((0.6, 0.8, 1), abs=1e-15)
    assert seen.light.x == pytest.approx(1.096, abs=1e-15)


def test_away_from_the_sun_there_is_only_sky():
    """N = -y under a sun overhead: NdL = 0 and NdSky = 0; nothing is received."""
    scene = raytrace.Scene(sun=raytrace.Sun(direction=[0, 1, 0]), lighting="on")
    assert light(scene, [0, 0, 0], [0, -1, 0]).light == (0, 0, 0)


def test_shadow_by_hand():
    """A unit sphere at height 3 over the origin, the sun overhead: the ground is dark up to distance 1."""
    ball = raytrace.Spheres(center=[[0, 3, 0]], radius=[1.0], color=[[1, 1, 1]])
    scene = raytrace.Scene(spheres=ball, sun=raytrace.Sun(direction=[0, 1, 0]))
    assert light(scene, [0.99, 0, 0], [0, 1, 0]).shadow == 0
    assert light(scene, [1.01, 0, 0], [0, 1, 0]).shadow == 1
    # Above the sphere nothing stands between.
    assert light(scene, [0, 5, 0], [0, 1, 0]).shadow == 1


def test_a_sphere_at_zero_blocks():
    """From the front of the unit sphere at z = 1: t1 = 0 going in, t2 = 0 going out, and t >= 0 blocks."""
    ball = raytrace.Spheres(center=[[0, 0, 0]], radius=[1.0], color=[[1, 1, 1]])
    given = shader(raytrace.Scene(spheres=ball))
    for direction in ([0, 0, -1], [0, 0, 1]):
        assert shadow_ray(vec3([0, 0, 1]), vec3(direction), *given) == 0


def test_the_offset_keeps_a_sphere_from_shadowing_itself():
    """Without 1e-3 * N the point's own sphere would be met at t = 0."""
    ball = raytrace.Spheres(center=[[0, 0, 0]], radius=[1.0], color=[[1, 1, 1]])
    scene = raytrace.Scene(spheres=ball, sun=raytrace.Sun(direction=[0, 0, 1]))
    assert light(scene, [0, 0, 1], [0, 0, 1]).shadow == 1


@pytest.mark.parametrize(("depth", "shadow"), [(0.9e-3, 1), (1.1e-3, 0)])
def test_the_shadow_ray_starts_a_thousandth_along_the_normal(depth, shadow):
    """A sphere whose top is `depth` above the point: below 1e-3 the ray starts above it, beyond 1e-3 within it."""
    ball = raytrace.Spheres(center=[[0, depth - 0.1, 0]], radius=[0.1], color=[[1, 1, 1]])
    scene = raytrace.Scene(spheres=ball, sun=raytrace.Sun(direction=[0, 1, 0]))
    assert light(scene, [0, 0, 0], [0, 1, 0]).shadow == shadow


@pytest.mark.parametrize("casts", [False, True])
def test_a_plane_casts_a_shadow_only_if_asked_to(casts):
    ceiling = raytrace.Plane(point=[0, 1, 0], normal=[0, -1, 0], casts_shadow=casts)
    scene = raytrace.Scene(planes=(ceiling,), sun=raytrace.Sun(direction=[0, 1, 0]))
    assert light(scene, [0, 0, 0], [0, 1, 0]).shadow == (0 if casts else 1)


@given(positions, directions, directions, st.integers(-40, 40))
def test_the_suns_direction_need_not_be_normalised(point, N, direction, k):
    """Scaled by a power of two, the direction's digits are the same and so is every bit of the light."""
    N = unit(N)
    a, b = (
        light(raytrace.Scene(sun=raytrace.Sun(direction=np.multiply(direction, scale)), lighting="on"), point, N)
        for scale in (1.0, 2.0**k)
    )
    assert a == b


def test_a_surface_does_not_shadow_itself_where_rays_start_on_it():
    """The unit sphere is met at t = 0 from its own front, but is left out; another one in the way is not."""
    balls = raytrace.Spheres(center=[[0, 0, 0], [0, 0, 5]], radius=[1.0, 1.0], color=[[1, 1, 1]] * 2)
    scene = raytrace.Scene(spheres=balls, sun=raytrace.Sun(direction=[0, 0, 1]))
    assert light(scene, [0, 0, 1], [0, 0, 1], index=0, shadow_start="surface").shadow == 0
    assert light(scene, [0, 0, 6], [0, 0, 1], index=1, shadow_start="surface").shadow == 1
    assert light(scene, [0, 0, 1], [0, 0, 1], index=1, shadow_start="surface").shadow == 0


def test_planes_leave_themselves_out_by_their_own_number():
    """Of three planes the first and last cast shadows: a point just under the last is shadowed by it, not on it."""
    plane = raytrace.Plane(point=[0, -5, 0], normal=[0, 1, 0], casts_shadow=True)
    planes = (plane, raytrace.Plane(), raytrace.Plane(point=[0, 1, 0], normal=[0, 1, 0], casts_shadow=True))
    scene = raytrace.Scene(planes=planes, sun=raytrace.Sun(direction=[0, 1, 0]))
    just_under = [0, 1 - 1e-9, 0]
    shadows = [light(scene, just_under, [0, 1, 0], index=i, shadow_start="surface").shadow for i in range(3)]
    assert shadows == [0, 0, 1]
