"""The built-in scenes as the parameter `name` of tests."""

from collections.abc import Container, Iterable

import pytest

import raytrace
from raytrace.scene.toml import figures

__all__ = ["EVERY_SCENE", "FIGURES_FIRST", "SEVERAL_SCENES"]


def _each(slow: Container[str], names: Iterable[str] = raytrace.scenes()) -> pytest.MarkDecorator:
    marks = {True: pytest.mark.slow, False: ()}
    return pytest.mark.parametrize("name", [pytest.param(name, marks=marks[name in slow]) for name in names])


_MANY = "two-hundred-spheres"

#: For what takes a moment; slow is only the scene of so many spheres.
EVERY_SCENE = _each(slow=[_MANY])

#: For what takes seconds: all but that scene; without the slow tests, the assignment's figures only.
_OTHERS = [name for name in raytrace.scenes() if name not in figures() and name != _MANY]
FIGURES_FIRST = _each(slow=_OTHERS, names=[*figures(), *_OTHERS])

#: For what takes many seconds: the figures, and of the others those that ask most of it.
_HARD = ["inside-a-sphere", "huge-sphere-as-ground", "two-tilted-planes"]
SEVERAL_SCENES = _each(slow=_HARD, names=[*figures(), *_HARD])
