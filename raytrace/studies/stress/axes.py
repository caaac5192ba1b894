"""The axes along which problems get harder."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

from raytrace.studies.stress.cameras import CameraStress
from raytrace.studies.stress.effort import Effort
from raytrace.studies.stress.functions import FunctionStress
from raytrace.studies.stress.measure import Measurement
from raytrace.studies.stress.planes import PlaneStress
from raytrace.studies.stress.shadows import ShadowStress
from raytrace.studies.stress.spheres import SphereStress

__all__ = ["AXES", "GROUPS", "Axis"]


class Axis(NamedTuple):
    """What is plotted: a title, and what x is."""

    title: str
    x: str
    decision: str = "hit or miss, or which root, is wrong"


AXES = {
    "distance": Axis("A sphere that is far away", "distance / radius"),
    "radius": Axis("A sphere of any size, at ten radii", "radius"),
    "offset": Axis("A scene far from the origin", "distance of the scene from the origin, in radii"),
    "grazing": Axis("Rays that graze a sphere", "angle between ray and surface, radians"),
    "inside": Axis("Rays from inside a sphere", "depth of the origin below the surface, in radii"),
    "outside": Axis("Rays from just outside a sphere", "height of the origin over the surface, in radii"),
    "search": Axis("The worst rays, by hill climbing", "steps of 400 climbers"),
    "narrow_view": Axis("A camera of a narrow view: a ray's direction", "field of view, degrees"),
    "wide_view": Axis("A camera that sees nearly half of everything", "180 less the field of view, degrees"),
    "near_far": Axis("Near and far plane: directions, and origins of parallel rays", "far / near"),
    "camera_matrix": Axis("Nearly singular camera matrices: a ray's direction", "condition number of each matrix"),
    "plane": Axis("Rays that graze a plane", "angle between ray and plane, radians"),
    "checkerboard": Axis("The checkerboard far out", "distance from the origin, tiles of 0.7", "wrong tile"),
    "gamma": Axis("x to the power 1/2.2", "x"),
    "sky_gradient": Axis("x to the power 1/4", "x"),
    "sun_lobe": Axis("x to the power 2400", "1 - x"),
    "lobe_vanishes": Axis("x to the power 2400, subnormal", "1 - x"),
    "tone_mapping": Axis("Tone mapping, clamp and 1/2.2", "linear light"),
    "normalization": Axis("Normalisation", "length of the vector"),
    "sun": Axis("The sun's direction, from the scene on", "length of the direction"),
    "acne": Axis("Surfaces that shadow themselves", "scale of the scene", "lit pixels that are dark"),
    "peter_panning": Axis("Shadows that are lost", "scale of the scene", "dark pixels that are lit"),
}


def _spheres(effort: Effort) -> Iterator[Callable[[], Iterator[Measurement]]]:
    stress = SphereStress(effort)
    yield from (stress.distance, stress.radius, stress.offset, stress.grazing, stress.inside, stress.outside)
    yield stress.search


def _cameras(effort: Effort) -> Iterator[Callable[[], Iterator[Measurement]]]:
    stress = CameraStress(effort)
    yield from (stress.narrow_view, stress.wide_view, stress.near_far, stress.camera_matrix)


def _planes(effort: Effort) -> Iterator[Callable[[], Iterator[Measurement]]]:
    stress = PlaneStress(effort)
    yield from (stress.plane, stress.checkerboard)


def _functions(effort: Effort) -> Iterator[Callable[[], Iterator[Measurement]]]:
    stress = FunctionStress(effort)
    yield from (stress.gamma, stress.sky_gradient, stress.sun_lobe, stress.lobe_vanishes, stress.tone_mapping)
    yield from (stress.normalization, stress.sun)


def _shadows(effort: Effort) -> Iterator[Callable[[], Iterator[Measurement]]]:
    yield ShadowStress(effort).points


#: What is run, and the names of its axes.
GROUPS = {
    _spheres: ("distance", "radius", "offset", "grazing", "inside", "outside", "search"),
    _cameras: ("narrow_view", "wide_view", "near_far", "camera_matrix"),
    _planes: ("plane", "checkerboard"),
    _functions: ("gamma", "sky_gradient", "sun_lobe", "lobe_vanishes", "tone_mapping", "normalization", "sun"),
    _shadows: ("acne", "peter_panning"),
}
