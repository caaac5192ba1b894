"""From a scene to what the shader is given: uniforms, computed in double, and the program's choices."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np

from raytrace.colour_science import colour_science
from raytrace.language.glsl import Mat3, Mat4, Vec3, Vec4, cross, normalize
from raytrace.language.namespace import namespace
from raytrace.language.tree import tree_map
from raytrace.scene.data import (
    Camera,
    Checkerboard,
    MatrixCamera,
    OrthographicCamera,
    PerspectiveCamera,
    Plain,
    Plane,
    Scene,
)
from raytrace.shader import uniforms as shader

__all__ = ["program_of", "rounded", "uniforms_of"]

#: A structure of arrays.
Tree = TypeVar("Tree")


def program_of(
    scene: Scene, intersection: str, shadow_start: str = "offset", antialias: str = "none"
) -> shader.Program:
    """The choices of `scene` that shape the shader's program."""
    surface = shadow_start == "surface"
    return shader.Program(
        lighting=scene.lighting,
        intersection=intersection,
        orthographic=isinstance(scene.camera, OrthographicCamera),
        patterned=any(isinstance(plane.pattern, Checkerboard) for plane in scene.planes),
        tone_mapper=scene.film.tone_mapper,
        transfer=scene.film.transfer,
        shadow_start=shadow_start,
        # Known only where they matter, so that the assignment's program does not depend on them.
        casting=tuple(i for i, plane in enumerate(scene.planes) if plane.casts_shadow) if surface else (),
        antialias=antialias,
    )


def uniforms_of(scene: Scene, aspect: float) -> shader.Uniforms:
    """The numbers of `scene` for an image of `aspect` (width / height): NumPy float64, or traced where they are."""
    return shader.Uniforms(
        camera=_matrices(scene.camera, aspect),
        spheres=_spheres(scene),
        planes=_planes(scene.planes),
        shadow_planes=_planes(tuple(plane for plane in scene.planes if plane.casts_shadow)),
        sun=shader.Sun(_sized(_vec3(scene.sun.direction)), _vec3(scene.sun.color)),
        sky=shader.Sky(*map(_vec3, (scene.sky.low, scene.sky.high, scene.sky.void))),
        film=_film(scene),
    )


def rounded(uniforms: Tree) -> Tree:
    """Return uniforms, or a part of them, rounded once to float32, as a GPU is given them; in NumPy's float64."""
    return tree_map(lambda x: np.asarray(x, np.float32).astype(np.float64), uniforms)


def _vec3(array: Any) -> Vec3:
    """The components (along the last axis) of an array."""
    return Vec3(array[..., 0], array[..., 1], array[..., 2])


def _sized(direction: Vec3) -> Vec3:
    """`direction` as it is, or times a power of two where float32 could not hold its squared length.

    Such a product is exact and changes no digit of the direction. (Between 2**-30 and 2**30 it is left alone.)
    """
    stacked = _stack(*direction)
    xp = namespace(stacked)
    _, exponent = xp.frexp(xp.max(xp.abs(stacked)))
    # 2**125 and its inverse are normal numbers of float32, and enough for all of its directions.
    scale = xp.ldexp(xp.ones_like(stacked[0]), xp.clip(-exponent, -125, 125))
    return direction * xp.where(abs(exponent) <= 30, xp.ones_like(scale), scale)


def _matrices(camera: Camera, aspect: float) -> shader.Camera:
    if isinstance(camera, MatrixCamera):
        return shader.Camera(_columns(camera.ndc_to_view), _columns(camera.view_to_world))
    near, far = camera.near, camera.far
    zero, one = np.float64(0), np.float64(1)
    if isinstance(camera, OrthographicCamera):
        half = camera.height / 2
        depth = Vec4(zero, zero, -(far - near) / 2, zero), Vec4(zero, zero, -(far + near) / 2, one)
    else:
        half = namespace(camera.field_of_view).tan(camera.field_of_view * (np.pi / 360))
        product = 2 * near * far
        depth = Vec4(zero, zero, zero, (near - far) / product), Vec4(zero, zero, -one, (near + far) / product)
    ndc_to_view = Mat4(Vec4(half * aspect, zero, zero, zero), Vec4(zero, half, zero, zero), *depth)
    return shader.Camera(ndc_to_view, _view_to_world(camera))


def _view_to_world(camera: PerspectiveCamera | OrthographicCamera) -> Mat4:
    """The camera's axes (right, up, backward) and position as columns: the inverse of GLU's lookAt matrix."""
    position = _vec3(camera.position)
    back = normalize(position - _vec3(camera.target))
    right = normalize(cross(_vec3(camera.up), back))
    up = cross(back, right)
    zero, one = np.float64(0), np.float64(1)
    return Mat4(Vec4(*right, zero), Vec4(*up, zero), Vec4(*back, zero), Vec4(*position, one))


def _columns(matrix: Any) -> Mat4:
    return Mat4(*(Vec4(*(matrix[row, column] for row in range(4))) for column in range(4)))


def _spheres(scene: Scene) -> shader.Sphere | None:
    spheres = scene.spheres
    if not spheres.radius.shape[0]:
        return None
    return shader.Sphere(_vec3(spheres.center), spheres.radius, _vec3(spheres.color))


def _planes(planes: Sequence[Plane]) -> shader.Plane | None:
    if not planes:
        return None
    # The normal's length may be anything, so it is normalised here, once, in double.
    structs = [
        shader.Plane(_vec3(plane.point), normalize(_sized(_vec3(plane.normal))), *_pattern(plane.pattern))
        for plane in planes
    ]
    return tree_map(_stack, *structs)


def _stack(*numbers: Any) -> Any:
    """One array of numbers of shape (), some of which may be traced."""
    traced = [number for number in numbers if not isinstance(number, np.floating | np.ndarray)]
    return namespace(*traced, *numbers).stack(numbers)


def _pattern(pattern: Checkerboard | Plain) -> tuple:
    if isinstance(pattern, Plain):
        color = _vec3(pattern.color)
        return np.float64(1), color, color, color
    return pattern.tile_size, _vec3(pattern.even), _vec3(pattern.odd), _vec3(pattern.line)


def _film(scene: Scene) -> shader.FilmUniforms:
    """``None`` for what leaves the image as it is: then the program has no operation for it."""
    film = scene.film
    neutral = isinstance(film.exposure, np.ndarray) and film.exposure == 0
    matrix = None if film.white_point is None else adaptation_matrix(film.white_point)
    return shader.FilmUniforms(
        exposure=None if neutral else 2**film.exposure,
        white_balance=None if matrix is None else Mat3(*(Vec3(*matrix[:, column]) for column in range(3))),
    )


@lru_cache
def adaptation_matrix(white_point: float | tuple[float, float]) -> np.ndarray:
    """Return the 3 x 3 matrix for linear sRGB columns that takes the colour of `white_point` to neutral white (D65).

    white_point: a correlated colour temperature in kelvin, on the Planckian locus after Kang et al. (2002), or
        CIE 1931 chromaticity coordinates (x, y).

    Bradford's chromatic adaptation (Lam 1985), by colour-science.
    """
    colour = colour_science()
    given_xy = isinstance(white_point, tuple)
    xy = np.array(white_point) if given_xy else colour.temperature.CCT_to_xy_Kang2002(white_point)
    srgb = colour.RGB_COLOURSPACES["sRGB"]
    adaptation = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        colour.xy_to_XYZ(xy), colour.xy_to_XYZ(srgb.whitepoint), transform="Bradford"
    )
    return srgb.matrix_XYZ_to_RGB @ adaptation @ srgb.matrix_RGB_to_XYZ
