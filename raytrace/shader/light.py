"""Sun, sky and shadow (assignment, 'Light and Shadow')."""

from collections.abc import Callable
from typing import Any, NamedTuple

from raytrace.language.control import branch, step
from raytrace.language.glsl import Vec3, clamp, dot, maximum, normalize, select
from raytrace.language.literal import literal
from raytrace.language.namespace import constant
from raytrace.language.types import Float, Int
from raytrace.shader.sphere import any_sphere_intersect
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["POINT", "SHADOW_OFFSET", "Footprint", "Light", "light_at_point", "shadow_ray"]

#: How far along the normal a shadow ray starts, so that a surface does not shadow itself.
SHADOW_OFFSET = literal("1e-3")


class Light(NamedTuple):
    """The light received at a point and what it is made of."""

    NdL: Float
    NdSky: Float
    shadow: Float
    light: Vec3


@step
def shadow_ray(ro: Vec3, rd: Vec3, uniforms: Uniforms, program: Program) -> Float:
    """Return how much light comes along the ray: 0 where a sphere stands at t >= 0, else 1."""
    blocked = any_sphere_intersect(ro, rd, uniforms.spheres, program.intersection)
    return select(blocked, constant(0, rd.x), 1)


def shadow_at_point(point: Vec3, N: Vec3, L: Vec3, index: Int, uniforms: Uniforms, program: Program) -> Float:
    """Return how much of the sun's light reaches a point of normal `N`; the ray starts off the surface."""
    return shadow_ray(point + SHADOW_OFFSET * N, L, uniforms, program)


class Footprint(NamedTuple):
    """What light is received at: a point, as in the assignment; what extends it states its own.

    positive: ``max(0, x)``, or its mean over a pixel. centre: a vector at the pixel's middle. shadow: what
    `shadow_at_point` says; extensions are in `raytrace.shader.shadows` and `raytrace.edges`.
    """

    positive: Callable[[Any], Float]
    centre: Callable[[Vec3], Vec3]
    shadow: Callable[[Vec3, Vec3, Vec3, Int, Uniforms, Program], Float]


#: The assignment's.
POINT = Footprint(positive=lambda x: maximum(x, 0), centre=lambda v: v, shadow=shadow_at_point)


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
    """Return the light that surface number `index`, of unit normal `N`, receives at `point`: Lambert's sun and a share
    of the sky.

    Where the surface faces away from the sun no shadow ray is sent, unless `every_shadow` asks for its value.
    """
    sun, sky = uniforms.sun, uniforms.sky
    L = normalize(sun.direction)
    NdL = footprint.positive(dot(N, L))
    N = footprint.centre(N)
    NdSky = clamp(0.5 * N.y + 0.5, 0, 1)

    def sent(point, N, index):
        return footprint.shadow(point, N, L, index, uniforms, program)

    def not_sent(point, N, index):
        return constant(1, N.x)

    if program.lighting == "shadow":
        at_point = (point, N, index)
        shadow = sent(*at_point) if every_shadow else branch(NdL > 0, sent, not_sent, *at_point)
    else:
        shadow = constant(1, NdL)
    return Light(NdL, NdSky, shadow, sun.color * NdL * shadow + sky.high * NdSky)
