"""LLVM's library, which Dr.Jit compiles with (Debian: libllvm15 or newer)."""

import glob
import os
import re

from raytrace.errors import InputError

__all__ = ["llvm"]

OLDEST_LLVM = 15


def llvm() -> None:
    """Tell Dr.Jit where LLVM's library is, unless the user did.

    Raises:
        InputError: it is not installed.
    """
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        os.environ["DRJIT_LIBLLVM_PATH"] = _newest_llvm()


def _newest_llvm() -> str:
    found = {
        int(version.group(1)): path
        for pattern in ("/usr/lib/*/libLLVM*.so*", "/usr/lib/llvm-*/lib/libLLVM*.so*", "/usr/lib*/libLLVM*.so*")
        for path in glob.glob(pattern)
        if (version := re.search(r"(?:libLLVM-|llvm-|libLLVM\.so\.)(\d+)", path))
    }
    newest = max(found, default=0)
    if newest < OLDEST_LLVM:
        raise InputError(f"needs LLVM's library, version {OLDEST_LLVM} or newer: apt-get install libllvm15")
    return found[newest]
