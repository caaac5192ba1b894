"""The built-in scenes as the parameter `name` of tests."""

from collections.abc import Container, Iterable

import pytest

import raytrace
from raytrace.scene.toml import figures

__all__ = ["EVERY_SCENE", "FIGURES_FIRST", "SEVERAL_SCENES"]


def _each(slow: Container[str], names: Iterable[str] = raytrace.scenes()) -> pytest.MarkDecorator:
    marks = {True: pytest.mark.slow, False: ()}
    return pytest.mark.parametrize("name", [pytest.param(name, marks=marks[name in slow]) for name in names])


#: For what takes a moment; slow is only the scene of so many spheres.
EVERY_SCENE = _each(slow=["two-hundred-spheres"])

#: For what takes seconds: without the slow tests, on the assignment's figures only.
FIGURES_FIRST = _each(slow=set(raytrace.scenes()) - set(figures()))

#: For what takes many seconds: the figures, and of the others those that ask most of it.
_HARD = ["inside-a-sphere", "huge-sphere-as-ground", "overlapping-spheres", "two-tilted-planes"]
SEVERAL_SCENES = _each(slow=_HARD, names=[*figures(), *_HARD])
