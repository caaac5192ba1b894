"""Which spheres rays can meet, told from two coordinates.

The rays of a picture either start at one point (a camera's: a pencil) or run in one direction (towards the sun, or an
orthographic camera's: a beam). Either kind is two-dimensional. A pencil's ray is the point where it meets an image
plane, a beam's ray the point where it meets a plane across its direction; a sphere is a rectangle there, and a ray
outside the rectangle misses the sphere. Along a beam a third coordinate tells which spheres are behind a ray's start.

A ray that misses must be one that the shader, in floating point, calls a miss. So spheres are made larger, and the
blocks of rays wider, by more than all roundings together. With u half the machine epsilon, `ro - center` errs by
u (|ro| + |center|) in each coordinate, b = dot(ro, rd) by 4 u D at a distance D, `nearest = ro - b * rd` by at most
12 u D, |rd|^2 by 6 u, and the squares by 4 u of themselves: together under 16 u (D + |ro| + |center|) in length for the
robust formula. The textbook's ``b*b - c`` errs by at most 16 u D^2 + 2 u r^2, so there the *square* of the radius
grows by that; the sign of t needs the same, since it hangs on ``|ro|^2 - r^2``. `SLACK` is
twice that, in machine epsilons, and covers the roundings of this file's own arithmetic too.

The robust formula limits ``|ro|^2 - r^2`` to the square of its larger root. That keeps the sign of t: a sphere that is
left out because it is behind has a larger root of more than its radius, whose square does not underflow.
"""

from math import inf, nan
from typing import Any, NamedTuple

from raytrace.language.glsl import Vec3, cross, dot, maximum, normalize, select
from raytrace.language.jet import Jet, values
from raytrace.language.namespace import constant, namespace
from raytrace.language.types import Array
from raytrace.shader.uniforms import Camera, Program, Sphere, Uniforms

__all__ = ["EDGE", "Beam", "Coordinates", "Extent", "Pencil", "Region", "outside", "primary_rays", "shadow_rays"]

#: What is added to a radius, in machine epsilons of the distances that enter.
SLACK = 32
#: So many pixels' widths from a ray is what its pixel may see: an edge half a pixel away, and more for its curvature.
PIXELS = 2
#: The coordinates of a picture's rays are in [-1, 1]; a little more, for the rounding at its border.
EDGE = 1.01
#: A camera whose axes are nearer to lying in one plane than this has no coordinates to be trusted.
FLATTEST = 1e-2


class Extent(NamedTuple):
    """A rectangle for each sphere, and how far along the rays it reaches; arrays (n,). NaN bounds nothing."""

    u_low: Array
    u_high: Array
    v_low: Array
    v_high: Array
    w_high: Array


class Coordinates(NamedTuple):
    """Where rays are: planes. `error` is what u and v, and w, may err by, with all that hitting a sphere may err by."""

    u: Array
    v: Array
    w: Array
    error: Array
    w_error: Array

    @classmethod
    def of(cls, u: Any, v: Any, w: Any, error: Any, w_error: Any) -> "Coordinates":
        """The coordinates of rays; of jets, of all rays around them in whose pixel they may be seen."""
        jets = [x for x in (u, v, w) if isinstance(x, Jet)]
        around = sum(PIXELS * jet.spread for jet in jets)
        u, v, w, error, w_error = values((u, v, w, error, w_error))
        return cls(u, v, w, error + around, w_error + around)


class Region(NamedTuple):
    """A rectangle that holds a block's rays, and the start of the rearmost; numbers of shape ()."""

    u_low: Array
    u_high: Array
    v_low: Array
    v_high: Array
    w_low: Array

    @classmethod
    def of(cls, where: Coordinates, among: Array) -> "Region":
        """The region of those rays for which `among` holds; an empty one where there are none."""
        u, v, w, error, w_error = where
        xp = namespace(u)

        def low(x: Array, error: Array) -> Array:
            return xp.min(select(among, x - error, inf))

        def high(x: Array, error: Array) -> Array:
            return xp.max(select(among, x + error, -inf))

        return cls(low(u, error), high(u, error), low(v, error), high(v, error), low(w, w_error))


def outside(bounds: Extent, region: Region) -> Array:
    """Whether no ray of the region can meet the sphere of these bounds; False where either is NaN."""
    return (
        (bounds.u_high < region.u_low)
        | (bounds.u_low > region.u_high)
        | (bounds.v_high < region.v_low)
        | (bounds.v_low > region.v_high)
        | (bounds.w_high < region.w_low)
    )


