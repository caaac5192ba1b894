"""Uniform blocks taken apart: each member becomes a uniform, so that it is bound by its name as any other is.

A block says where its numbers lie in a buffer. A shader cannot tell whether they come from there.
"""

import re

from raytrace.errors import InputError

__all__ = ["without_blocks"]

_BLOCK = re.compile(
    r"(?:layout\s*\([^)]{0,200}\)\s*)?"
    r"\b(uniform|buffer)\s+(?:(?:readonly|writeonly|coherent|restrict|volatile)\s+)*(\w+)\s*\{([^{}]*)\}([^;{}]*);"
)
_LAYOUT = re.compile(r"layout\s*\([^)]{0,200}\)")
_MEMBER = re.compile(r"(\s*)([^;]*);")


def without_blocks(name: str, code: str) -> str:
    """Return GLSL whose uniform blocks are uniforms, line by line the same; `code` has no comments.

    A block with an instance's name becomes a struct of that name.

    Raises:
        InputError: it has a storage buffer, for which a scene has nothing. `name` begins the message.
    """
    if "{" not in code or not re.search(r"\b(?:uniform|buffer)\b", code):
        return code

    def apart(block: re.Match) -> str:
        kind, title, body, instance = block.groups()
        if kind == "buffer":
            line = code.count("\n", 0, block.start(1)) + 1
            raise InputError(
                f"{name}:{line}: buffer {title}: a storage buffer cannot be given; use uniforms, as 'uniform vec3 eye'"
            )
        body = _LAYOUT.sub("", body)
        # What stood on lines of its own stays there.
        breaks = "\n" * (block[0].count("\n") - body.count("\n") - instance.count("\n"))
        if instance.strip():
            return f"struct {title} {breaks}{{{body}}}; uniform {title} {instance};"
        return breaks + _MEMBER.sub(r"\1uniform \2;", body) + instance

    return _BLOCK.sub(apart, code)
