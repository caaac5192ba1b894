"""The ways to run the shader. A backend is imported when it is first used."""

from importlib import import_module
from typing import Any, NamedTuple, Protocol, runtime_checkable

from raytrace.backends.job import Job
from raytrace.shader.uniforms import Uniforms

__all__ = ["BACKENDS", "Renderer", "renderer"]


class Backend(NamedTuple):
    """Where a backend is, which arithmetics it has, and its formula for the sphere unless another is asked for.

    intersection: ``None`` for robust in float32 and textbook otherwise.
    runs_shaders: whether it can run somebody's own shader.
    """

    module: str
    dtypes: tuple[str, ...]
    intersection: str | None = None
    runs_shaders: bool = False


BACKENDS = {
    "jax": Backend("raytrace.backends.jax", ("float32", "float64")),
    "numpy": Backend("raytrace.backends.numpy", ("float32", "float64", "longdouble")),
    "opengl": Backend("raytrace.backends.opengl", ("float32",), "textbook", runs_shaders=True),
    "webgl": Backend("raytrace.backends.webgl", ("float32",), "textbook", runs_shaders=True),
}


@runtime_checkable
class Renderer(Protocol):
    """What a backend's class `Renderer` is: made of a scene's uniforms, it renders rows on demand.

    It is made of the uniforms, in double, and a `Job`.
    """

    def compile(self, count: int) -> None:
        """Prepares for drawing `count` rows at a time, so that the next `draw` only draws."""

    def about(self) -> dict[str, str]:
        """What an image's metadata should say of what ran: "renderer", a name and a version."""
        ...

    def draw(self, first: int, count: int) -> dict[str, Any]:
        """The steps that are kept, for `count` rows from row `first` on.

        Each is an array (count, width) or (count, width, components). Rows below the image are drawn as well.
        """
        ...


def renderer(backend: str, uniforms: Uniforms, job: Job) -> Renderer:
    """The renderer of the backend of that name.

    Raises:
        InputError: it cannot be had here, or not for this job.
    """
    if job.shader is not None:
        from raytrace.backends.gpu.foreign import ForeignRenderer

        return ForeignRenderer(backend, uniforms, job, job.shader)
    return import_module(BACKENDS[backend].module).Renderer(uniforms, job)
