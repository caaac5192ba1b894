"""Which engine is running the shader: it gives the control words and some functions their meaning."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

__all__ = ["engine", "running"]

_engine: ContextVar[Any] = ContextVar("raytrace_engine", default=None)


@contextmanager
def running(engine: Any) -> Iterator[None]:
    """Within this context `engine` (`raytrace.shader.control.Engine`) runs the shader."""
    token = _engine.set(engine)
    try:
        yield
    finally:
        _engine.reset(token)


def engine() -> Any:
    """The engine that is running, or ``None``."""
    return _engine.get()
