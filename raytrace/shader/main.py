"""``main()``: the steps of the assignment, in order."""

from collections.abc import Callable
from math import inf
from typing import Any, NamedTuple

from raytrace.language.control import at, branch, count
from raytrace.language.glsl import Vec2, Vec3, normalize, select
from raytrace.language.namespace import constant
from raytrace.language.types import Float
from raytrace.shader.camera import orthographic_ray, primary_ray
from raytrace.shader.checkerboard import checkerboard
from raytrace.shader.film import develop
from raytrace.shader.hit import Hit
from raytrace.shader.light import POINT, Footprint, Light, light_at_point
from raytrace.shader.plane import closest_plane_intersect
from raytrace.shader.shadows import footprint_of
from raytrace.shader.sky import background_color
from raytrace.shader.sphere import closest_sphere_intersect
from raytrace.shader.uniforms import Plane, Program, Uniforms

__all__ = ["COMPONENTS", "Steps", "main", "shade"]


class Steps(NamedTuple):
    """Everything that the shader computes on its way to a pixel, by the assignment's names.

    On a miss t and index are -1 and the surface's fields 0. `index` counts the spheres first, then the planes.
    A field that was not asked for is ``None``.
    """

    pixelNdc: Any = None
    rd: Any = None
    t: Any = None
    index: Any = None
    hitPoint: Any = None
    N: Any = None
    NdL: Any = None
    NdSky: Any = None
    shadow: Any = None
    albedo: Any = None
    linear: Any = None
    display: Any = None

    def only(self, fields: tuple[str, ...]) -> "Steps":
        """These steps without the fields that are not among `fields`."""
        return Steps(**{name: getattr(self, name) for name in fields})


#: How many components each step has.
COMPONENTS = dict.fromkeys(Steps._fields, 1) | {
    "pixelNdc": 2,
    **dict.fromkeys(("rd", "hitPoint", "N", "albedo", "linear", "display"), 3),
}
#: The fields that say something of the surface that is seen, or of the sky in its place.
SURFACE = ("hitPoint", "N", "NdL", "NdSky", "shadow", "albedo", "linear")


def main(uniforms: Uniforms, program: Program, pixel_ndc: Vec2, keep: tuple[str, ...]) -> Steps:
    """The steps named in `keep` for the pixels at `pixel_ndc`; whatever else is needed is not kept."""
    ray = orthographic_ray if program.orthographic else primary_ray
    ro, rd = ray(uniforms.camera, pixel_ndc)
    hit = closest_hit(ro, rd, uniforms, program)

    # The film is given the linear image, whether that is kept or not.
    fields = tuple(name for name in SURFACE if name in keep or (name == "linear" and "display" in keep))

    def surface(ro, rd, hit):
        footprint = footprint_of(uniforms, program)
        return shade(ro, rd, hit, uniforms, program, "shadow" in keep, footprint=footprint).only(fields)

    def background(ro, rd, hit):
        zero = constant(0, rd.x)
        black = Vec3(zero, zero, zero)
        color = background_color(rd, uniforms.sky, uniforms.sun) if "linear" in fields else black
        return Steps(hitPoint=black, N=black, NdL=zero, NdSky=zero, shadow=zero, albedo=black, linear=color).only(
            fields
        )

    if uniforms.spheres is None and uniforms.planes is None:
        steps = background(ro, rd, hit)
    else:
        steps = branch(hit.index >= 0, surface, background, ro, rd, hit)

    steps = steps._replace(pixelNdc=pixel_ndc, rd=rd, t=hit.t, index=hit.index)
    if "display" in keep:
        steps = steps._replace(display=develop(steps.linear, uniforms.film, program))
    return steps.only(keep)


def closest_hit(ro: Vec3, rd: Vec3, uniforms: Uniforms, program: Program) -> Hit:
    """What the ray sees first: t and index of a sphere or, numbered after them, a plane; (-1, -1) for the sky.

    A plane is seen only where it is strictly nearer than the closest sphere. A sphere at t = 0 is the closest one
    and yet not seen, as ``main`` wants t > 0: there the planes and the sky are.
    """
    sphere_t, sphere_index = closest_sphere_intersect(ro, rd, uniforms.spheres, program.intersection)
    sphere_seen = sphere_t > 0
    nothing = Hit(constant(-1, sphere_t), constant(-1, sphere_index))
    if uniforms.planes is None:
        return select(sphere_seen, Hit(sphere_t, sphere_index), nothing)
    plane_t, plane_index = closest_plane_intersect(ro, rd, uniforms.planes)
    plane_seen = plane_t < select(sphere_seen, sphere_t, inf)
    plane = Hit(plane_t, plane_index + count(uniforms.spheres))
    return select(plane_seen, plane, select(sphere_seen, Hit(sphere_t, sphere_index), nothing))


def plane_surface(point: Vec3, t: Float, plane: Plane, program: Program) -> tuple[Vec3, Vec3]:
    """Unit normal and colour of a plane at `point`."""
    if not program.patterned:
        return plane.normal, plane.even
    return plane.normal, checkerboard(point, plane.tile_size, plane.even, plane.odd, plane.line)


def shade(
    ro: Vec3,
    rd: Vec3,
    hit: Hit,
    uniforms: Uniforms,
    program: Program,
    every_shadow: bool = False,
    plane_surface: Callable = plane_surface,
    footprint: Footprint = POINT,
) -> Steps:
    """Position, normal, light and colour of the surface that the ray meets at `hit`."""
    hit_point = ro + hit.t * rd
    N, albedo = normal_and_color(hit_point, hit, uniforms, program, plane_surface)
    if program.lighting == "off":
        zero = constant(0, hit.t)
        light = Light(zero, zero, zero, Vec3(zero, zero, zero))
        color = albedo
    else:
        light = light_at_point(hit_point, N, hit.index, uniforms, program, every_shadow, footprint)
        color = light.light * albedo
    return Steps(
        hitPoint=hit_point,
        N=N,
        NdL=light.NdL,
        NdSky=light.NdSky,
        shadow=light.shadow,
        albedo=albedo,
        linear=color,
    )


def normal_and_color(
    point: Vec3, hit: Hit, uniforms: Uniforms, program: Program, plane_surface: Callable = plane_surface
) -> tuple[Vec3, Vec3]:
    """Unit normal and colour of the surface that is hit at `point`, which lies on it."""
    spheres, planes = uniforms.spheres, uniforms.planes

    def on_sphere(point, t, index):
        sphere = at(spheres, index)
        return normalize(point - sphere.center), sphere.color

    def on_plane(point, t, index):
        return plane_surface(point, t, at(planes, index - count(spheres)), program)

    if planes is None:
        return on_sphere(point, *hit)
    if spheres is None:
        return on_plane(point, *hit)
    return branch(hit.index < count(spheres), on_sphere, on_plane, point, *hit)
