"""A signal ends the command at once, whatever its threads do."""

import os
import signal
import socket
import sys
import threading
from contextlib import suppress

from raytrace.cli.waits import hide_waits
from raytrace.files import remove_unfinished

__all__ = ["end_at_signals"]

#: As Ctrl-C, `timeout`, service managers and terminals end a process. Not every system has them all.
_ENDINGS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT") if hasattr(signal, name)]


def end_at_signals() -> None:
    """From now on end this process at a signal, with nothing left half-written; its exit code is 128 + the signal.

    A signal that is ignored, as under `nohup` or in a background job, stays ignored.

    An exception, as Python's own way is, would come wherever Python is just then: in an extension that is being loaded,
    or under C++ that crashes when it is left by one; and it would come late, as a compiler takes seconds to return.
    """
    heard, told = socket.socketpair()
    told.setblocking(False)
    # The system says a signal's number there at once, if Python handles that signal.
    signal.set_wakeup_fd(told.detach(), warn_on_full_buffer=False)
    endings = {number for number in _ENDINGS if signal.getsignal(number) != signal.SIG_IGN}
    for number in endings:
        signal.signal(number, lambda number, frame: None)

    def watch() -> None:
        while (number := heard.recv(1)[0]) not in endings:
            pass  # of another handler
        remove_unfinished()
        with suppress(Exception):  # a terminal that is gone
            hide_waits()
            if number == signal.SIGINT:
                print("raytrace: interrupted", file=sys.stderr, flush=True)
        os._exit(128 + number)

    threading.Thread(target=watch, daemon=True).start()
