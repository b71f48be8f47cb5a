"""The length of a record: as given, or until the impact is over and as long again."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from ..base import warn, with_unit
from ..scene import Plan
from .run import Run

__all__ = ["Record"]

# Contacts that go on for so many times the first guess, as under gravity, are left at that.
_MOST = 4096.0

# After the last contact the record goes on for as long as the impact took: in all, so many times.
_AS_LONG_AGAIN = 2.0


@dataclass
class Record:
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
        """Let the next run say anew when its impact is over, if the length was not given.

        From the first guess on, so that no poorer model has a say in it.
        """
        if not self.given:
            self.length, self._settled = self._first, False

    def run(self, plan: Plan, solve: Callable[[Plan], Run], *, last: bool = True) -> Run:
        """Run a plan for that long; for longer, from then on, until its impact is over.

        Parameters
        ----------
        plan : Plan
        solve : callable
        last : bool, optional
            Whether these bodies tell when it is over: not those that are rigid for a trial.
        """
        if self._settled:
            return solve(_lasting(plan, self.length))
        length = self.length
        while True:
            run = solve(_lasting(plan, length))
            wanted = _until_over(run)
            if wanted <= length or length >= self._longest:
                break
            further = wanted if math.isfinite(wanted) else _AS_LONG_AGAIN * length
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
    return start + _AS_LONG_AGAIN * (end - start)
