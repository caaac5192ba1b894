"""The bounds of each built-in hold what a machine may give for it in any of its forms, and little more."""

import numpy as np
import pytest

from raytrace.arithmetic.intervals import BUILT_INS, GLSL_HIGHP, REAL, IntervalNamespace
from raytrace.language.glsl import Mat3, Mat4, Vec3, Vec4, clamp, dot, exp2, log2, mix, mod, normalize, pow, sqrt
from raytrace.language.literal import literal
from tests.arithmetic.intervals.machine import Machine

N = 30_000
XP = IntervalNamespace(GLSL_HIGHP)


def numbers(random, low=-10, high=10):
    """Float32 numbers of many magnitudes, some of them 0, 1 or alike."""
    x = random.choice([-1.0, 1.0], N) * 2.0 ** random.uniform(low, high, N)
    x = np.where(random.random(N) < 0.3, random.normal(size=N), x)
    return np.float32(np.where(random.random(N) < 0.1, random.integers(-2, 3, N), x)).astype(float)


def vec(kind, x):
    return kind(*x[: len(kind._fields)])


#: What is computed, of up to 20 numbers each, positive where a function needs that.
OPERATIONS = {
    "sum of a product": lambda *x: x[0] * x[1] + x[2],
    "difference of products": lambda *x: x[0] * x[1] - x[2] * x[3],
    "quotient": lambda *x: x[0] / x[1],
    "root": lambda *x: sqrt(x[0] * x[0]),
    "dot of three": lambda *x: dot(Vec3(*x[:3]), Vec3(*x[3:6])),
    "dot of four": lambda *x: dot(Vec4(*x[:4]), Vec4(*x[4:8])),
    "squared length": lambda *x: dot(Vec3(*x[:3]), Vec3(*x[:3])),
    "mat3 * vec3": lambda *x: (Mat3(*(Vec3(*x[3 * i : 3 * i + 3]) for i in range(3))) * Vec3(*x[9:12])).y,
    "mat4 * vec4": lambda *x: (Mat4(*(Vec4(*x[4 * i : 4 * i + 4]) for i in range(4))) * Vec4(*x[16:18], 1, 1)).z,
    "mix": lambda *x: mix(x[0], x[1], clamp(x[2], 0, 1)),
    "mix beyond": lambda *x: mix(x[0], x[1], x[2]),
    "mix of vectors": lambda *x: mix(Vec3(*x[:3]), Vec3(*x[3:6]), x[6]).y,
    "mod 2": lambda *x: mod(x[0], 2),
    "normalize": lambda *x: normalize(Vec3(*x[:3])).x,
    "log2": lambda *x: log2(x[0] * x[0]),
    "log2 near 1": lambda *x: log2(1 + clamp(x[0], -0.4, 0.4)),
    "exp2": lambda *x: exp2(clamp(x[0], -100, 100)),
    "fourth root": lambda *x: pow(x[0] * x[0], literal("1/4")),
    "power": lambda *x: pow(x[0] * x[0], literal("5/11")),
    "decimal": lambda *x: literal("0.1") * x[0] + literal("1/60"),
}


@pytest.mark.parametrize("name", OPERATIONS)
@np.errstate(all="ignore")
def test_every_form_is_within(name):
    """Of points, and of intervals around them."""
    random = np.random.default_rng(3)
    points = [numbers(random) for _ in range(20)]
    machine = Machine(random)
    found = OPERATIONS[name](*(machine.given(x) for x in points)).value
    for spread in (0.0, 2.0**-20):
        given = [XP.given(x) for x in points]
        if spread:
            given = [x * XP.given(np.array(1 - spread)) for x in given]  # the number itself, less a little
            given = [
                type(x)(np.minimum(x.low, p), np.maximum(x.high, p), XP) for x, p in zip(given, points, strict=True)
            ]
        bounds = OPERATIONS[name](*given)
        outside = ~((bounds.low <= found) & (found <= bounds.high)) & np.isfinite(found)
        assert not outside.any(), [x[outside][:2] for x in points[:4]]


@pytest.mark.parametrize(
    ("field", "name"),
    [
        ("divide", "quotient"),
        ("root", "root"),
        ("exp2", "exp2"),
        ("exp2_slope", "exp2"),
        ("log2", "log2"),
        ("log2_absolute", "log2 near 1"),
    ],
)
@np.errstate(all="ignore")
def test_a_machine_uses_what_the_table_allows(field, name):
    """With less allowed it is outside: the test above would find a bound that is too narrow."""
    random = np.random.default_rng(4)
    points, machine = [numbers(random) for _ in range(20)], Machine(random)
    narrower = IntervalNamespace(GLSL_HIGHP._replace(**{field: 0.4 * getattr(GLSL_HIGHP, field)}))
    found = OPERATIONS[name](*(machine.given(x) for x in points)).value
    bounds = OPERATIONS[name](*(narrower.given(x) for x in points))
    assert (((found < bounds.low) | (found > bounds.high)) & np.isfinite(found)).any()


