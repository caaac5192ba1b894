"""Which engine is running the shader: it gives the control words and some functions their meaning."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from raytrace.language.namespace import lift, namespace
from raytrace.language.selection import maximum, minimum, select
from raytrace.language.tree import count, tree_map
from raytrace.language.types import Array

__all__ = ["Engine", "engine", "running"]


class Engine:
    """The plain engine: everything is computed everywhere. Others override what they can do better."""

    def step(self, function: Callable, args: tuple) -> Any:
        return function(*args)

    def branch(self, condition: Array, then: Callable, other: Callable, args: tuple) -> Any:
        return select(condition, then(*args), other(*args))

    def summed(self, number: Array, term: Callable, start: Any, args: tuple) -> Any:
        xp = namespace(number)
        total = start
        for k in range(int(xp.max(number))):
            one = term(xp.full_like(number, k), *args)
            total = tree_map(lambda total, one, k=k: select(number > k, total + one, total), total, one)
        return total

    def each(self, items: Any, body: Callable, start: Any, args: tuple, unroll: bool) -> Any:
        state = start
        for i in range(count(items)):
            state = body(state, i, self.item(items, i), *args)
        return state

    def item(self, items: Any, i: Any) -> Any:
        """Return item `i`, one number for all pixels."""
        return tree_map(lambda leaf: leaf[i], items)

    def at(self, items: Any, index: Array) -> Any:
        # The standard's `take` has one-dimensional indices, all of which exist.
        xp = namespace(index)
        flat = xp.reshape(minimum(maximum(index, 0), count(items) - 1), (-1,))
        return tree_map(lambda leaf: xp.reshape(xp.take(leaf, flat, axis=0), index.shape), items)

    def detach(self, x: Array) -> Array:
        return x

    def exp2(self, x: Array) -> Array:
        xp = namespace(x)
        # The array API standard has no exp2; NumPy and JAX do.
        return xp.exp2(x) if hasattr(xp, "exp2") else xp.pow(lift(2, x), x)

    def log2(self, x: Array) -> Array:
        return namespace(x).log2(x)


_PLAIN = Engine()
_engine: ContextVar[Engine] = ContextVar("raytrace_engine", default=_PLAIN)


@contextmanager
def running(engine: Engine) -> Iterator[None]:
    """Within this context `engine` runs the shader."""
    token = _engine.set(engine)
    try:
        yield
    finally:
        _engine.reset(token)


def engine() -> Engine:
    """The engine that is running: the plain one, where none was chosen."""
    return _engine.get()
