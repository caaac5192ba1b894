"""Files that appear whole or not at all, figures among them."""

import os
import secrets
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from raytrace.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["check_figure", "parsed_toml", "read_text", "reason", "remove_unfinished", "save_figure", "whole_file"]

#: What a figure's file can be called.
FIGURES = (".svg", ".png")


#: What `whole_file` is writing.
_unfinished: set[Path] = set()


def reason(error: OSError) -> str:
    """What the system said, in lower case: "permission denied"."""
    return (error.strerror or str(error)).lower()


def read_text(path: str | Path, what: str) -> str:
    """Return the text of a regular file; what: it should hold, for the message, such as "TOML".

    Raises:
        FileNotFoundError: there is none.
        InputError: it is no regular file, such as a pipe, which may never end; it cannot be read, or is not UTF-8.
    """
    if "\0" in str(path):
        raise FileNotFoundError(path)
    if os.path.exists(path) and not os.path.isfile(path):
        raise InputError(f"{path}: cannot be read: is not a regular file")
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise
    except UnicodeDecodeError:
        raise InputError(f"{path}: not {what}: not a text in UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason(error)}") from None


def parsed_toml(text: str) -> dict:
    """Return the document that a TOML text is.

    Raises:
        ValueError: it is none, it nests too deeply, or one of its numbers has too many digits; in one line.
    """
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None


@contextmanager
def whole_file(path: Path, durable: bool = True) -> Iterator[Path]:
    """A temporary file beside `path`, to be written by the body; it becomes `path` when the body ends well.

    Whatever goes wrong, an interruption included, leaves an existing `path` untouched and no other file behind.

    durable: wait for the disk, which may say only then that it is full.

    Raises:
        InputError: the folder is missing, nothing can be written there, or the disk is full.
    """
    if "\0" in str(path):
        raise InputError(f"{str(path)!r}: a file's name cannot hold NUL")
    shown, path = path, Path(os.path.realpath(path))  # a link stays, and what it leads to is written
    if path.suffix.lower() != shown.suffix.lower():
        raise InputError(f"{shown}: is a link to {path}, whose ending is another; give that file's name")
    if not os.path.isdir(path.parent):
        raise InputError(f"{shown}: the folder {shown.parent} does not exist")
    if os.path.isdir(path):
        raise InputError(f"{shown}: is a folder; give a file's name")
    if os.path.exists(path) and not os.path.isfile(path):
        raise InputError(f"{shown}: is not a regular file; give another name")
    if os.path.exists(path) and not os.access(path, os.W_OK):
        raise InputError(f"{shown}: cannot be written: permission denied")
    temporary = path.with_name(f".{path.stem[:32]}-{secrets.token_hex(4)}{path.suffix}")
    _unfinished.add(temporary)
    try:
        # With the permissions of any new file.
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporary
        if durable:
            _to_disk(temporary)
        if path.exists():
            temporary.chmod(path.stat().st_mode)
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"{shown}: cannot be written: {reason(error)}") from None
    finally:
        with suppress(OSError):
            temporary.unlink()
        _unfinished.discard(temporary)


def remove_unfinished() -> None:
    """Remove the files that are not whole yet, for a process that ends at once, whatever its threads do."""
    for path in list(_unfinished):
        with suppress(OSError):
            path.unlink()


def _to_disk(path: Path) -> None:
    """Wait until the file is on the disk: some systems say only then that it is full."""
    file = os.open(path, os.O_RDWR)
    try:
        os.fsync(file)
    finally:
        os.close(file)


def check_figure(path: str | Path, endings: tuple[str, ...] = FIGURES) -> None:
    """Check the name of a figure's file, before anything is measured that the figure will show.

    Raises:
        InputError: it has none of the endings.
    """
    if Path(path).suffix.lower() not in endings:
        raise InputError(f"{path}: a figure's file must be named {' or '.join(f'*{ending}' for ending in endings)}")


def save_figure(figure: "Figure", path: str | Path, dpi: int = 100) -> None:
    """Write a Matplotlib figure as an SVG or a PNG, by the file's name; the same figure gives the same PNG.

    dpi: dots of an inch.

    Raises:
        InputError: the file cannot be written, or has another ending.
    """
    path = Path(path)
    check_figure(path)
    kind = path.suffix[1:].lower()
    # A PNG would name Matplotlib's version.
    metadata = {"Software": None} if kind == "png" else None
    with whole_file(path) as temporary:
        figure.savefig(temporary, format=kind, dpi=dpi, metadata=metadata)
