"""Work by several threads, for calls that release the GIL; the same results by any number."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from typing import Any

__all__ = ["at_once"]


@cache
def _pool(process: int) -> tuple[ThreadPoolExecutor | None, int]:
    """Threads beside the caller's, and how many there are with it.

    Of one process: a forked one has none of its parent's threads, and would wait for ever.
    """
    whose = getattr(os, "sched_getaffinity", None)
    count = len(whose(0)) if whose is not None else os.cpu_count() or 1
    if count == 1:
        return None, 1
    return ThreadPoolExecutor(count - 1, thread_name_prefix="aoimpact"), count


def at_once(calls: Sequence[Callable[[], Any]]) -> None:
    """Make all calls, and return when all have ended, whatever happens."""
    pool, count = _pool(os.getpid())
    if pool is None or len(calls) == 1:
        _one_by_one(calls)
        return
    others = [pool.submit(_one_by_one, calls[k::count]) for k in range(1, min(count, len(calls)))]
    try:
        _one_by_one(calls[::count])
    finally:
        wait(others)
    for other in others:
        other.result()


def _one_by_one(calls: Sequence[Callable[[], Any]]) -> None:
    for call in calls:
        call()
