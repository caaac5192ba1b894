"""Into how many squares a pixel is cut: none where no edge runs through it, more where edges meet or bend.

An edge is looked for around the ray through the pixel's middle, by how far the ray's point on the surface moves over
the pixel (a ray differential; Igehy, 'Tracing Ray Differentials', SIGGRAPH 1999). It is rather found in vain than
missed.
"""

from typing import NamedTuple

from raytrace.edges.pattern import STRIPS
from raytrace.language.control import at, branch, count, each, step
from raytrace.language.glsl import (
    Vec2,
    Vec3,
    clamp,
    dot,
    floor,
    maximum,
    minimum,
    normalize,
    select,
    smallest_divisor,
    sqrt,
)
from raytrace.language.jet import Jet, values
from raytrace.language.namespace import constant
from raytrace.language.types import Bool, Float, Int
from raytrace.shader.hit import ShadowEdges, Silhouettes
from raytrace.shader.light import SHADOW_OFFSET
from raytrace.shader.main import Steps
from raytrace.shader.sky import SUN_GRADIENT
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["Cut", "cuts"]

#: Squares along either side of a pixel with one edge, of one with an edge over the pattern's, and of one in which edges
#: meet or bend.
FEW, SOME, MANY = 4, 8, 12
#: A sphere of fewer pixels' radius is tiny. Its pixel has so many columns and rows. Of these the share `MOST` is on the
#: sphere and a little `AROUND` it; on one that is smaller than `TINIEST` they are as on one of that radius.
TINY, TINYS, MOST, AROUND, TINIEST = 0.7, 24, 2 / 3, 1.1, 2.0**-10
#: Columns and rows of a pixel in which there is but the pattern: so many, or as many more as keep the strips of each
#: square shorter than so large a part of a tile.
PATTERN, FINER, LONGEST = 2, (4, 8, 16), 0.125
#: Edges are looked for so much farther away than the pixel reaches, as surfaces bend.
MARGIN = 1.25
#: A sphere, or its shadow, is small if its radius is less than so many times what the pixel reaches: its edge bends.
SMALL = 6
#: A surface that turns by more radians than this within a pixel is of many slopes; by fewer than that, the kink at its
#: terminator is none.
TURN, KINK = 0.25, 1 / 32
#: A surface seen at a smaller sine than this is taken to be seen at it, so that what a pixel sees of it is finite.
FLATTEST = 2.0**-10


class Footprint(NamedTuple):
    """How far a point moves from the middle of a pixel to its right and lower sides."""

    right: Vec3
    down: Vec3

    def along(self, axis: Vec3) -> Float:
        """How far it moves along a unit vector, at most."""
        return MARGIN * (abs(dot(self.right, axis)) + abs(dot(self.down, axis)))

    def reach(self) -> Float:
        """How far it moves, at most."""
        return MARGIN * (length(self.right) + length(self.down))


def length(v: Vec3) -> Float:
    return sqrt(dot(v, v))


def halves(v: Vec3) -> Footprint:
    """How a vector of jets, or of planes that do not change, changes from the pixel's middle to its sides."""
    zero = constant(0, values(v.x))
    sides = ((x.dx / 2, x.dy / 2) if isinstance(x, Jet) else (zero, zero) for x in v)
    return Footprint(*(Vec3(*side) for side in zip(*sides, strict=True)))


def on_surface(ray: Footprint, start: Footprint, rd: Vec3, seen: Steps) -> Footprint:
    """How far the point moves on the surface that the rays meet, which is taken to be flat."""
    facing = dot(rd, seen.N)
    facing = select(abs(facing) < FLATTEST, select(facing < 0, constant(-FLATTEST, facing), FLATTEST), facing)

    def moved(ray, start):
        across = start + seen.t * ray
        return across - rd * (dot(across, seen.N) / facing)

    return Footprint(*map(moved, ray, start))


class Cut(NamedTuple):
    """Into how many columns and rows a pixel is cut, (0, 0) where it has no edge, and where most of them are.

    Most are within `half` of (x, y), in pixels from the middle; the rest share what is left on either side.
    """

    columns: Int
    rows: Int
    x: Float
    y: Float
    half: Float

    def square(self, k: Int) -> tuple[Vec2, Vec2]:
        """Return the middle of square number `k`, in pixels from that of the pixel, and its width and height."""
        k, columns, rows = (constant(x, self.half) for x in (k, self.columns, self.rows))
        row = floor((k + 0.5) / columns)
        sides = []
        for place, number, middle in ((k - columns * row, columns, self.x), (row, rows, self.y)):
            low, high = (clamp(middle + side, -0.5, 0.5) for side in (-self.half, self.half))
            ends = [_warped(end / number, low, high) for end in (place, place + 1)]
            sides.append(((ends[0] + ends[1]) / 2, ends[1] - ends[0]))
        (x, width), (y, height) = sides
        return Vec2(x, y), Vec2(width, height)


