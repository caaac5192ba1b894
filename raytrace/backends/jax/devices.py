"""Which devices draw: all cores of this machine, and all machines of a cluster."""

import os
from contextlib import suppress
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh

from raytrace.cores import cores

__all__ = ["AXIS", "ask_for_all_cores", "fetched", "mesh", "one_device"]

#: The name of the mesh's one axis.
AXIS = "device"


def ask_for_all_cores() -> None:
    """A CPU device for each core, if JAX has not begun yet and nobody else has said how many there should be."""
    chosen = jax.config.jax_num_cpu_devices >= 0 or "xla_force_host_platform_device_count" in os.environ.get(
        "XLA_FLAGS", ""
    )
    if chosen:
        return
    with suppress(RuntimeError):  # JAX has begun: there are the devices that there are
        jax.config.update("jax_num_cpu_devices", cores())


def mesh() -> Mesh:
    """All devices, those of other processes too; JAX's default device alone if the user has chosen one."""
    default = jax.config.jax_default_device
    return Mesh(np.array(jax.devices() if default is None else [default]), (AXIS,))


def one_device() -> Mesh:
    """JAX's default device, or the first one of this process."""
    default = jax.config.jax_default_device
    return Mesh(np.array([jax.local_devices()[0] if default is None else default]), (AXIS,))


def fetched(image: Any) -> np.ndarray:
    """The image as a NumPy array; where it is spread over several processes, all of them must ask for it."""
    if isinstance(image, jax.Array) and not image.is_fully_addressable:
        from jax.experimental.multihost_utils import process_allgather

        return process_allgather(image, tiled=True)
    return np.asarray(image)
