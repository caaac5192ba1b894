"""Screen space to world space: the primary ray of a pixel (assignment, 'Ray Origin and Ray Direction')."""

from raytrace.language.control import step
from raytrace.language.glsl import Vec2, Vec3, Vec4, normalize
from raytrace.language.types import Float
from raytrace.shader.uniforms import Camera

__all__ = ["orthographic_ray", "pixel_to_ndc", "primary_ray"]


def pixel_to_ndc(u: Float, v: Float) -> Vec2:
    """Normalised device coordinates, in [-1, 1], of the texture coordinates (u, v), in [0, 1]."""
    return 2 * Vec2(u, v) - 1


@step
def primary_ray(camera: Camera, pixel_ndc: Vec2) -> tuple[Vec3, Vec3]:
    """Origin and unit direction, in world space, of the ray through a pixel.

    The pixel's point on the far plane is brought back to view space, where the camera is at the origin, so that
    the point is the direction too.
    """
    pixel_view_space = (camera.ndc_to_view * Vec4(pixel_ndc.x, pixel_ndc.y, 1, 1)).xyz
    ro = camera.view_to_world.w.xyz
    rd = normalize(camera.view_to_world.mat3 * pixel_view_space)
    return ro, rd


@step
def orthographic_ray(camera: Camera, pixel_ndc: Vec2) -> tuple[Vec3, Vec3]:
    """Origin and unit direction of a pixel's ray in a parallel projection.

    An extension: the assignment's formula would draw every projection in perspective. The rays start on the near
    plane and run along the camera's -z.
    """
    pixel_view_space = camera.ndc_to_view * Vec4(pixel_ndc.x, pixel_ndc.y, -1, 1)
    ro = (camera.view_to_world * pixel_view_space).xyz
    rd = normalize(-camera.view_to_world.z.xyz)
    return ro, rd
