"""Compiled programs, kept in the user's cache folder: the next process need neither trace nor compile them.

JAX's own persistent cache saves the compilation alone; tracing and lowering would still take longer than loading the
whole program does. A program is machine code for one kind of processor, so processor, JAX's and XLA's versions and this
package's own text are part of its name.

The environment variable RAYTRACE_CACHE names another folder, or is "off". Within `not_stored` no program is kept.
"""

import hashlib
import logging
import os
import pickle
import platform
import stat
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jaxlib.version
from jax.experimental import serialize_executable

from raytrace.errors import InputError
from raytrace.files import whole_file
from raytrace.shader.uniforms import Program

__all__ = ["Form", "choices_as_text", "not_stored", "stored"]

LOG = logging.getLogger("raytrace")

#: Bytes of the SHA-256 that a file begins with, of all the others in it.
DIGEST = hashlib.sha256().digest_size

#: The most bytes of programs that are kept; those that were not used for longest go first. One takes 1 to 20 MB.
MOST = 1 << 29


_off: ContextVar[bool] = ContextVar("raytrace_programs_not_stored", default=False)


@contextmanager
def not_stored() -> Iterator[None]:
    """Within this context programs are neither taken from the folder nor kept there."""
    token = _off.set(True)
    try:
        yield
    finally:
        _off.reset(token)


def folder() -> Path | None:
    """Where programs are kept, or ``None`` where they are not to be."""
    chosen = os.environ.get("RAYTRACE_CACHE")
    if chosen == "off" or _off.get():
        return None
    if chosen:
        return Path(chosen)
    import platformdirs

    return Path(platformdirs.user_cache_dir("raytrace"))


class Form(NamedTuple):
    """How a program is kept: what `pickle` can keep of it, and how that becomes a program again, on some devices."""

    kept: Callable[[Any], Any]
    loaded: Callable[[Any, Sequence[Any]], Any]


def _loaded(kept: tuple, devices: Sequence[Any]) -> jax.stages.Compiled:
    return serialize_executable.deserialize_and_load(*kept, execution_devices=devices)


#: That of `jax.stages.Compiled`.
COMPILED = Form(serialize_executable.serialize, _loaded)


def stored(name: str | None, devices: Sequence[Any], compiled: Callable[[], Any], form: Form = COMPILED) -> Any:
    """The program called `name`, from the folder if it is there, else as `compiled` makes it, which is then kept.

    A name holds everything that the program depends on, but for the machine and the versions. ``None`` for a program
    that has no such name. It runs on `devices`. Whatever goes wrong with the folder, there is a program.
    """
    place, made = folder(), partial(_told, compiled)
    if name is None or place is None:
        return made()
    digest = hashlib.sha256("\n".join([_here(), name]).encode()).hexdigest()
    path = place / f"{digest[:40]}.program"
    with suppress(OSError):  # a read-only disk
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
    if not _trusted(place):
        return made()
    with suppress(Exception):  # no such file, or one that does not load
        content = _whole(path)
        program = form.loaded(pickle.loads(content), devices)
        os.utime(path)
        return program
    program = made()
    with suppress(Exception):  # a full disk, or a program that cannot be stored
        content = pickle.dumps(form.kept(program))
        with suppress(InputError), whole_file(path, durable=False) as temporary:
            temporary.write_bytes(hashlib.sha256(content).digest() + content)
        _prune(place)
    return program


def _told(compiled: Callable[[], Any]) -> Any:
    """Compile, and log that it takes a while, and how long it took."""
    LOG.info("compiling for this machine, once for this size: some seconds", extra={"waits": True})
    begun = time.perf_counter()
    try:
        return compiled()
    finally:
        LOG.info("compiled in %.1f s", time.perf_counter() - begun, extra={"waits": False})


def _trusted(place: Path) -> bool:
    """Whether nobody else can have written into the folder: a program is code, and loading it unpickles."""
    try:
        about = place.stat()
    except OSError:
        return False
    if not hasattr(os, "getuid"):
        return True
    return about.st_uid == os.getuid() and not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _whole(path: Path) -> bytes:
    """The content of a file of the folder; a damaged one is removed, as its program could crash the process.

    Raises:
        OSError: there is no such file.
        ValueError: it is damaged, or somebody else's.
    """
    file = path.read_bytes()
    digest, content = file[:DIGEST], file[DIGEST:]
    if hashlib.sha256(content).digest() != digest or not _trusted(path):
        path.unlink()
        raise ValueError(path)
    return content


def choices_as_text(program: Program) -> str | None:
    """A shader's program as a part of a name; ``None`` if it calls what is not this package's."""
    choices = vars(program).items()
    if not all(getattr(value, "__module__", "raytrace.").startswith("raytrace.") for _, value in choices):
        return None
    return repr({key: getattr(value, "__qualname__", value) for key, value in choices})


def _prune(place: Path) -> None:
    programs = [(path.stat(), path) for path in place.glob("*.program")]
    kept = 0
    for about, path in sorted(programs, key=lambda program: program[0].st_mtime, reverse=True):
        kept += about.st_size
        if kept > MOST:
            path.unlink()


@cache
def _here() -> str:
    """This processor, these versions, this package's text."""
    text = hashlib.sha256()
    package = Path(__file__).parents[2]
    for path in sorted(package.rglob("*.py")):
        text.update(path.read_bytes())
    flags = os.environ.get("XLA_FLAGS", "")
    return "\n".join(
        [_processor(), jax.__version__, jaxlib.version.__version__, platform.python_version(), flags, text.hexdigest()]
    )


def _processor() -> str:
    """The processor's model and what it can do."""
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        about = {line.partition(":")[0].strip(): line for line in lines}
        # The names on x86 and on ARM.
        return "\n".join(about.get(key, "") for key in ("model name", "flags", "CPU part", "Features"))
    return f"{platform.machine()} {platform.processor()}"
