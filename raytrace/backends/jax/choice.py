"""Which engine draws where: tiles and steps on a CPU, one kernel on a GPU of NVIDIA's, one fusion elsewhere.

XLA compiles the same text very differently for a CPU and for a GPU. On a CPU it copies cheap producers into every
consumer, and control flow stops that; on a GPU every tile, branch and turn of a loop is a launch or a round trip.
"""

import logging
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import Any

from raytrace.backends.jax.engines import Fused
from raytrace.backends.jax.kernel import Kernels
from raytrace.backends.jax.staged import Staged
from raytrace.backends.jax.stored import choices_as_text
from raytrace.backends.job import Job

__all__ = ["ENGINES", "WHOLE", "engine_of", "or_fused", "platform_of"]

LOG = logging.getLogger("raytrace")

#: By the names that `raytrace.render` takes.
ENGINES: dict[str, Any] = {"staged": Staged(), "fused": Fused(), "kernel": Kernels()}

#: A tile of so many pixels at least is a whole image or band: where each control word costs a launch, one is enough.
WHOLE = 1 << 22

#: With more spheres than this a list that every pixel walks through takes longer than a grid.
MANY_FOR_A_FUSION = 32


def platform_of(device: Any) -> str:
    """Return the platform of a device by the name that JAX lowers for: "cpu", "cuda", "rocm", "tpu"."""
    if device.platform != "gpu":
        return device.platform
    return "rocm" if "rocm" in device.client.platform_version.lower() else "cuda"


def engine_of(job: Job, platform: str, spheres: int) -> Any:
    """Return the engine that the job asks for, or the fastest one on that platform for so many spheres.

    platform: a platform's name; or "differentiated", where an accelerator differentiates the picture.
    """
    chosen = job.engine
    if chosen is None:
        chosen = {"cpu": "staged", "cuda": "kernel"}.get(platform, "fused")
    if chosen == "kernel" or isinstance(chosen, Kernels):
        # A kernel has no derivative.
        chosen = chosen if platform != "differentiated" and _has_a_kernel(job) else "fused"
    if not isinstance(chosen, str):
        return chosen
    if chosen == "fused" and (spheres > MANY_FOR_A_FUSION or job.program.antialias == "edges"):
        return Staged(block=WHOLE)
    engine = ENGINES[chosen]
    return replace(engine, interpreted=True) if chosen == "kernel" and platform != "cuda" else engine


def or_fused(job: Job, engine: Any, spheres: int, lowered: Callable[[Any], Any]) -> Any:
    """Return `lowered(engine)`; if Pallas cannot lower the kernel, and no engine was asked for, that of XLA's fusion.

    Newer versions of Pallas know a list of GPUs only, and JAX plans to drop Pallas' Triton backend.
    """
    try:
        with _without_its_warning() if isinstance(engine, Kernels) else nullcontext():
            return lowered(engine)
    except (ImportError, NotImplementedError, RuntimeError, ValueError) as error:
        if not isinstance(engine, Kernels) or job.engine is not None:
            raise
        _tell(str(error).partition("\n")[0])
        return lowered(engine_of(job, "another", spheres))


@contextmanager
def _without_its_warning() -> Iterator[None]:
    """Within this context Pallas does not say that it is deprecated: nobody chose it who could choose otherwise."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The Pallas Triton backend is deprecated", DeprecationWarning)
        yield


@cache
def _tell(reason: str) -> None:
    LOG.warning("Pallas has no kernel for this GPU (%s); XLA draws instead", reason)


def _has_a_kernel(job: Job) -> bool:
    """Whether a kernel can draw it: it draws no edges, and Pallas lacks operations that a user's function may use."""
    return job.program.antialias == "none" and choices_as_text(job.program) is not None and _pallas()


@cache
def _pallas() -> bool:
    """Whether this JAX has Pallas' Triton backend, which is deprecated from 0.11 on."""
    try:
        return find_spec("jax.experimental.pallas.triton") is not None
    except ImportError:
        return False
