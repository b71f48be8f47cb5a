"""Workers: this thread, several threads, or the caller's executor, here or on a cluster."""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
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


class Workers:
    """Runs tasks of several items each, in order and a few at a time: items may be endless.

    Parameters
    ----------
    workers : int or executor
        Threads, or whatever has ``submit`` or ``map``: concurrent.futures, a dask.distributed
        Client, mpi4py.futures, multiprocessing.Pool.
    """

    def __init__(self, workers: Any) -> None:
        self._executor: Any = None
        if hasattr(workers, "map") or hasattr(workers, "submit"):
            self._executor, self._width = workers, _width(workers)
            return
        try:
            self._width = min(integer("workers", workers, low=1), _MOST_THREADS)
        except InputTypeError:
            raise InputTypeError(
                f"workers must be a number of threads, or an executor with .map, got {workers!r}"
            ) from None

    def run(
        self, task: Task, items: Iterable[Any], finished: Callable[[Any, Any], None] | None
    ) -> Iterator[tuple[Any, Any]]:
        """Yield each item and its outcome, in order.

        Parameters
        ----------
        finished : callable, optional
            Called with both as soon as their task has ended, out of order, in any thread, and once
            more before they are yielded.

        Raises
        ------
        WorkerError
            If a worker is lost, or items cannot be sent to it.
        """
        if hasattr(self._executor, "submit"):
            yield from self._run(self._executor.submit, task, items, finished)
        elif self._executor is not None or self._width == 1:
            yield from self._run(None, task, items, finished)
        else:
            with ThreadPoolExecutor(self._width, thread_name_prefix="aoimpact") as threads:
                yield from self._run(threads.submit, task, items, finished)

    def _run(
        self,
        submit: Callable[..., Any] | None,
        task: Task,
        items: Iterable[Any],
        finished: Callable[[Any, Any], None] | None,
    ) -> Iterator[tuple[Any, Any]]:
        source, size = iter(items), 1
        most = 1 if submit is None else _AHEAD * self._width
        target = _TASK_HERE if self._executor is None else _TASK_AWAY
        under_way: deque[tuple[list[Any], Any]] = deque()

        def report(batch: list[Any], future: Any) -> None:
            if finished is not None and not future.cancelled() and not future.exception():
                for item, outcome in zip(batch, future.result()[0], strict=True):
                    finished(item, outcome)

        try:
            while True:
                while len(under_way) < most and (batch := list(islice(source, size))):
                    future = self._ask(submit or self._at_once, task, batch)
                    under_way.append((batch, future))
                    future.add_done_callback(lambda done, batch=batch: report(batch, done))
                if not under_way:
                    return
                batch, future = under_way.popleft()
                outcomes, seconds = self._ask(future.result)
                report(batch, future)
                # As many items as take the time wanted, which grows slowly.
                wanted = target * len(batch) / seconds if seconds > 0.0 else math.inf
                size = int(max(1.0, min(wanted, 4.0 * len(batch))))
                yield from zip(batch, outcomes, strict=True)
        finally:
            for _, future in under_way:
                future.cancel()

    def _at_once(self, task: Task, batch: list[Any]) -> Future[Any]:
        """Run a task in this thread, or by all workers of an executor that has only a map."""
        future: Future[Any] = Future()
        if self._executor is None:
            future.set_result(task(batch))
            return future
        size = math.ceil(len(batch) / self._width)
        parts = [batch[i : i + size] for i in range(0, len(batch), size)]
        made, seconds = zip(*self._executor.map(task, parts), strict=True)
        future.set_result(([one for outcomes in made for one in outcomes], max(seconds)))
        return future

    def _ask(self, ask: Callable[..., Any], *arguments: Any) -> Any:
        """Call an executor; what it raises is its own failure, since tasks raise nothing."""
        if self._executor is None:
            return ask(*arguments)
        try:
            return ask(*arguments)
        except Exception as error:
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
