"""Files and folders that appear whole or not at all, figures among them."""

import os
import secrets
import shutil
import tempfile
import threading
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from raytrace.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "check_figure",
    "parsed_toml",
    "read_text",
    "reason",
    "remove_unfinished",
    "save_figure",
    "temporary_folder",
    "whole_file",
    "whole_folder",
]

#: What a figure's file can be called.
FIGURES = (".svg", ".png")


#: Files and folders that are there only for a time.
_unfinished: set[Path] = set()
#: Held while one of them comes, goes or gets its own name.
_changing = threading.Lock()
#: Seconds in which a process that ends waits for it: a disk may hang.
_LONGEST_CHANGE = 2.0


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
    beside = path.with_name(f".{path.stem[:32]}-{secrets.token_hex(4)}{path.suffix}")
    try:
        with _temporary(beside, _new_file) as temporary:
            yield temporary
            if durable:
                _to_disk(temporary)
            with _changing:
                if path.exists():
                    temporary.chmod(path.stat().st_mode)
                temporary.replace(path)
    except OSError as error:
        raise InputError(f"{shown}: cannot be written: {reason(error)}") from None


@contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """A temporary folder beside `folder`, to be filled by the body; it takes its place when the body ends well.

    Whatever goes wrong, an interruption included, leaves what `folder` was.

    Raises:
        InputError: nothing can be written there.
    """
    shown, folder = folder, Path(os.path.realpath(folder))
    try:
        with _temporary(folder.with_name(f".{folder.name}-{secrets.token_hex(4)}"), Path.mkdir) as temporary:
            yield temporary
            with _changing:
                old = temporary.with_name(f"{temporary.name}-old")
                try:
                    if folder.exists():
                        folder.rename(old)
                    temporary.rename(folder)
                finally:
                    if old.exists() and not folder.exists():
                        old.rename(folder)
                    _remove(old)
    except OSError as error:
        raise InputError(f"{shown}: cannot be written: {reason(error)}") from None


@contextmanager
def temporary_folder(place: str | None = None) -> Iterator[Path]:
    """A folder for this process alone, which is gone after the body; in the system's place for such, or in `place`."""
    path = Path(place or tempfile.gettempdir()) / f"raytrace-{secrets.token_hex(8)}"
    with _temporary(path, lambda path: path.mkdir(0o700)) as folder:
        yield folder


@contextmanager
def _temporary(path: Path, make: Callable[[Path], object]) -> Iterator[Path]:
    """What `make` makes at `path`, until the body ends, or until the process ends by `remove_unfinished`."""
    try:
        with _changing:
            _unfinished.add(path)
            make(path)
        yield path
    finally:
        with _changing:
            _remove(path)
            _unfinished.discard(path)


def _new_file(path: Path) -> None:
    # With the permissions of any new file.
    os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
        return
    with suppress(OSError):
        path.unlink()


def remove_unfinished() -> None:
    """Remove what is not whole yet, for a process that ends at once, whatever its threads do.

    From now on nothing more appears: a thread that wants to make a file, or to give one its name, waits for ever.
    """
    _changing.acquire(timeout=_LONGEST_CHANGE)
    for path in list(_unfinished):
        _remove(path)


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
