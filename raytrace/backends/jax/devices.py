"""Which devices draw: all cores of this machine, and all machines of a cluster."""

import logging
import os
from functools import cache
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh

from raytrace.cores import cores

__all__ = ["AXIS", "fetched", "hint_at_cores", "mesh", "one_device", "use_all_cores", "x64_mode"]

LOG = logging.getLogger("raytrace")

#: JAX makes the attributes of its options at run time.
CONFIG: Any = jax.config

#: The name of the mesh's one axis.
AXIS = "device"


def use_all_cores() -> None:
    """Give JAX a CPU device for each core; `raytrace.render` then draws with all of them.

    Call it before JAX is used, as JAX counts its devices once; after that it only logs that it came too late. It sets
    JAX's option ``jax_num_cpu_devices``, which the whole process sees: an array of `render` is spread over the devices.
    Where the user has chosen a number already, that stays. The command `raytrace` makes this call.
    """
    if _chosen():
        return
    try:
        jax.config.update("jax_num_cpu_devices", cores())
    except RuntimeError:
        LOG.warning("JAX is initialised; its device count can no longer change")


def hint_at_cores() -> None:
    """Log, once, that JAX has one device on a processor of several cores, unless that was asked for."""
    if not _chosen():
        _hint(len(jax.local_devices()), cores(), jax.default_backend())


@cache
def _hint(devices: int, available: int, platform: str) -> None:
    if platform == "cpu" and devices < available:
        LOG.warning(
            "JAX draws with %d of %d cores; call raytrace.use_all_cores() before JAX is used to draw with all of them",
            devices,
            available,
        )


def _chosen() -> bool:
    """Whether somebody has said how many CPU devices there should be."""
    flags = os.environ.get("XLA_FLAGS", "")
    return CONFIG.jax_num_cpu_devices >= 0 or "xla_force_host_platform_device_count" in flags


def x64_mode() -> bool:
    """Return whether JAX computes with 64 bits."""
    return bool(CONFIG.jax_enable_x64)


def mesh() -> Mesh:
    """All devices, those of other processes too; JAX's default device alone if the user has chosen one."""
    default = CONFIG.jax_default_device
    return Mesh(np.array(jax.devices() if default is None else [default]), (AXIS,))


def one_device() -> Mesh:
    """JAX's default device, or the first one of this process."""
    default = CONFIG.jax_default_device
    return Mesh(np.array([jax.local_devices()[0] if default is None else default]), (AXIS,))


def fetched(image: Any) -> np.ndarray:
    """The image as a NumPy array; where it is spread over several processes, all of them must ask for it."""
    if isinstance(image, jax.Array) and not image.is_fully_addressable:
        from jax.experimental.multihost_utils import process_allgather

        return process_allgather(image, tiled=True)
    return np.asarray(image)
