"""Files that appear whole or not at all."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from raytrace.errors import InputError

__all__ = ["reason", "whole_file"]


def reason(error: OSError) -> str:
    """What the system said, in lower case: "permission denied"."""
    return (error.strerror or str(error)).lower()


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A temporary file beside `path`, to be written by the body; it becomes `path` when the body ends well.

    Whatever goes wrong, an interruption included, leaves an existing `path` untouched and no other file behind.

    Raises:
        InputError: the folder is missing, nothing can be written there, or the disk is full.
    """
    shown, path = path, Path(os.path.realpath(path))  # a link stays, and what it leads to is written
    if not os.path.isdir(path.parent):
        raise InputError(f"{shown}: the folder {shown.parent} does not exist")
    if os.path.isdir(path):
        raise InputError(f"{shown}: is a folder; give a file's name")
    if os.path.exists(path) and not os.access(path, os.W_OK):
        raise InputError(f"{shown}: cannot be written: permission denied")
    temporary = path.with_name(f".{path.stem[:32]}-{secrets.token_hex(4)}{path.suffix}")
    try:
        # With the permissions of any new file.
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporary
        if path.exists():
            temporary.chmod(path.stat().st_mode)
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"{shown}: cannot be written: {reason(error)}") from None
    finally:
        with suppress(OSError):
            temporary.unlink()
