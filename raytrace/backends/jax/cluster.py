"""Several processes, on one machine or many, that draw one picture together."""

from collections.abc import Iterator
from contextlib import contextmanager

from raytrace.errors import EngineFailure, InputError

__all__ = ["cluster"]


@contextmanager
def cluster(coordinator: str | None, hosts: int | None, process_id: int | None) -> Iterator[bool]:
    """Within this context JAX's devices are those of all processes; gives whether this is the one that writes files.

    coordinator: HOST:PORT, an address of process 0 that the others reach. hosts: how many processes there are.
    process_id: which one this is, from 0. All ``None``: JAX asks the cluster's scheduler (Slurm, MPI, Kubernetes).

    Raises:
        InputError: only some are given, or they do not fit; or no scheduler answers.
        EngineFailure: the others did not come.
    """
    given = coordinator, hosts, process_id
    if any(value is None for value in given) and any(value is not None for value in given):
        raise InputError("coordinator, hosts, process_id: give all three, or none to have the scheduler asked")
    if hosts is not None and process_id is not None and not 0 <= process_id < hosts:
        raise InputError(f"process_id: must be from 0 to {hosts - 1} for {hosts} hosts, found {process_id}")
    if coordinator is not None and not coordinator.rpartition(":")[2].isdigit():
        raise InputError(f"coordinator: must be HOST:PORT, found {coordinator!r}")
    import jax

    try:
        jax.distributed.initialize(coordinator, hosts, process_id, initialization_timeout=60)
    except (RuntimeError, ValueError) as error:
        said = str(error).partition("\n")[0]
        if coordinator is None:
            raise InputError(f"cluster: no scheduler that JAX knows: {said}") from None
        raise EngineFailure(f"{coordinator}: process {process_id} of {hosts} could not join: {said}") from None
    try:
        yield jax.process_index() == 0
    finally:
        jax.distributed.shutdown()
