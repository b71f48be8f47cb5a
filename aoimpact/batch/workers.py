"""Workers: this thread, several threads, or the caller's executor, here or on a cluster."""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from itertools import islice
from typing import Any

from ..base import InputTypeError, WorkerError, integer

# Makes the outcomes of some items; returns the seconds that it took as well.
Task = Callable[[list[Any]], tuple[list[Any], float]]

# Seconds that one task should take, in our threads and in other executors: far above the cost of
# handing it over, and short enough that all workers finish together.
_TASK_HERE, _TASK_AWAY = 0.015, 0.1

# Tasks per worker: one that runs and one that waits.
_AHEAD = 2

# More threads than any machine serves at once.
_MOST_THREADS = 4096


def checked_workers(workers: Any) -> Any:
    """Return a number of threads, or an executor.

    Raises
    ------
    InputTypeError
        If it is neither.
    """
    if callable(getattr(workers, "submit", None)):
        return workers
    try:
        return min(integer("workers", workers, low=1), _MOST_THREADS)
    except InputTypeError:
        raise InputTypeError(
            f"workers must be a number of threads, or an executor with .submit, got {workers!r}"
        ) from None


def run_tasks(workers: Any, task: Task, items: Iterable[Any]) -> Iterator[tuple[Any, Any]]:
    """Yield each item and its outcome, in order; items are drawn a few tasks ahead.

    Parameters
    ----------
    workers : int or executor
        Threads, or what has ``submit`` as `concurrent.futures.Executor`: a dask.distributed Client,
        an executor of mpi4py.futures.

    Raises
    ------
    WorkerError
        If a worker is lost, or items cannot be sent to it.
    """
    source, size, target = iter(items), 1, _TASK_HERE if isinstance(workers, int) else _TASK_AWAY
    under_way: deque[tuple[list[Any], Any]] = deque()
    with ExitStack() as stack:
        if workers == 1:
            submit, most = None, 1
        elif isinstance(workers, int):
            threads = ThreadPoolExecutor(workers, thread_name_prefix="aoimpact")
            stack.callback(threads.shutdown, wait=False)  # nor does an interrupt wait
            submit, most = threads.submit, _AHEAD * workers
        else:
            submit, most = workers.submit, _AHEAD * _width(workers)
        stack.callback(lambda: [future.cancel() for _, future in under_way])
        while True:
            while len(under_way) < most and (batch := list(islice(source, size))):
                under_way.append((batch, submit and _asked(workers, submit, task, batch)))
            if not under_way:
                return
            batch, future = under_way.popleft()
            outcomes, seconds = _asked(workers, future.result) if submit else task(batch)
            # As many items as take the time wanted, which grows slowly.
            wanted = target * len(batch) / seconds if seconds > 0.0 else math.inf
            size = int(max(1.0, min(wanted, 4.0 * len(batch))))
            yield from zip(batch, outcomes, strict=True)


def _asked(workers: Any, ask: Callable[..., Any], *arguments: Any) -> Any:
    """Call an executor; what it raises is its own failure, since tasks raise nothing."""
    try:
        return ask(*arguments)
    except Exception as error:
        if isinstance(workers, int):
            raise
        raise WorkerError(
            f"workers: {type(error).__name__}: {error}. A worker was lost, or a case, a law or "
            "keep could not be sent to it: they must be picklable, functions of a module"
        ) from error


def _width(executor: Any) -> int:
    """Number of workers of an executor; of cores where that is not known."""
    for name in ("num_workers", "_max_workers"):
        if isinstance(number := getattr(executor, name, None), int) and number > 0:
            return number
    if hasattr(executor, "nthreads"):  # dask: threads by worker
        return max(1, int(sum(executor.nthreads().values())))
    return os.cpu_count() or 1
