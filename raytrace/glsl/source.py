"""Somebody's own fragment shader, as it was written."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from raytrace.errors import InputError
from raytrace.files import read_text
from raytrace.glsl.blocks import without_blocks
from raytrace.glsl.dialects import USUAL, dialect_of, implied_dialect, vertex_output, vertex_shader

__all__ = ["ShaderSource", "read_shader"]

#: A place in a compiler's log: Mesa's ``0:12(5): error: ...``, ANGLE's ``ERROR: 0:12: ...``, NVIDIA's
#: ``0(12) : error C1503: ...``.
_ERROR = re.compile(r"(?:ERROR:\s*)?0[:(](\d+)\)?(?:\(\d+\))?\s*:\s*(?:error\b\s*\w*\s*:\s*)?(.*)", re.IGNORECASE)
_MAIN_IMAGE = re.compile(r"\bvoid\s+mainImage\s*\(")
#: The uniforms that Shadertoy (shadertoy.com) declares in front of a shader.
_SHADERTOY = {
    "iResolution": "vec3",
    "iFrame": "int",
    **dict.fromkeys(("iTime", "iTimeDelta", "iFrameRate", "iSampleRate"), "float"),
    **dict.fromkeys(("iMouse", "iDate"), "vec4"),
    **dict.fromkeys((f"iChannel{n}" for n in range(4)), "sampler2D"),
}


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
        for number, words in self._directives():
            if words[0] == "version" and len(words) > 1:
                return number, " ".join(words[1:])
        return None

    @property
    def version(self) -> str:
        """What it is compiled as: what stands behind ``#version``, or what its words are of."""
        if self.directive is None:
            return implied_dialect(self.code)
        return dialect_of(self.directive[1]) or self.directive[1]

    @property
    def is_shadertoy(self) -> bool:
        """Whether it has Shadertoy's ``mainImage`` and no ``main``."""
        return bool(_MAIN_IMAGE.search(self.code)) and not re.search(r"\bmain\s*\(", self.code)

    @cached_property
    def head(self) -> str:
        """The lines that are compiled in front of the text; of GLSL ES, ``#version`` must be the first."""
        if self._misplaced:
            return ""
        lines = [f"#version {self.version}"]
        if self.is_shadertoy:
            lines += ["precision highp float; precision highp int;"]
            lines += [f"out vec4 {self._color};"] if not self._color.startswith("gl_") else []
            used = set(re.findall(r"\bi[A-Z]\w*", self.code)) - self.declared.keys()
            lines += [f"uniform {kind} {name};" for name, kind in _SHADERTOY.items() if name in used]
        return "".join(f"{line}\n" for line in lines)

    @cached_property
    def fragment(self) -> str:
        """The text that is compiled: `head`, and then line by line what was read.

        Raises:
            InputError: it has a storage buffer.
        """
        return self.head + self._body(self.text)

    @cached_property
    def fragment_code(self) -> str:
        """`fragment` without comments."""
        return self.head + self._body(self.code)

    @cached_property
    def vertex(self) -> str:
        """The vertex shader that goes with it: it gives the texture coordinates under the name that is asked for.

        Raises:
            InputError: the shader asks for another input.
        """
        return vertex_shader(self.version, vertex_output(self.name, self.code))

    @cached_property
    def declared(self) -> dict[str, str]:
        """The uniforms that the text declares, by name; what stands behind each: an array's brackets, a value."""
        found = {}
        for statement in re.split(r"[;{}]", self._apart):
            words = re.split(r"\buniform\b", statement)
            if len(words) < 2:
                continue
            kind = re.match(r"\s*(?:(?:lowp|mediump|highp)\s+)?\w+(\s+.*)", words[-1], re.DOTALL)
            for each in kind[1].split(",") if kind else ():
                name = re.match(r"\s*(\w+)\s*(.*)", each, re.DOTALL)
                if name:
                    found[name[1]] = name[2].strip()
        return found

    def check(self) -> None:
        """Check what a compiler would say in words of our own shader's, or not at all.

        Raises:
            InputError: it includes another file, is of no version of GLSL, or asks for what it cannot be given.
        """
        for number, words in self._directives():
            if words[0] == "include":
                raise InputError(f"{self.name}:{number + 1}: #include: GLSL has none; write that file's text here")
        if self.directive is not None and dialect_of(self.directive[1]) is None:
            number, found = self.directive
            raise InputError(
                f"{self.name}:{number + 1}: '#version {found}': is no version of GLSL; "
                f"that of WebGL2 is '#version {USUAL}'"
            )
        without_blocks(self.name, self.code)
        vertex_output(self.name, self.code)

    def explained(self, log: str, stage: str = "fragment") -> str:
        """The first error of a compiler's log, in one line: file and line, what is wrong, the line itself.

        stage: "fragment", or "vertex" or "link" for an error that is not in the text alone.
        """
        errors = [(int(found[1]), found[2].strip()) for found in _ERROR.finditer(log)]
        if stage == "vertex":
            said = errors[0][1] if errors else " ".join(log.split())
            return f"{self.name}: cannot be given its texture coordinates in '#version {self.version}': {said}"
        if not errors:
            return f"{self.name}: {' '.join(log.split())}"
        (line, message), *more = errors
        shown = self._line(line)
        said = f"{self.placed(line)}: {message}{f': {shown}' if shown else ''}"
        return said + (f" (and {len(more)} more)" if more else "")

    def placed(self, line: int) -> str:
        """Where a line of `fragment` stands in the file: its name and the number there."""
        return f"{self.name}:{line - self.head.count(chr(10))}"

    def _line(self, line: int) -> str:
        """The file's text of a line of `fragment`."""
        lines, line = self.text.split("\n"), line - self.head.count("\n")
        return lines[line - 1].strip() if 0 < line <= len(lines) else ""

    def _directives(self) -> Iterator[tuple[int, list[str]]]:
        """The lines that begin with ``#``: their numbers, from 0, and their words behind it."""
        for number, line in enumerate(self.code.split("\n")):
            if line.lstrip().startswith("#") and len(words := line.replace("#", " # ", 1).split()) > 1:
                yield number, words[1:]

    @cached_property
    def _apart(self) -> str:
        """`code` with its uniform blocks taken apart."""
        return without_blocks(self.name, self.code)

    @cached_property
    def _misplaced(self) -> bool:
        """Whether something stands before ``#version``: then the compiler is to say so of the text as it is."""
        return self.directive is not None and bool("".join(self.code.split("\n")[: self.directive[0]]).strip())

    def _body(self, text: str) -> str:
        """The lines of `text`, which is `text` or `code`, as they are compiled behind `head`."""
        if self._misplaced:
            return text
        if self._apart != self.code:
            text = self._apart
        if self.directive is not None:
            number = self.directive[0]
            lines = text.split("\n")
            if "/*" in lines[number]:
                lines = self.code.split("\n")  # the comment may end in another line
            text = "\n".join([*[""] * (number + 1), *lines[number + 1 :]])
        if self.is_shadertoy:
            text += f"\nvoid main(){{mainImage({self._color}, gl_FragCoord.xy);}}\n"
        return text

    @property
    def _color(self) -> str:
        return "gl_FragColor" if self.version == "100" else "raytraceColor"


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
        InputError: the file cannot be read, is no text, or `ShaderSource.check` refuses it.
    """
    try:
        source = ShaderSource(str(path), read_text(path, "a shader"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    source.check()
    return source
