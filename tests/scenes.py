"""The built-in scenes as the parameter `name` of tests."""

from collections.abc import Container

import pytest

import raytrace
from raytrace.scene.toml import figures

__all__ = ["EVERY_SCENE", "FIGURES_FIRST"]


def _each(slow: Container[str]) -> pytest.MarkDecorator:
    marks = {True: pytest.mark.slow, False: ()}
    return pytest.mark.parametrize(
        "name", [pytest.param(name, marks=marks[name in slow]) for name in raytrace.scenes()]
    )


#: For what takes a moment; slow is only the scene of so many spheres.
EVERY_SCENE = _each(slow=["two-hundred-spheres"])

#: For what takes seconds: without the slow tests, on the assignment's figures only.
FIGURES_FIRST = _each(slow=set(raytrace.scenes()) - set(figures()))
