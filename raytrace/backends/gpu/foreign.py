"""Somebody's own fragment shader, run on a graphics engine with the scene's uniforms bound by their names.

It is code that nobody has looked at: it runs in a process apart from that of our own drawings, with limits on its time
and its memory.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from raytrace.backends.gpu.drawing import Drawing, ShaderProgram, ShaderRejected
from raytrace.backends.gpu.process import engine_process
from raytrace.backends.job import ForeignShader, Job
from raytrace.errors import EngineFailure, InputError
from raytrace.glsl import turns
from raytrace.glsl.matching import matched
from raytrace.glsl.values import values_of
from raytrace.shader.uniforms import Uniforms

__all__ = ["ForeignRenderer"]

#: The versions of GLSL that WebGL2 takes.
_WEBGL = ("300 es", "100")
#: The alpha of pixels that a shader did not write, which none will write by chance.
_UNWRITTEN = -65536.5


class ForeignRenderer:
    """A scene and a shader, ready to be rendered; see `raytrace.backends.Renderer`.

    Raises:
        InputError: the shader does not compile, has a uniform that says nothing to us, or asks for another input.
        EngineFailure: it does not end within its time, takes too much memory, or crashes the engine.
    """

    def __init__(self, engine: str, uniforms: Uniforms, job: Job, shader: ForeignShader):
        self.job, self.shader = job, shader
        source = shader.source
        if engine == "webgl" and source.version not in _WEBGL:
            found = "no #version and no precision" if source.directive is None else f"'#version {source.directive[1]}'"
            raise InputError(
                f"{source.name}: backend webgl takes '#version 300 es', found {found}; "
                "change the first line, or use --backend opengl"
            )
        self.process = engine_process(engine, foreign=True)
        self.process.about()  # the engine's start takes none of the shader's time
        self.program = ShaderProgram(source.vertex, source.fragment)
        size = job.frame.width, job.frame.height
        active = self._asked("active_uniforms", self.program)
        self.uniforms, self.textures = matched(
            source.name, active, values_of(uniforms), size, dict(self.shader.uniforms), source.declared
        )
        self._image: np.ndarray | None = None

    def about(self) -> dict[str, str]:
        return {"renderer": self.process.about(), "shader": self.shader.source.name}

    def compile(self, count: int) -> None:
        """It is compiled already."""

    def draw(self, first: int, count: int) -> dict[str, np.ndarray]:
        # As a whole: the shader may look at gl_FragCoord, which counts from the lower end of what is drawn.
        if self._image is None:
            self._image = np.ascontiguousarray(self._drawn()[..., :3])
        (name,) = self.job.keep
        return {name: self._image[first : first + count]}

    def _drawn(self) -> np.ndarray:
        """The image, (height, width, RGBA).

        Raises:
            EngineFailure: of the shader's loops not all were run to their ends, which OpenGL does not say.
        """
        width, height, _ = self.job.frame
        drawing = Drawing(self.program, width, height, 0, height, self.uniforms, self.textures)
        watched = turns.watched(self.shader.source.fragment_code) if self.process.name == "opengl" else None
        if watched is None or not self._compiles(watched):
            return self._asked("draw", drawing)[0]
        drawing = replace(drawing, program=ShaderProgram(self.program.vertex, watched), alpha=_UNWRITTEN)
        image = self._pass(drawing, 2)
        unwritten = _unwritten(image)
        if unwritten.any():
            # By the shader's own `discard`, or because loops were cut: without the loop behind it only the first.
            cut = unwritten & ~_unwritten(self._pass(drawing, 0))
            if cut.any():
                raise EngineFailure(self._said_of_loops(drawing, cut))
        return image

    def _said_of_loops(self, drawing: Drawing, cut: np.ndarray) -> str:
        """The line of the loop that has taken the most turns, in the first of the pixels where loops were cut."""
        source = self.shader.source
        text, found = turns.counted(source.fragment_code), turns.loops(source.fragment_code)
        line = None
        if text is not None and self._compiles(text):
            y, x = map(int, np.argwhere(cut)[0])
            asked = tuple({turns.COUNTED: np.array(i, np.int32)} for i in range(len(found)))
            program = ShaderProgram(self.program.vertex, text)
            images = self._asked("draw", replace(drawing, program=program, passes=asked, only=(x, y)))
            most = np.flatnonzero(_unwritten(images[:, y, x]))
            line = found[int(most[0])].line if len(most) else None
        place = source.name if line is None else source.placed(line)
        return (
            f"{place}: this loop never ends, or takes too long: {self.process.about().split(' ')[0]} leaves all loops "
            "of a pixel after 65535 turns together (backend webgl has no such limit)"
        )

    def _pass(self, drawing: Drawing, last_turns: int) -> np.ndarray:
        added = {turns.TURNS: np.array(last_turns, np.int32)}
        return self._asked("draw", replace(drawing, uniforms=drawing.uniforms | added))[0]

    def _compiles(self, fragment: str) -> bool:
        """Whether a shader to which something was added still compiles: what was added may not go with it."""
        try:
            self._asked("active_uniforms", ShaderProgram(self.program.vertex, fragment))
        except InputError:
            return False
        return True

    def _asked(self, method: str, argument: ShaderProgram | Drawing) -> Any:
        source = self.shader.source
        try:
            return getattr(self.process, method)(argument, self.shader.time_limit)
        except ShaderRejected as rejected:
            raise InputError(source.explained(str(rejected), rejected.stage)) from None
        except EngineFailure as failure:
            raise EngineFailure(f"{source.name}: {failure}") from None


def _unwritten(image: np.ndarray) -> np.ndarray:
    """The pixels of an image (..., RGBA) that have the alpha of those that were not written."""
    return image[..., 3] == np.float32(_UNWRITTEN)
