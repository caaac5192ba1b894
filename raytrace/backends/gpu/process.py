"""The asking side of an engine's process: started when first needed, ended when it fails or is too slow.

A crash of a driver or an endless loop of a shader ends that process and nothing else.
"""

import atexit
import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.backends.gpu.drawing import ActiveUniform, Drawing, ShaderProgram, ShaderRejected, Unavailable
from raytrace.errors import EngineFailure, InputError

__all__ = ["TIME_LIMIT", "EngineProcess", "engine_process"]

#: Seconds that one drawing may take.
TIME_LIMIT = 300.0
#: The most bytes of an answer: names of uniforms, or a compiler's log.
LONGEST_ANSWER = 1 << 24

#: Where large files are memory, if there is such a place.
_MEMORY = "/dev/shm" if os.path.isdir("/dev/shm") else None


class EngineProcess:
    """An engine in a process of its own. Every method raises what `_ask` raises."""

    def __init__(self, name: str):
        self.name = name
        self._process: subprocess.Popen | None = None
        self._asking = threading.Lock()

    def about(self, limit: float = TIME_LIMIT) -> str:
        """The real renderer's name and version."""
        return self._ask("about", (), limit)

    def active_uniforms(self, program: ShaderProgram, limit: float = TIME_LIMIT) -> list[ActiveUniform]:
        """Compiles the program; the uniforms that it uses."""
        return [ActiveUniform(**uniform) for uniform in self._ask("active_uniforms", (program,), limit)]

    def draw(self, drawing: Drawing, limit: float = TIME_LIMIT) -> np.ndarray:
        """The drawing's passes: float32 (pass, row from the top down, column, RGBA)."""
        with tempfile.NamedTemporaryFile(prefix="raytrace-", dir=_MEMORY) as file:
            file.truncate(4 * int(np.prod(drawing.shape)))
            self._ask("draw", (drawing, file.name), limit)
            # The mapping outlives the file.
            return np.memmap(file.name, np.float32, "r", shape=drawing.shape)[:, ::-1]

    def stop(self) -> None:
        """Ends the process, with all that it has started."""
        process, self._process = self._process, None
        if process is None:
            return
        for pid in (process.pid, *_descendants(process.pid)):
            with suppress(OSError):
                os.kill(pid, getattr(signal, "SIGKILL", signal.SIGTERM))
        process.wait()
        for stream in filter(None, (process.stdin, process.stdout)):
            with suppress(OSError):
                stream.close()

    def _ask(self, method: str, arguments: tuple, limit: float) -> Any:
        """The engine's answer.

        Raises:
            InputError: the engine is not there, or cannot do this.
            ShaderRejected: a shader does not compile.
            EngineFailure: the engine crashed, or took longer than `limit` seconds.
        """
        with self._asking:
            process = self._running()
            assert process.stdin is not None
            assert process.stdout is not None
            late = threading.Event()
            timer = threading.Timer(limit, lambda: (late.set(), self.stop()))
            timer.start()
            try:
                pickle.dump((method, arguments), process.stdin)
                process.stdin.flush()
                answer = json.loads(process.stdout.readline(LONGEST_ANSWER))
            except (OSError, ValueError):
                timer.cancel()
                code = process.wait()
                self.stop()
                raise EngineFailure(_failure(self.name, late.is_set(), limit, code)) from None
            except BaseException:
                timer.cancel()
                self.stop()  # the answer to this must not be taken for the next one's
                raise
            timer.cancel()
        if "value" in answer:
            return answer["value"]
        if answer["refusal"] == Unavailable.__name__:
            raise InputError(f"backend {self.name}: {answer['message']}")
        raise ShaderRejected(answer["message"], answer["stage"])

    def _running(self) -> subprocess.Popen:
        if self._process is None or self._process.poll() is not None:
            # -P: the current folder, where a user's files are, is no place to import modules from.
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "raytrace.backends.gpu.worker", self.name],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        return self._process


@cache
def engine_process(name: str, foreign: bool = False) -> EngineProcess:
    """The process of the engine of that name, one for all who ask; `foreign` gives one apart, for foreign shaders."""
    process = EngineProcess(name)
    atexit.register(process.stop)
    return process


def _failure(name: str, late: bool, limit: float, code: int) -> str:
    if late:
        return f"backend {name}: did not finish within {limit:g} s"
    ended = f"ended by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
    return f"backend {name}: the engine crashed ({ended})"


def _descendants(pid: int) -> list[int]:
    """All processes that a process has started and they in turn, where the system lists them (Linux)."""
    found = []
    for children in Path("/proc").glob(f"{pid}/task/*/children"):
        with suppress(OSError):
            for child in map(int, children.read_text().split()):
                found += [child, *_descendants(child)]
    return found
