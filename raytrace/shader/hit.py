"""What a search among objects carries from one to the next."""

from typing import NamedTuple

from raytrace.language.types import Float, Int

__all__ = ["Darkest", "Hit", "Nearest"]


class Hit(NamedTuple):
    """The closest hit so far: its t (infinite: none) and whose it is (-1: nobody's)."""

    t: Float
    index: Int


class _Best(NamedTuple):
    merit: tuple[Float, ...]
    index: tuple[Int, ...]


class Nearest(_Best):
    """The nearest few surfaces so far, nearest first: 1 / t (0: none) and whose each is (-1: nobody's)."""

    __slots__ = ()


class Darkest(_Best):
    """What hides most of the sun so far: the share that it hides (0: none) and whose it is (-1: nobody's)."""

    __slots__ = ()
