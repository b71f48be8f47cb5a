"""Calls by several threads: all end, errors are raised, a forked process has its own."""

import multiprocessing
import os
import time
from functools import partial

import pytest

from aoimpact.base import at_once


def test_calls_at_once_are_all_made():
    for count in (0, 1, 2, 7):
        made: list[int] = []
        at_once([partial(made.append, number) for number in range(count)])
        assert sorted(made) == list(range(count))


@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_an_error_is_raised_when_no_call_goes_on(wrong):
    ended = []

    def call(number):
        if number == wrong:
            raise ValueError(f"call {number}")
        time.sleep(0.05)
        ended.append(number)

    with pytest.raises(ValueError, match=str(wrong)):
        at_once([lambda number=number: call(number) for number in range(3)])
    after = sorted(ended)
    assert set(after) <= {0, 1, 2} - {wrong}
    time.sleep(0.1)
    assert sorted(ended) == after


def test_calls_within_calls_do_not_wait_for_themselves():
    made = []
    inner = [lambda: made.append(1)] * 3
    at_once([lambda: at_once(inner)] * 4)
    assert len(made) == 12


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_has_threads_of_its_own():
    at_once([lambda: None] * 4)
    child = multiprocessing.get_context("fork").Process(target=at_once, args=([int] * 4,))
    child.start()
    child.join(20.0)
    assert child.exitcode == 0
