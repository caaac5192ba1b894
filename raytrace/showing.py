"""How objects show themselves in Jupyter, where that takes a layer above their own.

The package's `__init__`, which stands above all layers, names the functions.
"""

from collections.abc import Callable
from typing import Any

__all__ = ["PNG"]

#: By kind of object: what returns it as the bytes of a PNG file, or ``None`` where it has no picture.
PNG: dict[str, Callable[[Any], bytes | None]] = {}
