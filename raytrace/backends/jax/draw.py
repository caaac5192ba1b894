"""The program that draws: from uniforms to pictures, on one device or several, by whichever engine."""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jax.sharding import Mesh, PartitionSpec

from raytrace.backends.jax.devices import AXIS
from raytrace.backends.jax.engines import Fused
from raytrace.backends.jax.kernel import Images, Kernels, Where, draw_by_kernel, prepared
from raytrace.backends.jax.packing import Layout, Parts
from raytrace.backends.jax.staged import SEARCHED, Culling, Staged, culling
from raytrace.backends.jax.tiles import Tiles
from raytrace.backends.job import Job
from raytrace.edges import pixels
from raytrace.language.control import running
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import Frame
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["Given", "draw", "draw_columns", "draw_part", "planes", "prepare_spheres", "tiles_of", "trimmed"]

#: Images by name.
Drawn = dict[str, jax.Array]


def prepare_spheres(engine: Any, uniforms: Uniforms, program: Program) -> Culling | None:
    """Return what the engine prepares of the spheres once for a whole picture; ``None`` where it needs nothing."""
    if isinstance(engine, Kernels):
        return prepared(uniforms, program)
    return culling(uniforms, program) if isinstance(engine, Staged) else None


class Given(NamedTuple):
    """A scene as the program is given it.

    uniforms: a structure `Uniforms`; or with `layout` one array of all its numbers and, where there are few spheres, of
    what is prepared of them: a structure (uniforms, culled). culled: what `prepare_spheres` gives of many spheres.
    """

    uniforms: Any
    culled: Culling | None


def draw(
    job: Job, engine: Any, rows: int, devices: Mesh, layout: Layout | None, given: Given, mode: Any, first: Any
) -> Drawn:
    """Return the steps that the job keeps, for `rows` rows from row `first` on: arrays (rows, width[, components]).

    engine: what `raytrace.backends.jax.choice.engine_of` gives. layout: of `given`; ``None`` where JAX may
    differentiate the pictures. mode: 0, or 1 to skip nothing.
    """
    if layout is None:
        given = given._replace(culled=prepare_spheres(engine, given.uniforms, job.program))
    part = partial(draw_columns, job, engine, rows, devices.size, layout)
    numbers, args = jnp.arange(devices.size, dtype=jnp.int32), (given, mode, first)
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


def draw_columns(
    job: Job,
    engine: Any,
    rows: int,
    devices: int,
    layout: Layout | None,
    device: jax.Array,
    given: Given,
    mode: Any,
    first: Any,
) -> Drawn:
    """Return what number `device`, of shape (1,), of so many devices draws: arrays (rows, columns[, components]).

    Each has some columns of every row, which share the sky and the ground about equally.
    """
    columns = -(-job.frame.width // devices)
    where, parts = Where(mode, first, device[0] * columns), None
    if layout is not None:
        parts = Parts(layout, given.uniforms)
        uniforms, culled = parts.structure
        given = Given(uniforms, given.culled if culled is None else culled)
    return planes(draw_part(job, engine, rows, columns, given, where, layout is None, parts))


def planes(images: Drawn) -> Drawn:
    """Return the images, those of one component without that axis."""
    return {name: image if COMPONENTS[name] > 1 else image[..., 0] for name, image in images.items()}


def trimmed(job: Job, images: Drawn) -> Drawn:
    """Return the images without columns beyond the frame."""
    width = job.frame.width
    return {name: image if image.shape[1] == width else image[:, :width] for name, image in images.items()}


def draw_part(
    job: Job,
    engine: Any,
    rows: int,
    columns: int,
    given: Given,
    where: Where,
    differentiated: bool,
    parts: Parts | None = None,
) -> Drawn:
    """Return `rows` x `columns` pixels from a row and column on: arrays (rows, columns, components).

    parts: the scene's numbers, where they are one array. differentiated: whether JAX may differentiate the pictures.
    """
    if isinstance(engine, Kernels):
        drawn = draw_by_kernel(Images(job, rows, columns, engine), given.uniforms, given.culled, where)
        return dict(zip(job.keep, drawn, strict=True))
    mode = jnp.asarray(where.mode)
    # A division by a constant would be compiled to a product with the constant's inverse, which is rounded once more.
    one = (mode >= 0).astype(job.dtype)
    frame = job.frame._replace(width=job.frame.width * one, height=job.frame.height * one)
    if isinstance(engine, Fused):
        return _whole(job, engine, frame, rows, columns, given.uniforms, where)
    tiles = tiles_of(engine, job, rows, columns)
    images = _tiled(job, engine, frame, tiles, given, where, differentiated, parts)
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
    given: Given,
    where: Where,
    differentiated: bool,
    parts: Parts | None,
) -> Drawn:
    """A tile after another: arrays (rows, columns, components) of all `tiles`."""

    def tile(row: jax.Array, column: jax.Array) -> Drawn:
        at = engine
        if isinstance(engine, Staged) and given.culled is not None:
            at = engine.at_block(job.program, given.culled, where.mode, differentiated, parts)
        rows, columns = tiles.pixels(row + where.first_row, column + where.first_column)
        with running(at):
            # In a step of its own, so that no other kernel counts the pixels again.
            x, y = at.step(_floats, (columns, rows, jnp.zeros((), job.dtype)))
            steps = pixels(given.uniforms, job.program, x, y, frame, job.keep)

        def images(steps: Any) -> Drawn:
            return {name: _interleaved(getattr(steps, name), tiles) for name in job.keep}

        return at.step(images, (steps,))

    return tiles.map(tile, kept=SEARCHED) if differentiated else tiles.draw(tile, parts)


def _floats(column: jax.Array, row: jax.Array, like: jax.Array) -> tuple[jax.Array, jax.Array]:
    return column.astype(like.dtype), row.astype(like.dtype)


def _interleaved(planes: Any, tiles: Tiles) -> jax.Array:
    """A plane or a vector of planes of a tile's pixels as an array (height, width, components)."""
    planes = planes if isinstance(planes, tuple) else (planes,)
    size = tiles.tile_height * tiles.tile_width
    # XLA's fastest way to interleave on a CPU is a transposition.
    together = jnp.stack([jnp.broadcast_to(plane, (size,)) for plane in planes])
    return together.T.reshape(tiles.tile_height, tiles.tile_width, len(planes))
