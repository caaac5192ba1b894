"""How much is tried: a minute's worth, or as much as it takes."""

from typing import NamedTuple

import numpy as np

__all__ = ["FULL", "QUICK", "Effort"]


class Effort(NamedTuple):
    """cases: of each point; per_decade: points of an axis; size: of an image; climbing: steps of a search for the
    worst rays; seed: of all random numbers.
    """

    cases: int
    per_decade: int
    size: tuple[int, int]
    climbing: int
    seed: int = 0

    def decades(self, low: int, high: int) -> np.ndarray:
        """The places of an axis from 10**low to 10**high."""
        return 10.0 ** np.linspace(low, high, round((high - low) * self.per_decade) + 1)


QUICK = Effort(cases=2000, per_decade=1, size=(64, 36), climbing=100)
FULL = Effort(cases=20000, per_decade=3, size=(320, 180), climbing=1500)