@np.errstate(all="ignore")
def test_one_form_alone_is_not_enough():
    """Of a blend's and of a sum's forms each gives something that the others do not."""
    random = np.random.default_rng(5)
    x, y, z = (numbers(random) for _ in range(3))
    y = np.where(random.random(N) < 0.5, y, np.float32(x * (1 + 2.0**-12)))
    a = np.where(random.random(N) < 0.5, random.integers(0, 2, N), np.float32(random.random(N)))
    xp = Machine(random)
    for form in (
        lambda x, y, a: x * (1 - a) + y * a,
        lambda x, y, a: x + (y - x) * a,
        lambda x, y, a: (x - x * a) + y * a,
    ):
        found, bounds = mix(*map(xp.given, (x, y, a))).value, form(*map(XP.given, (x, y, a)))
        assert ((found < bounds.low) | (found > bounds.high)).any()
    # Two terms that cancel, in any place, and a small one.
    terms = random.permuted(np.stack([x, -y, np.float32(z * 2.0**-12)]), axis=0)
    found = np.stack([dot(Vec3(*map(xp.given, terms)), Vec3(1, 1, 1)).value for _ in range(8)])
    given = list(map(XP.given, terms))
    for i, j, k in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
        bounds = (given[i] + given[j]) + given[k]
        assert ((found < bounds.low) | (found > bounds.high)).any()


def test_the_ends_of_a_blend():
    """One form gives the second number at a = 1, another what is left of it when the difference is rounded."""
    white, tenth, one = (XP.given(np.array([x])) for x in (1.0, float(np.float32(0.1)), 1.0))
    blend = mix(white, tenth, one)
    assert blend.low[0] <= np.float32(0.1) < np.float32(0.10000002) <= blend.high[0]
    assert blend.high[0] - blend.low[0] <= 2.0**-22
    start = mix(white, tenth, XP.given(np.zeros(1)))
    assert (start.low[0], start.high[0]) == (1, 1)
    bright, dark = (XP.given(np.array([x])) for x in (1e6, float(np.float32(1e-2))))
    blend = mix(bright, dark, one)
    assert (blend.low[0], blend.high[0]) == (0, 0.0625)
    # In real numbers all forms are one.
    real = IntervalNamespace(REAL)
    blend = mix(*(real.given(np.array([x])) for x in (1.0, 0.1, 1.0)))
    assert blend.high[0] - blend.low[0] < 2.0**-50


def test_bounds_are_narrow():
    """A blend of close numbers by a wide share is no wider than between these, but for rounding."""
    random = np.random.default_rng(6)
    x = np.float32(random.uniform(0.5, 1, N)).astype(float)
    y = x + 2.0**-10
    share = type(XP.given(x))(np.full(N, 0.25), np.full(N, 0.75), XP)
    blend = mix(XP.given(x), XP.given(y), share)
    assert (blend.high - blend.low <= 2.0**-11 + 8 * 2.0**-23).all()
    # Any order of a sum of three costs at most one more rounding.
    v = Vec3(*(XP.given(np.float32(random.uniform(0.5, 1, N)).astype(float)) for _ in range(3)))
    total = dot(v, v)
    assert ((total.high - total.low) <= 8 * 2.0**-23 * total.high).all()
    parity = mod(type(v.x)(np.full(1, 3.0), np.full(1, 8.0), XP), 2)
    assert (parity.low[0], parity.high[0]) == (0, 2)


def test_terms_that_are_zero_stay_exact():
    zero, x = XP.given(np.asarray(0.0)), XP.given(np.float32([0.1, 0.3]).astype(float))
    found = dot(Vec4(zero, x, zero, zero), Vec4(x, 1, x, 1))
    np.testing.assert_array_equal(found.low, x.low)
    np.testing.assert_array_equal(found.high, x.high)
    nothing = dot(Vec3(zero, zero, zero), Vec3(x, x, x))
    assert not nothing.low.any()
    assert not nothing.high.any()


def test_a_quotient_by_a_huge_number_may_be_zero():
    """Its reciprocal is a subnormal number."""
    found = XP.given(np.full(1, 2.0**127)) / XP.given(np.full(1, 1.5 * 2.0**126))
    assert found.low[0] == 0
    assert found.high[0] > 1.3


def test_a_power_of_zero_may_be_that_of_a_subnormal_number():
    """SwiftShader's logarithm of 0 is -127."""
    found = pow(XP.given(np.zeros(1)), literal("5/11"))
    assert found.low[0] == 0
    assert 2.0 ** (-127 / 2.2) <= found.high[0] <= 2.0 ** (-125 / 2.2)


def test_the_table_is_what_certificates_say():
    from raytrace.certificates.certificate import ASSUMPTIONS

    assert {f"{name}: {forms}" for name, forms in BUILT_INS.items()} <= set(ASSUMPTIONS["glsl-highp"])
