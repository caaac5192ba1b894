"""What the fields of a scene may hold: their shapes, their limits and their words, each stated once.

The limits are those within which float32 neither overflows nor underflows on the way through the shader.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = [
    "ANGLE",
    "COLOR",
    "DIRECTION",
    "EXPOSURE",
    "LENGTH",
    "MATRIX",
    "POINT",
    "SHORTEST",
    "Kind",
    "Rule",
    "white_point",
]

#: Numbers that float32 holds; a direction may be as long or as short as that.
LARGEST = float(np.finfo(np.float32).max)
#: Lengths whose squares, and the quotients of those, float32 holds with room to spare.
LONGEST, SHORTEST = 1e12, 1e-12
#: Colours whose products among each other, exposed and squared by a tone mapper, float32 holds.
BRIGHTEST = 1e6
MOST_EXPOSURE = 16.0


@dataclass(frozen=True)
class Rule:
    """`holds` answers for a number or, elementwise, for an array; `message` says what would be right."""

    holds: Callable[[Any], Any]
    message: str


@dataclass(frozen=True)
class Kind:
    """Numbers of a shape; `rules` hold for each of them, `together` for all at once."""

    shape: tuple[int, ...]
    rules: tuple[Rule, ...]
    together: tuple[Rule, ...] = ()

    def __str__(self) -> str:
        numbers = {(): "a number that", (3,): "3 numbers, each of which", (4, 4): "4 rows of 4 numbers, each of which"}
        each = " and ".join(rule.message for rule in self.rules)
        return "; ".join([f"{numbers[self.shape]} {each}", *(rule.message for rule in self.together)])


def _at_most(limit: float) -> Rule:
    return Rule(lambda x: abs(x) <= limit, f"must be at most {limit:.3g} in size")


FINITE = Rule(np.isfinite, "must be a finite number")
COORDINATE = (FINITE, _at_most(LONGEST))
POSITIVE = (
    *COORDINATE,
    Rule(lambda x: x > 0, "must be greater than 0"),
    Rule(lambda x: x >= SHORTEST, f"must be at least {SHORTEST:.3g}"),
)
INTENSITY = (FINITE, Rule(lambda x: x >= 0, "must not be negative"), _at_most(BRIGHTEST))
DEGREES = (FINITE, Rule(lambda x: (x > 0) & (x < 180), "must be greater than 0 and less than 180 degrees"))

POINT = Kind((3,), COORDINATE)
DIRECTION = Kind((3,), (FINITE, _at_most(LARGEST)), (Rule(np.any, "must not be the zero vector"),))
COLOR = Kind((3,), INTENSITY)
LENGTH = Kind((), POSITIVE)
ANGLE = Kind((), DEGREES)
EXPOSURE = Kind((), (FINITE, _at_most(MOST_EXPOSURE)))
MATRIX = Kind((4, 4), COORDINATE)


def white_point(value: Any) -> float | tuple[float, float]:
    """Return a temperature in kelvin, or CIE 1931 (x, y), as numbers.

    Raises:
        ValueError: it is neither.
    """
    if isinstance(value, list | tuple) and len(value) == 2:
        if all(isinstance(v, int | float) and v > 0 for v in value) and sum(value) < 1:
            x, y = map(float, value)
            return x, y
    elif isinstance(value, int | float) and not isinstance(value, bool) and 1667 <= value <= 25000:
        return float(value)
    raise ValueError("must be a temperature from 1667 to 25000 kelvin or CIE [x, y] with x > 0, y > 0, x + y < 1")