def _warped(x: Float, low: Float, high: Float) -> Float:
    """Return the place of `x`, from 0 to 1, where most of that is stretched from `low` to `high`, the rest to +-1/2."""
    outside = (1 - MOST) / 2
    before = minimum(x / outside, 1) * (low + 0.5)
    within = clamp((x - outside) / MOST, 0, 1) * (high - low)
    after = maximum((x - 1) / outside + 1, 0) * (0.5 - high)
    return before + within + after - 0.5


def cuts(uniforms: Uniforms, program: Program, ro: Vec3, rd: Vec3, seen: Steps) -> Cut:
    """Return into what squares a pixel is cut.

    ro, rd: the ray through its middle, of jets. seen: t, index, hitPoint and N there.
    """
    number, size, x, y = edges(uniforms, program, ro, rd, seen)
    n = select(number > 1, constant(MANY, number), select(number > 0, constant(FEW, number), 0))
    tiny = size < TINY
    n = select(tiny, constant(TINYS, number), n)
    x, y = select(tiny, x, 0), select(tiny, y, 0)
    half = select(tiny, maximum(size, TINIEST) * AROUND, MOST / 2)
    if not program.patterned:
        return Cut(n, n, x, y, half)
    columns, rows = patterns(uniforms, ro, rd, seen)
    n = select((number > 0) & (columns > 0), maximum(n, SOME), n)
    return Cut(maximum(n, columns), maximum(n, rows), x, y, half)


@step
def edges(uniforms: Uniforms, program: Program, ro: Vec3, rd: Vec3, seen: Steps) -> tuple[Int, Float, Float, Float]:
    """Return how many edges a pixel has, but for the pattern's; one that bends within it counts twice.

    And of the smallest sphere there the radius and the middle (x, y), in pixels from that of the pixel.
    """
    start, ray = halves(ro), halves(rd)
    surface = on_surface(ray, start, values(rd), seen)
    reach = surface.reach()
    found = silhouettes(uniforms, ro, rd, start, ray, reach, seen)
    number = found.number + planes(uniforms, ray, values(rd), surface, seen)
    if program.lighting != "off" and uniforms.spheres is not None:
        # Where the surface turns within the pixel the light on it is of many kinds.
        radius = at(uniforms.spheres.radius, seen.index)
        turn = select(seen.index < count(uniforms.spheres), reach / maximum(radius, smallest_divisor(reach)), 0)
        number = number + 2 * counted((seen.index >= 0) & (turn > TURN))
        L = normalize(uniforms.sun.direction)
        facing = dot(seen.N, L)
        # The terminator: the light has a kink there.
        number = number + counted((seen.index >= 0) & (abs(facing) < turn) & (turn > KINK))
        if program.lighting == "shadow":
            lit = (seen.index >= 0) & (facing > -turn)
            number = number + shadow_edges(uniforms, program, L, surface, lit, seen)
    return number, found.size, found.x, found.y


def counted(condition: Bool) -> Int:
    """1 where the condition holds, else 0."""
    return select(condition, constant(1, condition, "int32"), 0)


def crosses(squared: Float, radius: Float, reach: Float) -> Bool:
    """Whether a distance, given as its square, is that radius within the reach."""
    low, high = maximum(radius - reach, 0), radius + reach
    return (squared <= high * high) & ((squared >= low * low) | (radius < reach))


def weight(edge: Bool, radius: Float, reach: Float) -> Int:
    """1 for a sphere's edge, or 2 for a small sphere's, which bends; 0 for none."""
    return counted(edge) + counted(edge & (radius < SMALL * reach))


def silhouettes(
    uniforms: Uniforms, ro: Vec3, rd: Vec3, start: Footprint, ray: Footprint, reach: Float, seen: Steps
) -> Silhouettes:
    """The silhouettes of spheres, and where spheres meet the surface that is seen."""

    # The rays are jets, so that an engine finds what the pixel sees, and not its middle alone.
    def body(found, i, sphere, ro, rd, start, ray, reach, t, index, point):
        ro, rd = values(ro), values(rd)
        center = sphere.center - ro
        b = dot(center, rd)
        beside = center - b * rd
        moved = Footprint(*(at_start + maximum(b, 0) * along for at_start, along in zip(start, ray, strict=True)))
        width = moved.reach()
        # Behind the surface it is not seen.
        ahead = (b > 0) & ((index < 0) | (index == i) | (b - sphere.radius - width <= t + reach))
        outside = dot(center, center) > sphere.radius * sphere.radius
        outline = ahead & outside & crosses(dot(beside, beside), sphere.radius, width)
        apart = point - sphere.center
        passed = dot(beside, beside) <= (sphere.radius + width) * (sphere.radius + width)
        meets = passed & (index >= 0) & (index != i) & crosses(dot(apart, apart), sphere.radius, reach)
        number = found.number + weight(outline, sphere.radius, width) + weight(meets, sphere.radius, reach)
        right, down = (maximum(dot(half, half), smallest_divisor(b)) for half in moved)
        size = sphere.radius / (2 * sqrt(minimum(right, down)))
        place = (dot(beside, half) / (2 * squared) for half, squared in zip(moved, (right, down), strict=True))
        smaller = outline & (size < found.size)
        return Silhouettes(number, *select(smaller, (size, *place), (found.size, found.x, found.y)))

    zero = constant(0, values(rd.x))
    nothing = Silhouettes(constant(0, seen.index), constant(1, zero), zero, zero)
    return each(uniforms.spheres, body, nothing, ro, rd, start, ray, reach, seen.t, seen.index, seen.hitPoint)


