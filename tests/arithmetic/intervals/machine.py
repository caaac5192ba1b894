"""A simulated machine: float32 arithmetic that errs at random, as far as the table of the error model allows.

Every element of every array errs on its own. Each operation gives one of the results that
`raytrace.arithmetic.intervals.error_models.BUILT_INS` allows, often one of the farthest; inside a built-in the form,
the order of a sum and what is fused are drawn, too. It shares no code with the bounds that it is to test.
"""

import numpy as np

from raytrace.language.namespace import Unlimited

__all__ = ["Machine"]

SMALLEST, LARGEST_DIVISOR = 2.0**-126, 2.0**126


class Truth:
    """The answers of a comparison."""

    __array_ufunc__ = None

    def __init__(self, value, xp):
        self.value, self.xp = np.asarray(value), xp
        self.shape, self.ndim, self.dtype = self.value.shape, self.value.ndim, "bool"

    def __array_namespace__(self):
        return self.xp

    def __and__(self, other):
        return Truth(self.value & other.value, self.xp)

    def __or__(self, other):
        return Truth(self.value | other.value, self.xp)

    def __invert__(self):
        return Truth(~self.value, self.xp)


class Number:
    """Floats, or indices.

    value: float32 numbers as float64. product: where this is a product, the exact one, which a sum may be fused with.
    inverse: where this is a square root, an inverse root of the same number, by which a division may multiply.
    """

    __array_ufunc__ = None

    def __init__(self, value, xp, product=None, inverse=None):
        self.value, self.xp, self.product, self.inverse = np.asarray(value), xp, product, inverse
        self.shape, self.ndim = self.value.shape, self.value.ndim
        self.dtype = "int32" if self.value.dtype.kind == "i" else "float32"

    def __array_namespace__(self):
        return self.xp

    def __getitem__(self, key):
        return Number(self.value[key], self.xp)

    def other(self, x):
        if isinstance(x, Number):
            return x
        return Number(np.asarray(x, self.value.dtype), self.xp) if isinstance(x, int | float) else None

    def __neg__(self):
        return Number(-self.value, self.xp, None if self.product is None else -self.product)

    def __add__(self, other):
        other = self.other(other)
        return NotImplemented if other is None else self.xp.sum(self, other)

    __radd__ = __add__

    def __sub__(self, other):
        other = self.other(other)
        return NotImplemented if other is None else self.xp.sum(self, -other)

    def __rsub__(self, other):
        other = self.other(other)
        return NotImplemented if other is None else self.xp.sum(other, -self)

    def __mul__(self, other):
        other = self.other(other)
        return NotImplemented if other is None else self.xp.times(self, other)

    __rmul__ = __mul__

    def __truediv__(self, other):
        other = self.other(other)
        return NotImplemented if other is None else self.xp.quotient(self, other)

    def __rtruediv__(self, other):
        other = self.other(other)
        return NotImplemented if other is None else self.xp.quotient(other, self)

    __hash__ = None


def _comparison(name):
    def compare(self, other):
        other = self.other(other)
        return NotImplemented if other is None else Truth(getattr(self.value, name)(other.value), self.xp)

    setattr(Number, name, compare)


for _name in ("__lt__", "__le__", "__gt__", "__ge__", "__eq__", "__ne__"):
    _comparison(_name)


