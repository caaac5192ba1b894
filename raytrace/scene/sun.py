"""The sun's direction as two angles, in degrees."""

import math
from typing import Any

import numpy as np

from raytrace.language.namespace import namespace

__all__ = ["sun_angles", "sun_direction"]

_DEGREE = math.pi / 180


def sun_direction(azimuth: Any, elevation: Any) -> Any:
    """Return the unit vector (3,) to the sun: azimuth 0 is -z, 90 degrees +x; elevation 90 degrees is +y.

    NumPy arrays and numbers give a NumPy array, JAX arrays a JAX array.
    """
    xp = namespace(azimuth, elevation, np.float64(0))
    azimuth, elevation = xp.asarray(azimuth) * _DEGREE, xp.asarray(elevation) * _DEGREE
    level = xp.cos(elevation)
    return xp.stack([level * xp.sin(azimuth), xp.sin(elevation), -level * xp.cos(azimuth)])


def sun_angles(direction: Any) -> tuple[Any, Any]:
    """Return (azimuth, elevation) in degrees of a direction (3,) of any length: atan2(x, -z) and asin(y)."""
    xp = namespace(direction, np.float64(0))
    direction = xp.asarray(direction)
    x, y, z = direction / xp.max(xp.abs(direction))
    length = xp.sqrt(x * x + y * y + z * z)
    # A rounding may take y / length above 1.
    return xp.arctan2(x, -z) / _DEGREE, xp.arcsin(xp.clip(y / length, -1, 1)) / _DEGREE