class Pencil(NamedTuple):
    """Rays from `apex`; `x`, `y`, `z` are the rows of the inverse of the matrix (x, y, 1) -> direction.

    So a direction's coordinates are those of its pixel, in [-1, 1]. lengths: those of the longer of `x` and `y`, and of
    `z`.
    """

    apex: Vec3
    x: Vec3
    y: Vec3
    z: Vec3
    lengths: tuple[Array, Array]

    def coordinates(self, ro: Vec3, rd: Vec3, quadratic: bool) -> Coordinates:
        forward = dot(self.z, rd)
        u, v = dot(self.x, rd) / forward, dot(self.y, rd) / forward
        across, along = self.lengths
        widest = across + maximum(abs(u), abs(v)) * along
        error = SLACK * _epsilon(u) * widest / forward
        none = constant(0, u)
        return Coordinates.of(u, v, none, select(forward > 0, error, inf), none)

    def bounds(self, spheres: Sphere, quadratic: bool) -> Extent:
        center = spheres.center - self.apex
        distance = _length(center)
        slack = SLACK * _epsilon(distance)
        radius = spheres.radius
        grown = _sqrt(radius * radius + slack * distance * distance)
        extra = slack * (distance + radius + _size(spheres.center) + _size(self.apex))
        reach = (grown if quadratic else radius) + extra
        forward, flat = dot(self.z, center), self.lengths[1]
        depth = forward - reach * flat

        def interval(axis: Vec3) -> tuple[Array, Array]:
            """|dot(axis, c) - x * dot(z, c)| <= reach * |axis - x * z| solved for x, without cancellation."""
            middle = dot(axis, center) / forward
            half = reach * _length(axis - middle * self.z) / depth
            # The apex plane cuts the sphere: it may be anywhere on this side of a plane through the apex that it is
            # wholly beyond.
            unbounded = ~(depth > slack * distance * flat)
            low, high = select(unbounded, -inf, middle - half), select(unbounded, inf, middle + half)
            right, left = beyond(axis), beyond(-axis)
            return select(unbounded & right, EDGE, low), select(unbounded & left, -EDGE, high)

        def beyond(axis: Vec3) -> Array:
            """Whether the sphere is beyond the plane of all rays whose coordinate on that axis is `EDGE`."""
            across = axis - self.z * EDGE
            return dot(across, center) > (reach + slack * distance) * _length(across)

        behind = forward + (grown + extra) * flat < -slack * distance * flat
        (u_low, u_high), (v_low, v_high) = interval(self.x), interval(self.y)
        return Extent(u_low, u_high, v_low, v_high, select(behind, constant(-inf, forward), inf))


class Beam(NamedTuple):
    """Rays along the unit vector `direction`; `x` and `y` are unit vectors across it."""

    x: Vec3
    y: Vec3
    direction: Vec3

    def coordinates(self, ro: Vec3, rd: Vec3, quadratic: bool) -> Coordinates:
        size = _size(ro)
        linear = SLACK * _epsilon(size) * size
        # sqrt(r^2 + k (D + S)^2) <= sqrt(r^2 + 2 k D^2) + sqrt(2 k) S: the sphere takes one part, the ray the other.
        square = linear + (2 * SLACK * _epsilon(size)) ** 0.5 * size
        return Coordinates.of(
            dot(self.x, ro), dot(self.y, ro), dot(self.direction, ro), square if quadratic else linear, square
        )

    def bounds(self, spheres: Sphere, quadratic: bool) -> Extent:
        center, radius = spheres.center, spheres.radius
        size = _size(center)
        slack = SLACK * _epsilon(size)
        grown = _sqrt(radius * radius + 2 * slack * size * size)
        extra = slack * (size + radius)
        reach = (grown if quadratic else radius) + extra
        u, v, w = dot(self.x, center), dot(self.y, center), dot(self.direction, center)
        return Extent(u - reach, u + reach, v - reach, v + reach, w + grown + extra)


def primary_rays(uniforms: Uniforms, program: Program) -> Pencil | Beam:
    """The rays of the scene's camera."""
    return beam(-uniforms.camera.view_to_world.z.xyz) if program.orthographic else pencil(uniforms.camera)


def shadow_rays(uniforms: Uniforms, program: Program) -> Beam | None:
    """The rays to the sun, where the program has any."""
    return beam(uniforms.sun.direction) if program.lighting == "shadow" else None


def pencil(camera: Camera) -> Pencil:
    """The rays of a perspective camera (`raytrace.shader.camera.primary_ray`)."""
    turn, columns = camera.view_to_world.mat3, camera.ndc_to_view
    a, b, c = turn * columns.x.xyz, turn * columns.y.xyz, turn * (columns.z.xyz + columns.w.xyz)
    # Each axis is scaled to unit length, so that nothing overflows, and back.
    lengths = [_length(axis) for axis in (a, b, c)]
    a, b, c = (axis / length for axis, length in zip((a, b, c), lengths, strict=True))
    rows = cross(b, c), cross(c, a), cross(a, b)
    volume = dot(a, rows[0])
    volume = select(abs(volume) > FLATTEST, volume, nan)
    x, y, z = (row / (volume * length) for row, length in zip(rows, lengths, strict=True))
    return Pencil(camera.view_to_world.w.xyz, x, y, z, (maximum(_length(x), _length(y)), _length(z)))


def beam(direction: Vec3) -> Beam:
    """The rays along `direction`, of any length but 0."""
    direction = normalize(direction)
    size = Vec3(*(abs(component) for component in direction))
    # The axis that is farthest from the direction is surely not along it.
    along_x = (size.x <= size.y) & (size.x <= size.z)
    along_y = ~along_x & (size.y <= size.z)
    one = constant(1, size.x)
    axis = Vec3(*(select(choice, one, 0) for choice in (along_x, along_y, ~(along_x | along_y))))
    x = normalize(cross(axis, direction))
    return Beam(x, cross(direction, x), direction)


def _length(v: Vec3) -> Array:
    return _sqrt(dot(v, v))


def _sqrt(x: Array) -> Array:
    # Not the shader's: here a NaN must stay one.
    return namespace(x).sqrt(x)


def _size(v: Vec3) -> Array:
    """The sum of the components' sizes, which is at least the length and needs no root."""
    return abs(v.x) + abs(v.y) + abs(v.z)


def _epsilon(x: Array) -> float:
    return float(namespace(x).finfo(x.dtype).eps)
