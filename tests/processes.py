"""Commands in processes of their own."""

import os
import subprocess
import sys

__all__ = ["command", "peak_memory"]


def command(*arguments: str) -> subprocess.CompletedProcess:
    """The command `raytrace` with its output as text, however it ends."""
    return subprocess.run([sys.executable, "-m", "raytrace", *arguments], capture_output=True, text=True)


def peak_memory(*arguments: str) -> int:
    """The most memory, in bytes, that Python took for some arguments, once it ended well."""
    process = subprocess.Popen([sys.executable, *arguments], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    return usage.ru_maxrss * 1024
