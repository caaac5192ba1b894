"""The operands' array namespace: what makes the shader independent of any array library.

An array type that is to carry the shader needs ``__array_namespace__`` and the functions of the Python array API
standard (2023.12) that `raytrace.language.glsl` names, and operators that leave types they do not know to the other
operand (``NotImplemented``), as Python's data model asks. Nothing asks an array for its truth.
"""

from typing import Any

from raytrace.language.types import Array

__all__ = ["Unlimited", "constant", "lift", "namespace"]


class Unlimited:
    """What ``finfo`` gives for an arithmetic in which no number is the smallest."""

    smallest_normal = 0


def namespace(*operands: Any) -> Any:
    """The array namespace of the first operand that has one.

    Raises:
        TypeError: none of the operands is an array.
    """
    for operand in operands:
        find = getattr(operand, "__array_namespace__", None)
        if find is not None:
            return find()
    kinds = ", ".join(type(operand).__name__ for operand in operands)
    raise TypeError(f"expected at least one array with __array_namespace__, found {kinds}")


def lift(value: Any, like: Array) -> Array:
    """`value` (an array, a literal or a Python number) in the arithmetic of the array `like`.

    Python numbers must not meet arrays in ``where``: the result would be float64 whatever the arrays are.
    """
    if hasattr(value, "__array_namespace__"):
        return value
    if hasattr(value, "like"):
        return value.like(like)
    return constant(value, like)


def constant(value: Any, like: Array, dtype: str | None = None) -> Array:
    """A number of shape () in the arithmetic of the array `like`, or of the namespace's type named `dtype`."""
    xp = namespace(like)
    return xp.asarray(value, dtype=like.dtype if dtype is None else getattr(xp, dtype))
