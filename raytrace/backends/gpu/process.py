"""The asking side of an engine's process: started when first needed, ended when it fails or asks for too much.

A crash of a driver, an endless loop of a shader or one that takes all memory ends that process and nothing else.
"""

import atexit
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from raytrace.backends.gpu.drawing import ActiveUniform, Drawing, ShaderProgram, ShaderRejected, Unavailable
from raytrace.errors import EngineFailure, InputError
from raytrace.files import temporary_folder

if TYPE_CHECKING:
    from psutil import Process

__all__ = ["TIME_LIMIT", "EngineProcess", "engine_process"]

#: Seconds that one drawing may take.
TIME_LIMIT = 300.0
#: The most bytes of an answer: names of uniforms, or a compiler's log.
LONGEST_ANSWER = 1 << 24

#: Bytes that a process for foreign shaders, and all that it starts, may hold, beside `IMAGES` times the image.
MEMORY_LIMIT = 2 << 30
IMAGES = 4
#: Seconds between two looks at them.
_LOOKS = 0.2

#: Where large files are memory, if there is such a place.
_MEMORY = "/dev/shm" if os.path.isdir("/dev/shm") else None


class EngineProcess:
    """An engine in a process of its own. Every method raises what `_ask` raises.

    memory: the most bytes that it may hold, beside its images; ``None`` for as many as it needs.
    """

    def __init__(self, name: str, memory: int | None = None):
        self.name, self.memory = name, memory
        self._process: subprocess.Popen | None = None
        #: An end of a pipe that nothing is written to: the system closes it when this process ends, however it does.
        self._alive: int | None = None
        self._asking = threading.Lock()

    def about(self, limit: float = TIME_LIMIT) -> str:
        """The real renderer's name and version."""
        return self._ask("about", (), limit)

    def active_uniforms(self, program: ShaderProgram, limit: float = TIME_LIMIT) -> list[ActiveUniform]:
        """Compiles the program; the uniforms that it uses."""
        return [ActiveUniform(**uniform) for uniform in self._ask("active_uniforms", (program,), limit)]

    def draw(self, drawing: Drawing, limit: float = TIME_LIMIT) -> np.ndarray:
        """The drawing's passes: float32 (pass, row from the top down, column, RGBA)."""
        with temporary_folder(_MEMORY) as folder:
            path, size = folder / "image", 4 * int(np.prod(drawing.shape))
            path.touch()
            os.truncate(path, size)
            self._ask("draw", (drawing, str(path)), limit, IMAGES * size)
            # The mapping outlives the file.
            return np.memmap(path, np.float32, "r", shape=drawing.shape)[:, ::-1]

    def stop(self) -> None:
        """Ends the process, with all that it has started."""
        process, self._process = self._process, None
        if process is None:
            return
        end_family(process.pid)
        process.wait()
        alive, self._alive = self._alive, None
        if alive is not None:
            os.close(alive)
        for stream in filter(None, (process.stdin, process.stdout)):
            with suppress(OSError):
                stream.close()

    def _ask(self, method: str, arguments: tuple, limit: float, images: int = 0) -> Any:
        """The engine's answer.

        limit: seconds. images: bytes that it may hold beside `self.memory`.

        Raises:
            InputError: the engine is not there, or cannot do this.
            ShaderRejected: a shader does not compile.
            EngineFailure: the engine crashed, or took more than it may of time or memory.
        """
        with self._asking:
            process = self._running()
            assert process.stdin is not None
            assert process.stdout is not None
            answered, wrong = threading.Event(), []
            memory = None if self.memory is None else self.memory + images
            watch = threading.Thread(target=self._watch, args=(answered, wrong, limit, memory), daemon=True)
            watch.start()
            try:
                pickle.dump((method, arguments), process.stdin)
                process.stdin.flush()
                answer = json.loads(process.stdout.readline(LONGEST_ANSWER))
            except (OSError, ValueError):
                answered.set()
                watch.join()
                code = process.wait()
                self.stop()
                raise EngineFailure(f"backend {self.name}: {wrong[0] if wrong else _crashed(code)}") from None
            except BaseException:
                answered.set()
                self.stop()  # the answer to this must not be taken for the next one's
                raise
            answered.set()
            watch.join()
        if "value" in answer:
            return answer["value"]
        if answer["refusal"] == Unavailable.__name__:
            raise InputError(f"backend {self.name}: {answer['message']}")
        raise ShaderRejected(answer["message"], answer["stage"])

    def _watch(self, answered: threading.Event, wrong: list[str], limit: float, memory: int | None) -> None:
        """Ends the process when it takes longer, or more bytes, than it may, and says so in `wrong`."""
        process, end = self._process, time.monotonic() + limit
        assert process is not None
        while not answered.wait(max(0.0, min(_LOOKS, end - time.monotonic()))):
            if time.monotonic() >= end:
                wrong.append(f"did not finish within {limit:g} s")
            elif memory is not None and _resident(process.pid) > memory:
                wrong.append(f"took more than {memory / (1 << 30):.1f} GiB of memory")
            if wrong:
                self.stop()
                return

    def _running(self) -> subprocess.Popen:
        if self._process is None or self._process.poll() is not None:
            self.stop()
            try:
                import psutil  # noqa: F401 (needed to end it)
            except ImportError:
                raise InputError(f"backend {self.name}: needs psutil: pip install psutil") from None
            # -P: the current folder, where a user's files are, is no place to import modules from.
            command = [sys.executable, "-P", "-m", "raytrace.backends.gpu.worker", self.name]
            there, handed = None, ()
            if hasattr(os, "fork"):
                there, self._alive = os.pipe()
                command.append(str(there))
                handed = (there,)
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                pass_fds=handed,
                start_new_session=True,
            )
            if there is not None:
                os.close(there)
        return self._process


@cache
def engine_process(name: str, foreign: bool = False) -> EngineProcess:
    """The process of the engine of that name, one for all who ask.

    foreign: gives one apart, for foreign shaders, whose memory is limited.
    """
    process = EngineProcess(name, MEMORY_LIMIT if foreign else None)
    atexit.register(process.stop)
    return process


def _crashed(code: int) -> str:
    ended = f"ended by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
    return f"the engine crashed ({ended})"


def end_family(pid: int) -> None:
    """End a process and all that it has started, and they in turn."""
    import psutil

    for process in _family(pid):
        with suppress(psutil.Error):
            process.kill()


def _family(pid: int) -> "list[Process]":
    import psutil

    try:
        process = psutil.Process(pid)
        return [process, *process.children(recursive=True)]
    except psutil.Error:
        return []


def _resident(pid: int) -> int:
    """Bytes that a process and all that it has started hold in memory, but for what they share."""
    import psutil

    total = 0
    for process in _family(pid):
        with suppress(psutil.Error):
            held = process.memory_info()
            total += held.rss - getattr(held, "shared", 0)
    return total
