"""A scene, compiled by JAX, and rendered."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.extend.backend import backends
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from raytrace.backends.jax.choice import engine_of, or_fused, platform_of
from raytrace.backends.jax.devices import check_devices, fetched, hint_at_cores, mesh, one_device, x64_mode
from raytrace.backends.jax.draw import Given, draw, draw_columns, planes, prepare_spheres, trimmed
from raytrace.backends.jax.forward import by_forward_mode
from raytrace.backends.jax.kernel import MANY, Kernels
from raytrace.backends.jax.packing import Layout, Parts, pack
from raytrace.backends.jax.picture import traced_picture
from raytrace.backends.jax.replicas import REPLICAS, Replicas, compiled_for_a_core, possible
from raytrace.backends.jax.staged import MANY_FOR_SHADOW, Culling, Staged, without_grids
from raytrace.backends.jax.stored import choices_as_text, stored
from raytrace.backends.job import Job
from raytrace.edges.moving import moving_edges
from raytrace.errors import InputError
from raytrace.language.control import count
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["Renderer"]

#: XLA would use half of the width that a vector register of a newer CPU has; and its own threads only wait for those of
#: other devices (see `raytrace.backends.jax.replicas`).
OPTIONS = {"xla_cpu_prefer_vector_width": 512, "xla_cpu_multi_thread_eigen": False}

#: What is said to whom asks how an edge that moves bends the picture.
REFUSAL = (
    "antialias: edges: no second derivative by numbers that move edges, as places, sizes, the camera and, where there "
    "are shadows, the sun: the first one jumps where an edge passes from pixel to pixel"
)

#: With more spheres than this a program of its own prepares them.
FEW: dict[type, int] = {Staged: MANY_FOR_SHADOW, Kernels: MANY}

#: The most programs of a kind that are held. One takes some 600 of the 65530 memory mappings that Linux lets a process
#: have. JAX's own caches hold a program for as long as the function lives that it was made of, so each is made of a
#: function of its own, and goes with it.
MOST = 32


@lru_cache(maxsize=MOST)
def _traced(job: Job, rows: int, devices: Mesh) -> Callable:
    """The function that draws traced uniforms; without options, which are those of the program that it is part of."""
    platform = platform_of(devices.devices.flat[0])

    def by(engine: Any, uniforms: Uniforms, mode: Any, first: Any) -> dict[str, jax.Array]:
        return draw(job, engine, rows, devices, None, Given(uniforms, None), mode, first)

    def as_picture(uniforms: Uniforms, mode: Any, first: Any) -> dict[str, jax.Array]:
        return trimmed(job, planes(traced_picture(job, rows, uniforms, mode, first)))

    @jax.jit
    def drawn(uniforms: Uniforms, mode: Any, first: Any) -> dict[str, jax.Array]:
        spheres = count(uniforms.spheres)
        # On a machine of CPUs the other platforms' residuals would be kept for reverse mode, as zeros.
        several = set(backends()) != {"cpu"}
        if several and job.engine is None and job.program.antialias == "none":
            on_cpu = partial(by, engine_of(job, "cpu", spheres))
            return lax.platform_dependent(uniforms, mode, first, cpu=on_cpu, default=as_picture)
        # Edges' text would be traced once for each platform.
        engine = engine_of(job, platform, spheres)
        return as_picture(uniforms, mode, first) if isinstance(engine, Kernels) else by(engine, uniforms, mode, first)

    return drawn


@lru_cache(maxsize=MOST)
def _culled(program: Program, engine: Any, layout: Layout) -> Callable:
    """The function that prepares many spheres, from all numbers."""

    @partial(jax.jit, compiler_options=OPTIONS)
    def culled(numbers: jax.Array) -> Culling | None:
        uniforms, _ = Parts(layout, numbers).structure
        return prepare_spheres(engine, uniforms, program)

    return culled


@lru_cache(maxsize=MOST)
def _compiled(job: Job, engine: Any, rows: int, devices: Mesh, layout: Layout, culled: Any) -> Callable:
    """The program for uniforms of that layout, whatever their values. `culled`: the shapes, hashable, or ``None``."""
    everywhere, places = NamedSharding(devices, PartitionSpec()), list(devices.devices.flat)

    def given(shape: tuple[int, ...], dtype: Any) -> jax.ShapeDtypeStruct:
        return jax.ShapeDtypeStruct(shape, dtype, sharding=everywhere)

    if culled is not None:
        tree, shapes = culled
        culled = tree.unflatten(given(shape, dtype) for shape, dtype in shapes)
    name = _name(job, engine, rows, devices, layout, culled)
    args = given((layout.size,), job.dtype), culled, given((), np.int32), given((), np.int32)

    def by_each(numbers: jax.Array, culled: Any, mode: Any, first: Any, device: Any) -> dict[str, jax.Array]:
        return draw_columns(job, engine, rows, devices.size, layout, device, Given(numbers, culled), mode, first)

    def replicas() -> Replicas:
        return Replicas(compiled_for_a_core(by_each, OPTIONS, *args, given((1,), np.int32)), job.keep, places)

    if isinstance(engine, Staged) and possible(devices):
        return stored(name, places, replicas, REPLICAS)

    def by(engine: Any) -> Any:
        def drawn(numbers: jax.Array, culled: Any, mode: Any, first: Any) -> dict[str, jax.Array]:
            return draw(job, engine, rows, devices, layout, Given(numbers, culled), mode, first)

        return jax.jit(drawn, compiler_options=OPTIONS).lower(*args).compile()

    def compiled() -> Any:
        uniforms, _ = layout.tree.unflatten(given(shape, job.dtype) for shape in layout.shapes)
        return or_fused(job, engine, count(uniforms.spheres), by)

    return stored(name, places, compiled)


def _name(job: Job, engine: Any, rows: int, devices: Mesh, layout: Layout, culled: Any) -> str | None:
    """What a program depends on, as text that is the same in another process; ``None`` where there is no such text."""
    choices = choices_as_text(job.program)
    if choices is None or not isinstance(job.engine, str | None) or jax.process_count() > 1:
        return None
    shapes = jax.tree.map(lambda leaf: (leaf.shape, str(leaf.dtype)), culled)
    kinds = [
        (device.platform, device.device_kind, device.client.platform_version, device.id)
        for device in devices.devices.flat
    ]
    # The layout's and the culling's trees say of every leaf whose it is.
    return repr((choices, job.frame, job.keep, job.dtype, engine, rows, kinds, layout, shapes, sorted(OPTIONS.items())))


def _given(x: Any, dtype: str, exact: bool) -> jax.Array:
    """A traced uniform as the program gets it: rounded once to float32 unless `exact`, then in `dtype`.

    The gradient passes the rounding as if it were not there.
    """
    if not isinstance(x, jax.core.Tracer):
        return jnp.asarray(_rounded(x, exact), dtype=dtype)
    if not exact and x.dtype == jnp.float64 and dtype == "float64":
        # Neighbours' difference is exact, and so is the sum.
        return x + lax.stop_gradient(x.astype(jnp.float32).astype(dtype) - x)
    return x.astype(dtype)


def _check_sharding(uniforms: Uniforms) -> None:
    """Check that traced uniforms are not sharded by hand in shard_map, whose types the text's loops do not keep."""
    for leaf in filter(lambda leaf: isinstance(leaf, jax.core.Tracer), jax.tree.leaves(uniforms)):
        kind: Any = jax.typeof(leaf)
        if getattr(getattr(kind, "manual_axis_type", None), "varying", None):
            raise InputError(
                "jax: render within shard_map: give shard_map check_vma=False, or jit a vmap of render with sharded "
                "arguments"
            )


