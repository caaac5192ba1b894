"""Four words of control flow, and the engine that decides what they become.

| in the shader            | in GLSL      |
|--------------------------|--------------|
| ``@step`` on a function  | a call       |
| ``branch(c, a, b, ...)`` | ``if / else``|
| ``each(items, ...)``     | ``for``      |
| ``at(items, index)``     | ``items[i]`` |
| ``summed(n, f, a, ...)`` | ``for (k = 0; k < n; k++) a += f(k, ...)`` |

The shader says what depends on what; an engine decides what is computed where: every pixel, only those
concerned, or nothing at all for a block of pixels that does not need it. `Engine` itself is the plainest one
and runs on any conforming array type: both sides of every branch, then a selection. The backends have their own.

Bodies receive planes as arguments, never by closure: an engine may hand them a part of each plane. Uniforms
(arrays of shape ()) and lists of items may be closed over.
"""

from collections.abc import Callable
from functools import wraps
from typing import Any

from raytrace.language.engine import Engine, engine, running
from raytrace.language.tree import Numbers, count
from raytrace.language.types import Array

__all__ = ["Engine", "Numbers", "at", "branch", "count", "detach", "each", "running", "step", "summed"]


def step(function: Callable) -> Callable:
    """Marks a step of the shader: a function of planes that an engine may run as a kernel of its own."""

    @wraps(function)
    def call(*args):
        return engine().step(function, args)

    return call


def branch(condition: Array, then: Callable, other: Callable, *args: Any) -> Any:
    """``condition ? then(*args) : other(*args)`` for every pixel.

    `args` are planes of the condition's shape, scalars of shape (), or structures of them. Both sides return
    the same structure. A side may see only the pixels concerned, or not be called at all.
    """
    return engine().branch(condition, then, other, args)


def each(items: Any, body: Callable, start: Any, *args: Any, unroll: bool = True) -> Any:
    """``for`` over `items`, a structure of arrays of shape (n,): ``state = body(state, i, item, *args)``.

    Where the state is a `Hit`, the item of its index alone made it: an engine that cannot differentiate the loop
    runs the body of that one item again instead. With `unroll` an engine that compiles may write the body out for
    each item; without, the body is too large for that.
    """
    return engine().each(items, body, start, args, unroll)


def summed(number: Array, term: Callable, start: Any, *args: Any) -> Any:
    """`start` and the sum of ``term(k, *args)`` for the whole numbers k below `number`, a plane: few pixels have any.

    start: a plane or a structure of planes, as a term is. k: a plane of whole numbers.
    """
    return engine().summed(number, term, start, args)


def at(items: Any, index: Array) -> Any:
    """``items[index]`` for every pixel; any item where there is none of that index."""
    return engine().at(items, index)


def detach(x: Array) -> Array:
    """`x` as a constant: equal in value, without derivative."""
    return engine().detach(x)
