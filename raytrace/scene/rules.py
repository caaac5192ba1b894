"""What a number of a scene must satisfy: each rule once, for one number (pydantic) and for a million (NumPy)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic_core import PydanticCustomError

__all__ = ["ANGLE", "NOT_NEGATIVE", "NUMBER", "POSITIVE", "Rule", "mistake"]

LARGEST = float(np.finfo(np.float32).max)
SMALLEST = float(np.finfo(np.float32).smallest_normal)


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


#: Every number: finite, in the arithmetic at hand and in float32, to which a scene is rounded.
NUMBER = (
    Rule(np.isfinite, "must be a finite number"),
    Rule(lambda x: abs(x) <= LARGEST, f"must be at most {LARGEST:.2e} in size (scenes are float32)"),
)
POSITIVE = (
    *NUMBER,
    Rule(lambda x: x > 0, "must be greater than 0"),
    Rule(lambda x: x >= SMALLEST, f"must be at least {SMALLEST:.2e} (scenes are float32)"),
)
NOT_NEGATIVE = (*NUMBER, Rule(lambda x: x >= 0, "must not be negative"))
ANGLE = (*NUMBER, Rule(lambda x: (x > 0) & (x < 180), "must be greater than 0 and less than 180 degrees"))
