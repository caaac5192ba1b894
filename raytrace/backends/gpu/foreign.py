"""Somebody's own fragment shader, run on a graphics engine with the scene's uniforms bound by their names.

It is code that nobody has looked at: it runs in a process apart from that of our own drawings, with a time limit.
"""

from typing import Any

import numpy as np

from raytrace.backends.gpu.drawing import Drawing, ShaderProgram, ShaderRejected
from raytrace.backends.gpu.process import engine_process
from raytrace.backends.job import ForeignShader, Job
from raytrace.errors import EngineFailure, InputError
from raytrace.glsl.matching import matched
from raytrace.glsl.values import values_of
from raytrace.shader.uniforms import Uniforms

__all__ = ["ForeignRenderer"]


class ForeignRenderer:
    """A scene and a shader, ready to be rendered; see `raytrace.backends.Renderer`.

    Raises:
        InputError: the shader does not compile, has a uniform that says nothing to us, or asks for another input.
        EngineFailure: it does not end within its time, or crashes the engine.
    """

    def __init__(self, engine: str, uniforms: Uniforms, job: Job, shader: ForeignShader):
        self.job, self.shader = job, shader
        source = shader.source
        if engine == "webgl" and source.version != "300 es":
            raise InputError(f"{source.name}: backend webgl takes '#version 300 es', found '#version {source.version}'")
        self.process = engine_process(engine, foreign=True)
        self.program = ShaderProgram(source.vertex, source.fragment)
        size = job.frame.width, job.frame.height
        active = self._asked("active_uniforms", self.program)
        self.uniforms, self.textures = matched(
            source.name, active, values_of(uniforms), size, dict(self.shader.uniforms)
        )
        self._image: np.ndarray | None = None

    def about(self) -> dict[str, str]:
        return {"renderer": self.process.about(), "shader": self.shader.source.name}

    def compile(self, count: int) -> None:
        """It is compiled already."""

    def draw(self, first: int, count: int) -> dict[str, np.ndarray]:
        # As a whole: the shader may look at gl_FragCoord, which counts from the lower end of what is drawn.
        if self._image is None:
            width, height, _ = self.job.frame
            drawing = Drawing(self.program, width, height, 0, height, self.uniforms, self.textures)
            self._image = np.ascontiguousarray(self._asked("draw", drawing)[0, ..., :3])
        (name,) = self.job.keep
        return {name: self._image[first : first + count]}

    def _asked(self, method: str, argument: ShaderProgram | Drawing) -> Any:
        source = self.shader.source
        try:
            return getattr(self.process, method)(argument, self.shader.time_limit)
        except ShaderRejected as rejected:
            raise InputError(source.explained(str(rejected))) from None
        except EngineFailure as failure:
            raise EngineFailure(f"{source.name}: {failure}") from None
