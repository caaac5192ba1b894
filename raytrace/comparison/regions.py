"""Where in a scene two images differ: by what each pixel shows, and by the steps of the shader that made it."""

from typing import NamedTuple

import numpy as np

from raytrace.comparison.reference import Reference

__all__ = ["Part", "regions"]


class Part(NamedTuple):
    """A part of the image: how many of its pixels differ by more than 1/255, and how many it has."""

    name: str
    over: int
    pixels: int


def regions(over: np.ndarray, reference: Reference) -> tuple[Part, ...]:
    """The pixels of `over`, (height, width), that lie in each part of the scene; parts without pixels are left out.

    Sky, spheres and planes, which are the whole image; then, over all of these, the surfaces in shadow and the edges:
    pixels that border on one of another surface, colour, shadow, or side of the horizon.
    """
    return tuple(
        Part(name, int(np.count_nonzero(over & part)), int(np.count_nonzero(part)))
        for name, part in _parts(reference).items()
        if part.any()
    )


def _parts(reference: Reference) -> dict[str, np.ndarray]:
    steps, scene = reference.steps, reference.scene
    index, spheres = steps["index"], len(scene.spheres.radius)
    parts = {"sky": index < 0}
    parts |= {f"sphere {n}": index == n for n in range(spheres)}
    parts |= {f"plane {n}": index == spheres + n for n in range(len(scene.planes))}
    if scene.lighting == "shadow":
        parts["shadow"] = (index >= 0) & (steps["shadow"] == 0)
    void = (index < 0) & (steps["rd"][..., 1] < 0)
    return parts | {"edges": _edges(np.dstack([index, steps["shadow"], steps["albedo"], void]))}


def _edges(planes: np.ndarray) -> np.ndarray:
    """Where one of `planes`, (height, width, n), is not the same number in a pixel's 3 x 3 neighbourhood."""
    from scipy.ndimage import maximum_filter, minimum_filter

    size = (3, 3, 1)
    return (maximum_filter(planes, size) != minimum_filter(planes, size)).any(axis=-1)
