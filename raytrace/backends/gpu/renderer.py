"""A scene, as the assignment's GLSL, rendered by a graphics engine."""

from collections.abc import Iterator

import numpy as np

from raytrace.backends.gpu.drawing import Drawing, ShaderProgram
from raytrace.backends.gpu.process import engine_process
from raytrace.backends.job import Job
from raytrace.glsl import vertex_shader
from raytrace.glsl.bindings import bindings
from raytrace.glsl.choices import choices_of
from raytrace.glsl.shader import shader_text
from raytrace.glsl.values import values_of
from raytrace.shader.main import COMPONENTS, Steps
from raytrace.shader.uniforms import Uniforms

__all__ = ["GlslRenderer"]

#: Intersection tests of one draw call, so that none takes longer than a few seconds, even on a CPU.
TESTS = 1 << 30


class GlslRenderer:
    """The base of both backends' `Renderer`; see `raytrace.backends.Renderer`."""

    #: The engine's name.
    engine: str

    def __init__(self, uniforms: Uniforms, job: Job):
        width, height, samples = job.frame
        self.job = job
        choices = choices_of(
            uniforms,
            job.program,
            data="uniforms",
            output=job.keep[0] if job.keep in (("display",), ("linear",)) else "steps",
            samples=samples,
            size=(width, height),
        )
        values = values_of(uniforms)
        self.program = ShaderProgram(vertex_shader(), shader_text(choices, values))
        self.uniforms, self.textures = bindings(choices, values)
        tests = width * samples**2 * (2 * choices.spheres + choices.planes + 8)
        self.rows = max(1, TESTS // tests)
        self.process = engine_process(self.engine)

    def about(self) -> dict[str, str]:
        return {"renderer": self.process.about()}

    def compile(self, count: int) -> None:
        self.process.active_uniforms(self.program)

    def draw(self, first: int, count: int) -> dict[str, np.ndarray]:
        images = {name: _empty(name, count, self.job.frame.width) for name in self.job.keep}
        for start in range(0, count, self.rows):
            rows = min(self.rows, count - start)
            for (name, image), drawn in zip(images.items(), self._drawn(first + start, rows), strict=True):
                image[start : start + rows] = drawn[..., : COMPONENTS[name]].reshape(rows, *image.shape[1:])
        return images

    def _drawn(self, first: int, count: int) -> Iterator[np.ndarray]:
        """Every step that is kept, (count, width, 4)."""
        return iter(self.process.draw(self.drawing(first, count)))

    def drawing(self, first: int, count: int) -> Drawing:
        """Return what the engine is asked for `count` rows from row `first` on: a pass for each step that is kept."""
        width, height, _ = self.job.frame
        numbers = {name: i for i, name in enumerate(Steps._fields)}
        passes = tuple({"shownStep": np.array(numbers[name], np.int32)} for name in self.job.keep)
        return Drawing(self.program, width, height, first, count, self.uniforms, self.textures, passes)


def _empty(name: str, height: int, width: int) -> np.ndarray:
    components = COMPONENTS[name]
    shape = (height, width) if components == 1 else (height, width, components)
    return np.empty(shape, np.int32 if name == "index" else np.float32)
