"""Calls by several threads: all end, errors are raised, a forked process has its own."""

import multiprocessing
import os

import pytest

from aoimpact.base import at_once, threads


def test_calls_at_once_all_end_and_the_first_error_is_raised():
    ended = []

    def call(number):
        ended.append(number)
        if number % 2:
            raise ValueError(f"call {number}")

    with pytest.raises(ValueError, match="call"):
        at_once([lambda number=number: call(number) for number in (0, 1, 2)])
    assert 0 in ended
    at_once([lambda: ended.append("alone")])
    assert ended[-1] == "alone"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_has_threads_of_its_own():
    at_once([lambda: None] * 4)
    child = multiprocessing.get_context("fork").Process(target=at_once, args=([int] * 4,))
    child.start()
    child.join(20.0)
    assert child.exitcode == 0
    assert threads._pool(os.getpid())[1] >= 1
