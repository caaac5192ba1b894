"""Walking structures of planes: nested tuples, named or not, whose leaves are arrays.

``None`` is a structure without leaves, so a record can leave a field out.
"""

from collections.abc import Callable
from typing import Any

__all__ = ["Numbers", "array_map", "count", "tree_leaves", "tree_map"]


def tree_map(function: Callable, tree: Any, *others: Any) -> Any:
    """`function` of every leaf of `tree` and of the leaves at the same places of `others`."""
    return _map(lambda part: False, function, tree, *others)


def array_map(function: Callable, tree: Any, *others: Any) -> Any:
    """The same, but whatever can be computed with is a leaf, even if it is made of several planes."""
    return _map(lambda part: hasattr(part, "__array_namespace__"), function, tree, *others)


def _map(is_leaf: Callable, function: Callable, tree: Any, *others: Any) -> Any:
    if tree is None:
        return None
    if not isinstance(tree, tuple) or any(map(is_leaf, (tree, *others))):
        return function(tree, *others)
    mapped = [_map(is_leaf, function, *parts) for parts in zip(tree, *others, strict=True)]
    return type(tree)(*mapped) if hasattr(tree, "_fields") else tuple(mapped)


def tree_leaves(tree: Any) -> list:
    """The leaves of `tree`, in order."""
    leaves: list = []
    tree_map(leaves.append, tree)
    return leaves


class Numbers:
    """The whole numbers from 0 to `n` - 1, as items of ``each``: no array holds them."""

    def __init__(self, n: int):
        self.shape = (n,)

    def __getitem__(self, i: Any) -> Any:
        return i


def count(items: Any) -> int:
    """How many items a structure of arrays of shape (n,) holds; 0 for ``None``."""
    leaves = tree_leaves(items)
    return leaves[0].shape[0] if leaves else 0
