"""The sun's direction as two angles, in degrees."""

from typing import Any

from raytrace.shader.namespace import namespace

__all__ = ["sun_angles", "sun_direction"]

_DEGREE = 0.017453292519943295


def sun_direction(azimuth: Any, elevation: Any) -> Any:
    """The unit vector (3,) to the sun: azimuth 0 is -z, 90 degrees +x; elevation 90 degrees is +y.

    NumPy arrays and numbers give a NumPy array, JAX arrays a JAX array.
    """
    import numpy as np

    if not hasattr(azimuth, "__array_namespace__") and not hasattr(elevation, "__array_namespace__"):
        azimuth = np.float64(azimuth)
    xp = namespace(azimuth, elevation)
    azimuth, elevation = xp.asarray(azimuth) * _DEGREE, xp.asarray(elevation) * _DEGREE
    level = xp.cos(elevation)
    return xp.stack([level * xp.sin(azimuth), xp.sin(elevation), -level * xp.cos(azimuth)])


def sun_angles(direction: Any) -> tuple[Any, Any]:
    """(azimuth, elevation) in degrees of a direction (3,) of any length: atan2(x, -z) and asin(y)."""
    import numpy as np

    if not hasattr(direction, "__array_namespace__"):
        direction = np.asarray(direction, dtype=np.float64)
    xp = namespace(direction)
    x, y, z = direction / xp.max(xp.abs(direction))
    length = xp.sqrt(x * x + y * y + z * z)
    # In 2.0 asin(y / length) may be asked of a number one rounding above 1.
    return xp.arctan2(x, -z) / _DEGREE, xp.arcsin(xp.clip(y / length, -1, 1)) / _DEGREE
