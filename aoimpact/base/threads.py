"""Threads for calls that release the GIL; results do not depend on the number of threads."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextvars import copy_context
from functools import cache
from typing import Any

_PREFIX = "aoimpact"


def at_once(calls: Sequence[Callable[[], Any]]) -> None:
    """Run all calls in several threads, and return when all have ended.

    The caller's thread runs its share of the calls. If a call itself uses this function, its calls
    run one by one, since threads of a pool that wait for each other may deadlock. If a call raises
    an error, the error is raised here, and some calls may not have run.
    """
    inside = threading.current_thread().name.startswith(_PREFIX)
    count = 1 if inside or len(calls) == 1 else min(_cores(), len(calls))
    if count <= 1:
        _one_by_one(calls)
        return
    pool = _pool(os.getpid(), count)
    others: list[Future[None]] = []
    try:
        for k in range(1, count):  # the context holds the caller's np.errstate and held warnings
            others.append(pool.submit(copy_context().run, _one_by_one, calls[k::count]))
        _one_by_one(calls[::count])
    finally:
        try:
            wait(others)
        finally:  # wait even after an interrupt: calls write to the caller's arrays
            wait(others)
    for other in others:
        other.result()


def _one_by_one(calls: Sequence[Callable[[], Any]]) -> None:
    for call in calls:
        call()


def _cores() -> int:
    """Return the number of cores that this process may use, at most OMP_NUM_THREADS."""
    whose = getattr(os, "sched_getaffinity", None)
    cores = len(whose(0)) if whose is not None else os.cpu_count() or 1
    # "4,2" gives the numbers of threads of two nested levels: the first one counts.
    wanted = os.environ.get("OMP_NUM_THREADS", "").split(",")[0].strip()
    return min(cores, max(1, int(wanted))) if wanted.isdecimal() else cores


@cache
def _pool(process: int, count: int) -> ThreadPoolExecutor:
    """Return the threads of a process, by its id: a forked process lacks its parent's threads."""
    return ThreadPoolExecutor(count - 1, thread_name_prefix=_PREFIX)
