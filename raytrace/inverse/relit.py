"""A picture under other suns: what a sun does not change is computed once; light and sky are computed for each sun.

Camera rays and what they meet do not depend on the sun, so they are computed once for every sample. What is left for
each sun is a shadow ray, Lambert's cosine and the lobe in the sky: half a millisecond for 192 x 108 samples. The values
are those of `raytrace.render`.

All programs work on chunks of samples, so that they are compiled once for pictures of any size.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from raytrace.inverse.blocks import SIDE, Blocks
from raytrace.inverse.likelihood import Noise, log_likelihood
from raytrace.inverse.programs import kept
from raytrace.scene.data import Scene
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.uniforms import Program

__all__ = ["Relit"]

#: Samples of a chunk, unless one block has more.
CHUNK = 1 << 12
#: The planes of `Chunk.met` that say what surface it is: its colour and its number.
SURFACE = slice(9, 13)
#: How near to an edge a sample lies on it, in pixels.
TIED = 1e-3
#: Suns that one call of a program computes.
SUNS = 32


class Chunk(NamedTuple):
    """Some pixels: what their rays meet, the picture's values (pixels, 3), and which of the pixels there are.

    met: (13, pixels, samples): the ray's direction; position, normal and colour of the surface; its number, -1 for the
    sky. surface, sky: whether any ray meets such.
    """

    met: Any
    surface: Any
    sky: Any
    target: Any
    inside: Any


class Relit:
    """The pixels `blocks` of a scene's picture, with `samples` x `samples` samples each, under any sun and exposure.

    target: the display values (height, width, 3) that it is compared with.
    """

    def __init__(self, scene: Scene, target: np.ndarray, samples: int, blocks: Blocks):
        import jax
        import jax.numpy as jnp

        width, height = target.shape[1::-1]
        # An exposure of 0 would not be a part of the program.
        exposed = replace(scene, film=replace(scene.film, exposure=np.float64(1)))
        self.program, self.samples = program_of(exposed, "robust"), samples
        self.uniforms = jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), uniforms_of(exposed, width / height))
        count, together = len(blocks.row), max(1, CHUNK // (SIDE * SIDE * samples**2))
        chunks = -(-count // together)

        def whole(part: np.ndarray) -> np.ndarray:
            """With as many blocks as fill the last chunk."""
            return part[np.arange(chunks * together) % count]

        at = [whole(part).reshape(chunks, -1).astype(np.float32) for part in (blocks.column, blocks.row)]
        size = np.array([width, height], np.float32)
        given = self.uniforms, size, at[0][0], at[1][0]
        meet = kept(f"met {samples}", self.program, _met(self.program, samples), given)

        def met_at(shift: np.float32) -> np.ndarray:
            parts = [np.asarray(meet(self.uniforms, size, x + shift, y + shift)) for x, y in zip(*at, strict=True)]
            return np.stack(parts, 1).reshape(len(parts[0]), -1, SIDE * SIDE, samples**2)[:, :count]

        met = met_at(np.float32(0))
        # Where a sample lies on an edge of the pattern, or of a silhouette, any engine's last bit decides.
        beside = [met_at(np.float32(shift))[SURFACE] for shift in (-TIED, TIED)]
        tied = (beside[0] != beside[1]).any((0, -1))
        blocks = blocks._replace(inside=blocks.inside & ~tied)
        # Blocks of the sky come first, those of surfaces last: a chunk computes only what it has.
        order = np.argsort((met[-1] >= 0).mean((1, 2)), kind="stable")
        self.blocks, met = blocks.take(order), met[:, order]
        self.target = self.blocks.values(target)
        self._rays, self._index = np.moveaxis(met[:3, :, :, 0], 0, -1), met[-1]
        inside = whole(self.blocks.inside) & (np.arange(chunks * together) < count)[:, None]
        parts = zip(
            np.split(met[:, np.arange(chunks * together) % count], chunks, axis=1),
            np.split(whole(self.target), chunks),
            np.split(inside, chunks),
            strict=True,
        )
        self.chunks = [
            Chunk(
                jnp.asarray(some.reshape(len(some), -1, samples**2)),
                jnp.asarray((some[-1] >= 0).any()),
                jnp.asarray((some[-1] < 0).any()),
                jnp.asarray(values.reshape(-1, 3), jnp.float32),
                jnp.asarray(there.reshape(-1)),
            )
            for some, values, there in parts
        ]

    def log_likelihoods(self, directions: np.ndarray, stops: np.ndarray, noise: Noise) -> np.ndarray:
        """Return the logarithm of the target's probability under each of the suns (n, 3) and exposures (n,)."""
        numbers = noise.numbers()
        sun = np.zeros((SUNS, 3), np.float32), np.zeros(SUNS, np.float32)
        given = self.uniforms, self.chunks[0], *sun, *numbers
        program = kept("log likelihood", self.program, _log_likelihoods(self.program), given)
        total = np.zeros(len(directions))
        for first in range(0, len(directions), SUNS):
            some = np.arange(first, first + SUNS) % len(directions)
            suns = directions[some].astype(np.float32), stops[some].astype(np.float32)
            found = [program(self.uniforms, chunk, *suns, *numbers) for chunk in self.chunks]
            last = min(SUNS, len(directions) - first)
            total[first : first + last] = np.sum([np.asarray(part, np.float64) for part in found], 0)[:last]
        return total

    def values(self, direction: np.ndarray, stops: float) -> np.ndarray:
        """Return the display values (blocks, SIDE * SIDE, 3) under one sun."""
        sun = np.asarray(direction, np.float32), np.float32(stops)
        program = kept("values", self.program, _values(self.program), (self.uniforms, self.chunks[0], *sun))
        found = [np.asarray(program(self.uniforms, chunk, *sun)) for chunk in self.chunks]
        return np.concatenate(found).reshape(-1, SIDE * SIDE, 3)[: len(self.target)].astype(np.float64)

    def slopes(self, direction: np.ndarray, stops: float, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the values under one sun, and their derivatives (3, blocks, SIDE * SIDE, 3).

        They are by the direction along two axes (2, 3), in which it may have any length, and by the stops. A shadow's
        edge that passes a sample has none.
        """
        given = np.asarray(direction, np.float32), np.float32(stops), np.asarray(axes, np.float32)
        program = kept("slopes", self.program, _slopes(self.program), (self.uniforms, self.chunks[0], *given))
        found = [program(self.uniforms, chunk, *given) for chunk in self.chunks]
        values, slopes = (np.concatenate(list(map(np.asarray, parts)), -2) for parts in zip(*found, strict=True))
        values, slopes = (part.reshape(*part.shape[:-2], -1, SIDE * SIDE, 3) for part in (values, slopes))
        count = len(self.target)
        return values[:count].astype(np.float64), slopes[:, :count].astype(np.float64)

    def sky_rays(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the direction of each pixel's first ray, (blocks, SIDE * SIDE, 3), and whether only sky is seen."""
        return self._rays, (self._index < 0).all(-1) & (self._rays[..., 1] >= 0) & self.blocks.inside


@lru_cache
def _met(program: Program, samples: int) -> Callable:
    """What the samples of some pixels meet, as `Chunk.met`."""
    import jax
    import jax.numpy as jnp

    from raytrace.backends.jax.engines import OwnFunctions
    from raytrace.language.control import running
    from raytrace.language.glsl import Vec2
    from raytrace.shader.camera import pixel_to_ndc
    from raytrace.shader.main import main
    from raytrace.shader.pixel import Frame, texture_coordinates
    from raytrace.shader.sampling import sample_grid

    @jax.jit
    def met(uniforms: Any, size: Any, column: Any, row: Any) -> Any:
        with running(OwnFunctions()):
            # Width and height are traced: a division by a constant would be compiled to a product.
            frame = Frame(size[0], size[1], samples)
            offset = sample_grid(samples, column) if samples > 1 else Vec2(*jnp.full((2, 1), 0.5, column.dtype))
            uv = texture_coordinates(column[:, None], row[:, None], Vec2(*(x[None] for x in offset)), frame)
            shape = uv.x.shape
            flat = pixel_to_ndc(uv.x.reshape(-1), uv.y.reshape(-1))
            steps = main(uniforms, program, flat, ("rd", "hitPoint", "N", "albedo", "index"))
        planes = *steps.rd, *steps.hitPoint, *steps.N, *steps.albedo, steps.index.astype(column.dtype)
        return jnp.stack([jnp.broadcast_to(plane, flat.x.shape).reshape(shape) for plane in planes])

    return met


def _developed(program: Program, uniforms: Any, chunk: Chunk, direction: Any, stops: Any) -> Any:
    """The display values, a `Vec3` of (pixels,), of a chunk under one sun."""
    import jax.numpy as jnp
    from jax import lax

    from raytrace.backends.jax.engines import OwnFunctions
    from raytrace.language.control import running
    from raytrace.language.glsl import Vec3
    from raytrace.shader.film import develop
    from raytrace.shader.light import light_at_point
    from raytrace.shader.shadows import footprint_of
    from raytrace.shader.sky import background_color

    shape = chunk.met.shape[1:]
    planes = chunk.met.reshape(len(chunk.met), -1)
    rd, point, normal, albedo = (Vec3(*planes[k : k + 3]) for k in range(0, 12, 3))
    index = planes[12].astype(jnp.int32)
    uniforms = uniforms._replace(
        sun=uniforms.sun._replace(direction=Vec3(*direction)),
        film=uniforms.film._replace(exposure=jnp.exp2(stops)),
    )

    def surface() -> Vec3:
        if program.lighting == "off":
            return albedo
        footprint = footprint_of(uniforms, program)
        return light_at_point(point, normal, index, uniforms, program, False, footprint).light * albedo

    def sky() -> Vec3:
        color = background_color(rd, uniforms.sky, uniforms.sun)
        return Vec3(*(jnp.broadcast_to(c, index.shape) for c in color))

    def nothing() -> Vec3:
        return Vec3(*jnp.zeros((3, *index.shape), chunk.met.dtype))

    with running(OwnFunctions()):
        hit = lax.cond(chunk.surface, surface, nothing)
        missed = lax.cond(chunk.sky, sky, nothing)
        linear = Vec3(*(jnp.where(index < 0, b, a).reshape(shape).mean(-1) for a, b in zip(hit, missed, strict=True)))
        return develop(linear, uniforms.film, program)


@lru_cache
def _log_likelihoods(program: Program) -> Callable:
    import jax

    def many(uniforms: Any, chunk: Chunk, directions: Any, stops: Any, *noise: Any) -> Any:
        def one(sun: tuple) -> Any:
            values = _developed(program, uniforms, chunk, *sun)
            return log_likelihood(chunk.target, values, chunk.inside, *noise)

        return jax.lax.map(one, (directions, stops))

    return jax.jit(many)


@lru_cache
def _values(program: Program) -> Callable:
    import jax
    import jax.numpy as jnp

    def values(uniforms: Any, chunk: Chunk, direction: Any, stops: Any) -> Any:
        return jnp.stack(_developed(program, uniforms, chunk, direction, stops), axis=-1)

    return jax.jit(values)


@lru_cache
def _slopes(program: Program) -> Callable:
    import jax
    import jax.numpy as jnp

    def slopes(uniforms: Any, chunk: Chunk, direction: Any, stops: Any, axes: Any) -> Any:
        def picture(change: Any) -> Any:
            sun = direction + change[:2] @ axes, stops + change[2]
            return jnp.stack(_developed(program, uniforms, chunk, *sun), axis=-1)

        along = jax.vmap(lambda axis: jax.jvp(picture, (jnp.zeros(3),), (axis,)), out_axes=(None, 0))
        return along(jnp.eye(3))

    return jax.jit(slopes)
