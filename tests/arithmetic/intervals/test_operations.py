"""No result escapes its bounds: random operations on random intervals against exact arithmetic."""

import numpy as np
import pytest

pytest.importorskip("flint")

from flint import arb

from raytrace.arithmetic.exact import Exact, precision
from raytrace.arithmetic.intervals import GLSL_HIGHP, REAL, Interval, IntervalNamespace
from raytrace.arithmetic.intervals.error_models import LIBM
from raytrace.language.literal import literal

N = 100_000
MODELS = pytest.mark.parametrize("model", [REAL, GLSL_HIGHP], ids=lambda model: model.name)


def sizes(random, model, n=N):
    """Numbers of all sizes that an interval of this model holds, some of them 0 or small whole ones."""
    low, high = (-120, 120) if model.float32 else (-480, 480)
    numbers = random.choice([-1.0, 1.0], n) * 2.0 ** random.uniform(low, high, n)
    numbers = np.where(random.random(n) < 0.5, random.normal(size=n), numbers)
    numbers = np.where(random.random(n) < 0.2, random.integers(-4, 5, n), numbers)
    return numbers.astype(np.float32).astype(np.float64) if model.float32 else numbers


def intervals(random, model, n=N):
    """Intervals, half of them points, and a number in each."""
    a = sizes(random, model, n)
    b = np.where(random.random(n) < 0.5, a, np.where(random.random(n) < 0.5, sizes(random, model, n), a * 1.0001))
    if model.float32:
        b = b.astype(np.float32).astype(np.float64)
    low, high = np.minimum(a, b), np.maximum(a, b)
    within = np.where(random.random(n) < 0.5, low, high)
    return Interval(low, high, IntervalNamespace(model)), within


def rounded(exact, model):
    """What the arithmetic may make of exact results: in float32 both neighbours, or 0 for a subnormal one."""
    if not model.float32:
        yield exact
        return
    floats = exact.floats(np.float64)
    with np.errstate(all="ignore"):
        nearest = floats.astype(np.float32)
        known = np.isfinite(nearest) & np.isfinite(floats)
        compared = Exact.of(np.where(known, nearest, 0).astype(np.float64)), Exact(np.where(known, exact.value, arb(0)))
        over, under = (compared[0] > compared[1]).value, (compared[0] < compared[1]).value
        down = np.where(over, np.nextafter(nearest, np.float32(-np.inf)), nearest)
        up = np.where(under, np.nextafter(nearest, np.float32(np.inf)), nearest)
    for neighbour in (down, up):
        yield Exact(np.where(known & np.isfinite(neighbour), Exact.of(neighbour.astype(np.float64)).value, exact.value))
    yield Exact(np.where(np.abs(floats) < 2.0**-126, arb(0), exact.value))


def assert_holds(interval, exact):
    """Every number of `exact` lies within; numbers that are none, anywhere."""
    low, high = (np.broadcast_to(end, exact.shape) for end in (interval.low, interval.high))
    below = np.array([x.is_finite() and not x >= arb(float(e)) for x, e in zip(exact.value, low, strict=True)])
    above = np.array([x.is_finite() and not x <= arb(float(e)) for x, e in zip(exact.value, high, strict=True)])
    assert not below.any(), np.flatnonzero(below)[:5]
    assert not above.any(), np.flatnonzero(above)[:5]


@MODELS
@pytest.mark.parametrize("name", ["add", "sub", "mul", "square", "truediv", "half", "third"])
def test_arithmetic(model, name):
    random = np.random.default_rng(5)
    (a, x), (b, y) = intervals(random, model), intervals(random, model)
    operations = {
        "add": lambda a, b: a + b,
        "sub": lambda a, b: a - b,
        "mul": lambda a, b: a * b,
        "square": lambda a, b: a * a,
        "truediv": lambda a, b: a / b,
        "half": lambda a, b: a * 0.5,
        "third": lambda a, b: a / 3,
    }
    operation = operations[name]
    with np.errstate(all="ignore"):
        found = operation(a, b)
    with precision(4000 if name in ("add", "sub", "mul", "square", "half") else 300):
        exact = operation(Exact.of(x), Exact.of(y))
        for result in rounded(exact, model):
            assert_holds(found, result)