def _rounded(x: Any, exact: bool) -> np.ndarray:
    return np.asarray(x, np.float64 if exact else np.float32)


class Renderer:
    """A scene, ready to be rendered; see `raytrace.backends.Renderer`.

    The uniforms may be traced, as in a `jax.grad` of the image. Arrays are JAX's, but for float64 while JAX's
    x64 mode is off: then they are NumPy's. Where there are several devices each has some columns of the image; a
    traced one is drawn by one device.

    Raises:
        InputError: float64 is asked of a trace without x64; JAX has no device, or the uniforms are sharded in a way
            that a traced image cannot be.
    """

    def __init__(self, uniforms: Uniforms, job: Job):
        #: The first row and the count that were drawn last, by which program, and what it was given.
        self.ready: tuple[int, int, Callable, tuple] | None = None
        #: What the program depends on: not the switch that it is given when it runs.
        self.job, self.mode = replace(job, skip=True, exact_inputs=False), int(not job.skip)
        check_devices()
        self.traced = any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(uniforms))
        if self.traced:
            _check_sharding(uniforms)
        #: float64 without x64 mode: switched on for as long as it takes.
        self.borrows_x64 = job.dtype == "float64" and not x64_mode()
        if self.traced and self.borrows_x64:
            raise InputError(
                "dtype float64: JAX is tracing in 32 bit; set jax_enable_x64, or trace within jax.enable_x64(True)"
            )
        # What somebody makes of a traced image, such as its mean and the mean's derivative, has devices wait for each
        # other in an order that XLA's threads may not keep: with as many threads as devices they wait for ever.
        self.devices = one_device()
        self.engine = engine_of(job, platform_of(self.devices.devices.flat[0]), count(uniforms.spheres))
        if isinstance(self.engine, Staged | Kernels) and not self.traced:
            hint_at_cores()
            self.devices = mesh()
        if self.traced:
            self.uniforms = jax.tree.map(partial(_given, dtype=job.dtype, exact=job.exact_inputs), uniforms)
        else:
            self.uniforms = jax.tree.map(partial(_rounded, exact=job.exact_inputs), uniforms)

    def about(self) -> dict[str, str]:
        device = self.devices.devices.flat[0]
        return {"renderer": f"JAX {jax.__version__} on {getattr(device, 'device_kind', device)}"}

    def prepare(self) -> None:
        """Prepare the scene, unless it was the last one that was prepared, and wait for it. `draw` does so too."""
        with self._outside():
            prepared = self.prepared()
            jax.block_until_ready((prepared.numbers, prepared.culled))

    def executable(self, count: int) -> Any:
        """Return the program for `count` rows at a time, which `draw` runs: `Replicas`, or `jax.stages.Compiled`."""
        with self._outside():
            return self._program(count, self.prepared())

    def compile(self, count: int) -> None:
        """Compile the program for `count` rows at a time, which `draw` does otherwise."""
        if not self.traced:
            self.executable(count)

    def draw(self, first: int, count: int) -> dict[str, Any]:
        row, mode = np.int32(first), np.int32(self.mode)
        with self._outside():
            if self.traced:
                drawn = _traced(self.job, count, self.devices)
                if self.job.program.antialias == "edges":
                    # Every edge's text is there several times over, which reverse mode takes minutes to compile.
                    once = moving_edges(self.uniforms, self.job.program)
                    return by_forward_mode(lambda uniforms: drawn(uniforms, mode, row), self.uniforms, once, REFUSAL)
                return drawn(self.uniforms, mode, row)
            ready = self.ready
            if ready is None or ready[:2] != (first, count):
                prepared = self.prepared()
                given = prepared.numbers, prepared.culled, *jax.device_put((mode, row), self._everywhere())
                ready = self.ready = first, count, self._program(count, prepared), given
            _, _, program, given = ready
            images = trimmed(self.job, program(*given))
            # Spread over several processes it would be of no use to any of them.
            whole = self.borrows_x64 or jax.process_count() > 1
            return jax.tree.map(fetched, images) if whole else images

    def prepared(self) -> "Prepared":
        """Return the uniforms, and what is prepared of the spheres, on all devices."""
        numbers, layout = pack((self.uniforms, None), self.job.dtype)
        return _kept(self.job.program, self.job.dtype, self.engine, layout, numbers.tobytes(), self._everywhere())

    def _everywhere(self) -> NamedSharding:
        return NamedSharding(self.devices, PartitionSpec())

    def _program(self, rows: int, prepared: "Prepared") -> Callable:
        culled = prepared.culled
        if culled is not None:
            leaves, tree = jax.tree.flatten(culled)
            culled = tree, tuple((leaf.shape, leaf.dtype) for leaf in leaves)
        return _compiled(self.job, self.engine, rows, self.devices, prepared.layout, culled)

    @contextmanager
    def _outside(self) -> Iterator[None]:
        """x64 as it is needed; and what is not traced is computed at once, even while JAX traces something else."""
        with (
            jax.enable_x64(True) if self.borrows_x64 else nullcontext(),
            # A picture by single operations would take minutes.
            jax.disable_jit(False),
            nullcontext() if self.traced else jax.core.eval_context(),
        ):
            yield


class Prepared(NamedTuple):
    """A scene on the devices: its numbers, with what is prepared of few spheres; and what is prepared of many."""

    layout: Layout
    numbers: jax.Array
    culled: Culling | None


@lru_cache(maxsize=1)
def _kept(
    program: Program, dtype: str, engine: Any, layout: Layout, content: bytes, everywhere: NamedSharding
) -> Prepared:
    """Return what is prepared of the uniforms with that content: one picture of a scene is often followed by another.

    layout: of (uniforms, ``None``).
    """
    numbers, culled = np.frombuffer(content, dtype), None
    uniforms, _ = Parts(layout, numbers).structure
    few = FEW.get(type(engine))
    if few is not None and count(uniforms.spheres) <= few:
        # Here, and not in the program, where each of these few numbers would be a kernel by itself.
        with np.errstate(all="ignore"):
            numbers, layout = pack((uniforms, without_grids(uniforms, program)), dtype)
    elif few is not None:
        culled = _culled(program, engine, layout)(numbers)
        if jax.process_count() > 1:
            culled = jax.tree.map(np.asarray, culled)
        culled = jax.device_put(culled, everywhere)
    return Prepared(layout, jax.device_put(numbers, everywhere), culled)
