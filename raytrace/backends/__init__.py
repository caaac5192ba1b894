"""The ways to run the shader. A backend is imported when it is first used."""

from importlib import import_module
from typing import Any, NamedTuple, Protocol, runtime_checkable

__all__ = ["BACKENDS", "Renderer", "renderer"]


class Backend(NamedTuple):
    """Where a backend is and which arithmetics it has."""

    module: str
    dtypes: tuple[str, ...]


BACKENDS = {
    "jax": Backend("raytrace.backends.jax", ("float32", "float64")),
    "numpy": Backend("raytrace.backends.numpy", ("float32", "float64", "longdouble")),
}


@runtime_checkable
class Renderer(Protocol):
    """What a backend's class `Renderer` is: made of a scene's uniforms, it renders rows on demand.

    It is called with the uniforms in double, the program, the frame, the names of the steps to keep, the dtype,
    `exact_inputs` (without it, every uniform is rounded once to float32 before it is carried in the dtype) and an
    engine, where it is not the backend's own.
    """

    def compile(self, count: int) -> None:
        """Prepares for drawing `count` rows at a time, so that the next `draw` only draws."""

    def draw(self, first: int, count: int) -> dict[str, Any]:
        """The steps that are kept, for `count` rows from row `first` on.

        Each is an array (count, width) or (count, width, components). Rows below the image are drawn as well.
        """


def renderer(backend: str, *args: Any, **options: Any) -> Renderer:
    """The renderer of the backend of that name."""
    return import_module(BACKENDS[backend].module).Renderer(*args, **options)