def planes(uniforms: Uniforms, ray: Footprint, rd: Vec3, surface: Footprint, seen: Steps) -> Int:
    """The horizons, and where planes meet the surface that is seen."""
    first = count(uniforms.spheres)
    # Beside a sphere there is no horizon to be seen; its silhouette is an edge by itself.
    open_ = (seen.index < 0) | (seen.index >= first)

    def body(number, i, plane, ray, rd, surface, open_, index, point):
        horizon = open_ & (abs(dot(rd, plane.normal)) < ray.along(plane.normal))
        other = (index >= 0) & (index != i + first)
        meets = other & (abs(dot(point - plane.point, plane.normal)) < surface.along(plane.normal))
        return number + counted(horizon) + counted(meets)

    up = Vec3(*(constant(x, rd.x) for x in (0, 1, 0)))
    # The sky is steep at its horizon, and about the sun.
    from_sun = (1 - dot(rd, normalize(uniforms.sun.direction))) * SUN_GRADIENT
    steep = (from_sun < 8) & (ray.reach() * ray.reach() * SUN_GRADIENT > 1 / 16)
    sky = counted((seen.index < 0) & (steep | (abs(rd.y) < 2 * ray.along(up))))
    return each(uniforms.planes, body, sky, ray, rd, surface, open_, seen.index, seen.hitPoint)


@step
def patterns(uniforms: Uniforms, ro: Vec3, rd: Vec3, seen: Steps) -> tuple[Int, Int]:
    """Return into how many columns and rows a pixel is cut for the pattern that is seen: the more, the farther."""
    first = count(uniforms.spheres)

    def on_plane(surface, point, index):
        plane = at(uniforms.planes, index - first)

        def edge(x, right, down):
            x, reach = x / plane.tile_size, MARGIN * (abs(right) + abs(down)) / plane.tile_size
            return abs(x - floor(x) - 0.5) <= reach

        crossed = edge(point.x, surface.right.x, surface.down.x) | edge(point.z, surface.right.z, surface.down.z)

        def parts(side):
            longest = 2 * maximum(abs(side.x), abs(side.z)) / plane.tile_size
            n = constant(PATTERN, index)
            for power in FINER:
                n = maximum(n, select(longest > power / 2 * STRIPS * LONGEST, constant(power, index), 0))
            return select(crossed, n, 0)

        return parts(surface.right), parts(surface.down)

    def none(surface, point, index):
        return constant(0, index), constant(0, index)

    surface = on_surface(halves(rd), halves(ro), values(rd), seen)
    return branch(seen.index >= first, on_plane, none, surface, seen.hitPoint, seen.index)


def shadow_edges(uniforms: Uniforms, program: Program, L: Vec3, surface: Footprint, lit: Bool, seen: Steps) -> Int:
    """The edges of spheres' shadows on the surface that is seen; those of planes are where it meets them."""

    def beside(v):
        return v - dot(v, L) * L

    def sent(reach, point, index):
        def body(found, i, sphere, ro, rd, reach, index):
            center = sphere.center - values(ro)
            b = dot(center, rd)
            across = center - b * rd
            edge = (b > -reach) & crosses(dot(across, across), sphere.radius, reach)
            if program.shadow_start == "surface":
                edge = edge & (index != i)
            return ShadowEdges(found.number + weight(edge, sphere.radius, reach))

        rd = Vec3(*(x + 0 * reach for x in L))
        return each(uniforms.spheres, body, ShadowEdges(constant(0, index)), point, rd, reach, index).number

    def not_sent(reach, point, index):
        return constant(0, index)

    reach = Footprint(*map(beside, surface)).reach()
    start = seen.hitPoint + SHADOW_OFFSET * seen.N if program.shadow_start == "offset" else seen.hitPoint
    start = Vec3(*(Jet(x, 2 * right, 2 * down) for x, right, down in zip(start, *surface, strict=True)))
    return branch(lit, sent, not_sent, reach, start, seen.index)
