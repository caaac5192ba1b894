"""Sun, sky and shadow (assignment, 'Light and Shadow')."""

from collections.abc import Callable
from typing import Any, NamedTuple

from raytrace.language.control import branch, count, step
from raytrace.language.glsl import Vec3, clamp, dot, maximum, normalize, select
from raytrace.language.literal import literal
from raytrace.language.namespace import constant
from raytrace.language.types import Float, Int
from raytrace.shader.plane import any_plane_intersect
from raytrace.shader.sphere import any_sphere_intersect
from raytrace.shader.uniforms import Program, Uniforms

__all__ = [
    "POINT",
    "SHADOW_OFFSET",
    "SHADOW_STARTS",
    "Footprint",
    "Light",
    "light_at_point",
    "place_of_plane",
    "shadow_ray",
]

#: How far along the normal a shadow ray starts, so that a surface does not shadow itself.
SHADOW_OFFSET = literal("1e-3")

#: Where a shadow ray starts: there, as in the assignment, whatever the scene's scale; or on the surface itself, which
#: then is left out of what can block the ray, so that a scene's shadows do not depend on its unit of length.
SHADOW_STARTS = ("offset", "surface")


class Light(NamedTuple):
    """The light received at a point and what it is made of."""

    NdL: Float
    NdSky: Float
    shadow: Float
    light: Vec3


@step
def shadow_ray(ro: Vec3, rd: Vec3, uniforms: Uniforms, program: Program, but: Int | None = None) -> Float:
    """How much light comes along the ray: 0 where a sphere stands at t >= 0, else 1.

    Planes block only where they are asked to (``casts_shadow``); the assignment's does not. `but`: the index of a
    surface that does not block, spheres counted first, then planes; ``None`` for none.
    """
    blocked = any_sphere_intersect(ro, rd, uniforms.spheres, program.intersection, but)
    if uniforms.shadow_planes is not None:
        blocked = blocked | any_plane_intersect(ro, rd, uniforms.shadow_planes, place_of_plane(but, uniforms, program))
    return select(blocked, constant(0, rd.x), 1)


def place_of_plane(index: Int | None, uniforms: Uniforms, program: Program) -> Int | None:
    """Where surface number `index` stands among the planes that cast shadows; -1 where it is none of them."""
    if index is None:
        return None
    number = index - count(uniforms.spheres)
    place = constant(-1, number)
    for i, known in enumerate(program.casting):
        place = select(number == known, i, place)
    return place


class Footprint(NamedTuple):
    """What light is received at: a point, as in the assignment, or all of a pixel (`raytrace.edges`).

    positive: ``max(0, x)``, or its mean over the pixel. centre: a vector at the middle. shadow: `shadow_ray`, or the
    share of the pixel that the sun reaches.
    """

    positive: Callable[[Any], Float]
    centre: Callable[[Vec3], Vec3]
    shadow: Callable[..., Float]


#: The assignment's.
POINT = Footprint(positive=lambda x: maximum(x, 0), centre=lambda v: v, shadow=shadow_ray)


@step
def light_at_point(
    point: Vec3,
    N: Vec3,
    index: Int,
    uniforms: Uniforms,
    program: Program,
    every_shadow: bool = False,
    footprint: Footprint = POINT,
) -> Light:
    """The light that the surface number `index`, of unit normal `N`, receives at `point`: Lambert's sun and a share of
    the sky.

    Where the surface faces away from the sun no shadow ray is sent, unless `every_shadow` asks for its value.
    """
    sun, sky = uniforms.sun, uniforms.sky
    L = normalize(sun.direction)
    NdL = footprint.positive(dot(N, L))
    N = footprint.centre(N)
    NdSky = clamp(0.5 * N.y + 0.5, 0, 1)

    def sent(point, N, index):
        if program.shadow_start == "surface":
            return footprint.shadow(point, L, uniforms, program, index)
        return footprint.shadow(point + SHADOW_OFFSET * N, L, uniforms, program)

    def not_sent(point, N, index):
        return constant(1, N.x)

    if program.lighting == "shadow":
        at_point = (point, N, index)
        shadow = sent(*at_point) if every_shadow else branch(NdL > 0, sent, not_sent, *at_point)
    else:
        shadow = constant(1, NdL)
    return Light(NdL, NdSky, shadow, sun.color * NdL * shadow + sky.high * NdSky)
