"""The processor's cores, and work for all of them."""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

__all__ = ["cores", "in_threads"]

Item = TypeVar("Item")
Result = TypeVar("Result")


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_threads(function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """Yield `function` of each item, in order, from a thread for each core.

    After an error or an interruption the items that have not begun are not begun.
    """
    pool = ThreadPoolExecutor(cores())
    try:
        for pending in [pool.submit(function, item) for item in items]:
            yield pending.result()
    finally:
        pool.shutdown(cancel_futures=True)
