"""Ctrl-C while a library computes for long: NumPy, LAPACK and SuperLU look at no signals."""

from __future__ import annotations

import contextvars
import threading
from collections.abc import Callable
from typing import TypeVar

__all__ = ["OFTEN", "heard"]

T = TypeVar("T")

# s; where waiting itself hears no signals (Windows), they are heard this often.
OFTEN = 0.05


def heard(call: Callable[[], T]) -> T:
    """Return what `call` returns, computed in another thread while this one hears signals.

    For calls that let other threads run, and that give no warnings. What Ctrl-C ends is the
    waiting: the call itself goes on to its end in the background, where nothing hears of it.
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
    while not ended.wait(OFTEN):
        pass
    if errors:
        raise errors.pop()
    return results.pop()
