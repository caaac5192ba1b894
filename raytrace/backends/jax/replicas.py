"""A program that each core runs by itself, on its own part of a picture.

XLA's compiler for CPUs cuts a large kernel into as many parts as its client has threads. All devices of a client share
these threads, so that the parts of one device's kernels wait for those of the others: a frame takes twice as long as
its kernels do. A client of one thread cuts nothing. Such a client compiles here, and JAX's own client loads what it has
made, once for all its devices.
"""

import logging
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import jax
import numpy as np
from jax import lax
from jax.extend.backend import get_compile_options
from jax.sharding import Mesh, NamedSharding, PartitionSpec, SingleDeviceSharding
from jaxlib import xla_client

from raytrace.backends.jax.devices import AXIS
from raytrace.backends.jax.stored import Form

__all__ = ["REPLICAS", "Replicas", "compiled_for_a_core", "possible"]

LOG = logging.getLogger("raytrace")


def possible(devices: Mesh) -> bool:
    """Return whether these devices can run such a program: they are CPUs of one process, and there is a compiler."""
    platforms = {device.platform for device in devices.devices.flat}
    return platforms == {"cpu"} and jax.process_count() == 1 and _compiler() is not None


@cache
def _compiler() -> Any:
    """The client of one thread: it has as many as its maker may use cores. ``None`` where there can be none.

    Nothing but the new thread that makes it is confined to a core, and what the client starts, which only compiles.
    """

    def made() -> Any:
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        return xla_client.make_cpu_client(num_devices=1)

    with ThreadPoolExecutor(1) as thread:
        try:
            return thread.submit(made).result()
        except (AttributeError, OSError, RuntimeError, TypeError) as error:
            # Not every system confines threads, or allows it; and JAX does not promise that client.
            LOG.debug("no compiler for single cores: %s", error)
            return None


def compiled_for_a_core(function: Callable, options: dict[str, Any], *given: Any) -> bytes:
    """Return the program of a function of arrays, as `Replicas` loads it.

    function: gives a structure of arrays. options: the compiler's. given: structures of `jax.ShapeDtypeStruct`.
    """
    place = SingleDeviceSharding(_compiler().local_devices()[0])
    given = jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype, sharding=place), given)

    def with_all(*given: Any) -> Any:
        # What is not used would be left out of the program's parameters.
        return function(*lax.optimization_barrier(given))

    executable: Any = jax.jit(with_all, compiler_options=options).lower(*given).compile().runtime_executable()
    return executable.serialize()


class Replicas:
    """A program of `compiled_for_a_core` on several devices, called with arrays that all of them have.

    Its function's last argument is the device's number, of shape (1,); it gives a part of each image, a dict (rows,
    columns[, components]) by its name. Calling this gives the images, whose columns the devices share.
    """

    def __init__(self, content: bytes, names: Sequence[str], devices: Sequence[Any]):
        options = get_compile_options(len(devices), 1, np.array([[device.id] for device in devices]))
        places, mesh = xla_client.DeviceList(tuple(devices)), Mesh(np.array(devices), (AXIS,))
        self._program = devices[0].client.deserialize_executable(content, places, options)
        self._names = sorted(names)  # as JAX takes a dict apart
        # As JAX has it: the image of a single device is not divided.
        self._columns = NamedSharding(mesh, PartitionSpec(None, AXIS) if len(devices) > 1 else PartitionSpec())
        everyone = np.arange(len(devices), dtype=np.int32)
        self._numbers = jax.device_put(everyone, NamedSharding(mesh, PartitionSpec(AXIS)))
        #: What a file keeps: with its devices, this makes the program again.
        self.kept = content, tuple(names)

    def __call__(self, *given: Any) -> dict[str, jax.Array]:
        drawn = self._program.execute_sharded([*jax.tree.leaves(given), self._numbers])
        parts = drawn.disassemble_into_single_device_arrays()
        return dict(zip(self._names, map(self._joined, parts), strict=True))

    def _joined(self, parts: list[jax.Array]) -> jax.Array:
        rows, columns, *components = parts[0].shape
        shape = rows, columns * len(parts), *components
        return jax.make_array_from_single_device_arrays(shape, self._columns, parts)

    def cost_analysis(self) -> dict[str, Any]:
        """Return what the compiler counts of one device's program, as `jax.stages.Compiled` does."""
        return self._program.cost_analysis()


#: How `stored` keeps them.
REPLICAS = Form(lambda program: program.kept, lambda kept, devices: Replicas(kept[0], kept[1], devices))
