"""Whether an engine has cut a shader's loops short.

Mesa's llvmpipe lets all loops of a shader take 65,535 turns together. From then on it leaves each loop after its first
turn, without a word, and the image is another. Two signs are put into the shader's text:
- a loop of two turns behind its ``main``: where it takes one, the limit was reached, and the pixel is discarded;
- in the head of each loop, a count of its turns, which tells the loop that has taken most of them.
"""

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

__all__ = ["COUNTED", "TURNS", "Loop", "counted", "loops", "watched"]

#: The uniform that asks for the last loop's turns: 2, or 0 for none.
TURNS = "raytraceTurns"
#: The uniform that asks for a loop, by its number: pixels in which that took the most turns are discarded.
COUNTED = "raytraceLoop"

_MAIN = re.compile(r"\bvoid\s+main\s*\(")
_HEAD = re.compile(r"\b(for|while)\s*\(")
#: True at every pixel, which no compiler knows: it would leave out what stands behind an endless loop.
_TRUE = "gl_FragCoord.x > -1."
_WATCH = f"""
uniform int {TURNS};
void main(){{
    raytraceMain();
    int turns = 0;
    for(int i = 0; i < {TURNS} + int(gl_FragCoord.x < 0.); i++) turns++; // a sum that no compiler knows
    if(turns < {TURNS}) discard;
}}
"""


class Loop(NamedTuple):
    """A loop in a text: the line of its head, from 1; where its condition begins and ends."""

    line: int
    begin: int
    end: int


def watched(fragment: str) -> str | None:
    """Return a fragment shader that discards the pixels in which its loops were cut, if `TURNS` is 2.

    fragment: without comments. ``None`` if its ``main`` cannot be found.
    """
    if not _MAIN.search(fragment):
        return None
    return _MAIN.sub("void raytraceMain(", _conditions(fragment, lambda number: _TRUE)) + _WATCH


def counted(fragment: str) -> str | None:
    """Return a fragment shader that discards the pixels in which the loop number `COUNTED` took the most turns.

    fragment: without comments. ``None`` if its ``main`` or its loops cannot be found.
    """
    found = loops(fragment)
    if not found or not _MAIN.search(fragment):
        return None
    body = _conditions(fragment, lambda number: f"raytraceTurn({number}) && {_TRUE}")
    # Of 32 bits: GLSL ES gives an int 16, unless it is told.
    count = f"highp int raytraceTurnsOf[{len(found)}]; bool raytraceTurn(int i){{raytraceTurnsOf[i]++; return true;}}"
    ask = (
        f"\nuniform int {COUNTED};\nvoid main(){{\n"
        + "".join(f"raytraceTurnsOf[{i}] = 0;" for i in range(len(found)))
        + "\nraytraceMain();\nint most = 0;\n"
        + "".join(f"if(raytraceTurnsOf[{i}] > raytraceTurnsOf[most]) most = {i};\n" for i in range(len(found)))
        + f"if(most == {COUNTED}) discard;\n}}\n"
    )
    head, rest = _behind_directives(_MAIN.sub("void raytraceMain(", body))
    return head + count + rest + ask


def _conditions(fragment: str, also: Callable[[int], str]) -> str:
    """The text whose loops go on only if `also`, of the loop's number, is true, too."""
    text, place = [], 0
    for number, loop in enumerate(loops(fragment)):
        condition = fragment[loop.begin : loop.end].strip() or "true"
        text += [fragment[place : loop.begin], f" {also(number)} && ({condition})"]
        place = loop.end
    return "".join([*text, fragment[place:]])


def loops(code: str) -> list[Loop]:
    """Return the loops of a text without comments."""
    return list(_loops(code))


def _loops(code: str) -> Iterator[Loop]:
    heads = list(_HEAD.finditer(code))
    # No loop stands in another one's head.
    limits = [*(head.start() for head in heads[1:]), len(code)]
    for head, limit in zip(heads, limits, strict=False):
        depth, semicolons, end = 1, [], head.end()
        while depth and end < limit:
            character = code[end]
            depth += {"(": 1, ")": -1}.get(character, 0)
            if character == ";" and depth == 1:
                semicolons.append(end)
            end += 1
        line = code.count("\n", 0, head.start()) + 1
        if head[1] == "while" and not depth and not semicolons:
            yield Loop(line, head.end(), end - 1)
        elif not depth and len(semicolons) == 2:
            yield Loop(line, semicolons[0] + 1, semicolons[1])


def _behind_directives(text: str) -> tuple[str, str]:
    """The text up to the last line that must come first, and the rest: a declaration may stand between them."""
    lines = text.split("\n")
    first = [i for i, line in enumerate(lines) if re.match(r"\s*#\s*(version|extension)\b", line)]
    end = (first[-1] if first else -1) + 1
    return "\n".join(lines[:end]) + "\n", "\n".join(lines[end:])