@MODELS
@pytest.mark.parametrize("name", ["sqrt", "exp2", "log2"])
def test_functions(model, name):
    random = np.random.default_rng(6)
    a, x = intervals(random, model, N // 10)
    if name == "exp2":
        a, x = Interval(np.clip(a.low, -1000, 1000), np.clip(a.high, -1000, 1000), a.xp), np.clip(x, -1000, 1000)
        if model.float32:
            a, x = Interval(np.clip(a.low, -126, 127), np.clip(a.high, -126, 127), a.xp), np.clip(x, -126, 127)
    else:
        a, x = Interval(np.maximum(a.low, 0), np.maximum(a.high, 0), a.xp), np.maximum(x, 0)
    found = getattr(a.xp, name)(a)
    with precision(300):
        xp = Exact.of(x).__array_namespace__()
        exact = getattr(xp, name)(Exact.of(x))
    # A float32's rounding beyond what the function itself may err is none: results are float32 then.
    assert_holds(found, exact)


@pytest.mark.parametrize("name", ["exp2", "log2"])
def test_numpys_functions_err_by_what_is_assumed(name):
    """Also near 1, where a logarithm is small."""
    random = np.random.default_rng(7)
    near = 1 + 2.0 ** random.uniform(-52, -1, 50_000) * random.choice([-1, 1], 50_000)
    everywhere = 2.0 ** random.uniform(-1000, 1000, 50_000)
    x = np.concatenate([near, everywhere]) if name == "log2" else random.uniform(-1000, 1000, 100_000)
    found = getattr(np, name)(x)
    with precision(200):
        exact = getattr(Exact.of(x).__array_namespace__(), name)(Exact.of(x))
        error = np.abs((Exact.of(found) - exact).floats())
    assert (error <= LIBM * np.spacing(np.abs(found)) / 2).all()


@pytest.mark.parametrize(("name", "factor"), [("divide", 2.5), ("root", 5)])
def test_a_gpu_may_err_by_so_many_units(name, factor):
    """The bound holds the exact quotient or root moved by that much, and is not much wider."""
    random = np.random.default_rng(8)
    xp = IntervalNamespace(GLSL_HIGHP)
    x, y = (random.uniform(1, 8, 1000).astype(np.float32).astype(np.float64) for _ in range(2))
    found = xp.given(x) / xp.given(y) if name == "divide" else xp.sqrt(xp.given(x))
    exact = x / y if name == "divide" else np.sqrt(x)
    unit = np.spacing(exact.astype(np.float32)).astype(np.float64)
    assert (found.low <= exact - factor * unit).all()
    assert (found.high >= exact + factor * unit).all()
    assert (found.high - found.low <= (4 * factor + 2) * unit).all()


@MODELS
def test_exact_operations_stay_exact(model):
    xp = IntervalNamespace(model)
    numbers = xp.given(np.arange(-5.0, 5.0))
    for found, expected in (
        (numbers + 3, np.arange(-2.0, 8.0)),
        (numbers * 0.25, np.arange(-5.0, 5.0) / 4),
        (numbers / 2, np.arange(-5.0, 5.0) / 2),
        (xp.floor(numbers / 2), np.floor(np.arange(-5.0, 5.0) / 2)),
        (numbers - 2 * xp.floor(numbers / 2), np.mod(np.arange(-5.0, 5.0), 2)),
    ):
        np.testing.assert_array_equal(found.low, expected)
        np.testing.assert_array_equal(found.high, expected)


def test_what_is_undecided_is_both():
    xp = IntervalNamespace(REAL)
    x = Interval(np.array([-1.0, 1.0, -2.0]), np.array([1.0, 2.0, -1.0]), xp)
    negative = x < 0
    np.testing.assert_array_equal(negative.may_hold, [True, False, True])
    np.testing.assert_array_equal(negative.may_fail, [True, True, False])
    chosen = xp.where(negative, xp.given(np.full(3, 10.0)), xp.given(np.full(3, 20.0)))
    np.testing.assert_array_equal(chosen.low, [10, 20, 10])
    np.testing.assert_array_equal(chosen.high, [20, 20, 10])
    for combined, holds, fails in (
        (negative & ~negative, [True, False, False], [True, True, True]),
        (negative | ~negative, [True, True, True], [True, False, False]),
    ):
        np.testing.assert_array_equal(combined.may_hold, holds)
        np.testing.assert_array_equal(combined.may_fail, fails)


def test_a_quotient_that_may_be_by_zero_is_anything():
    xp = IntervalNamespace(REAL)
    wide = Interval(np.array([-1.0]), np.array([1.0]), xp)
    found = xp.given(np.ones(1)) / wide
    assert (found.low[0], found.high[0]) == (-np.inf, np.inf)
    # It may be no number, which no comparison holds for.
    assert (found < np.inf).may_fail.all()
    assert (found < np.inf).may_hold.all()
    with np.errstate(all="ignore"):
        nothing = (found * 0.0) + xp.given(np.ones(1))
    assert (nothing.low[0], nothing.high[0]) == (-np.inf, np.inf)


def test_indices_that_may_be_several_give_the_hull():
    xp = IntervalNamespace(REAL)
    items = xp.given(np.array([3.0, -1.0, 7.0]))
    index = Interval(np.array([0, 0, 2], np.int32), np.array([0, 1, 2], np.int32), xp)
    found = xp.take(items, index, axis=0)
    np.testing.assert_array_equal(found.low, [3, -1, 7])
    np.testing.assert_array_equal(found.high, [3, 3, 7])


def test_literals_are_their_neighbours_in_float32():
    xp = IntervalNamespace(GLSL_HIGHP)
    one = xp.given(np.ones(1))
    tenth = literal("0.1").like(one)
    assert tenth.low < 0.1 < tenth.high
    assert np.float32(tenth.high) == np.nextafter(np.float32(tenth.low), np.float32(1))
    half = literal("0.5").like(one)
    assert half.low == half.high == 0.5
    quotient = literal("5/11").like(one)
    assert quotient.low < np.float32(1 / np.float32(2.2)) < quotient.high


def test_subnormal_numbers_may_be_zero():
    xp = IntervalNamespace(GLSL_HIGHP)
    given = xp.given(np.array([1e-40, -1e-40, 0.0, 1.0]))
    np.testing.assert_array_equal(given.low <= 0, [True, True, True, False])
    np.testing.assert_array_equal(given.high >= 0, [True, True, True, True])
    np.testing.assert_array_equal(given.high >= [1e-40, -1e-40, 0, 1], True)
    np.testing.assert_array_equal(given.low <= [1e-40, -1e-40, 0, 1], True)
    small = xp.given(np.array([2.0**-100])) * xp.given(np.array([2.0**-40]))
    assert (small.low[0], small.high[0]) == (0, 2.0**-126)
