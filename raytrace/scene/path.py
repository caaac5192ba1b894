"""Paths to a scene's values, as scene files and their messages write them: ``spheres[0].radius``."""

import re

__all__ = ["parts_of"]

_PART = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)((?:\[\d+\])*)")


def parts_of(path: str) -> list[str | int]:
    """Return ``["spheres", 0, "radius"]`` for ``spheres[0].radius``; an empty list if it is not a path."""
    parts: list[str | int] = []
    for name in path.split("."):
        match = _PART.fullmatch(name)
        if not match:
            return []
        parts += [match[1], *map(int, re.findall(r"\d+", match[2]))]
    return parts
