"""One of two numbers for every pixel."""

from functools import partial
from typing import Any

from raytrace.language.jet import Jet
from raytrace.language.namespace import lift, namespace
from raytrace.language.tree import array_map
from raytrace.language.types import Array

__all__ = ["maximum", "minimum", "select"]


def select(condition: Array, then: Any, other: Any) -> Any:
    """`then` where `condition` holds, else `other`: planes, scalars, or equal structures of them."""
    return array_map(partial(_selected, condition), then, other)


def _selected(condition: Array, a: Any, b: Any) -> Any:
    jet = next((x for x in (a, b) if isinstance(x, Jet)), None)
    if jet is not None:
        return namespace(jet).where(condition, a, b)
    like = a if hasattr(a, "__array_namespace__") else b
    return namespace(condition).where(condition, lift(a, like), lift(b, like))


def minimum(a: Any, b: Any) -> Any:
    """The smaller of two numbers, GLSL's ``min``; of a vector and a number, each component's."""
    return array_map(lambda a: namespace(a).minimum(a, lift(b, a)), a)


def maximum(a: Any, b: Any) -> Any:
    """The larger of two numbers, GLSL's ``max``; of a vector and a number, each component's."""
    return array_map(lambda a: namespace(a).maximum(a, lift(b, a)), a)
