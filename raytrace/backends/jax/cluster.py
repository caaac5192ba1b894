"""Several processes, on one machine or many, that draw one picture together."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from raytrace.backends.jax.rendezvous import ending_after, met
from raytrace.errors import EngineFailure, InputError

__all__ = ["cluster"]

#: Seconds that the processes may wait for each other.
LONGEST_WAIT = 86400.0
MOST_HOSTS = 4096


@contextmanager
def cluster(coordinator: str | None, hosts: int | None, process_id: int | None, wait: float) -> Iterator[bool]:
    """Within this context JAX's devices are those of all processes; gives whether this is the one that writes files.

    coordinator: HOST:PORT, an address of process 0 that the others reach. hosts: how many processes there are.
    process_id: which one this is, from 0. All ``None``: JAX asks the cluster's scheduler (Slurm, MPI, Kubernetes).
    wait: seconds in which all must have come.

    When one of the processes ends within the context, all end with exit code 1, and leave no unfinished file behind.

    Raises:
        InputError: only some are given, or they do not fit; or no scheduler answers.
        EngineFailure: the others did not come.
    """
    given = coordinator, hosts, process_id
    if any(value is None for value in given) and any(value is not None for value in given):
        raise InputError("coordinator, hosts, process_id: give all three, or none to have the scheduler asked")
    if not 0 < wait <= LONGEST_WAIT:
        raise InputError(f"wait: must be greater than 0 and at most {LONGEST_WAIT:g} seconds, found {wait}")
    if hosts is not None and not 1 <= hosts <= MOST_HOSTS:
        raise InputError(f"hosts: must be from 1 to {MOST_HOSTS}, found {hosts}")
    if hosts is not None and process_id is not None and not 0 <= process_id < hosts:
        raise InputError(f"process_id: must be from 0 to {hosts - 1} for {hosts} hosts, found {process_id}")
    if coordinator is not None and not _is_address(coordinator):
        raise InputError(f"coordinator: must be HOST:PORT, found {coordinator!r}")
    if coordinator is not None and hosts is not None and process_id is not None:
        with met(coordinator, hosts, process_id, wait):
            yield from _joined(coordinator, hosts, process_id, wait)
    else:
        yield from _joined(None, None, None, wait)


def _is_address(text: str) -> bool:
    host, _, port = text.rpartition(":")
    return bool(host) and port.isascii() and port.isdigit() and 0 < int(port[:6]) < 1 << 16 and len(port) <= 5


def _joined(coordinator: str | None, hosts: int | None, process_id: int | None, wait: float) -> Iterator[bool]:
    """JAX's part of `cluster`."""
    import jax

    ending = signal.getsignal(signal.SIGTERM)
    late = f"cluster: JAX did not join the processes within {wait:g} s (--wait)"
    try:
        with ending_after(wait, late):
            # Its own limit ends the process in its own way.
            jax.distributed.initialize(coordinator, hosts, process_id, initialization_timeout=int(wait) + 60)
    except (RuntimeError, ValueError) as error:
        said = str(error).partition("\n")[0]
        if coordinator is None:
            raise InputError(f"cluster: no scheduler that JAX knows: {said}") from None
        raise EngineFailure(f"{coordinator}: process {process_id} of {hosts} could not join: {said}") from None
    # JAX takes SIGTERM for a notice that the host will go, and goes on.
    if ending is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, ending)
    yield jax.process_index() == 0
    # Not after a failure: it waits for the others.
    with ending_after(wait, late):
        jax.distributed.shutdown()
