"""The shader on arrays of other people: a strict implementation of the standard, and a type of our own."""

from collections import Counter

import array_api_strict
import numpy as np
import pytest

import raytrace
from raytrace.language.literal import literal
from raytrace.language.namespace import lift, namespace
from raytrace.language.tree import tree_map
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.film import aces, gamma22
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import Frame, pixels
from tests.scenes import SEVERAL_SCENES

KEEP = tuple(COMPONENTS)
FRAME = Frame(24, 13)


def run(scene, array, intersection):
    """The shader itself, with every number made by `array` from NumPy float64; leaves converted back by the caller."""
    uniforms = tree_map(lambda x: array(np.asarray(np.float32(x), np.float64)), uniforms_of(scene, 24 / 13))
    column = array(np.arange(24.0)[None, :] + np.zeros((13, 1)))
    row = array(np.arange(13.0)[:, None] + np.zeros((1, 24)))
    return pixels(uniforms, program_of(scene, intersection), column, row, FRAME, KEEP)


def expected(scene, intersection):
    with np.errstate(all="ignore"):
        return run(scene, lambda x: x, intersection)


FORMULAS = pytest.mark.parametrize("intersection", ["textbook", "robust"])


@pytest.fixture
def polite(monkeypatch):
    """array_api_strict raises where Python's data model asks an operator for NotImplemented; here it does not."""
    array = type(array_api_strict.asarray(0.0))
    for name in ("add", "sub", "mul", "truediv"):
        method = getattr(array, f"__{name}__")

        def operator(self, other, method=method):
            return method(self, other) if isinstance(other, array | int | float) else NotImplemented

        monkeypatch.setattr(array, f"__{name}__", operator)


@SEVERAL_SCENES
@FORMULAS
@pytest.mark.usefixtures("polite")
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_runs_on_strictly_standard_arrays(name, intersection):
    scene = raytrace.load_scene(name)
    steps = run(scene, array_api_strict.asarray, intersection)
    tree_map(
        lambda strict, plain: np.testing.assert_allclose(np.asarray(strict), plain, rtol=1e-12, atol=1e-12),
        steps,
        expected(scene, intersection),
    )


class Condition:
    """The answer of a comparison. It may be undecided one day, so nobody may ask it for yes or no."""

    def __init__(self, answer, count):
        self.answer, self.count, self.shape, self.dtype = np.asarray(answer), count, np.shape(answer), np.dtype(bool)

    def __array_namespace__(self):
        return Counting(self.count)

    def __bool__(self):
        raise AssertionError("the shader asked a comparison for yes or no")

    def __and__(self, other):
        return Condition(self.answer & other.answer, self.count)

    def __or__(self, other):
        return Condition(self.answer | other.answer, self.count)

    def __invert__(self):
        return Condition(~self.answer, self.count)


class Counted:
    """A number, or an index, that counts what is done to it. It does not say what it is but through its namespace."""

    __array_ufunc__ = None

    def __init__(self, value, count):
        self.value, self.count = np.asarray(value), count
        self.shape, self.dtype, self.ndim = self.value.shape, self.value.dtype, self.value.ndim

    def __array_namespace__(self):
        return Counting(self.count)

    def __bool__(self):
        raise AssertionError("the shader asked a number for yes or no")

    def __getitem__(self, key):
        return Counted(self.value[key], self.count)


def _operator(name, wrap):
    def operator(self, *others):
        if not all(isinstance(other, Counted | int | float) for other in others):
            return NotImplemented
        self.count[name.strip("_")] += self.value.size
        return wrap(getattr(self.value, name)(*(getattr(other, "value", other) for other in others)), self.count)

    setattr(Counted, name, operator)


for _name in ("add", "radd", "sub", "rsub", "mul", "rmul", "truediv", "rtruediv", "neg", "abs"):
    _operator(f"__{_name}__", Counted)
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    _operator(f"__{_name}__", Condition)


class Counting:
    """Just the functions of the standard that the shader uses."""

    bool, int32 = np.bool, np.int32
    finfo = staticmethod(np.finfo)

    def __init__(self, count):
        self.count = count

    def asarray(self, value, dtype):
        wrap = Condition if dtype == np.bool else Counted
        return wrap(np.asarray(value, dtype), self.count)

    def where(self, condition, a, b):
        assert isinstance(condition, Condition)
        self.count["where"] += condition.answer.size
        if isinstance(a, Condition):
            return Condition(np.where(condition.answer, a.answer, b.answer), self.count)
        return Counted(np.where(condition.answer, a.value, b.value), self.count)

    def isfinite(self, x):
        return Condition(np.isfinite(x.value), self.count)

    def reshape(self, x, shape):
        return Counted(x.value.reshape(shape), self.count)

    def take(self, x, index, axis):
        assert index.dtype == np.int32
        assert index.ndim == 1
        return Counted(np.take(x.value, index.value, axis), self.count)

    def __getattr__(self, name):
        if name not in ("sqrt", "exp2", "log2", "floor", "minimum", "maximum"):
            raise AttributeError(name)

        def function(*args):
            self.count[name] += args[0].value.size
            return Counted(getattr(np, name)(*(arg.value for arg in args)), self.count)

        return function


@SEVERAL_SCENES
@FORMULAS
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_runs_on_a_type_of_ones_own(name, intersection):
    """Equal bits, no comparison asked for yes or no, and no operation outside the namespace."""
    scene, count = raytrace.load_scene(name), Counter()
    steps = run(scene, lambda x: Counted(x, count), intersection)
    tree_map(
        lambda counted, plain: np.testing.assert_array_equal(counted.value, plain),
        steps,
        expected(scene, intersection),
    )
    assert count["mul"] > 0


def test_the_count_is_that_of_the_formulas():
    """One pixel of the assignment's film: for each channel 2 + 1 products of ACES and one of the power, y * log2 x."""
    count = Counter()
    x = lift(np.float64(0.5), np.float64(0))
    gamma22(aces(tree_map(lambda v: Counted(v, count), raytrace.language.glsl.Vec3(x, x, x))))
    # x*(a*x+b) and x*(c*x+d): four products each way, and (y * log2(x)).
    assert count["mul"] + count["rmul"] == 3 * (4 + 1)
    assert count["log2"] == count["exp2"] == 3
    assert "sqrt" not in count


def test_no_array_no_namespace():
    with pytest.raises(TypeError, match="expected at least one array"):
        namespace(1, "a")


def test_lift_takes_literals_numbers_and_arrays():
    like = np.float32(0)
    assert lift(literal("1/3"), like) == np.float32(1) / np.float32(3)
    assert lift(0.1, like).dtype == np.float32
    assert lift(like, like) is like