class Machine:
    """The array namespace, with a source of randomness."""

    bool, int32 = "bool", "int32"

    def __init__(self, random):
        self.random, self.built_ins = random, self

    def finfo(self, dtype):
        return Unlimited

    # How results err.

    def rounded(self, exact):
        """Either neighbour; a subnormal result may be 0."""
        with np.errstate(over="ignore"):
            nearest = exact.astype(np.float32)
        down = np.where(nearest > exact, np.nextafter(nearest, np.float32(-np.inf)), nearest)
        up = np.where(nearest < exact, np.nextafter(nearest, np.float32(np.inf)), nearest)
        known = np.where(self.some(exact), down, up).astype(np.float64)
        return self.flushed(np.where(np.isnan(exact), np.nan, known))

    def flushed(self, x):
        return np.where((np.abs(x) < SMALLEST) & self.some(x), 0.0, x)

    def within(self, exact, units, absolute=0.0):
        """A float32 that is up to so many units off, or by so much; half of the time it is one of the farthest."""
        exact = np.asarray(exact, np.float64)
        with np.errstate(all="ignore"):
            # The unit of the numbers between the powers of two around it.
            unit = np.where(exact == 0, 0, 2.0 ** (np.floor(np.log2(np.abs(exact))) - 23))
            unit = np.where(np.isfinite(exact), np.maximum(unit, np.where(exact == 0, 0, 2.0**-149)), 0)
            share = np.where(
                self.some(exact), self.random.choice([-1, 1], exact.shape), self.random.uniform(-1, 1, exact.shape)
            )
            target = exact + share * np.maximum(units * unit, absolute)
            nearest = target.astype(np.float32)
        # The neighbour on the side of the exact result is no farther off.
        back = np.nextafter(nearest, exact.astype(np.float32))
        beyond = np.where(share > 0, nearest > target, nearest < target)
        return self.flushed(np.where(np.isfinite(exact), np.where(beyond, back, nearest).astype(np.float64), exact))

    def some(self, like):
        return self.random.random(np.shape(like)) < 0.5

    def one_of(self, *forms):
        """For each element that of one of the forms."""
        values = np.broadcast_arrays(*(form.value for form in forms))
        return Number(np.choose(self.random.integers(len(forms), size=values[0].shape), values), self)

    # Operations.

    def sum(self, a, b):
        if a.dtype == "int32":
            return Number(a.value + b.value, self)
        with np.errstate(all="ignore"):
            results = [self.rounded(a.value + b.value)]
            if a.product is not None:
                results.append(self.rounded(a.product + b.value))
            if b.product is not None:
                results.append(self.rounded(a.value + b.product))
        return self.one_of(*(Number(result, self) for result in results))

    def times(self, a, b):
        with np.errstate(all="ignore"):
            product = a.value * b.value
            return Number(self.rounded(product), self, product)

    def quotient(self, a, b):
        with np.errstate(all="ignore"):
            exact = a.value / b.value
            if b.ndim == 0 and np.frexp(b.value)[0] in (0.5, -0.5):
                return Number(self.rounded(exact), self)
            found = self.within(exact, 2.5)
        # A quotient by zero is infinite, with either sign.
        found = np.where((b.value == 0) & self.some(found), -found, found)
        found = np.where((np.abs(b.value) > LARGEST_DIVISOR) & self.some(found), 0, found)
        if b.inverse is None:
            return Number(found, self)
        with np.errstate(all="ignore"):
            return self.one_of(Number(found, self), Number(self.rounded(a.value * b.inverse), self))

    def sqrt(self, x):
        with np.errstate(all="ignore"):
            inverse = self.within(1 / np.sqrt(x.value), 2)
            forms = (
                self.within(1 / inverse, 2.5),
                np.where(x.value == 0, 0, self.rounded(x.value * inverse)),
                self.within(np.sqrt(x.value), 5),
            )
        return Number(self.one_of(*(Number(form, self) for form in forms)).value, self, inverse=inverse)

    def exp2(self, x):
        with np.errstate(all="ignore"):
            return Number(self.within(2.0**x.value, 3 + 2 * np.minimum(np.abs(x.value), 1000)), self)

    def log2(self, x):
        with np.errstate(all="ignore"):
            near = (x.value >= 0.5) & (x.value <= 2)
            exact = np.log2(x.value)
            return Number(self.within(exact, np.where(near, 0, 3), np.where(near, 2.0**-21, 0)), self)

    def floor(self, x):
        return Number(np.floor(x.value), self)

    def minimum(self, a, b):
        return Number(np.fmin(a.value, b.value), self)

    def maximum(self, a, b):
        return Number(np.fmax(a.value, b.value), self)

    def isfinite(self, x):
        return Truth(np.isfinite(x.value), self)

    # Built-ins.

    def dot(self, x, y):
        return self.one_of(*(self.grouped(x, y) for _ in range(3)))

    def grouped(self, x, y):
        """The sum of products in some order and grouping."""
        terms = [a * b for a, b in zip(x, y, strict=True)]
        while len(terms) > 1:
            a, b = (terms.pop(self.random.integers(len(terms))) for _ in range(2))
            terms.append(a + b)
        return terms[0]

    def mix(self, x, y, a):
        return self.one_of(x * (1 - a) + y * a, x + (y - x) * a, (x - x * a) + y * a)

    def mod(self, x, y):
        quotient = x / y
        whole = self.floor(quotient)
        return self.one_of(x - y * whole, y * (quotient - whole))

    def power(self, x, y):
        small = self.random.uniform(0, SMALLEST, x.shape)
        x = Number(np.where((np.abs(x.value) < SMALLEST) & self.some(x.value), np.float32(small), x.value), self)
        return self.where(x > 0, self.exp2(y * self.log2(x)), Number(np.zeros(x.shape), self))

    def either(self, *forms):
        return self.one_of(*forms)

    # What arrays are made of.

    def rational(self, value):
        denominator = value.denominator
        for factor in (2, 5):
            while denominator % factor == 0:
                denominator //= factor
        exact = np.asarray(float(value))
        return Number(self.rounded(exact) if denominator == 1 else self.within(exact, 4), self)

    def asarray(self, value, dtype):
        if dtype == "bool":
            return Truth(value, self)
        return Number(np.asarray(value, np.int32 if dtype == "int32" else np.float64), self)

    def given(self, numbers):
        return Number(self.flushed(np.asarray(np.float32(numbers), np.float64)), self)

    def where(self, condition, a, b):
        if isinstance(a, Truth):
            return Truth(np.where(condition.value, a.value, b.value), self)
        inverse = None
        if a.inverse is not None:
            with np.errstate(all="ignore"):
                inverse = np.where(condition.value, a.inverse, 1 / b.value)
        return Number(np.where(condition.value, a.value, b.value), self, inverse=inverse)

    def reshape(self, x, shape):
        return Number(x.value.reshape(shape), self)

    def take(self, x, index, axis):
        return Number(np.take(x.value, index.value, axis), self)
