"""The program that draws: from uniforms to pictures, on one device or several, a tile after another."""

from typing import Any

import jax
import jax.numpy as jnp
from jax.sharding import Mesh, PartitionSpec

from raytrace.backends.jax.devices import AXIS
from raytrace.backends.jax.staged import SEARCHED, Culling, Staged, culling
from raytrace.backends.jax.tiles import Tiles
from raytrace.backends.job import Job
from raytrace.edges import pixels
from raytrace.language.control import running
from raytrace.shader.main import COMPONENTS
from raytrace.shader.uniforms import Uniforms

__all__ = ["draw", "engine_of", "tiles_of"]

Images = dict[str, jax.Array]

_STAGED = Staged()


def engine_of(job: Job) -> Any:
    """Return the engine that the job asks for, a `OneProgram`, or the fast one."""
    return job.engine or _STAGED


def draw(
    job: Job,
    rows: int,
    devices: Mesh,
    differentiated: bool,
    uniforms: Uniforms,
    culled: Culling | None,
    mode: Any,
    first: Any,
) -> Images:
    """The steps that the job keeps, for `rows` rows from row `first` on: arrays (rows, width[, components]).

    culled: what `raytrace.backends.jax.staged.culling` gives, or ``None`` to have it computed here.
    mode: 0, or 1 to skip nothing. differentiated: whether JAX is to differentiate the pictures.
    """
    if culled is None and isinstance(engine_of(job), Staged):
        culled = culling(uniforms, job.program)
    width = job.frame.width
    # Each device has some columns of every row, which share the sky and the ground about equally.
    columns = -(-width // devices.size)

    tiles = tiles_of(job, rows, columns)

    def part(device: jax.Array, *args: Any) -> Images:
        images = _part(job, tiles, device[0] * columns, differentiated, *args)
        return jax.tree.map(lambda image: image[:, :columns], images) if tiles.width > columns else images

    numbers, args = jnp.arange(devices.size, dtype=jnp.int32), (uniforms, culled, mode, first)
    if devices.size > 1:
        everyone = jax.tree.map(lambda _: PartitionSpec(), args)
        part = jax.shard_map(
            part,
            mesh=devices,
            in_specs=(PartitionSpec(AXIS), *everyone),
            out_specs=PartitionSpec(None, AXIS),
            check_vma=False,
        )

    def trimmed(name: str, image: jax.Array) -> jax.Array:
        image = image if image.shape[1] == width else image[:, :width]
        return image if COMPONENTS[name] > 1 else image.reshape(rows, width)

    return {name: trimmed(name, image) for name, image in part(numbers, *args).items()}


def tiles_of(job: Job, rows: int, columns: int) -> Tiles:
    """The tiles of a part of the image, of a size that does not depend on how many parts there are.

    So the kernels are the same, to the last bit, on any number of devices.
    """
    whole = Tiles.of(rows, job.frame.width, engine_of(job).block)
    return whole._replace(width=max(columns, whole.tile_width))


def _part(
    job: Job,
    tiles: Tiles,
    first_column: jax.Array,
    differentiated: bool,
    uniforms: Uniforms,
    culled: Culling | None,
    mode: Any,
    first_row: Any,
) -> Images:
    """One device's part, all of `tiles`: arrays (rows, columns, components)."""
    engine = engine_of(job)
    # A division by a constant would be compiled to a product with the constant's inverse, which is rounded once more.
    one = (mode >= 0).astype(job.dtype)
    frame = job.frame._replace(width=job.frame.width * one, height=job.frame.height * one)

    def tile(row: jax.Array, column: jax.Array) -> Images:
        at = engine
        if isinstance(engine, Staged) and culled is not None:
            at = engine.at_block(job.program, culled, mode, differentiated)
        rows, columns = tiles.pixels(row + first_row, column + first_column)
        with running(at):
            # In a step of its own, so that no other kernel counts the pixels again.
            x, y = at.step(_floats, (columns, rows, jnp.zeros((), job.dtype)))
            steps = pixels(uniforms, job.program, x, y, frame, job.keep)

        def images(steps: Any) -> Images:
            return {name: _interleaved(getattr(steps, name), tiles) for name in job.keep}

        return at.step(images, (steps,))

    return tiles.map(tile, kept=SEARCHED) if differentiated else tiles.draw(tile)


def _floats(column: jax.Array, row: jax.Array, like: jax.Array) -> tuple[jax.Array, jax.Array]:
    return column.astype(like.dtype), row.astype(like.dtype)


def _interleaved(planes: Any, tiles: Tiles) -> jax.Array:
    """A plane or a vector of planes of a tile's pixels as an array (height, width, components)."""
    planes = planes if isinstance(planes, tuple) else (planes,)
    size = tiles.tile_height * tiles.tile_width
    # XLA's fastest way to interleave on a CPU is a transposition.
    together = jnp.stack([jnp.broadcast_to(plane, (size,)) for plane in planes])
    return together.T.reshape(tiles.tile_height, tiles.tile_width, len(planes))
