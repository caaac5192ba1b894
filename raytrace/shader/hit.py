"""What a search for the closest intersection carries from one object to the next."""

from typing import NamedTuple

from raytrace.shader.types import Float, Int

__all__ = ["Hit"]


class Hit(NamedTuple):
    """The closest hit so far: its t (infinite: none) and whose it is (-1: nobody's)."""

    t: Float
    index: Int
