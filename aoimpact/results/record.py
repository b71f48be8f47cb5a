"""The length of a record: as given, or until the impact is over and as long again."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from ..base import warn, with_unit
from ..scene import Plan
from .run import Run

__all__ = ["AS_LONG_AGAIN", "RecordLength"]

# Longest record in units of the first guess, for contacts that do not end, as under gravity.
_MOST = 4096.0

# Length of the record in units of the time from the first contact's start to the last one's end.
AS_LONG_AGAIN = 2.0


@dataclass
class RecordLength:
    """How long a scene is recorded, s.

    Attributes
    ----------
    length : float
        The duration given, or a first guess.
    given : bool
        Whether it was given.
    """

    length: float
    given: bool

    def __post_init__(self) -> None:
        self._first = self.length
        self._longest = self.length if self.given else _MOST * self.length
        self._settled = self.given
        self._cut = False

    def reopen(self) -> None:
        """Let the next run determine the length of the record, unless it was given.

        It starts from the first guess: the result does not depend on earlier, smaller models.
        """
        if not self.given:
            self.length, self._settled = self._first, False

    def run(self, plan: Plan, solve: Callable[[Plan], Run], *, last: bool = True) -> Run:
        """Run a plan for this length, or, where that is open, until its impact is over.

        Parameters
        ----------
        plan : Plan
        solve : callable
        last : bool, optional
            Whether this run determines the length: not one with bodies that are rigid for a trial.
        """
        if self._settled:
            return solve(_lasting(plan, self.length))
        length = self.length
        while True:
            run = solve(_lasting(plan, length))
            wanted = _until_over(run)
            if wanted <= length or length >= self._longest:
                break
            further = wanted if math.isfinite(wanted) else AS_LONG_AGAIN * length
            length = min(further, self._longest)
        self._cut = wanted > length and any(events.contacts for events in run.events)
        self.length = min(wanted, length)
        self._settled = last
        return run if self.length == length else solve(_lasting(plan, self.length))

    def warn_if_cut(self) -> None:
        """Warn where the impact was not over after the longest record."""
        if self._cut:
            warn(
                f"duration: it was left out, and after {with_unit(self.length, 's')} the impact is "
                "not over: its numbers are those until then; give duration="
            )


def _lasting(plan: Plan, length: float) -> Plan:
    """The plan with that duration, s."""
    return plan if plan.duration == length else replace(plan, duration=length)


def _until_over(run: Run) -> float:
    """How long the record must be, s; infinite where that is not known yet."""
    intervals = [interval for events in run.events for interval in events.contacts]
    if not intervals or run.in_contact_at_end:
        return math.inf
    start = min(first for first, _ in intervals)
    end = max(last for _, last in intervals)
    return start + AS_LONG_AGAIN * (end - start)
