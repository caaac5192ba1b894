"""Files that appear whole or not at all."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
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
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    if path.is_dir():
        raise InputError(f"{path}: is a folder; give a file's name")
    if path.exists() and not os.access(path, os.W_OK):
        raise InputError(f"{path}: cannot be written: permission denied")
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem[:32]}-", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {reason(error)}") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        # mkstemp's files are private; the result has the permissions of any new file, or those of the old one.
        temporary.chmod(path.stat().st_mode if path.exists() else 0o666 & ~_umask())
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {reason(error)}") from None
    finally:
        temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
