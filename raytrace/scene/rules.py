"""What a number of a scene must satisfy: each rule once, for one number (pydantic) and for a million (NumPy).

The limits are those within which float32 neither overflows nor underflows on the way through the shader.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic_core import PydanticCustomError

__all__ = [
    "ANGLE",
    "COORDINATE",
    "EXPOSURE",
    "INTENSITY",
    "NUMBER",
    "POSITIVE",
    "SHORTEST",
    "Rule",
    "mistake",
]

#: Numbers that float32 holds; a direction may be as long or as short as that.
LARGEST = float(np.finfo(np.float32).max)
#: Lengths whose squares, and the quotients of those, float32 holds with room to spare.
LONGEST, SHORTEST = 1e12, 1e-12
#: Colours whose products among each other, exposed and squared by a tone mapper, float32 holds.
BRIGHTEST = 1e6
MOST_EXPOSURE = 16.0


def mistake(message: str) -> PydanticCustomError:
    """The error that pydantic reports with the place where it was raised."""
    return PydanticCustomError("rule", "{message}", {"message": message})


@dataclass(frozen=True)
class Rule:
    """`holds` answers for a number or, elementwise, for an array; `message` says what would be right."""

    holds: Callable[[Any], Any]
    message: str

    def __call__(self, x: float) -> float:
        """`x` if the rule holds for it; pydantic's error if not."""
        if not self.holds(x):
            raise mistake(self.message)
        return x


def _at_most(limit: float) -> Rule:
    return Rule(lambda x: abs(x) <= limit, f"must be at most {limit:.3g} in size")


FINITE = Rule(np.isfinite, "must be a finite number")
NUMBER = (FINITE, _at_most(LARGEST))
COORDINATE = (FINITE, _at_most(LONGEST))
POSITIVE = (
    *COORDINATE,
    Rule(lambda x: x > 0, "must be greater than 0"),
    Rule(lambda x: x >= SHORTEST, f"must be at least {SHORTEST:.3g}"),
)
INTENSITY = (FINITE, Rule(lambda x: x >= 0, "must not be negative"), _at_most(BRIGHTEST))
EXPOSURE = (FINITE, _at_most(MOST_EXPOSURE))
ANGLE = (FINITE, Rule(lambda x: (x > 0) & (x < 180), "must be greater than 0 and less than 180 degrees"))
