"""Rays that leave the surface they start on, and the search for the worst of them."""

import numpy as np
import pytest

pytest.importorskip("flint")

from raytrace.language.glsl import Vec3, dot, select, sqrt
from raytrace.shader.sphere import closest_approach, robust_roots, sphere_intersect
from raytrace.shader.uniforms import Sphere
from raytrace.studies.stress import QUICK, stress, verdicts
from raytrace.studies.stress.arithmetics import of_floats
from raytrace.studies.stress.limits import ROBUST
from raytrace.studies.stress.rays import Rays, answered, given
from raytrace.studies.stress.search import climb, random_rays, rows_of

ARITHMETICS = pytest.mark.parametrize("arithmetic", of_floats(), ids=lambda a: a.name)


def intersection(arithmetic):
    run = arithmetic.of(lambda ro, rd, center, radius: sphere_intersect(ro, rd, Sphere(center, radius, None), "robust"))
    return lambda rays: run(*rays)


def leaving(dtype):
    """Rays that start on a large sphere, as nearly as `dtype` can say, and leave it tangentially.

    The first is the one whose t was once the squared length that is left of the cancellation: 262144 for 54.18.
    """
    random = np.random.default_rng(0)
    center = np.vstack([[-88987.9765625, -142476.921875, 200584.640625], random.normal(size=(999, 3)) * 1e5])
    radius = np.concatenate([[261634.734375], np.sqrt((center[1:] ** 2).sum(axis=1))])
    across = np.cross(center, random.normal(size=(1000, 3)))
    direction = across / np.sqrt((across**2).sum(axis=1))[:, None]
    direction[0] = 0.54674375, 0.5487951, 0.6323727
    parts = (Vec3(*np.moveaxis(x.astype(np.longdouble), -1, 0)) for x in (0 * center, direction, center))
    return given(Rays(*parts, radius.astype(np.longdouble)), dtype)


@ARITHMETICS
def test_rays_that_leave_the_surface_tangentially(arithmetic):
    rays = leaving(arithmetic.dtype)
    exact, t = answered(rays), intersection(arithmetic)(rays)
    assert np.isfinite(t).all()
    right = exact.decided(t) & exact.hit
    units = np.spacing(exact.t.floats()[right].astype(arithmetic.dtype))
    errors = np.abs(t[right] - exact.t.floats()[right]) / units
    assert right.sum() > 100
    assert (errors / exact.condition[right]).max() <= ROBUST
    if arithmetic.dtype is np.float32:
        assert exact.t.floats()[0] == pytest.approx(54.18, abs=0.01)
        assert abs(t[0] - 54.18) < 100


@ARITHMETICS
def test_the_first_root_is_never_beyond_the_second(arithmetic):
    """However wrong their product is near the surface."""
    rays = leaving(arithmetic.dtype)
    roots = arithmetic.of(lambda ro, rd, radius: tuple(robust_roots(ro, rd, radius)))
    _, t1, t2 = roots(rays.origin - rays.center, rays.direction, rays.radius)
    assert (t1 <= t2 + 4 * np.finfo(arithmetic.dtype).eps * np.abs(t2)).all()


def unmended(ro, rd, center, radius):
    """The formula as it was: the other root is c / q, and c where q is 0."""
    ro = ro - center
    b, nearest = closest_approach(ro, rd)
    root, c = sqrt(radius * radius - dot(nearest, nearest)), dot(ro, ro) - radius * radius
    q = select(b < 0, root - b, -(root + b))
    other = c / select(q == 0, 1, q)
    t1, t2 = select(b < 0, other, q), select(b < 0, q, other)
    return select(radius * radius - dot(nearest, nearest) >= 0, select(t1 < 0, t2, t1), -1)


def test_the_search_finds_what_random_rays_do_not():
    """The fault of the old formula, which no axis had met, in as many steps as the quick run has."""
    numpy32 = of_floats()[0]
    old = numpy32.of(unmended)
    random = np.random.default_rng((0, 1))
    start = random_rays(random, 400)
    found = climb(lambda rays: old(*rays), np.float32, start, QUICK.climbing, random)
    assert found.found.height.max() > 2 * ROBUST
    mended = climb(intersection(numpy32), np.float32, start, QUICK.climbing, np.random.default_rng(1))
    assert 1 < mended.found.height.max() <= ROBUST


def test_the_search_is_that_of_its_seed():
    few = QUICK._replace(climbing=10, cases=50)
    once, again, other = (list(stress(few._replace(seed=seed), ["search"])) for seed in (1, 1, 2))
    assert once == again != other
    assert all(verdict.holds for verdict in verdicts(once))
    assert {point.who for point in once} == {f"{a.name} robust" for a in of_floats()}


def test_rays_as_rows_and_back():
    rays = given(leaving(np.float64), np.longdouble)
    rows = rows_of(rays)
    assert rows.shape == (1000, 10)
    np.testing.assert_array_equal(rows[:, 6], rays.center.x)


def test_derivatives_where_a_ray_leaves_the_surface_are_finite():
    """Also where the roots are 0, or too near to 0 to be divided by."""
    import jax
    import jax.numpy as jnp

    def t(ro, rd, center, radius):
        return sphere_intersect(Vec3(*ro), Vec3(*rd), Sphere(Vec3(*center), radius, None), "robust")

    slopes = jax.jit(jax.vmap(jax.grad(t, argnums=(0, 1, 2, 3))))
    rays = leaving(np.float32)
    parts = [np.stack(np.broadcast_arrays(*vector), -1) for vector in (rays.origin, rays.direction, rays.center)]
    touching = 10.0 ** -np.arange(10, 46)
    n = len(touching)
    # From the top of a sphere, along it but for a component that is as small as can be.
    sideways = np.column_stack([touching * 0, touching, np.ones(n)])
    tops = [np.tile([0, r, 0], (n, 1)) for r in (1e-12, 1.0, 1e12)]
    origins = np.vstack([parts[0], *tops, *tops])
    directions = np.vstack([parts[1], *[sideways] * 3, *[sideways * [1, -1, 1]] * 3])
    centers = np.vstack([parts[2], np.zeros((6 * n, 3))])
    radii = np.concatenate([rays.radius, np.repeat([1e-12, 1.0, 1e12] * 2, n)])
    for slope in slopes(*(jnp.asarray(x, jnp.float32) for x in (origins, directions, centers, radii))):
        assert np.isfinite(slope).all()
