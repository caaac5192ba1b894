"""A scene's uniforms as one array: JAX is handed one thing instead of a hundred."""

import math
from typing import Any, NamedTuple

import jax
import numpy as np

__all__ = ["Layout", "pack"]


class Layout(NamedTuple):
    """What stands where in the array; hashable."""

    tree: Any
    shapes: tuple[tuple[int, ...], ...]

    @property
    def size(self) -> int:
        return sum(map(math.prod, self.shapes))

    def unpack(self, numbers: jax.Array) -> Any:
        """The structure whose leaves are the parts of `numbers`, an array (size,)."""
        ends = np.cumsum([math.prod(shape) for shape in self.shapes])
        return self.tree.unflatten(
            numbers[end - math.prod(shape) : end].reshape(shape) for end, shape in zip(ends, self.shapes, strict=True)
        )


def pack(structure: Any, dtype: str) -> tuple[np.ndarray, Layout]:
    """All numbers of `structure` in one array, and how to have them back."""
    leaves, tree = jax.tree.flatten(structure)
    leaves = [np.asarray(leaf, dtype) for leaf in leaves]
    return np.concatenate([leaf.reshape(-1) for leaf in leaves]), Layout(tree, tuple(leaf.shape for leaf in leaves))
