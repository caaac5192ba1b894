import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from raytrace.shader.sphere import any_sphere_intersect, closest_sphere_intersect, sphere_intersect
from raytrace.shader.uniforms import Sphere
from tests.strategies import directions, numbers, positions, radii, unit, vec3


@st.composite
def aimed(draw):
    """(ro, rd, center, radius, miss): a ray whose line passes the centre at `miss` radii, 0 ... 0.99."""
    ro, center, radius = np.array(draw(positions)), np.array(draw(positions)), draw(radii)
    across, miss = unit(draw(directions)), draw(numbers(0, 0.99))
    distance = np.linalg.norm(center - ro)
    assume(distance > 1.01 * radius)
    forward = (center - ro) / distance
    across = across - np.dot(across, forward) * forward
    assume(np.linalg.norm(across) > 0.1)
    sine = miss * radius / distance
    rd = np.sqrt(1 - sine**2) * forward + sine * unit(across)
    return ro, unit(rd), center, radius, miss


FORMULAS = pytest.mark.parametrize("formula", ["textbook", "robust"])


def sphere(center, radius, dtype=np.float64):
    return Sphere(vec3(center, dtype), np.asarray(radius, dtype), vec3(np.zeros_like(center), dtype))


def intersect(ro, rd, center, radius, formula="textbook", dtype=np.float64):
    with np.errstate(all="ignore"):
        return sphere_intersect(vec3(ro, dtype), vec3(rd, dtype), sphere(center, radius, dtype), formula)


@FORMULAS
@pytest.mark.parametrize(
    ("ro", "rd", "t"),
    [
        # From z = 5 towards the unit sphere: its front is at z = 1.
        ([0, 0, 5], [0, 0, -1], 4),
        # Away from it: both roots are behind, t2 = -4 is returned and means no hit.
        ([0, 0, 5], [0, 0, 1], -4),
        # Past it: no root.
        ([2, 0, 5], [0, 0, -1], -1),
        # From its centre: t1 = -1 < 0, so t2 = 1.
        ([0, 0, 0], [0, 0, -1], 1),
        # From its front into it: t1 = 0 is not < 0 and is returned.
        ([0, 0, 1], [0, 0, -1], 0),
        # From its front away from it: t1 = -2, t2 = 0 is returned.
        ([0, 0, 1], [0, 0, 1], 0),
        # Touching it at (1, 0, 0).
        ([1, 0, 5], [0, 0, -1], 5),
        # Starting where it touches: q = 0 in the robust formula.
        ([1, 0, 0], [0, 0, -1], 0),
    ],
)
def test_by_hand(ro, rd, t, formula):
    """The unit sphere around the origin and axis-parallel rays: every t can be read off a sketch."""
    assert intersect(ro, rd, [0, 0, 0], 1, formula) == t


def test_textbook_by_hand():
    """ro = (0,0,3), rd = (0,0.6,-0.8), r = 2: b = -2.4, c = 5, d = 0.76, t1 = 2.4 - sqrt(0.76) = 1.52822..."""
    assert intersect([0, 0, 3], [0, 0.6, -0.8], [0, 0, 0], 2) == pytest.approx(2.4 - np.sqrt(0.76), abs=1e-15)


@FORMULAS
@given(aimed())
def test_a_hit_lies_on_the_sphere(formula, ray):
    """Every aimed ray hits, in front of the centre, at the radius from it.

    The discriminant's terms are rounded in proportion to |ro - center|**2 (textbook) or radius**2 (robust); the
    chord's half, its root, divides that by itself.
    """
    ro, rd, center, radius, miss = ray
    t = intersect(ro, rd, center, radius, formula)
    distance = np.linalg.norm(ro - center)
    assert 0 < t < distance
    scale = distance**2 if formula == "textbook" else distance * radius
    chord = radius * np.sqrt(1 - miss**2)
    assert np.linalg.norm(ro + t * rd - center) == pytest.approx(
        radius, abs=1e-15 * (10 * distance + 10 * scale / chord)
    )


@given(aimed())
def test_the_formulas_agree(ray):
    """To the error of the textbook's discriminant: some ulp of |ro - center|**2 over the chord."""
    ro, rd, center, radius, miss = ray
    textbook, robust = (intersect(ro, rd, center, radius, formula) for formula in ("textbook", "robust"))
    distance = np.linalg.norm(ro - center)
    chord = radius * np.sqrt(1 - miss**2)
    assert textbook == pytest.approx(robust, rel=0, abs=1e-15 * (10 * distance + 10 * distance**2 / chord))


