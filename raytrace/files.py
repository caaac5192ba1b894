"""Files that appear whole or not at all."""

import os
import secrets
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
    temporary = path.with_name(f".{path.stem[:32]}-{secrets.token_hex(4)}{path.suffix}")
    try:
        # With the permissions of any new file.
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporary
        if path.exists():
            temporary.chmod(path.stat().st_mode)
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {reason(error)}") from None
    finally:
        temporary.unlink(missing_ok=True)
