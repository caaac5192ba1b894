"""Which devices draw: all cores of this machine, and all machines of a cluster."""

import logging
import os
from functools import cache
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh

from raytrace.cores import cores
from raytrace.errors import InputError

__all__ = ["AXIS", "check_devices", "fetched", "hint_at_cores", "mesh", "one_device", "use_all_cores", "x64_mode"]

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
    default = _default_device()
    return Mesh(np.array(jax.devices() if default is None else [default]), (AXIS,))


def one_device() -> Mesh:
    """JAX's default device, or the first one of this process."""
    default = _default_device()
    return Mesh(np.array([jax.local_devices()[0] if default is None else default]), (AXIS,))


def check_devices() -> None:
    """Check that JAX has devices, and that it works in this process.

    Raises:
        InputError: it has none, as where JAX_PLATFORMS names what is not there; or this process was forked from one in
            which JAX had begun.
    """
    if _begun_in() != os.getpid():
        raise InputError(
            "jax: this process was forked after JAX had begun, and would wait for ever; start it by multiprocessing's "
            "'spawn' or 'forkserver'"
        )
    try:
        jax.local_devices()
        _default_device()
    except (RuntimeError, AssertionError) as error:
        said = str(error).partition("\n")[0] or "JAX knows no such platform here"
        variables = [
            name for name in ("JAX_PLATFORMS", "JAX_NUM_CPU_DEVICES", "JAX_DEFAULT_DEVICE") if name in os.environ
        ]
        asked = ", ".join(f"{name}={os.environ[name]}" for name in variables)
        raise InputError(f"jax: has no device{f' with {asked}' if asked else ''}: {said}") from None


@cache
def _begun_in() -> int:
    """The process in which JAX was first used here."""
    return os.getpid()


def _default_device() -> Any:
    """The device that the user has chosen, also by its platform's name; ``None`` if none is chosen."""
    default = CONFIG.jax_default_device
    return jax.local_devices(backend=default)[0] if isinstance(default, str) else default


def fetched(image: Any) -> np.ndarray:
    """The image as a NumPy array; where it is spread over several processes, all of them must ask for it."""
    if isinstance(image, jax.Array) and not image.is_fully_addressable:
        from jax.experimental.multihost_utils import process_allgather

        return process_allgather(image, tiled=True)
    return np.asarray(image)
