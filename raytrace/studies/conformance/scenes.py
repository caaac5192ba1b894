"""Random scenes: few structures, each of which is one program, and numbers of many magnitudes."""

from typing import Any, NamedTuple

import numpy as np

from raytrace.scene import Scene
from raytrace.scene.data import (
    Camera,
    Checkerboard,
    Film,
    MatrixCamera,
    OrthographicCamera,
    PerspectiveCamera,
    Plain,
    Plane,
    Sky,
    Spheres,
    Sun,
)

__all__ = ["STRUCTURES", "Structure", "random_scene"]


class Structure(NamedTuple):
    """What shapes a scene's program.

    planes: for each whether it is "plain" or "checkered", and whether it casts a shadow. intersection: the formula for
    the sphere; ``None`` leaves it to the engine. The other fields are those of a scene.
    """

    spheres: int
    planes: tuple[tuple[str, bool], ...]
    lighting: str
    camera: str
    tone_mapper: str
    transfer: str
    exposure: bool
    white_point: bool
    intersection: str | None


_NONE = ()
_GROUND = (("checkered", False),)
_WALLS = (("plain", True), ("checkered", True))
#: Every choice of a scene is in several of these, and every two of a kind in one at least.
STRUCTURES = (
    Structure(4, _GROUND, "shadow", "perspective", "aces", "gamma2.2", False, False, None),
    Structure(3, _WALLS, "shadow", "matrix", "none", "none", False, True, "textbook"),
    Structure(2, _GROUND, "off", "orthographic", "none", "none", False, False, "robust"),
    Structure(6, _NONE, "on", "perspective", "reinhard", "srgb", True, False, "robust"),
    Structure(0, _WALLS, "shadow", "orthographic", "hable", "gamma2.2", True, True, None),
    Structure(3, _NONE, "shadow", "matrix", "hable", "srgb", False, False, "textbook"),
    Structure(0, _NONE, "off", "perspective", "none", "srgb", False, True, None),
    Structure(1, _WALLS, "on", "perspective", "aces", "none", True, True, "robust"),
    Structure(5, _GROUND, "shadow", "orthographic", "reinhard", "gamma2.2", False, True, "textbook"),
    Structure(4, _WALLS, "off", "matrix", "aces", "srgb", True, False, "textbook"),
    Structure(2, _NONE, "on", "orthographic", "none", "gamma2.2", True, False, None),
    Structure(1, _GROUND, "shadow", "matrix", "reinhard", "none", True, False, "robust"),
)


def random_scene(random: np.random.Generator, structure: Structure) -> Scene:
    """Return a scene of that structure."""
    # A unit of length is anything; most things lie within a few units of what the camera looks at.
    unit = 10.0 ** random.uniform(-2, 3) if random.random() < 0.5 else 1.0
    origin = unit * random.normal(size=3) * random.choice([0.0, 1.0, 1.0, 30.0])
    towards = _unit(random)
    distance = unit * 10.0 ** random.uniform(0, 1)
    target = origin + distance * towards
    white_point = None
    if structure.white_point:
        white_point = float(random.uniform(2500, 20000)) if random.random() < 0.7 else (0.3, 0.35)
    return Scene(
        spheres=_spheres(random, structure.spheres, unit, origin, target),
        planes=tuple(_plane(random, kind, casts, unit, origin, towards) for kind, casts in structure.planes),
        sun=Sun(_unit(random) * 10.0 ** random.choice([0.0, random.uniform(-15, 15)]), _color(random)),
        sky=Sky(_color(random), _color(random), _color(random)),
        lighting=structure.lighting,
        camera=_camera(random, structure.camera, unit, origin, target),
        film=Film(
            exposure=float(random.uniform(-12, 12)) if structure.exposure else 0.0,
            white_point=white_point,
            tone_mapper=structure.tone_mapper,
            transfer=structure.transfer,
        ),
    )


def _unit(random: np.random.Generator) -> np.ndarray:
    vector = random.normal(size=3)
    return vector / np.linalg.norm(vector)


def _color(random: np.random.Generator) -> np.ndarray:
    """Return an ordinary colour, one whose components have any magnitude, or one of zeros and ones."""
    kind = random.integers(3)
    if kind == 0:
        return random.uniform(0, 1, 3)
    return 10.0 ** random.uniform(-6, 6, 3) if kind == 1 else random.integers(0, 2, 3).astype(float)


def _spheres(random: np.random.Generator, n: int, unit: float, origin: Any, target: Any) -> Spheres:
    """Return spheres in view, near and far, some of which hold the camera."""
    share = 10.0 ** random.uniform(-0.5, 1, n)
    distance = share * np.linalg.norm(target - origin)
    center = origin + share[:, None] * (target - origin) + 0.3 * distance[:, None] * random.normal(size=(n, 3))
    radius = distance * 10.0 ** np.where(random.random(n) < 0.1, 0.2, random.uniform(-1.5, -0.3, n))
    return Spheres(center, radius, np.array([_color(random) for _ in range(n)]).reshape(n, 3))


def _plane(random: np.random.Generator, kind: str, casts: bool, unit: float, origin: Any, towards: Any) -> Plane:
    """Return a ground below the camera, or any plane in view."""
    if random.random() < 0.5:
        normal, point = np.array([0.0, 1.0, 0.0]), origin - unit * np.array([0.0, random.uniform(0.2, 2), 0.0])
    else:
        normal = _unit(random) * 10.0 ** random.uniform(-3, 3)
        point = origin + unit * 10.0 ** random.uniform(0, 1) * (towards + 0.3 * random.normal(size=3))
    pattern = Plain(_color(random))
    if kind == "checkered":
        tile = unit * 10.0 ** random.uniform(-1, 1)
        pattern = Checkerboard(tile, _color(random), _color(random), _color(random))
    return Plane(point, normal, pattern, casts)


def _camera(random: np.random.Generator, kind: str, unit: float, origin: Any, target: Any) -> Camera:
    if kind == "orthographic":
        return OrthographicCamera(unit * 10.0 ** random.uniform(0, 1), origin, target, near=0.1 * unit, far=100 * unit)
    if kind == "perspective":
        angle = random.uniform(10, 120) if random.random() < 0.8 else 180 - 10.0 ** random.uniform(-2, 1)
        return PerspectiveCamera(origin, target, field_of_view=angle)
    # Any projection whose points do not lie at infinity, and axes that need be neither perpendicular nor of length 1.
    back = -(target - origin) / np.linalg.norm(target - origin)
    axes = np.stack([_unit(random), _unit(random), back], axis=1) * 10.0 ** random.uniform(-1, 1)
    view = np.vstack([np.column_stack([axes, origin]), [0, 0, 0, 1]])
    projection = np.diag(10.0 ** random.uniform(-0.5, 0.5, 4)) + 0.1 * random.normal(size=(4, 4))
    projection[2, 3] = -projection[2, 2] - 1
    return MatrixCamera(projection, view)
