"""Somebody's own fragment shader, as it was written."""

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from raytrace.errors import InputError
from raytrace.files import reason
from raytrace.glsl.shader import vertex_shader

__all__ = ["ShaderSource", "read_shader"]

_VERSION = re.compile(r"^[ \t]*#[ \t]*version[ \t]+([^\n]*?)[ \t]*$", re.MULTILINE)
_NO_CODE = re.compile(r"//[^\n]*|/\*.*?\*/|^[ \t]*#[^\n]*", re.DOTALL | re.MULTILINE)
_INPUT = re.compile(
    r"(?:^|(?<=[;}]))\s*(?:layout\s*\([^)]*\)\s*)?(?:smooth\s+|flat\s+|centroid\s+)*"
    r"in\s+(?:(?:lowp|mediump|highp)\s+)?(\w+)\s+(\w+)\s*;"
)
#: A place in a compiler's log: Mesa's ``0:12(5): error: ...``, ANGLE's ``ERROR: 0:12: ...``, NVIDIA's
#: ``0(12) : error C1503: ...``.
_ERROR = re.compile(r"(?:ERROR:\s*)?0[:(](\d+)\)?(?:\(\d+\))?\s*:\s*(?:error\b\s*\w*\s*:\s*)?(.*)", re.IGNORECASE)
_USUAL = "#version 300 es"


@dataclass(frozen=True)
class ShaderSource:
    """A fragment shader's name, for messages, and its text as it was read."""

    name: str
    text: str

    @property
    def version(self) -> str:
        """What stands behind ``#version``; ``300 es`` where that is missing."""
        found = _VERSION.search(self.text)
        return found[1] if found else "300 es"

    @property
    def fragment(self) -> str:
        """The text that is compiled."""
        return self.text if _VERSION.search(self.text) else f"{_USUAL}\n{self.text}"

    @cached_property
    def vertex(self) -> str:
        """The vertex shader that goes with it: it gives the texture coordinates under the name that is asked for.

        Raises:
            InputError: the shader asks for another input.
        """
        inputs = _INPUT.findall(_NO_CODE.sub(" ", self.text))
        wrong = [f"{kind} {name}" for kind, name in inputs if kind != "vec2"]
        if wrong or len(inputs) > 1:
            found = wrong[0] if wrong else ", ".join(f"{kind} {name}" for kind, name in inputs)
            raise InputError(
                f"{self.name}: input '{found}': a shader is given one input, "
                "the texture coordinates as 'in vec2 fragmentTextureCoordinates'"
            )
        return vertex_shader(self.version, *(name for _, name in inputs))

    def explained(self, log: str) -> str:
        """The first error of a compiler's log, in one line: file and line, what is wrong, the line itself."""
        errors = [(int(found[1]), found[2].strip()) for found in _ERROR.finditer(log)]
        if not errors:
            return f"{self.name}: {' '.join(log.split())}"
        added = self.fragment.count("\n") - self.text.count("\n")
        (line, message), *more = errors
        line -= added
        lines = self.text.splitlines()
        shown = f": {lines[line - 1].strip()}" if 0 < line <= len(lines) else ""
        return f"{self.name}:{line}: {message}{shown}" + (f" (and {len(more)} more)" if more else "")


def read_shader(path: str | Path) -> ShaderSource:
    """The shader in a file.

    Raises:
        InputError: the file cannot be read, or is no text.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a shader: not a text in UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason(error)}") from None
    return ShaderSource(str(path), text)
