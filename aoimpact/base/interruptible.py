"""Ctrl-C during long calls of libraries: NumPy, LAPACK and SuperLU do not check for signals."""

from __future__ import annotations

import contextvars
import threading
from collections.abc import Callable
from typing import TypeVar

__all__ = ["SIGNAL_INTERVAL", "interruptible"]

T = TypeVar("T")

# s; on Windows waiting does not check for signals, so it is interrupted this often.
SIGNAL_INTERVAL = 0.05


def interruptible(call: Callable[[], T]) -> T:
    """Return what `call` returns, computed in another thread while this one checks for signals.

    For calls that release the GIL and give no warnings. Ctrl-C ends the waiting only: the call
    itself runs to its end in the background, and its result is discarded.
    """
    if threading.current_thread() is not threading.main_thread():
        return call()  # signals are the main thread's
    context, ended = contextvars.copy_context(), threading.Event()
    results: list[T] = []
    errors: list[BaseException] = []

    def run() -> None:
        try:
            results.append(context.run(call))
        except BaseException as error:
            errors.append(error)
        ended.set()

    threading.Thread(target=run, daemon=True).start()
    while not ended.wait(SIGNAL_INTERVAL):
        pass
    if errors:
        raise errors.pop()
    return results.pop()
