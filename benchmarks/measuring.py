"""Times as the shortest of several calls, and tables of times with their ratios."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from aoimpact.base import with_unit


def best_times(
    *calls: Callable[[], object],
    enough: float = 1.0,
    clock: Callable[[], float] = time.perf_counter,
) -> list[float]:
    """Return the shortest time of each call, s, of as many rounds as fit into `enough` s.

    The calls take turns, so that other load of the machine affects all of them alike.
    """
    best = [math.inf] * len(calls)
    end = time.perf_counter() + enough
    while math.isinf(best[0]) or time.perf_counter() < end:
        for i, call in enumerate(calls):
            start = clock()
            call()
            best[i] = min(best[i], clock() - start)
    return best


@dataclass(frozen=True)
class Line:
    """A measured time, s, and the time that it is compared with, s."""

    what: str
    seconds: float
    yardstick: str = ""
    yardstick_seconds: float = math.nan


def print_table(title: str, lines: list[Line]) -> None:
    """Print times, each with its ratio to the time that it is compared with."""
    print(f"\n{title}")
    width = max(len(line.what) for line in lines)
    for line in lines:
        ratio = ""
        if line.yardstick:
            times = line.seconds / line.yardstick_seconds
            ratio = (
                f" = {times:.3g} x {line.yardstick} ({with_unit(line.yardstick_seconds, 's', 3)})"
            )
        print(f"  {line.what:<{width}}  {with_unit(line.seconds, 's', 3):>9}{ratio}")
