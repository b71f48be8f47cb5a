"""Work by several threads, for calls that release the GIL; the same results by any number."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, wait
from functools import cache, partial
from typing import Any

__all__ = ["Turns", "at_once"]

_Calls = Sequence[Callable[[], Any]]

# Marks the threads of a pool: one that waited for others of it might wait for ever.
_of_pool = threading.local()


def at_once(calls: _Calls) -> None:
    """Make all calls, and return when all have ended.

    After an error, which is raised, some may not have been made; none goes on, not even where the
    caller's thread is interrupted. Calls from within one of them are made one by one.
    """
    others: list[Future[None]] = []
    try:
        _one_by_one(_hand_over(calls, others))
    finally:
        _wait_for(others)
    for other in others:
        other.result()


class Turns:
    """A lock for one thread at a time; a forked process has another one, which nobody holds."""

    def __init__(self) -> None:
        self._locks: dict[int, threading.RLock] = {}

    def __enter__(self) -> None:
        self._locks.setdefault(os.getpid(), threading.RLock()).acquire()

    def __exit__(self, *error: object) -> None:
        self._locks[os.getpid()].release()


def _hand_over(calls: _Calls, others: list[Future[None]]) -> _Calls:
    """Start other threads on their shares, and return the caller's own."""
    cores = 1 if getattr(_of_pool, "is_one", False) else _cores()
    count = min(cores, len(calls))
    own = list(calls[::count]) if count else []
    for share in (calls[k::count] for k in range(1, count)):
        try:
            others.append(_pool(os.getpid(), cores).submit(_one_by_one, share))
        except RuntimeError:  # the interpreter is ending, and starts no threads any more
            own += share
    return own


def _one_by_one(calls: _Calls) -> None:
    for call in calls:
        call()


def _wait_for(others: list[Future[None]]) -> None:
    """Wait, through any interrupt: what the others write to is the caller's again afterwards."""
    interrupt: BaseException | None = None
    while not all(other.done() for other in others):
        try:
            wait(others)
        except BaseException as error:
            interrupt = error
    if interrupt is not None:
        raise interrupt


def _cores() -> int:
    """Return how many cores this process may use now; OMP_NUM_THREADS holds here as for BLAS."""
    whose = getattr(os, "sched_getaffinity", None)
    cores = len(whose(0)) if whose is not None else os.cpu_count() or 1
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    return min(cores, max(1, int(wanted))) if wanted.isdecimal() else cores


@cache
def _pool(process: int, cores: int) -> Any:
    """Return the threads beside the caller's.

    A forked process has none of its parent's threads, and would wait for them for ever.
    """
    from concurrent.futures import ThreadPoolExecutor  # not while the interpreter ends

    mark = partial(setattr, _of_pool, "is_one", True)
    return ThreadPoolExecutor(cores - 1, thread_name_prefix="aoimpact", initializer=mark)
