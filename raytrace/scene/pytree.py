"""Scenes as JAX pytrees, without importing JAX: its own import, before or after, makes them so."""

from collections.abc import Callable
from dataclasses import fields
from functools import partial
from typing import Any

import wrapt

from raytrace.scene.data import NODES

__all__ = ["register_with_jax"]


def _with_keys(key: Callable, leaves: list[str], static: list[str], record: Any) -> tuple:
    children = tuple((key(name), getattr(record, name)) for name in leaves)
    return children, tuple(getattr(record, name) for name in static)


def _without_keys(cls: type, leaves: list[str], static: list[str], choices: tuple, children: tuple) -> Any:
    """A record of whatever JAX puts in the leaves' places, which is not converted to arrays."""
    record = object.__new__(cls)
    for name, value in zip([*leaves, *static], [*children, *choices], strict=True):
        object.__setattr__(record, name, value)
    return record


def register_with_jax() -> None:
    """Makes the scene's classes pytrees when JAX is imported, or now if it is: floats are leaves, choices structure."""
    wrapt.register_post_import_hook(_register, "jax")


def _register(jax: Any) -> None:
    for cls in NODES:
        leaves, static = (
            [entry.name for entry in fields(cls) if bool(entry.metadata.get("static")) == is_static]
            for is_static in (False, True)
        )
        jax.tree_util.register_pytree_with_keys(
            cls,
            partial(_with_keys, jax.tree_util.GetAttrKey, leaves, static),
            partial(_without_keys, cls, leaves, static),
        )
