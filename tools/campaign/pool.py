"""Work in child processes with a time limit for each piece: what hangs is ended, and noted."""

from __future__ import annotations

import multiprocessing as mp
import os
import time as clock
from collections.abc import Callable, Iterable, Iterator
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

# s that a child may take to start: its time begins when it does.
_STARTING = 60.0

# Others may have the processor for long: so many times a limit of its time may pass on the clock.
PATIENCE = 10.0

# s between looks at a child that is late.
_BETWEEN_LOOKS = 0.5


def processor_time(pid: int) -> float:
    """s of the processor that a process has had so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _serve(connection: Connection, work: Callable[[Any], Any]) -> None:
    while True:
        try:
            item = connection.recv()
        except EOFError:
            return
        connection.send(None)
        try:
            connection.send((True, work(item)))
        except Exception as error:
            connection.send((False, f"{type(error).__name__}: {error}"))


class _Worker:
    def __init__(self, work: Callable[[Any], Any]) -> None:
        context = mp.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs, work), daemon=True)
        self.process.start()
        theirs.close()
        self.item: Any = None
        self.since = self.used = 0.0

    def give(self, item: Any) -> None:
        self.item, self.since = item, clock.monotonic() + _STARTING
        self.connection.send(item)

    def begins(self) -> None:
        self.since, self.used = clock.monotonic(), self._processor_time()

    def overdue(self, limit: float) -> bool:
        """By the processor's time."""
        if (waited := clock.monotonic() - self.since) <= limit:
            return False
        return waited > PATIENCE * limit or self._processor_time() - self.used > limit

    def _processor_time(self) -> float:
        return processor_time(self.process.pid) if self.process.pid else 0.0

    def end(self) -> None:
        self.process.kill()
        self.process.join()


def each(
    work: Callable[[Any], Any], items: Iterable[Any], *, workers: int, limit: float
) -> Iterator[tuple[Any, str, Any]]:
    """Yield (item, "done" | "failed" | "hangs" | "died", result) as they come.

    Parameters
    ----------
    work : callable
        A function of a module, called in child processes.
    items : iterable
    workers : int
    limit : float
        s of the processor for one item.
    """
    left = iter(items)
    team = [_Worker(work) for _ in range(workers)]
    busy: list[_Worker] = []
    try:
        for worker in team:
            _next(worker, left, busy)
        while busy:
            first = min(worker.since for worker in busy)
            left_over = max(_BETWEEN_LOOKS, first + limit - clock.monotonic())
            ready = wait([w.connection for w in busy], left_over)
            for worker in list(busy):
                if worker.connection in ready:
                    try:
                        message = worker.connection.recv()
                    except (EOFError, OSError):
                        busy.remove(worker)
                        yield worker.item, "died", worker.process.exitcode
                        _next(_replaced(worker, team, work), left, busy)
                        continue
                    if message is None:
                        worker.begins()
                        continue
                    busy.remove(worker)
                    good, result = message
                    yield worker.item, "done" if good else "failed", result
                    _next(worker, left, busy)
                elif worker.overdue(limit):
                    busy.remove(worker)
                    yield worker.item, "hangs", limit
                    _next(_replaced(worker, team, work), left, busy)
    finally:
        for worker in team:
            worker.end()


def _next(worker: _Worker, left: Iterator[Any], busy: list[_Worker]) -> None:
    item = next(left, None)
    if item is not None:
        worker.give(item)
        busy.append(worker)


def _replaced(worker: _Worker, team: list[_Worker], work: Callable[[Any], Any]) -> _Worker:
    worker.end()
    new = _Worker(work)
    team[team.index(worker)] = new
    return new
