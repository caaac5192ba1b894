"""Numbers as GLSL writes them."""

from typing import Any

import numpy as np

__all__ = ["number", "vector"]


def number(x: Any) -> str:
    """The shortest decimal that is the float32 nearest to `x`, always with a point or an exponent."""
    rounded = np.float32(x)
    size = abs(rounded)
    if size == 0 or 1e-4 <= size < 1e6:
        return np.format_float_positional(rounded, unique=True, trim="0")
    return np.format_float_scientific(rounded, unique=True, trim="-", exp_digits=1).replace("e+", "e")


def vector(components: Any) -> str:
    """``vec3(...)`` of so many components, written once where they are equal."""
    texts = [number(component) for component in components]
    inner = texts[0] if len(set(texts)) == 1 else ", ".join(texts)
    return f"vec{len(texts)}({inner})"
