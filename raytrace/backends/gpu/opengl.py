"""OpenGL, headless: moderngl on EGL, which is Mesa's llvmpipe where there is no GPU."""

import re
import sys
from collections.abc import Generator
from functools import lru_cache
from typing import Any

import numpy as np

from raytrace.backends.gpu.drawing import (
    CORNERS,
    ActiveUniform,
    Drawing,
    ShaderProgram,
    ShaderRejected,
    Unavailable,
)

__all__ = ["OpenGL"]

#: OpenGL's numbers of the types that a uniform may have.
_TYPES = {
    0x1406: "float",
    0x8B50: "vec2",
    0x8B51: "vec3",
    0x8B52: "vec4",
    0x1404: "int",
    0x8B53: "ivec2",
    0x8B54: "ivec3",
    0x8B55: "ivec4",
    0x1405: "uint",
    0x8B56: "bool",
    0x8B57: "bvec2",
    0x8B58: "bvec3",
    0x8B59: "bvec4",
    0x8B5A: "mat2",
    0x8B5B: "mat3",
    0x8B5C: "mat4",
    0x8B5E: "sampler2D",
}


class OpenGL:
    """An OpenGL context and the programs compiled on it."""

    def __init__(self) -> None:
        try:
            import moderngl
        except ImportError:
            raise Unavailable("needs moderngl: pip install moderngl") from None
        options: dict[str, Any] = {"backend": "egl"} if sys.platform == "linux" else {}
        try:
            self._context = moderngl.create_standalone_context(**options)
        except Exception as error:
            reason = " ".join(str(error).split())
            raise Unavailable(f"needs EGL and a driver: apt-get install libegl1 libgl1-mesa-dri ({reason})") from None
        self._moderngl = moderngl
        self._compiled = lru_cache(maxsize=32)(self._compile)

    def about(self) -> str:
        """The real renderer: its name, and OpenGL's version on it."""
        info = self._context.info
        return f"{info['GL_RENDERER']}; OpenGL {info['GL_VERSION']}"

    def active_uniforms(self, program: ShaderProgram) -> list[ActiveUniform]:
        """The uniforms that the program uses."""
        members = self._compiled(program)
        uniforms = [members[name] for name in members]
        for member in uniforms:
            if isinstance(member, self._moderngl.UniformBlock | self._moderngl.StorageBlock):
                raise ShaderRejected(
                    f"error: block {member.name}: takes its numbers from a buffer; use uniforms", "link"
                )
        return [
            # An array of numbers is called by its first element's name or by its own, as the driver likes.
            ActiveUniform(re.sub(r"\[0\]$", "", uniform.name), _type(uniform), uniform.array_length)
            for uniform in uniforms
            if isinstance(uniform, self._moderngl.Uniform)
        ]

    def draw(self, drawing: Drawing, out: np.ndarray) -> None:
        """Draw into `out`, an array of `drawing.shape`."""
        for image, target in zip(out, self.drawn(drawing), strict=True):
            target.read_into(image, components=4, dtype="f4")

    def drawn(self, drawing: Drawing) -> Generator[Any, None, None]:
        """Draw pass after pass; after each its framebuffer, moderngl's, in which the engine may still be drawing."""
        context, program = self._context, self._compiled(drawing.program)
        limits = context.info["GL_MAX_VIEWPORT_DIMS"]
        if drawing.width > limits[0] or drawing.height > limits[1]:
            raise Unavailable(f"draws at most {limits[0]}x{limits[1]} pixels, found {drawing.width}x{drawing.height}")
        target = context.framebuffer([context.renderbuffer((drawing.width, drawing.count), 4, dtype="f4")])
        textures = {name: self._texture(texels) for name, texels in drawing.textures.items()}
        corners = context.buffer(CORNERS)
        # GLSL ES 1.00 takes them from a buffer, what is newer counts the vertices.
        quad = context.vertex_array(program, [(corners, "2f", "corner")] if "corner" in program else [])
        try:
            samplers = {name: np.array(unit, np.int32) for unit, name in enumerate(textures)}
            for unit, texture in enumerate(textures.values()):
                texture.use(unit)
            for changed in drawing.passes:
                self._set(program, drawing.uniforms | samplers | changed)
                target.use()
                context.viewport = drawing.viewport
                target.clear(alpha=drawing.alpha, viewport=(0, 0, drawing.width, drawing.count))
                context.scissor = drawing.box
                quad.render(self._moderngl.TRIANGLE_STRIP, vertices=4)
                context.scissor = None
                yield target
        finally:
            for resource in (quad, corners, target, *target.color_attachments, *textures.values()):
                resource.release()

    def finish(self) -> None:
        """Wait until everything is drawn."""
        self._context.finish()

    def close(self) -> None:
        """Nothing to do: the context ends with the process."""

    def _compile(self, program: ShaderProgram) -> Any:
        try:
            return self._context.program(vertex_shader=program.vertex, fragment_shader=program.fragment)
        except self._moderngl.Error as error:
            stage = re.search(r"^(vertex|fragment)_shader$", str(error), re.MULTILINE)
            raise ShaderRejected(str(error), stage[1] if stage else "link") from None

    def _texture(self, texels: np.ndarray) -> Any:
        height, width, _ = texels.shape
        texture = self._context.texture((width, height), 4, np.ascontiguousarray(texels, np.float32), dtype="f4")
        texture.filter = self._moderngl.NEAREST, self._moderngl.NEAREST
        return texture

    def _set(self, program: Any, uniforms: dict[str, np.ndarray]) -> None:
        for name, value in uniforms.items():
            uniform = program.get(name, None)
            if uniform is not None:
                uniform.write(np.ascontiguousarray(value))


def _type(uniform: Any) -> str:
    return _TYPES.get(uniform.gl_type, f"type 0x{uniform.gl_type:x}")
