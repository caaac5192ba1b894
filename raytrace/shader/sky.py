"""The skybox (assignment, 'Skybox')."""

from raytrace.language.control import branch, step
from raytrace.language.glsl import Vec3, dot, exp2, log2, maximum, mix, normalize, pow, smallest_normal
from raytrace.language.literal import literal
from raytrace.language.namespace import constant
from raytrace.language.types import Float
from raytrace.shader.uniforms import Sky, Sun

__all__ = ["SUN_GRADIENT", "background_color"]

SKY_GRADIENT = literal("1/4")
SUN_GRADIENT = literal("2400")


@step
def background_color(rd: Vec3, sky: Sky, sun: Sun) -> Vec3:
    """The light that comes from infinitely far away along the unit direction `rd`; linear, HDR.

    Gradients by height and by closeness to the sun above the horizon, one colour below it.
    """
    sun_direction = normalize(sun.direction)

    def above_horizon(rd):
        sky_color = mix(sky.low, sky.high, pow(rd.y, SKY_GRADIENT))
        towards_sun = maximum(dot(rd, sun_direction), 0)
        sun_amount = branch(towards_sun > vanishing(rd.y), lobe, no_lobe, towards_sun)
        return mix(sky_color, sun.color, sun_amount)

    def lobe(towards_sun):
        return pow(towards_sun, SUN_GRADIENT)

    def no_lobe(towards_sun):
        return constant(0, towards_sun)

    def below_horizon(rd):
        return sky.void

    return branch(rd.y < 0, below_horizon, above_horizon, rd)


def vanishing(x: Float) -> Float:
    """The cosine, of shape (), up to which the sun's lobe is less than the smallest normal number of the arithmetic.

    smallest_normal ** (1 / 2400): 15.4 degrees from the sun in float32, 42 in float64. So small a share of the sun is
    no share: beside any sky that is not perfectly black it changes no bit of the colour, as it is less than half a unit
    in its last place; many arithmetics make it 0 in any case.
    """
    return exp2(log2(smallest_normal(x)) / SUN_GRADIENT)
