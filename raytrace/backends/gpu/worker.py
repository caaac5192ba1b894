"""The process that an engine lives in: ``python -m raytrace.backends.gpu.worker ENGINE``.

It reads requests, pickled (method, arguments), from standard input, and answers each with a line of JSON on standard
output, {"value": ...} or {"refusal": its kind, "message": ..., "stage": ...}, until the input ends. So what this
process sends, which runs foreign code, is data. An image is written to a file that the asker maps.

A second process, its guard, waits for the asker's end, and then ends this one with all that it has started.
"""

import json
import os
import pickle
import signal
import sys
from dataclasses import asdict
from importlib import import_module
from typing import Any

import numpy as np

from raytrace.backends.gpu.drawing import ShaderRejected, Unavailable
from raytrace.backends.gpu.process import end_family

__all__ = ["main"]

#: Where the engines' classes are.
ENGINES = {"opengl": ("raytrace.backends.gpu.opengl", "OpenGL"), "webgl": ("raytrace.backends.gpu.webgl", "WebGL")}


def main(name: str, alive: int | None = None) -> None:
    """Serves the engine of that name.

    alive: the reading end of a pipe whose other end is the asker's; it ends with the asker.
    """
    if alive is not None:
        _guard(alive)
    # Ctrl-C is for the process that asks, which ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Whatever a driver prints must not come between the answers.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    engine = None
    while True:
        try:
            method, arguments = pickle.load(sys.stdin.buffer)
        except EOFError:
            break
        try:
            if engine is None:
                module, kind = ENGINES[name]
                engine = getattr(import_module(module), kind)()
            answer = {"value": _answer(engine, method, arguments)}
        except (ShaderRejected, Unavailable) as refusal:
            stage = getattr(refusal, "stage", None)
            answer = {"refusal": type(refusal).__name__, "message": str(refusal), "stage": stage}
        print(json.dumps(answer), file=answers, flush=True)
    if engine is not None:
        engine.close()


def _guard(alive: int) -> None:
    """Starts the guard: a driver may hold this process for minutes, and it would not see that the asker is gone."""
    worker = os.getpid()
    if os.fork():
        os.close(alive)
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for stream in (0, 1, 2):
        os.close(stream)  # the answers end when the worker does
    os.read(alive, 1)
    if os.getppid() == worker:
        end_family(worker)
    os._exit(0)


def _answer(engine: Any, method: str, arguments: tuple) -> Any:
    if method == "about":
        return engine.about()
    if method == "active_uniforms":
        return [asdict(uniform) for uniform in engine.active_uniforms(*arguments)]
    drawing, path = arguments
    image = np.memmap(path, np.float32, "r+", shape=drawing.shape)
    engine.draw(drawing, image)
    return None


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
