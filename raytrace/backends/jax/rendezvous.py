"""How the processes of a cluster meet before JAX joins them, and notice that one of them has ended.

JAX itself ends a process without a word that a user could read when another does not come, and notices only after
minutes that one is gone. So each process first connects to process 0, at the coordinator's address, and stays
connected. A connection that closes before its process has said that it is done means that it has ended.
"""

import os
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from raytrace.errors import EngineFailure
from raytrace.files import reason, remove_unfinished

__all__ = ["ending_after", "met"]

_HELLO, _BEGIN, _DONE = "raytrace", "begin", "done"
#: Letters of a line that the processes send each other.
_LINE = 300
#: Seconds between two tries to connect; that a connection may stay silent at first; that others are given to end first.
_RETRY, _SILENT, _FAREWELL = 0.2, 5.0, 1.0


@contextmanager
def met(coordinator: str, hosts: int, process_id: int, wait: float) -> Iterator[None]:
    """Within this context all processes are connected; when one ends before its context does, all end with 1.

    The arguments are those of `raytrace.backends.jax.cluster.cluster`.

    Raises:
        EngineFailure: they are not all there within `wait` seconds, or the address cannot be used.
    """
    end = time.monotonic() + wait
    if process_id == 0:
        others = _all_others(coordinator, hosts, end)
    else:
        others = {0: _process_0(coordinator, hosts, process_id, end)}
    connections, over = list(others.values()), threading.Event()
    for number, connection in others.items():
        ended = f"process {number} of {hosts} has ended"
        threading.Thread(target=_watch, args=(connection, connections, over, ended), daemon=True).start()
    try:
        yield
    except BaseException:
        over.set()
        if process_id == 0:
            _farewell(connections, f"process 0 of {hosts} has ended")
        # Another one says nothing: that it has ended is heard when it has.
        raise
    over.set()
    for connection in connections:
        _say(connection, _DONE)


@contextmanager
def ending_after(seconds: float, message: str) -> Iterator[None]:
    """When the body takes longer, the process ends with 1 and that message: JAX cannot be interrupted there."""
    done = threading.Event()

    def watch() -> None:
        if not done.wait(seconds):
            _end(message)

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        done.set()


def _all_others(coordinator: str, hosts: int, end: float) -> dict[int, socket.socket]:
    """Process 0's connections to the others, by their numbers, when all are there."""
    port = int(coordinator.rpartition(":")[2])
    both = socket.has_dualstack_ipv6()
    try:
        listener = socket.create_server(
            ("", port), family=socket.AF_INET6 if both else socket.AF_INET, dualstack_ipv6=both, backlog=128
        )
    except OSError as error:
        raise EngineFailure(f"{coordinator}: port {port} cannot be used: {reason(error)}") from None
    found: dict[int, socket.socket] = {}
    with listener:
        while len(found) < hosts - 1:
            listener.settimeout(max(0.01, end - time.monotonic()))
            try:
                connection, _ = listener.accept()
                connection.settimeout(_SILENT)
                hello = _heard(connection).split()
            except TimeoutError:
                if time.monotonic() < end:
                    continue  # one that was silent
                missing = [str(number) for number in range(1, hosts) if number not in found]
                for connection in found.values():
                    _say(connection, f"{len(missing)} of {hosts} processes did not come")
                raise EngineFailure(
                    f"{coordinator}: {len(missing)} of {hosts} processes did not come (--wait): {', '.join(missing)}"
                ) from None
            except OSError:
                continue
            if len(hello) != 3 or hello[0] != _HELLO or not (hello[1] + hello[2]).isdecimal():
                connection.close()
                continue
            number = int(hello[2])
            if int(hello[1]) != hosts or not 0 < number < hosts or number in found:
                _say(connection, f"process {number} of {hello[1]} does not fit: there are {hosts}, each once")
                connection.close()
                continue
            found[number] = connection
    for connection in found.values():
        _say(connection, _BEGIN)
    return found


def _process_0(coordinator: str, hosts: int, process_id: int, end: float) -> socket.socket:
    """Another process's connection to process 0, when all are there."""
    host, _, port = coordinator.rpartition(":")
    said = "nobody listens there"
    while time.monotonic() < end:
        try:
            left = max(0.01, end - time.monotonic())
            connection = socket.create_connection((host.strip("[]"), int(port)), timeout=left)
            connection.settimeout(left)
            _say(connection, f"{_HELLO} {hosts} {process_id}")
            answer = _heard(connection)
        except socket.gaierror as error:
            raise EngineFailure(f"{coordinator}: {host} is no host's name: {reason(error)}") from None
        except OSError as error:
            said = reason(error)
            time.sleep(_RETRY)
            continue
        if answer == _BEGIN:
            return connection
        if answer:
            raise EngineFailure(f"{coordinator}: {answer if answer.isprintable() else 'is not process 0'}")
        time.sleep(_RETRY)
    raise EngineFailure(f"{coordinator}: process {process_id} of {hosts} could not join (--wait): {said}")


def _watch(connection: socket.socket, all_connections: list[socket.socket], over: threading.Event, ended: str) -> None:
    """Ends this process when the other end has ended, and tells the others; `ended` is what is said then."""
    connection.settimeout(None)
    try:
        said = _heard(connection)
    except OSError:
        said = ""
    if said == _DONE or over.is_set():
        return
    said = said or ended
    _farewell([other for other in all_connections if other is not connection], said)
    _end(said)


def _farewell(others: list[socket.socket], said: str) -> None:
    """Lets the others end first: when process 0 is gone, JAX ends them in its own way."""
    for other in others:
        _say(other, said)
    if others:
        time.sleep(_FAREWELL)


def _end(message: str) -> None:
    """Ends this process, whose other threads may be anywhere in JAX."""
    remove_unfinished()
    with suppress(Exception):
        print(f"raytrace: {message}", file=sys.stderr, flush=True)
    os._exit(1)


def _say(connection: socket.socket, line: str) -> None:
    with suppress(OSError):
        connection.sendall(f"{line[: _LINE - 1]}\n".encode())


def _heard(connection: socket.socket) -> str:
    """The next line from the other end; an empty one at its end."""
    with connection.makefile("rb", buffering=0) as stream:
        return stream.readline(_LINE).decode(errors="replace").strip()
