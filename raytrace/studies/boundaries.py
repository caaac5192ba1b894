"""The derivative of an image by boundary integrals: what others are held against.

The mean of the linear colour f over a pixel has two reasons to change with a number p of the scene: f itself changes,
and the edges between its smooth parts move. So

    d mean / dp = integral of df/dp over the smooth parts + integral along the edges of jump * normal velocity

Both are taken along scanlines through each pixel, level and upright ones. Every point has a label: which surface, lit
or dark, which tile of a pattern. Where the label changes there is an edge, found by bisection; its velocity is found by
bisection at p + h and p - h. The shader is asked as it is, for points: no edge is derived from a sphere's or a plane's
equation.

A scanline sees an edge well that it crosses steeply. Of an edge of unit normal n the level scanlines have the share
n_x**2 and the upright ones n_y**2: so neither is asked about an edge along which it runs.

The display image's derivative is that of the film at the mean, along the mean's derivative. All is done twice, with
scanlines in other places: the mean of both is the result, half the difference its error. Of one block that is a guess
from two numbers; of the blocks of an image together it says more.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from raytrace.backends.numpy import Masked
from raytrace.language.control import running
from raytrace.language.glsl import Vec3
from raytrace.language.tree import count, tree_map
from raytrace.scene.data import Scene
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.film import develop
from raytrace.shader.pixel import Frame, pixels
from raytrace.shader.uniforms import Program, Uniforms
from raytrace.studies.differences import block_sums

__all__ = ["Reference", "reference"]

#: Points that are computed at once: their planes fit into the cache, and they lie near to each other.
CHUNK = 1 << 15
#: Sides of the squares in whose order pixels are computed.
NEAR = 16
#: Points along a side of a pixel by which it is judged whether there is an edge in it.
FIRST = 4
#: Steps of a bisection: from a pixel's part to some 1e-8 pixels; and from a bracket to 1e-3 of it, which is enough for
#: velocities, as there are very many.
ROUNDS, FEW = 24, 13
#: An edge that stays within so many pixels does not move.
STILL = 1e-7
#: Edges of a pattern between two neighbouring points that are told apart. More, as near a horizon, are a crowd, and are
#: taken to move alike: then all but the colours at the two ends cancels.
MOST = 2
#: In this distance, in pixels, crowds on a scanline move alike.
NEARBY = 0.5
#: From this share on an edge is crossed steeply.
STEEP = 0.5
#: Edges of all kinds are looked for so often; each time one is found in what is left.
TURNS = 4
#: Bits of a label that number a pattern's tiles.
TILES = 40
#: Half the width of the bracket in which a moved edge is looked for, in pixels, and how far to move a scanline to learn
#: how an edge runs.
BRACKET, ASIDE = 0.02, 2e-3
#: Of a parameter's step, to move edges and to change colours. The second is smaller: the points next to an edge are to
#: stay on their side.
MOVE, CHANGE = 0.03, 1e-5
#: Where an edge passes out of its bracket, or another comes into it, both are made smaller, the move by the square.
SMALLER, TRIES = 8, 3
#: Edges of a smaller jump are kinks: a sphere's terminator is one.
LEAST_JUMP = 1e-9
#: Of so many scanlines one is asked how colours change.
FEWER = 4
#: No colour changes that much by so small a step, but where an edge has passed.
LARGEST_CHANGE = 1e-2
#: A sphere of less than a pixel has so many scanlines across its radius, at most so many in a pixel.
ACROSS, MOST_SCANLINES = 32, 512
#: Where the level and the upright scanlines of the two sets lie, in parts of the distance between them.
GOLDEN = 0.6180339887498949
PLACES = (0.25, GOLDEN - 0.25), (0.25 + GOLDEN, 0.25)

#: Points and weights to integrate over (0, 1). They crowd at both ends, so that what grows like x**(-3/4) there does no
#: harm, which is how the sky's colour changes at the horizon: x = 35 u**4 - 84 u**5 + 70 u**6 - 20 u**7.
_u, _weight = np.polynomial.legendre.leggauss(6)
_u = (_u + 1) / 2
CROWDED = _u**4 * (35 - 84 * _u + 70 * _u**2 - 20 * _u**3)
WEIGHTS = 70 * (_u * (1 - _u)) ** 3 * _weight
#: The same where nothing is near, for both directions at once.
GAUSS = 0.5 - 3**-0.5 / 2, 0.5 + 3**-0.5 / 2


class Reference(NamedTuple):
    """The derivative of a display image.

    image: (height, width, 3). blocks: its sums over blocks (`raytrace.studies.differences.block_sums`), (rows,
    columns). error: their errors, (rows, columns), with a sign: the sum is the error of the total. lost: the share of
    the edges, weighed by their jumps, whose velocity was not found, as where three surfaces meet.
    """

    image: np.ndarray
    blocks: np.ndarray
    error: np.ndarray
    lost: float


def reference(
    scene: Scene,
    parameters: Mapping[str, tuple[Callable[[Scene, Any], Scene], float]],
    size: tuple[int, int],
    scanlines: int = 12,
) -> dict[str, Reference]:
    """Return the derivative of the display image by each of the parameters, from float64.

    parameters: by name, how a scene is changed by a number, and the step of that number that moves edges by some tenths
    of a pixel (`raytrace.studies.worlds.Parameter`). size: (width, height) in pixels. scanlines: of each direction in a
    pixel that has an edge, at least; spheres of less than a pixel have more.
    """
    made = [_Scanned(scene, parameters, size, scanlines, place) for place in PLACES]
    found = {}
    for name in parameters:
        one, other = (each.slopes[name] for each in made)
        sums = [block_sums(image) for image in (one, other)]
        found[name] = Reference(
            (one + other) / 2,
            (sums[0] + sums[1]) / 2,
            (sums[0] - sums[1]) / 2,
            float(np.mean([each.lost[name] for each in made])),
        )
    return found


class _Points:
    """The shader of one scene, asked at points of the picture, in pixels: (0, 0) is the upper left corner of it."""

    def __init__(self, scene: Scene, size: tuple[int, int]):
        self.program: Program = program_of(scene, "textbook")
        self.uniforms: Uniforms = tree_map(
            lambda x: np.asarray(x, np.float64), uniforms_of(scene, float(size[0] / size[1]))
        )
        self.frame = Frame(*size)
        self.spheres = count(self.uniforms.spheres)
        planes = self.uniforms.planes
        if planes is not None:
            colors = [np.stack(color) for color in (planes.even, planes.odd, planes.line)]
            self.patterned = ((colors[0] != colors[1]) | (colors[0] != colors[2])).any(0)
        with np.errstate(all="ignore"):
            self.engine = Masked(self.uniforms, self.program)

    def labels(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the label of each point, whole numbers; x, y: of any shape, the same."""
        return self._ask(x, y, ("index", "shadow", "NdL", "hitPoint", "rd"))[0]

    def colors(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the labels and the linear colours, of shape (..., 3)."""
        return self._ask(x, y, ("index", "shadow", "NdL", "hitPoint", "rd", "linear"))

    def _ask(self, x: np.ndarray, y: np.ndarray, keep: tuple[str, ...]) -> tuple[np.ndarray, Any]:
        shape, x, y = x.shape, x.ravel(), y.ravel()
        label = np.empty(x.size, np.int64)
        color = np.empty((x.size, 3)) if "linear" in keep else None
        for first in range(0, x.size, CHUNK):
            some = slice(first, first + CHUNK)
            with running(self.engine), np.errstate(all="ignore"):
                steps = pixels(self.uniforms, self.program, x[some] - 0.5, y[some] - 0.5, self.frame, keep)
            label[some] = self._label(steps)
            if color is not None:
                for component, plane in enumerate(steps.linear):
                    color[some, component] = plane
        return label.reshape(shape), None if color is None else color.reshape(*shape, 3)

    def _label(self, steps: Any) -> np.ndarray:
        index = np.asarray(steps.index, np.int64)
        dark = (steps.shadow == 0) | ~(steps.NdL > 0)
        across, along = np.zeros(index.shape), np.zeros(index.shape)
        if self.uniforms.planes is not None:
            plane = np.maximum(index - self.spheres, 0)
            shown = (index >= self.spheres) & self.patterned[plane]
            tile = self.uniforms.planes.tile_size[plane]
            across = np.where(shown, np.floor(steps.hitPoint.x / tile + 0.5), 0)
            along = np.where(shown, np.floor(steps.hitPoint.z / tile + 0.5), 0)
        across = np.where(index < 0, steps.rd.y < 0, across)
        most = 2**19 - 1
        tiles = [np.clip(np.nan_to_num(tile), -most, most).astype(np.int64) + most for tile in (across, along)]
        return (((index + 1) * 2 + (dark & (index >= 0))) << TILES) + (tiles[0] << 20) + tiles[1]


class _Edges(NamedTuple):
    """Where scanlines cross edges, arrays (k,), in their order.

    scanline: the number of the scanline. at: where on it, in pixels. before, after: the labels on both sides. kind: how
    many bits of the labels do not matter. jump: the colour before less the colour after, (k, 3). share: n_x**2 or
    n_y**2, whichever is the scanlines'. like: the number of the edge whose share and velocity it has: its own, but for
    some of a crowd.
    """

    scanline: np.ndarray
    at: np.ndarray
    before: np.ndarray
    after: np.ndarray
    kind: np.ndarray
    jump: np.ndarray
    share: np.ndarray
    like: np.ndarray


class _Bracket(NamedTuple):
    """Parts of scanlines whose ends have different labels, arrays (k,)."""

    scanline: np.ndarray
    low: np.ndarray
    high: np.ndarray
    before: np.ndarray
    after: np.ndarray

    def some(self, chosen: np.ndarray) -> "_Bracket":
        return _Bracket._make(array[chosen] for array in self)


class _Scanlines:
    """The scanlines of one direction through some pixels, each from one side of its pixel to the other.

    pixel: the number of the pixel of each scanline, (k,). start: where it begins. beside: its other coordinate. weight:
    the share of the pixel that it stands for.
    """

    def __init__(self, upright: bool, pixel: np.ndarray, start: np.ndarray, beside: np.ndarray, weight: np.ndarray):
        self.upright, self.pixel, self.start, self.beside, self.weight = upright, pixel, start, beside, weight
        self.edges: _Edges

    def points(self, at: np.ndarray, beside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (beside, at) if self.upright else (at, beside)

    def find(self, here: _Points, at: np.ndarray, labels: np.ndarray) -> None:
        """Find the edges between the points `at`, (k, m), whose labels are known."""
        scanline, left = np.nonzero(labels[:, 1:] != labels[:, :-1])
        rest = _Bracket(
            scanline, at[scanline, left], at[scanline, left + 1], labels[scanline, left], labels[scanline, left + 1]
        )
        none = np.empty(0, np.int64)
        found = [_Edges(none, np.empty(0), none, none, none, np.empty((0, 3)), np.empty(0), none)]
        for turn in range(TURNS):
            if not len(rest.scanline):
                break
            # First the edge of a surface or a shadow: of a pattern that is far away there may be very many beside it.
            coarse = rest.before >> TILES != rest.after >> TILES
            kind = np.where(coarse, TILES, 0)
            scanline, low, high, before, after = rest
            beside, goal = self.beside[scanline], before >> kind
            for _ in range(ROUNDS):
                middle = (low + high) / 2
                same = here.labels(*self.points(middle, beside)) >> kind == goal
                low, high = np.where(same, middle, low), np.where(same, high, middle)
            last, inner = here.colors(*self.points(low, beside))
            first, outer = here.colors(*self.points(high, beside))
            crowd = ~coarse & ((_tiles_between(before, after) > MOST) | (turn == TURNS - 1))
            ends = [here.colors(*self.points(at[crowd], beside[crowd]))[1] for at in (rest.low, rest.high)]
            jump = inner - outer
            jump[crowd] = ends[0] - ends[1]
            # What is of a crowd is marked for a while.
            found.append(_Edges(scanline, (low + high) / 2, last, first, kind, jump, np.ones(len(low)), -1 * crowd))
            parts = [
                _Bracket(scanline, rest.low, low, before, last).some((before != last) & ~crowd),
                _Bracket(scanline, high, rest.high, first, after).some((first != after) & ~crowd),
            ]
            rest = _Bracket._make(map(np.concatenate, zip(*parts, strict=True)))
        edges = _Edges._make(map(np.concatenate, zip(*found, strict=True)))
        order = np.lexsort([edges.at, edges.scanline])
        self.edges = _Edges._make(array[order] for array in edges)
        crowd, own = self.edges.like < 0, np.arange(len(order))
        self.edges = self.edges._replace(like=own)
        slope = self.velocities(here, here, ASIDE, aside=True)
        like = np.where(crowd & np.isnan(slope), self._near(np.isnan(slope)), own)
        # An edge that runs along the scanline, as far as can be seen, is left to the scanlines of the other direction.
        share = np.where(np.isnan(slope), 0, 1 / (1 + np.nan_to_num(slope) ** 2))
        self.edges = self.edges._replace(share=share[like], like=like)

    def _near(self, unknown: np.ndarray) -> np.ndarray:
        """Return for each edge the number of the nearest one on its scanline that is known; its own if none is near."""
        edges, own = self.edges, np.arange(len(unknown))
        known = np.flatnonzero(~unknown & (edges.kind == 0))
        if not len(known):
            return own
        best, closest = own, np.full(len(own), NEARBY)
        after = np.searchsorted(known, own)
        for side in (after - 1, after):
            candidate = known[np.clip(side, 0, len(known) - 1)]
            away = np.abs(edges.at[candidate] - edges.at)
            better = (edges.scanline[candidate] == edges.scanline) & (away < closest)
            best, closest = np.where(better, candidate, best), np.where(better, away, closest)
        return best

    def velocities(self, ahead: Any, back: Any, step: float, aside: bool = False) -> np.ndarray:
        """Return how far each edge moves along its scanline, for a number that changes by 1; NaN where not found.

        ahead, back: give the points of the scene for a change by h and -h, or, aside, the scene itself, in which the
        scanline moves.
        """
        edges = self.edges
        result = np.full(len(edges.at), np.nan)
        # A crowd's ends may have one colour; another may yet be taken to move as it does.
        left = np.flatnonzero((np.abs(edges.jump).max(-1, initial=0) > LEAST_JUMP) | (edges.kind == 0))
        bracket = BRACKET
        for _ in range(TRIES):
            if not len(left):
                break
            at, kind = edges.at[left], edges.kind[left]
            before, after = edges.before[left] >> kind, edges.after[left] >> kind
            beside = self.beside[edges.scanline[left]]
            sides = [
                (side, beside + sign * step) if aside else (side(step), beside)
                for sign, side in ((1, ahead), (-1, back))
            ]
            moves = np.ones(len(left), bool)
            if bracket == BRACKET:
                still = [self._between(*side, at - STILL, at + STILL, before, after, kind) for side in sides]
                moves = ~(still[0] & still[1])
                result[left[~moves]] = 0
            at, before, after, kind = (array[moves] for array in (at, before, after, kind))
            places = [self._moved(points, beside[moves], at, before, after, kind, bracket) for points, beside in sides]
            result[left[moves]] = (places[0] - places[1]) / (2 * step)
            left = left[np.isnan(result[left])]
            bracket, step = bracket / SMALLER, step / SMALLER**2
        result = result[edges.like]
        if aside:
            return result
        # Near a horizon crowds are too dense for that.
        lacking = np.isnan(result) & (edges.kind == 0) & (edges.share > STEEP)
        return np.where(lacking, result[self._near(np.isnan(result) | (edges.share <= STEEP))], result)

    def _between(self, points: _Points, beside: Any, low: Any, high: Any, before: Any, after: Any, kind: Any) -> Any:
        """Whether what is between `low` and `high` is that edge and no other, as far as their labels say."""
        return (points.labels(*self.points(low, beside)) >> kind == before) & (
            points.labels(*self.points(high, beside)) >> kind == after
        )

    def _moved(
        self, points: _Points, beside: Any, at: Any, before: Any, after: Any, kind: Any, bracket: float
    ) -> np.ndarray:
        """Return where the edges are that were `at`; NaN where they are not in the bracket, or not alone."""
        # Else neighbours that move alike would all be rounded alike.
        uneven = bracket * (1 + 0.3 * np.random.default_rng(0).uniform(-1, 1, (2, len(at))))
        low, high = at - uneven[0], at + uneven[1]
        fits = self._between(points, beside, low, high, before, after, kind)
        result = np.full(len(at), np.nan)
        low, high, beside, before, kind = low[fits], high[fits], beside[fits], before[fits], kind[fits]
        for _ in range(FEW):
            middle = (low + high) / 2
            same = points.labels(*self.points(middle, beside)) >> kind == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        result[fits] = (low + high) / 2
        return result

    def pieces(self, chosen: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return points that integrate over the pieces between edges of the chosen pixels' scanlines.

        chosen: whether a pixel is, by its number. Gives the pixel's number (k,), the points' two coordinates and their
        weights, (k, m); and (k,) by how much those weights are to be multiplied if few scanlines are to stand for all.
        """
        lines = np.flatnonzero(chosen[self.pixel])
        inside = chosen[self.pixel[self.edges.scanline]]
        scanline, cut = self.edges.scanline[inside], self.edges.at[inside]
        owner = np.concatenate([lines, scanline, lines])
        place = np.concatenate([self.start[lines], cut, self.start[lines] + 1])
        kind = np.repeat([0, 1, 2], [len(lines), len(scanline), len(lines)])
        order = np.lexsort([place, kind, owner])
        owner, place = owner[order], place[order]
        whole = owner[1:] == owner[:-1]
        owner, low, length = owner[:-1][whole], place[:-1][whole], np.diff(place)[whole]
        at = low[:, None] + length[:, None] * CROWDED
        beside = np.broadcast_to(self.beside[owner, None], at.shape)
        weights = length[:, None] * WEIGHTS * self.weight[owner, None]
        few = np.where((owner + self.pixel[owner]) % FEWER == 0, FEWER, 0)
        return self.pixel[owner], *self.points(at, beside), weights, few


class _Scanned:
    """One set of scanlines through a picture: its mean linear colour, and the display image's derivatives."""

    def __init__(self, scene: Scene, parameters: Mapping[str, Any], size: tuple[int, int], least: int, place: Any):
        self.width, self.height = size
        self.here = _Points(scene, size)
        number = _scanlines_of(scene, size, least)
        row, column = np.divmod(np.arange(self.width * self.height), self.width)
        order = np.lexsort([column, row, column // NEAR, row // NEAR])
        edged = self._have_edges(row, column)
        # A pixel with a sphere that may be missed has as many scanlines as find it.
        edged |= number.ravel() > least
        order_of = order[edged[order]]
        self.sets = []
        for n in np.unique(number.ravel()[order_of]):
            chosen = order_of[number.ravel()[order_of] == n]
            # Many points a pixel: some pixels at a time.
            self.sets.append(self._scan(row[chosen], column[chosen], chosen, int(n), place))
        plain = order[~edged[order]]
        v, u = (np.array(corner) for corner in np.meshgrid(GAUSS, GAUSS))
        x, y = column[plain, None] + u.ravel(), row[plain, None] + v.ravel()
        smooth = [(plain, x, y, np.full(x.shape, 1 / 4), np.ones(len(plain)))]
        for level, upright, steep in self.sets:
            smooth += [level.pieces(steep), upright.pieces(~steep)]
        self.smooth = [np.concatenate([np.repeat(part[0], part[1].shape[1]) for part in smooth])]
        self.smooth += [np.concatenate([part[i].ravel() for part in smooth]) for i in (1, 2, 3)]
        pixel, x, y, weight = self.smooth
        labels, color = self.here.colors(x, y)
        self.mean = self._sums(pixel, weight[:, None] * color)
        # How colours change is asked of fewer points: only those of the pixels without edges count in full.
        some = np.concatenate([np.repeat(part[4], part[1].shape[1]) for part in smooth])
        self.smooth = [array[some > 0] for array in (pixel, x, y, weight * some)]
        self.labels = labels[some > 0]
        self.slopes, self.lost = {}, {}
        for name, (moved, step) in parameters.items():

            def at(h: float, moved: Any = moved) -> _Points:
                return _Points(moved(scene, h), size)

            slope = self._smooth(at, CHANGE * step)
            edges, self.lost[name] = self._edges(at, MOVE * step)
            self.slopes[name] = _developed(self.here, self.mean, slope + edges).reshape(self.height, self.width, 3)

    def _sums(self, pixel: np.ndarray, values: np.ndarray) -> np.ndarray:
        number = self.width * self.height
        return np.stack([np.bincount(pixel, values[:, i], number) for i in range(3)], -1)

    def _have_edges(self, row: np.ndarray, column: np.ndarray) -> np.ndarray:
        """Whether not all points of a pixel have one label: a grid inside, and its corners."""
        n = FIRST
        x, y = (np.arange(side * n + 1) / n for side in (self.width, self.height))
        # Tile after tile, so that points that are computed together are near each other.
        labels = np.empty((len(y), len(x)), np.int64)
        for top in range(0, len(y), 64):
            for left in range(0, len(x), 64):
                tile = slice(top, top + 64), slice(left, left + 64)
                labels[tile] = self.here.labels(*np.meshgrid(x[tile[1]], y[tile[0]]))
        first = labels[n * row, n * column]
        edged = np.zeros(len(row), bool)
        for down in range(n + 1):
            for across in range(n + 1):
                edged |= labels[n * row + down, n * column + across] != first
        return edged

    def _scan(self, row: np.ndarray, column: np.ndarray, pixel: np.ndarray, n: int, place: Any) -> tuple:
        """Return level and upright scanlines through pixels with their edges found, and which pixels' are steep."""
        u, v = ((np.arange(n) + part % 1) / n for part in place)
        k = len(pixel)
        # The points of level scanlines are those of upright ones, but for the ends.
        x, y = (np.concatenate([[0], offset, [1]]) for offset in (u, v))
        labels = self.here.labels(
            np.broadcast_to(column[:, None, None] + x, (k, n + 2, n + 2)),
            np.broadcast_to(row[:, None, None] + y[:, None], (k, n + 2, n + 2)),
        )
        which = np.repeat(pixel, n)
        weight = np.full(k * n, 1 / n)
        level = _Scanlines(False, which, np.repeat(column * 1.0, n), (row[:, None] + v).ravel(), weight)
        upright = _Scanlines(True, which, np.repeat(row * 1.0, n), (column[:, None] + u).ravel(), weight)
        level.find(self.here, level.start[:, None] + x, labels[:, 1:-1].reshape(k * n, n + 2))
        upright.find(self.here, upright.start[:, None] + y, labels[:, :, 1:-1].swapaxes(1, 2).reshape(k * n, n + 2))
        across, down = (
            np.bincount(
                lines.pixel[lines.edges.scanline],
                lines.edges.share * np.abs(lines.edges.jump).max(-1, initial=0) / n,
                self.width * self.height,
            )
            for lines in (level, upright)
        )
        return level, upright, across >= down

    def _smooth(self, at: Callable, h: float) -> np.ndarray:
        """The mean of df/dp over each pixel, (pixels, 3)."""
        pixel, x, y, weight = self.smooth
        slopes = []
        fits = np.ones(len(x), bool)
        for sign in (1, -1):
            label, color = at(sign * h).colors(x, y)
            fits &= label == self.labels
            slopes.append(sign * color)
        change = slopes[0] + slopes[1]
        # Next to a horizon tiles are too far away to be numbered.
        fits &= np.abs(change).max(-1, initial=0) < LARGEST_CHANGE
        return self._sums(pixel, np.where(fits, weight / (2 * h), 0)[:, None] * change)

    def _edges(self, at: Callable, h: float) -> tuple[np.ndarray, float]:
        """What edges that move add, (pixels, 3), and the share of them that is lost."""
        total, lost, seen = np.zeros((self.width * self.height, 3)), 0.0, 0.0
        for level, upright, _ in self.sets:
            for lines in (level, upright):
                edges = lines.edges
                velocity = lines.velocities(at, lambda step: at(-step), h)
                weight = edges.share * lines.weight[edges.scanline]
                size = weight * np.abs(edges.jump).max(-1, initial=0)
                missed = np.isnan(velocity) & (np.abs(edges.jump).max(-1, initial=0) > LEAST_JUMP)
                lost, seen = lost + size[missed].sum(), seen + size.sum()
                moved = (weight * np.nan_to_num(velocity))[:, None] * edges.jump
                total += self._sums(lines.pixel[edges.scanline], moved)
        return total, lost / (seen or 1.0)


def _tiles_between(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """How many edges of tiles lie between points of one surface, by their labels."""
    half, mask = TILES // 2, (1 << TILES // 2) - 1
    across, along = (np.abs((before >> bits & mask) - (after >> bits & mask)) for bits in (half, 0))
    return across + along


def _developed(here: _Points, mean: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """The derivative of the display values of `mean` along `slope`, both (k, 3)."""
    light, fastest = (np.abs(each).max(-1, keepdims=True) for each in (mean, slope))
    step = np.where((light > 0) & (fastest > 0), 1e-5 * light / np.maximum(fastest, 1e-300), 1.0)
    # No light is negative, which a component that is nearly dark must not become.
    darkened = np.where((mean > 0) & (slope != 0), 0.1 * mean / np.maximum(np.abs(slope), 1e-300), np.inf)
    step = np.minimum(step, darkened.min(-1, keepdims=True))
    ahead, back = (
        np.stack(develop(Vec3(*np.maximum(mean + sign * step * slope, 0).T), here.uniforms.film, here.program), -1)
        for sign in (1, -1)
    )
    return (ahead - back) / (2 * step)


def _scanlines_of(scene: Scene, size: tuple[int, int], least: int) -> np.ndarray:
    """How many scanlines each pixel has, (height, width): more where a sphere of less than a pixel may be."""
    width, height = size
    number = np.full((height, width), least)
    uniforms = uniforms_of(scene, width / height)
    if uniforms.spheres is None:
        return number
    to_view, to_world = (np.array(columns, float).T for columns in uniforms.camera)
    to_ndc = np.linalg.inv(to_world @ to_view)
    for center, radius in zip(np.stack(uniforms.spheres.center, -1), uniforms.spheres.radius, strict=True):
        ndc = to_ndc @ np.append(center, 1)
        if ndc[3] <= 0:
            continue
        x, y = (ndc[0] / ndc[3] + 1) / 2 * width, (1 - ndc[1] / ndc[3]) / 2 * height
        distance = np.linalg.norm(center - to_world[:3, 3])
        # What it is in the middle of the picture; towards the corners it is more.
        seen = radius / max(distance, 1e-9) / to_view[1, 1] * height / 2
        if seen >= 1:
            continue
        n = int(np.clip(np.ceil(ACROSS / seen), least, MOST_SCANLINES))
        top, left = (max(int(np.floor(c - 2 * seen)), 0) for c in (y, x))
        bottom, right = (int(np.floor(c + 2 * seen)) + 1 for c in (y, x))
        part = number[top : max(bottom, 0), left : max(right, 0)]
        np.maximum(part, n, out=part)
    return number
