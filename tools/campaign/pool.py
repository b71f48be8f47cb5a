"""Work in child processes with a time limit for each piece: what hangs is ended, and noted."""

from __future__ import annotations

import multiprocessing as mp
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from typing import Any

# s that a child may take to start. Others may have the processor for long: so many times the limit
# of its time may pass on the clock.
_STARTING, _PATIENCE = 60.0, 10.0


def _serve(
    connection: Connection, work: Callable[[Any], Any], begin: Callable[[], Any], limit: float
) -> None:
    begin()
    while True:
        try:
            item = connection.recv()
        except EOFError:
            return
        signal.setitimer(signal.ITIMER_PROF, limit)  # ends the process, whatever it is at
        try:
            answer = "done", work(item)
        except Exception as error:
            answer = "failed", f"{type(error).__name__}: {error}"
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        connection.send(answer)


def each(
    work: Callable[[Any], Any],
    items: Iterable[Any],
    *,
    workers: int,
    limit: float,
    begin: Callable[[], Any] = int,
) -> Iterator[tuple[Any, str, Any]]:
    """Yield (item, "done" | "failed" | "hangs" | "died", result) in the order of the items.

    Parameters
    ----------
    work : callable
        A function of a module, called in child processes.
    items : iterable
    workers : int
    limit : float
        s of the processor for one item.
    begin : callable, optional
        Called once in each child process, outside the limit.
    """
    context, mine, running = mp.get_context("spawn"), threading.local(), list[Any]()

    def one(item: Any) -> tuple[Any, str, Any]:
        if not hasattr(mine, "child"):
            connection, theirs = context.Pipe()
            process = context.Process(target=_serve, args=(theirs, work, begin, limit), daemon=True)
            process.start()
            theirs.close()
            running.append(connection)
            mine.child = process, connection
        process, connection = mine.child
        connection.send(item)
        if connection.poll(_STARTING + _PATIENCE * limit):
            try:
                return item, *connection.recv()
            except (EOFError, OSError):
                pass
        else:
            process.kill()
        process.join()
        del mine.child
        late = process.exitcode in (-signal.SIGPROF, -signal.SIGKILL)
        return item, "hangs" if late else "died", process.exitcode

    team = ThreadPoolExecutor(workers)
    try:
        yield from team.map(one, items)
    finally:
        team.shutdown(wait=False, cancel_futures=True)
        for connection in running:  # at whose end the children end
            connection.close()
