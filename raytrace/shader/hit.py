"""What a search among objects carries from one to the next."""

from typing import NamedTuple

from raytrace.language.types import Float, Int

__all__ = ["CAMERA", "Darkest", "Hit", "Nearest", "ShadowEdges", "Silhouettes"]


class Hit(NamedTuple):
    """The closest hit so far: its t (infinite: none) and whose it is (-1: nobody's)."""

    t: Float
    index: Int


class Nearest(NamedTuple):
    """The nearest few surfaces so far, nearest first: 1 / t (0: none) and whose each is (-1: nobody's)."""

    approach: tuple[Float, ...]
    index: tuple[Int, ...]


class Silhouettes(NamedTuple):
    """Edges of spheres in a pixel so far: how many, and the smallest sphere's radius and middle, in pixels."""

    number: Int
    size: Float
    x: Float
    y: Float


class ShadowEdges(NamedTuple):
    """How many edges spheres' shadows have in a pixel so far."""

    number: Int


class Darkest(NamedTuple):
    """What hides most of the sun so far: about what share it hides (0: none) and whose it is (-1: nobody's)."""

    share: tuple[Float, ...]
    index: tuple[Int, ...]


#: What a search along the camera's rays carries; others search along the sun's.
CAMERA = (Hit, Nearest, Silhouettes)
