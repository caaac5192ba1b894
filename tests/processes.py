"""Commands in processes of their own. None of them outlives its test."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

__all__ = ["COMMAND", "command", "peak_memory", "started"]

#: What each child runs first. A suite that was started in the background may ignore SIGINT, and a child inherits that.
#: The limit, in seconds, ends a child even where the suite itself was killed.
_AS_FROM_A_TERMINAL = (
    "import resource, signal;"
    "signal.signal(signal.SIGINT, signal.default_int_handler); signal.signal(signal.SIGTERM, signal.SIG_DFL);"
    "resource.setrlimit(resource.RLIMIT_CPU, (900, 900));"
)
#: The command `raytrace`, to which arguments are added.
COMMAND = [sys.executable, "-c", f"{_AS_FROM_A_TERMINAL} from raytrace.cli import run; run()"]


#: Imports the command once and then forks for each line that it is given: importing takes longer than most commands.
_SERVER = (
    _AS_FROM_A_TERMINAL
    + """
import json, os, sys
import colour, jax, matplotlib.figure, numpy, OpenImageIO, raytrace.cli, scipy.ndimage, skimage.metrics
from raytrace.cli.groups import COMMANDS, command
for name in COMMANDS:
    command(name)
for line in sys.stdin:
    asked = json.loads(line)
    child = os.fork()
    if child == 0:
        os.chdir(asked["cwd"])
        os.environ.clear()
        os.environ.update(asked["environment"])
        for number, path in ((0, os.devnull), (1, asked["out"]), (2, asked["err"])):
            os.dup2(os.open(path, os.O_RDWR), number)
        signal.alarm(asked["limit"])
        sys.argv = ["raytrace", *asked["arguments"]]
        raytrace.cli.run()
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""
)


@cache
def _server() -> subprocess.Popen:
    """The server of this process. It ends when its standard input does, which is when this process does."""
    return subprocess.Popen(
        [sys.executable, "-W", "ignore::DeprecationWarning", "-c", _SERVER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def command(*arguments: object, cwd: str | Path | None = None, limit: int = 0) -> subprocess.CompletedProcess:
    """Run the command `raytrace` in a process of its own; return it with its output as text, however it ended.

    limit: seconds after which SIGALRM ends it; 0 for none.
    """
    arguments = [str(argument) for argument in arguments]
    with tempfile.NamedTemporaryFile("r") as out, tempfile.NamedTemporaryFile("r") as err:
        place = {"cwd": str(cwd or Path.cwd()), "out": out.name, "err": err.name, "limit": limit}
        server = _server()
        server.stdin.write(json.dumps({"arguments": arguments, "environment": dict(os.environ), **place}) + "\n")
        server.stdin.flush()
        code = int(server.stdout.readline())
        return subprocess.CompletedProcess(arguments, code, out.read(), err.read())


@contextmanager
def started(arguments: list[str], **options: object) -> Iterator[subprocess.Popen]:
    """Start a process in a session of its own; kill it, and all that it started, when the body ends."""
    process = subprocess.Popen(arguments, start_new_session=True, **options)
    try:
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        for pipe in (process.stdin, process.stdout, process.stderr):
            if pipe is not None:
                pipe.close()


def peak_memory(*arguments: str) -> int:
    """Return the most memory, in bytes, that Python took for some arguments, once it ended well."""
    # By way of a small process: Linux counts the memory of the process that starts another as the other's own.
    code = (
        "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL);"
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024)"
    )
    with started(
        [sys.executable, "-c", code, sys.executable, *arguments], stdout=subprocess.PIPE, text=True
    ) as process:
        told, _ = process.communicate()
    assert process.returncode == 0
    return int(told)
