"""What the shader is given: the scene's numbers in one arithmetic, and the choices that shape the program."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from raytrace.language.glsl import Mat3, Mat4, Vec3
from raytrace.language.types import Array

__all__ = ["Camera", "FilmUniforms", "Plane", "Program", "Sky", "Sphere", "Sun", "Uniforms"]


class Camera(NamedTuple):
    """The uniforms ``ndcToView`` and ``viewToWorld``: inverse projection and inverse view matrix."""

    ndc_to_view: Mat4
    view_to_world: Mat4


class Sphere(NamedTuple):
    """``struct Sphere``; with leaves of shape (n,) the array ``spheres``."""

    center: Vec3
    radius: Array
    color: Vec3


class Plane(NamedTuple):
    """A plane and its checkerboard; with leaves of shape (n,) an array of them.

    A plain plane is one whose three colours are equal.
    """

    point: Vec3
    normal: Vec3
    tile_size: Array
    even: Vec3
    odd: Vec3
    line: Vec3


class Sun(NamedTuple):
    """``sunDirection``, towards the sun and of any length, and ``sunColor``."""

    direction: Vec3
    color: Vec3


class Sky(NamedTuple):
    """``skyColorLow``, ``skyColorHigh`` and ``voidColor``."""

    low: Vec3
    high: Vec3
    void: Vec3


class FilmUniforms(NamedTuple):
    """What the film needs beyond the assignment's; ``None`` where it has nothing to do."""

    exposure: Array | None
    white_balance: Mat3 | None


class Uniforms(NamedTuple):
    """Every number of a scene. `spheres` and `planes` are ``None`` where there are none."""

    camera: Camera
    spheres: Sphere | None
    planes: Plane | None
    #: Those planes that cast shadows; none in the assignment.
    shadow_planes: Plane | None
    sun: Sun
    sky: Sky
    film: FilmUniforms


@dataclass(frozen=True)
class Program:
    """The choices that shape the program, known before any number is. Hashable.

    `lighting` is what the assignment has added by figure 3 (off), 5 (on) and 6 (shadow). `intersection` chooses
    the formula for the sphere. `patterned` is False where every plane is plain. `shadow_start` is where a shadow ray
    starts: at the assignment's offset along the normal, or on the surface, which then casts no shadow on itself.
    `casting` are the numbers of the planes in ``shadow_planes``. `antialias` is "edges" where a pixel is to be the mean
    over its square of what is on either side of the edges in it. `tone_mapper` and `transfer` are names of
    `raytrace.shader.film`, or functions of a `Vec3`.
    """

    lighting: str
    intersection: str
    orthographic: bool
    patterned: bool
    tone_mapper: str | Callable[[Vec3], Vec3]
    transfer: str | Callable[[Vec3], Vec3]
    shadow_start: str = "offset"
    casting: tuple[int, ...] = ()
    antialias: str = "none"
