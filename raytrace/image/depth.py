"""How finely an image's values are stored, and which numbers a stored value may stand for."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from raytrace.errors import InputError

__all__ = ["FLOAT32", "Depth", "array_of", "coarsest_depth", "depth_of_dtype", "values_of"]

#: The binary floats of IEEE 754, by their bits: digits, smallest exponent of a normal number, largest number.
_FLOATS = {
    16: (11, -14, 65504.0),
    32: (24, -126, float(np.finfo(np.float32).max)),
    64: (53, -1022, float(np.finfo(np.float64).max)),
}
#: Integers that files and displays have, the coarsest first.
_INTEGERS = (8, 10, 12, 16)


@dataclass(frozen=True)
class Depth:
    """What a channel is stored as: an unsigned integer of so many bits, whose largest stands for 1, or a binary float.

    bits: of a channel. floating: whether it is a float of IEEE 754, of 16, 32 or 64 bits.
    """

    bits: int
    floating: bool = False

    def __str__(self) -> str:
        if not self.floating:
            return f"{self.bits} bits"
        return {16: "half float", 32: "float32", 64: "float64"}[self.bits]

    @property
    def unit(self) -> float:
        """The distance between neighbours just below 1."""
        return 2.0 ** -_FLOATS[self.bits][0] if self.floating else 1 / self._most

    @property
    def rounding(self) -> str:
        """How a value is stored as an integer, in a formula."""
        return f"floor({self._most}*x + 0.5)"

    @property
    def _most(self) -> int:
        return 2**self.bits - 1

    def half_unit(self, values: Any) -> np.ndarray:
        """Return how far from each stored value, at most, the number was that became it; float64.

        That is half the distance to the next value. Numbers pass through float32 on their way into a file and out of
        it, so what is coarser than float32 has a unit of that too, half for each.
        """
        values = np.asarray(values, np.float64)
        own = _unit_in_the_last_place(values, self.bits) / 2 if self.floating else 0.5 / self._most
        if self.floating and self.bits >= 32:
            return np.asarray(own)
        return own + _unit_in_the_last_place(values, 32)

    def numbers(self, values: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the smallest and the largest number that may be stored as each of `values`; NaN for NaN.

        Integers hold no number outside [0, 1]: all that are larger became 1, all that are smaller 0. Numbers beyond a
        float's largest became infinite.
        """
        values = np.asarray(values, np.float64)
        with np.errstate(invalid="ignore"):
            slack = self.half_unit(values)
            low, high = values - slack, values + slack
        if not self.floating:
            return np.where(values <= 0, -np.inf, low), np.where(values >= 1, np.inf, high)
        largest = _FLOATS[self.bits][2]
        low, high = np.where(values == np.inf, largest, low), np.where(values == np.inf, np.inf, high)
        return np.where(values == -np.inf, -np.inf, low), np.where(values == -np.inf, -largest, high)

    def rounded(self, values: Any) -> np.ndarray:
        """Return `values` as they come back from a file of this depth; float64."""
        values = np.asarray(values, np.float64)
        if not self.floating:
            return np.rint(np.clip(values, 0, 1) * self._most) / self._most
        with np.errstate(over="ignore"):
            return values.astype(f"float{self.bits}").astype(np.float64)


FLOAT32 = Depth(32, floating=True)


def depth_of_dtype(dtype: Any) -> Depth:
    """Return the depth of an array of unsigned integers or of floats; longdouble counts as float64.

    Raises:
        InputError: the array is of something else.
    """
    dtype = np.dtype(dtype)
    if dtype.kind not in "uf":
        raise InputError(
            f"image: an image's values are floats, with 1 for white, or unsigned integers, with their largest for "
            f"white, found {dtype}"
        )
    return Depth(min(8 * dtype.itemsize, 64), dtype.kind == "f")


def array_of(image: Any, name: str = "image") -> np.ndarray:
    """Return an image as an array (height, width, 3); `name` begins the message where it is none.

    Raises:
        InputError: it has another shape, or no pixels.
    """
    array = np.asarray(image)
    if array.ndim != 3 or array.shape[2] != 3 or not array.size:
        raise InputError(f"{name}: an image is an array (height, width, 3), found {array.shape}")
    return array


def values_of(image: Any) -> np.ndarray:
    """Return the values of an array as float64, with 1 for white; unsigned integers are divided by their largest.

    Raises:
        InputError: the array is of something else than unsigned integers or floats.
    """
    image = np.asarray(image)
    depth = depth_of_dtype(image.dtype)
    values = image.astype(np.float64)
    return values if depth.floating else values / depth._most


def coarsest_depth(image: Any) -> Depth:
    """Return the coarsest depth that an array's values can have been stored with.

    An array does not tell whether its floats came out of a file. So where all are k / 255, an image of only 0 and 1
    included, it may be an image of 8 bits; likewise of 10, 12 and 16 bits and of half floats. Bounds that are widened
    by this depth never exclude a right image.

    Raises:
        InputError: the array is of something else than unsigned integers or floats.
    """
    image = np.asarray(image)
    own = depth_of_dtype(image.dtype)
    if not own.floating or own.bits == 16:
        return own
    values = values_of(image)
    known = sorted([*map(Depth, _INTEGERS), Depth(16, floating=True)], key=lambda depth: -depth.unit)
    return next((depth for depth in known if _stored(values, depth)), own)


def _stored(values: np.ndarray, depth: Depth) -> bool:
    """Whether all of `values`, read as float32 at the least, have that depth."""
    with np.errstate(invalid="ignore"):
        off = np.abs(values - depth.rounded(values))
        return bool((off <= _unit_in_the_last_place(values, 32)).all())


def _unit_in_the_last_place(values: np.ndarray, bits: int) -> np.ndarray:
    """The distance from a float of so many bits to the next one away from 0; of NaN and infinity NaN."""
    digits, smallest, _ = _FLOATS[bits]
    exponent = np.where(values == 0, smallest, np.frexp(values)[1])
    unit = np.ldexp(1.0, np.maximum(exponent - 1, smallest) - (digits - 1))
    return np.where(np.isfinite(values), unit, np.nan)
