"""The steps of the shader as the layers of one OpenEXR file."""

from typing import Any

import numpy as np

from raytrace.shader.main import COMPONENTS

__all__ = ["STEP_CHANNELS", "step_channels", "steps_of"]

_COLORS = ("albedo", "linear", "display")


def _channels(step: str) -> list[str]:
    """Colours by name, vectors by axis, numbers by themselves; the layer without a name is what a viewer shows."""
    if COMPONENTS[step] == 1:
        return [step]
    axes = "RGB" if step in _COLORS else "XYZ"[: COMPONENTS[step]]
    return [axis if step == "display" else f"{step}.{axis}" for axis in axes]


#: All channels of a file of steps, the display's first.
STEP_CHANNELS = [
    channel for step in ("display", *(step for step in COMPONENTS if step != "display")) for channel in _channels(step)
]


def step_channels(steps: dict[str, Any]) -> np.ndarray:
    """The steps of some rows as one float32 array (rows, width, channels), in the order of `STEP_CHANNELS`."""
    planes = {}
    for name, step in steps.items():
        components = np.atleast_3d(np.asarray(step))
        planes |= {channel: components[..., k] for k, channel in enumerate(_channels(name))}
    return np.stack([planes[channel].astype(np.float32, copy=False) for channel in STEP_CHANNELS], axis=-1)


def steps_of(planes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The steps of a file's channels, which are found by their names."""
    steps = {}
    for name, components in COMPONENTS.items():
        parts = [planes[channel] for channel in _channels(name)]
        steps[name] = parts[0] if components == 1 else np.stack(parts, axis=-1)
    return steps | {"index": steps["index"].astype(np.int32)}
