"""Built-in scenes as the parameter `name` of tests that take seconds for each."""

import pytest

from raytrace.scene.toml import figures

__all__ = ["SEVERAL_SCENES"]

#: Of those that are no figures, the ones that ask most of the arithmetic.
_HARD = ["inside-a-sphere", "huge-sphere-as-ground", "two-tilted-planes"]

SEVERAL_SCENES = pytest.mark.parametrize(
    "name", [*figures(), *(pytest.param(name, marks=pytest.mark.slow) for name in _HARD)]
)
