"""A scene's numbers as one array: JAX is handed one thing instead of a hundred."""

import math
from typing import Any, NamedTuple

import jax
import numpy as np

__all__ = ["Layout", "Parts", "pack"]


#: A part of the array: where it begins, how many numbers it has, and its shape.
Place = tuple[int, int, tuple[int, ...]]


class Layout(NamedTuple):
    """What stands where in the array; hashable."""

    tree: Any
    shapes: tuple[tuple[int, ...], ...]

    @property
    def size(self) -> int:
        return sum(map(math.prod, self.shapes))


class Parts:
    """A structure whose leaves are the parts of `numbers`, an array (size,)."""

    def __init__(self, layout: Layout, numbers: Any):
        self._numbers = numbers
        sizes = [math.prod(shape) for shape in layout.shapes]
        starts = [sum(sizes[:k]) for k in range(len(sizes))]
        #: By a leaf's identity the leaf, which is held so that no other has it, and its place.
        self._known: dict[int, tuple[Any, Place]] = {}
        self.structure = layout.tree.unflatten(map(self._leaf, zip(starts, sizes, layout.shapes, strict=True)))

    def _leaf(self, place: Place) -> Any:
        leaf = self._part(place)
        self._known[id(leaf)] = leaf, place
        return leaf

    def _part(self, place: Place) -> Any:
        start, size, shape = place
        return self._numbers[start : start + size].reshape(shape)

    def __contains__(self, x: Any) -> bool:
        return id(x) in self._known

    def item(self, x: Any, i: int) -> Any:
        """Return ``x[i]`` of an array of shape (n,); of one of the leaves as a part that `here` knows."""
        if x not in self:
            return x[i]
        _, (start, _, _) = self._known[id(x)]
        return self._leaf((start + i, 1, ()))

    def column(self, items: list[Any], i: Any) -> Any:
        """Return ``x[i]`` of each of `items` as an array, which one kernel reads; ``None`` if they are no such leaves.

        items: arrays (n,). i: a whole number of shape (), which exists.
        """
        if not all(x in self for x in items):
            return None
        places = [self._known[id(x)][1] for x in items]
        start, n, _ = places[0]
        if places != [(start + k * n, n, (n,)) for k in range(len(items))]:
            return None
        table = self._numbers[start : start + len(items) * n].reshape(len(items), n)
        return jax.lax.dynamic_index_in_dim(table, i, axis=1, keepdims=False, allow_negative_indices=False)

    def here(self, x: Any) -> Any:
        """Return `x`; if it is one of the leaves, as a part that is taken where this is called.

        What is taken outside of a body of control flow is a kernel by itself, which is compiled and run. Taken within,
        it is a part of the kernel that reads it.
        """
        return self._part(self._known[id(x)][1]) if x in self else x


def pack(structure: Any, dtype: str) -> tuple[np.ndarray, Layout]:
    """Return all numbers of `structure` in one array, and what stands where."""
    leaves, tree = jax.tree.flatten(structure)
    leaves = [np.asarray(leaf, dtype) for leaf in leaves]
    return np.concatenate([leaf.reshape(-1) for leaf in leaves]), Layout(tree, tuple(leaf.shape for leaf in leaves))
