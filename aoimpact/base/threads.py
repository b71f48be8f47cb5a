"""Work by several threads, for calls that release the GIL; the same results by any number."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

__all__ = ["Turns", "at_once"]

_Calls = Sequence[Callable[[], Any]]

# s, after which whoever waits for a thread looks whether it has ended: an interrupt may have come
# between the lock, which is released once, and the look.
_LOOK_AGAIN = 1.0

# Marks the threads of a pool: one that waited for others of it might wait for ever.
_of_pool = threading.local()


def at_once(calls: _Calls) -> None:
    """Make all calls, and return when all have ended.

    After an error, which is raised, some may not have been made; none goes on, not even where the
    caller's thread is interrupted. Calls from within one of them are made one by one.
    """
    cores = 1 if getattr(_of_pool, "is_one", False) else _cores()
    count = min(cores, len(calls))
    others = [_Share(calls[k::count]) for k in range(1, count)]
    try:
        for share in others:
            _hand_over(share.make, cores)
        _one_by_one(calls[:: max(count, 1)])
        for share in others:  # where no thread has begun, as none could be started
            if share.is_own():
                _one_by_one(share.calls)
    finally:
        try:
            _wait_for(others)
        finally:  # an interrupt may have come before the first of these waited
            _wait_for(others)
    for share in others:
        if share.error is not None:
            raise share.error


class _Share:
    """Calls that belong to the first thread that asks: a pool keeps what it could not start."""

    def __init__(self, calls: _Calls) -> None:
        self.calls, self.is_over = calls, False
        self.error: BaseException | None = None
        self.end = threading.Lock()
        self.end.acquire()
        self._owner: dict[str, int] = {}

    def is_own(self) -> bool:
        """Whether it is this thread's; from the first answer on it is nobody else's."""
        me = threading.get_ident()
        return self._owner.setdefault("thread", me) == me  # at once, in one call of C

    def make(self) -> None:
        """Make the calls in a thread of a pool, unless they belong to the caller."""
        if self.is_own():
            try:
                _one_by_one(self.calls)
            except BaseException as error:
                self.error = error
            finally:
                self.is_over = True
                self.end.release()


class Turns:
    """A lock for one thread at a time; a forked process has another one, which nobody holds."""

    def __init__(self) -> None:
        self._locks: dict[int, threading.RLock] = {}

    def __enter__(self) -> None:
        self._locks.setdefault(os.getpid(), threading.RLock()).acquire()

    def __exit__(self, *error: object) -> None:
        self._locks[os.getpid()].release()


def _hand_over(call: Callable[[], None], cores: int) -> None:
    try:
        _pool(os.getpid(), cores).submit(call)
    except RuntimeError:  # no thread can be started, for want of any or as the interpreter ends
        return


def _one_by_one(calls: _Calls) -> None:
    for call in calls:
        call()


def _wait_for(shares: list[_Share]) -> None:
    """Wait, through any interrupt: what other threads write to is the caller's again afterwards.

    What they have not begun they never will. Locks of `threading` alone are not broken by an
    interrupt; those of `concurrent.futures` may stay locked for ever.
    """
    interrupt: BaseException | None = None
    for share in shares:
        while not share.is_own() and not share.is_over:
            try:
                share.end.acquire(timeout=_LOOK_AGAIN)
            except BaseException as error:
                interrupt = error
    if interrupt is not None:
        raise interrupt


def _cores() -> int:
    """Return how many cores this process may use now; OMP_NUM_THREADS holds here as for BLAS."""
    whose = getattr(os, "sched_getaffinity", None)
    cores = len(whose(0)) if whose is not None else os.cpu_count() or 1
    wanted = os.environ.get("OMP_NUM_THREADS", "").split(",")[0].strip()  # "4,2": nested levels
    return min(cores, max(1, int(wanted))) if wanted.isdecimal() else cores


@cache
def _pool(process: int, cores: int) -> Any:
    """Return the threads beside the caller's.

    A forked process has none of its parent's threads, and would wait for them for ever.
    """
    from concurrent.futures import ThreadPoolExecutor  # not while the interpreter ends

    mark = partial(setattr, _of_pool, "is_one", True)
    return ThreadPoolExecutor(cores - 1, thread_name_prefix="aoimpact", initializer=mark)
