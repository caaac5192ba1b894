"""The program that draws: from uniforms to pictures, on one device or several, by whichever engine."""

from typing import Any

import jax
import jax.numpy as jnp
from jax import lax
from jax.sharding import Mesh, PartitionSpec

from raytrace.backends.jax.devices import AXIS
from raytrace.backends.jax.engines import Fused
from raytrace.backends.jax.kernel import Images, Kernels, Where, draw_by_kernel, prepared
from raytrace.backends.jax.staged import SEARCHED, Culling, Staged, culling
from raytrace.backends.jax.tiles import Tiles
from raytrace.backends.job import Job
from raytrace.edges import pixels
from raytrace.language.control import running
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import Frame
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["draw", "draw_part", "prepare_spheres", "tiles_of", "trimmed"]

#: Images by name.
Drawn = dict[str, jax.Array]


def prepare_spheres(engine: Any, uniforms: Uniforms, program: Program) -> Culling | None:
    """Return what the engine prepares of the spheres once for a whole picture; ``None`` where it needs nothing."""
    if isinstance(engine, Kernels):
        return prepared(uniforms, program)
    return culling(uniforms, program) if isinstance(engine, Staged) else None


def draw(
    job: Job,
    engine: Any,
    rows: int,
    devices: Mesh,
    differentiated: bool,
    uniforms: Uniforms,
    culled: Culling | None,
    mode: Any,
    first: Any,
) -> Drawn:
    """The steps that the job keeps, for `rows` rows from row `first` on: arrays (rows, width[, components]).

    engine: what `raytrace.backends.jax.choice.engine_of` gives. culled: what `prepare_spheres` gives, or ``None`` to
    have it computed here. mode: 0, or 1 to skip nothing. differentiated: whether JAX is to differentiate the pictures.
    """
    if culled is None:
        culled = prepare_spheres(engine, uniforms, job.program)
    # Each device has some columns of every row, which share the sky and the ground about equally.
    columns = -(-job.frame.width // devices.size)

    def part(device: jax.Array, uniforms: Uniforms, culled: Culling | None, mode: Any, first: Any) -> Drawn:
        where = Where(mode, first, device[0] * columns)
        return draw_part(job, engine, rows, columns, uniforms, culled, where, differentiated)

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
    return trimmed(job, part(numbers, *args))


def trimmed(job: Job, images: Drawn) -> Drawn:
    """Return the images without columns beyond the frame, and those of one component without that axis."""

    def trim(name: str, image: jax.Array) -> jax.Array:
        image = image if image.shape[1] == job.frame.width else image[:, : job.frame.width]
        return image if COMPONENTS[name] > 1 else image[..., 0]

    return {name: trim(name, image) for name, image in images.items()}


def draw_part(
    job: Job,
    engine: Any,
    rows: int,
    columns: int,
    uniforms: Uniforms,
    culled: Culling | None,
    where: Where,
    differentiated: bool,
) -> Drawn:
    """Return `rows` x `columns` pixels from a row and column on: arrays (rows, columns, components)."""
    if isinstance(engine, Kernels):
        drawn = draw_by_kernel(Images(job, rows, columns, engine), uniforms, culled, where)
        return dict(zip(job.keep, drawn, strict=True))
    mode = jnp.asarray(where.mode)
    # A division by a constant would be compiled to a product with the constant's inverse, which is rounded once more.
    one = (mode >= 0).astype(job.dtype)
    frame = job.frame._replace(width=job.frame.width * one, height=job.frame.height * one)
    if isinstance(engine, Fused):
        return _whole(job, engine, frame, rows, columns, uniforms, where)
    tiles = tiles_of(engine, job, rows, columns)
    images = _tiled(job, engine, frame, tiles, uniforms, culled, where, differentiated)
    return {name: image[:, :columns] for name, image in images.items()} if tiles.width > columns else images


def _whole(job: Job, engine: Fused, frame: Frame, rows: int, columns: int, uniforms: Uniforms, where: Where) -> Drawn:
    """All pixels at once: planes of two dimensions, which the program counts out itself."""
    row, column = (lax.broadcasted_iota(jnp.int32, (rows, columns), axis) for axis in (0, 1))
    x, y = (column + where.first_column).astype(job.dtype), (row + where.first_row).astype(job.dtype)
    with running(engine):
        steps = pixels(uniforms, job.program, x, y, frame, job.keep)

    def image(planes: Any) -> jax.Array:
        planes = planes if isinstance(planes, tuple) else (planes,)
        return jnp.stack([jnp.broadcast_to(plane, (rows, columns)) for plane in planes], axis=-1)

    return {name: image(getattr(steps, name)) for name in job.keep}


def tiles_of(engine: Any, job: Job, rows: int, columns: int) -> Tiles:
    """The tiles of a part of the image, of a size that does not depend on how many parts there are.

    So the kernels are the same, to the last bit, on any number of devices.
    """
    whole = Tiles.of(rows, job.frame.width, engine.block)
    return whole._replace(width=max(columns, whole.tile_width))


def _tiled(
    job: Job,
    engine: Any,
    frame: Frame,
    tiles: Tiles,
    uniforms: Uniforms,
    culled: Culling | None,
    where: Where,
    differentiated: bool,
) -> Drawn:
    """A tile after another: arrays (rows, columns, components) of all `tiles`."""

    def tile(row: jax.Array, column: jax.Array) -> Drawn:
        at = engine
        if isinstance(engine, Staged) and culled is not None:
            at = engine.at_block(job.program, culled, where.mode, differentiated)
        rows, columns = tiles.pixels(row + where.first_row, column + where.first_column)
        with running(at):
            # In a step of its own, so that no other kernel counts the pixels again.
            x, y = at.step(_floats, (columns, rows, jnp.zeros((), job.dtype)))
            steps = pixels(uniforms, job.program, x, y, frame, job.keep)

        def images(steps: Any) -> Drawn:
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
