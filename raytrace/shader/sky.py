"""The skybox (assignment, 'Skybox')."""

from raytrace.shader.control import branch, step
from raytrace.shader.glsl import Vec3, dot, maximum, mix, normalize, pow
from raytrace.shader.literal import literal
from raytrace.shader.uniforms import Sky, Sun

__all__ = ["background_color"]

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
        sun_amount = pow(maximum(dot(rd, sun_direction), 0), SUN_GRADIENT)
        return mix(sky_color, sun.color, sun_amount)

    def below_horizon(rd):
        return sky.void

    return branch(rd.y < 0, below_horizon, above_horizon, rd)