@FORMULAS
@given(positions, directions, positions, radii, st.integers(-20, 20))
def test_scaling_by_a_power_of_two_scales_t_exactly(formula, ro, rd, center, radius, k):
    rd, scale = unit(rd), 2.0**k
    t = intersect(ro, rd, center, radius, formula)
    scaled = intersect(np.multiply(ro, scale), rd, np.multiply(center, scale), radius * scale, formula)
    assert scaled == (t if t == -1 and scaled == -1 else t * scale)


@FORMULAS
@given(positions, directions, positions, radii)
def test_mirroring_changes_nothing(formula, ro, rd, center, radius):
    mirror = np.array([-1, 1, 1])
    rd = unit(rd)
    t = intersect(ro, rd, center, radius, formula)
    assert intersect(ro * mirror, rd * mirror, center * mirror, radius, formula) == t


@FORMULAS
@given(aimed())
def test_a_ray_reversed_comes_out_where_it_went_in(formula, ray):
    """From beyond the sphere back along the same line: the first hit there and the first hit back span the chord."""
    ro, rd, center, radius, miss = ray
    far = 2 * np.linalg.norm(ro - center) + radius
    there = intersect(ro, rd, center, radius, formula)
    back = far - intersect(ro + far * rd, -rd, center, radius, formula)
    chord = 2 * radius * np.sqrt(1 - miss**2)
    assert back - there == pytest.approx(chord, abs=1e-13 * (far + far**2 / chord))


def test_float32_robust_resolves_what_textbook_does_not():
    """Rays around the silhouette of a unit sphere at distance 3000: the hits that float32 gets wrong."""
    random = np.random.default_rng(1)
    n, distance = 200_000, 3000.0
    angle, reach = random.uniform(0, 2 * np.pi, n), random.uniform(0.5, 1.5, n)
    aim = np.stack([reach * np.cos(angle), reach * np.sin(angle), np.zeros(n)], -1)
    ro = np.array([0, 0, distance])
    rd = (aim - ro) / np.linalg.norm(aim - ro, axis=-1, keepdims=True)
    rd = rd.astype(np.float32)

    def hits(formula, dtype):
        return intersect(np.broadcast_to(ro, rd.shape), rd, [0, 0, 0], 1, formula, dtype) > 0

    # In longdouble the direction is what float32 holds, normalised again: the formulas take unit length for granted.
    truth = hits("robust", np.longdouble)
    wrong = {formula: np.mean(hits(formula, np.float32) != truth) for formula in ("textbook", "robust")}
    assert wrong["textbook"] > 0.05
    assert wrong["robust"] < wrong["textbook"] / 1000


@pytest.fixture
def three():
    """Around z = 0, -3 and -3 again: the last two are the same sphere."""
    return sphere([[0, 0, 0], [0, 0, -3], [0, 0, -3]], [1, 1, 1])


@FORMULAS
def test_closest_by_hand(three, formula):
    """From z = 5 the first sphere is met at 4; from z = -1.5 the others at 0.5, and the later of the two wins."""
    rd = vec3([0, 0, -1])
    assert closest_sphere_intersect(vec3([0, 0, 5]), rd, three, formula) == (4, 0)
    assert closest_sphere_intersect(vec3([0, 0, -1.5]), rd, three, formula) == (0.5, 2)
    assert closest_sphere_intersect(vec3([0, 9, 5]), rd, three, formula) == (-1, -1)


@FORMULAS
def test_a_sphere_at_zero_is_the_closest_and_blocks(three, formula):
    """On the first sphere's front t1 = 0, which is not < 0: it wins, and a shadow ray is blocked."""
    ro, rd = vec3([0, 0, 1]), vec3([0, 0, -1])
    assert closest_sphere_intersect(ro, rd, three, formula) == (0, 0)
    assert any_sphere_intersect(ro, rd, three, formula)


def test_of_no_spheres_none_is_closest():
    ro, rd = vec3([0, 0, 1]), vec3([0, 0, -1])
    assert closest_sphere_intersect(ro, rd, None) == (-1, -1)
    assert not any_sphere_intersect(ro, rd, None)


@FORMULAS
@given(positions, directions, st.lists(st.tuples(positions, radii), min_size=1, max_size=8))
def test_no_sphere_is_nearer_than_the_closest(formula, ro, rd, balls):
    ro, rd = vec3(ro), vec3(unit(rd))
    centers, radius = map(list, zip(*balls, strict=True))
    t, index = closest_sphere_intersect(ro, rd, sphere(centers, radius), formula)
    each = np.array([sphere_intersect(ro, rd, sphere(c, r), formula) for c, r in balls])
    met = each[each >= 0]
    assert t == (met.min() if len(met) else -1)
    assert index == (np.flatnonzero(each == t)[-1] if len(met) else -1)
    assert any_sphere_intersect(ro, rd, sphere(centers, radius), formula) == (t >= 0)
