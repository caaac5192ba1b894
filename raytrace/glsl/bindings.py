"""The numbers that an emitted shader is to be given."""

from typing import Any

import numpy as np

from raytrace.glsl.choices import Choices
from raytrace.glsl.declarations import sphere_texture, struct_values
from raytrace.glsl.values import flat_values

__all__ = ["bindings"]


def bindings(choices: Choices, values: dict[str, Any]) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The uniforms and the textures that the text of `choices` declares, float32, by name.

    Uniforms that it has as constants are among them, and so are those that it does not use.
    """
    spheres = [] if choices.spheres_in_texture else values["spheres"]
    planes = {
        name: [struct_values("Plane", plane, choices) for plane in values[name]] for name in ("planes", "shadowPlanes")
    }
    flat = flat_values(values | {"spheres": spheres} | planes)
    textures = {"sphereTexture": sphere_texture(values["spheres"])} if choices.spheres_in_texture else {}
    return {name: np.asarray(value, np.float32) for name, value in flat.items()}, textures
