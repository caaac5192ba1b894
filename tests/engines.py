"""What a test needs and may not find: it is skipped then, unless everything is required."""

import os
from typing import NoReturn

import pytest

from raytrace.backends.gpu.process import engine_process
from raytrace.errors import InputError

__all__ = ["need", "skip_unless_required"]


def need(engine: str) -> None:
    """Skips the test where the graphics engine of that name is missing."""
    try:
        engine_process(engine).about()
    except InputError as missing:
        skip_unless_required(missing)


def skip_unless_required(missing: Exception) -> NoReturn:
    """Skips the test, for the reason that `missing` gives; fails it where RAYTRACE_TEST_EVERYTHING is set."""
    if os.environ.get("RAYTRACE_TEST_EVERYTHING"):
        raise missing
    pytest.skip(str(missing))
