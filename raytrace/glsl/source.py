"""Somebody's own fragment shader, as it was written."""

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from raytrace.errors import InputError
from raytrace.files import read_text
from raytrace.glsl.shader import vertex_shader

__all__ = ["ShaderSource", "read_shader"]

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

    @cached_property
    def code(self) -> str:
        """The text without its comments, of which the line breaks stay."""
        return without_comments(self.text)

    @cached_property
    def directive(self) -> tuple[int, str] | None:
        """The number of the line with ``#version``, and what stands behind it; ``None`` where there is none."""
        for number, line in enumerate(self.code.split("\n")):
            words = line.replace("#", " # ", 1).split()
            if words[:2] == ["#", "version"] and len(words) > 2:
                return number, " ".join(words[2:])
        return None

    @property
    def version(self) -> str:
        """What stands behind ``#version``; ``300 es`` where that is missing."""
        return "300 es" if self.directive is None else self.directive[1]

    @cached_property
    def fragment(self) -> str:
        """The text that is compiled: ``#version`` comes first, as GLSL ES wants it."""
        if self.directive is None:
            return f"{_USUAL}\n{self.text}"
        number, version = self.directive
        if "".join(self.code.split("\n")[:number]).strip():
            return self.text  # the compiler says that something stands before it
        return "\n".join([f"#version {version}", *self.text.split("\n")[number + 1 :]])

    @cached_property
    def vertex(self) -> str:
        """The vertex shader that goes with it: it gives the texture coordinates under the name that is asked for.

        Raises:
            InputError: the shader asks for another input.
        """
        code = "\n".join(line for line in self.code.split("\n") if not line.lstrip().startswith("#"))
        inputs = _INPUT.findall(code)
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


def without_comments(text: str) -> str:
    """Return GLSL with a space for each comment, in time that grows with its length; line breaks stay."""
    parts, place = [], 0
    while (start := text.find("/", place)) >= 0:
        opening = text[start : start + 2]
        if opening not in ("//", "/*"):
            parts.append(text[place : start + 1])
            place = start + 1
            continue
        end = text.find("\n", start) if opening == "//" else text.find("*/", start + 2)
        end = len(text) if end < 0 else end if opening == "//" else end + 2
        parts += [text[place:start], " ", "\n" * text.count("\n", start, end)]
        place = end
    return "".join([*parts, text[place:]])


def read_shader(path: str | Path) -> ShaderSource:
    """The shader in a file.

    Raises:
        InputError: the file cannot be read, or is no text.
    """
    try:
        return ShaderSource(str(path), read_text(path, "a shader"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
