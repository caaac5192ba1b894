"""What OpenImageIO has to say, and what the libraries under it should not say."""

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["complaint_of", "quiet"]

_QUIETENING = threading.Lock()


def complaint_of(source: Any) -> str:
    """The last line of what a file of OpenImageIO, or the library itself, has to complain of; empty if nothing."""
    try:
        lines = source.geterror().strip().splitlines()
    except UnicodeDecodeError:
        return "its texts are damaged"  # they stand in the message
    return lines[-1] if lines else ""


@contextmanager
def quiet() -> Iterator[None]:
    """Keeps libpng, which writes to the process's standard error itself, from doing so. One thread at a time."""
    with _QUIETENING:
        if sys.stderr is not None:
            sys.stderr.flush()
        kept = os.dup(2)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            os.close(nowhere)
