"""Waiting for a long call with open ears."""

import signal
import sys
import threading
import time

import pytest

from aoimpact.base import interruptible


def test_what_a_call_returns_and_raises_comes_through() -> None:
    assert interruptible(lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        interruptible(lambda: 1 // 0)


def test_beside_the_main_thread_a_call_is_only_called() -> None:
    found: list[threading.Thread] = []
    thread = threading.Thread(
        target=lambda: interruptible(lambda: found.append(threading.current_thread()))
    )
    thread.start()
    thread.join()
    assert found == [thread]


@pytest.mark.skipif(sys.platform == "win32", reason="needs a timer that interrupts")
def test_an_interrupt_is_heard_while_the_call_goes_on() -> None:
    go_on = threading.Event()
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    start = time.perf_counter()
    try:
        with pytest.raises(KeyboardInterrupt):
            interruptible(lambda: go_on.wait(20.0))
    finally:
        signal.signal(signal.SIGALRM, before)
        go_on.set()
    assert time.perf_counter() - start < 5.0
