"""Which examples of a law are run by default; all of them belong to the full set."""

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings

from raytrace.scene.toml import figures

__all__ = ["SEVERAL_SCENES", "examples", "some"]

#: Of those that are no figures, the ones that ask most of the arithmetic.
_HARD = ["inside-a-sphere", "huge-sphere-as-ground", "two-tilted-planes"]


def some(parameters: Iterable[Any], *default: Any) -> list:
    """Return all parameters of a test; those that are not among `default` belong to the full set alone."""

    def with_mark(each: Any) -> Any:
        values = each if isinstance(each, tuple) else (each,)
        return pytest.param(*values, marks=() if each in default else pytest.mark.full)

    return [with_mark(each) for each in parameters]


def examples(few: int, full: int) -> settings:
    """Return Hypothesis' settings for `few` random examples by default and `full` ones in the full set."""
    return settings(max_examples=full if settings.get_current_profile_name() == "full" else few)


#: Built-in scenes for tests that take seconds for each.
SEVERAL_SCENES = pytest.mark.parametrize("name", some([*figures(), *_HARD], "checkerboard"))
