"""Workers: this thread, several threads, or the caller's executor, here or on a cluster."""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from typing import Any, NamedTuple

from ..base import InputTypeError, WorkerError, integer

__all__ = ["Workers"]

# What a task returns: the outcomes of its items, and the seconds that it took.
Done = tuple[Any, float]
Task = Callable[[list[Any]], Done]
Finished = Callable[[Sequence[Any], Any], None]

# Seconds that one task should take, in our threads and in other executors: far above the cost of
# handing it over, and short enough that all workers finish together.
_TASK_HERE, _TASK_AWAY = 0.015, 0.1

# Tasks per worker: one that runs and one that waits.
_AHEAD = 2

# More threads than any machine serves at once.
_MOST_THREADS = 4096


class _UnderWay(NamedTuple):
    """A task that was handed over: its items, how to wait for it, and how to cancel it."""

    items: list[Any]
    result: Callable[[], Done]
    cancel: Callable[[], Any]


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
        self.local = not (hasattr(workers, "map") or hasattr(workers, "submit"))
        if not self.local:
            self._executor, self._width = workers, _width(workers)
            return
        try:
            self._width = min(integer("workers", workers, low=1), _MOST_THREADS)
        except InputTypeError:
            raise InputTypeError(
                f"workers must be a number of threads, or an executor with .map, got {workers!r}"
            ) from None

    def run(
        self, task: Task, items: Iterable[Any], finished: Finished | None
    ) -> Iterator[tuple[list[Any], Any]]:
        """Yield the items of each task and what it made of them, in order.

        Parameters
        ----------
        finished : callable, optional
            Called with the same two as soon as a task has ended, out of order, in any thread.

        Raises
        ------
        WorkerError
            If a worker is lost, or items cannot be sent to it.
        """
        if self.local and self._width > 1:
            with ThreadPoolExecutor(self._width, thread_name_prefix="aoimpact") as threads:
                self._executor = threads
                yield from self._run(task, items, finished)
        else:
            yield from self._run(task, items, finished)

    def _run(
        self, task: Task, items: Iterable[Any], finished: Finished | None
    ) -> Iterator[tuple[list[Any], Any]]:
        source, size = iter(items), 1
        most = 1 if self._executor is None else _AHEAD * self._width
        under_way: deque[_UnderWay] = deque()
        try:
            while True:
                # By halves: a plain map works through all that it is given before it yields.
                if 2 * len(under_way) <= most:
                    room = most - len(under_way)
                    batches = [batch for _ in range(room) if (batch := list(islice(source, size)))]
                    under_way.extend(self._start(task, batches, finished))
                if not under_way:
                    return
                batch, result, _ = under_way.popleft()
                made, seconds = self._sent(result)
                size = _next_size(len(batch), seconds, _TASK_HERE if self.local else _TASK_AWAY)
                yield batch, made
        finally:
            for waiting in under_way:
                waiting.cancel()

    def _start(
        self, task: Task, batches: list[list[Any]], finished: Finished | None
    ) -> list[_UnderWay]:
        if hasattr(self._executor, "submit"):
            return [self._sent(self._submit, task, batch, finished) for batch in batches]
        maps = map if self._executor is None else self._executor.map
        made = iter(self._sent(maps, task, batches))
        return [_UnderWay(batch, _nexts(made, batch, finished), bool) for batch in batches]

    def _submit(self, task: Task, batch: list[Any], finished: Finished | None) -> _UnderWay:
        future = self._executor.submit(task, batch)
        if finished is not None:
            future.add_done_callback(_reporter(batch, finished))
        return _UnderWay(batch, future.result, future.cancel)

    def _sent(self, ask: Callable[..., Any], *arguments: Any) -> Any:
        """Call an executor; what it raises is its own failure, since tasks raise nothing."""
        if self.local:
            return ask(*arguments)
        try:
            return ask(*arguments)
        except Exception as error:
            raise WorkerError(
                f"workers: {type(error).__name__}: {error}. A worker was lost, or a case, a law or "
                "keep could not be sent to it (they must be picklable, functions defined in a "
                "module); with checkpoint=path what is finished is kept, and the same call goes on "
                "from there"
            ) from error


def _nexts(made: Iterator[Done], batch: list[Any], finished: Finished | None) -> Callable[[], Done]:
    def result() -> Done:
        done = next(made)
        if finished is not None:
            finished(batch, done[0])
        return done

    return result


def _reporter(batch: list[Any], finished: Finished) -> Callable[[Any], None]:
    def report(future: Any) -> None:
        if not future.cancelled() and not future.exception():
            finished(batch, future.result()[0])

    return report


def _next_size(size: int, seconds: float, target: float) -> int:
    """The number of items for which a task takes `target` seconds; it grows slowly."""
    wanted = target * size / seconds if seconds > 0.0 else math.inf
    return int(max(1.0, min(wanted, 4.0 * size)))


def _width(executor: Any) -> int:
    """How many workers an executor has; the number of cores where it is not known."""
    for name in ("num_workers", "_max_workers"):
        if isinstance(number := getattr(executor, name, None), int) and number > 0:
            return number
    if hasattr(executor, "nthreads"):  # dask: threads by worker
        return max(1, int(sum(executor.nthreads().values())))
    return os.cpu_count() or 1
