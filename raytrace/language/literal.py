"""Numbers that stand in the shader's text.

A literal means its decimal value. ``2.51 * x`` in Python would mean the float64 nearest to 2.51, which is
another number in longdouble and no enclosure at all for intervals. So a literal is kept as a fraction and
becomes a number of its operand's own arithmetic: one division, correctly rounded wherever division is.
Numbers that every arithmetic holds exactly (0, 1, 2, 0.5) need no literal.
"""

import operator
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from raytrace.language.namespace import namespace

__all__ = ["Literal", "literal"]


def _operator(operation: Callable) -> tuple[Callable, Callable]:
    """The methods of `operation` with a literal on its left and on its right."""

    def left(self, other):
        if isinstance(other, tuple):
            return NotImplemented  # a vector: it does its components one by one
        if isinstance(other, (Literal, int)):
            return Literal(operation(self.value, _exact(other)))
        return operation(self.like(other), other)

    def right(self, other):
        if isinstance(other, (tuple, int)):
            return NotImplemented if isinstance(other, tuple) else Literal(operation(other, self.value))
        return operation(other, self.like(other))

    return left, right


def _exact(number: "Literal | int") -> Fraction:
    return number.value if isinstance(number, Literal) else Fraction(number)


class Literal:
    """An exact rational number that takes on the arithmetic of the array it meets.

    Among literals and integers arithmetic is exact.
    """

    # NumPy's operators then leave the operation to this class.
    __array_ufunc__ = None
    __slots__ = ("value",)

    def __init__(self, value: Fraction):
        self.value = value

    def like(self, operand: Any) -> Any:
        """This number in the arithmetic of the array `operand`, of shape ().

        The namespace's own function `rational` gives it, where there is one: what a compiler may make of a literal.
        """
        xp = namespace(operand)
        if hasattr(xp, "rational"):
            return xp.rational(self.value)
        numerator, denominator = (xp.asarray(float(n), dtype=operand.dtype) for n in self.value.as_integer_ratio())
        return numerator / denominator

    __add__, __radd__ = _operator(operator.add)
    __sub__, __rsub__ = _operator(operator.sub)
    __mul__, __rmul__ = _operator(operator.mul)
    __truediv__, __rtruediv__ = _operator(operator.truediv)

    def __repr__(self) -> str:
        return f"literal({str(self.value)!r})"


def literal(text: str) -> Literal:
    """The number written in `text`, exactly: a decimal (``"2.51"``, ``"1e-3"``) or a fraction (``"5/11"``)."""
    return Literal(Fraction(text))
