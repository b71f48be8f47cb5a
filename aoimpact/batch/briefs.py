"""Many runs of two bodies by one call of the core, which returns only their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np

from .. import _core
from ..base import FloatArray
from ..integrate import Events
from ..laws import ContactLaw
from ..reduction import Body, BodyModel
from ..results import Speeds


class Answer(IntEnum):
    """Columns of what the core returns (enum in csrc/python/many.c).

    The last are the velocities of both centres of mass after the contact.
    """

    STATUS = 0
    TOUCHES = 1
    LASTING = 2
    PEAK_FORCE = 3
    PEAK_TIME = 4
    IMPULSE = 5
    START = 6
    END = 7
    FIRST = 8
    SECOND = 9


class Briefs:
    """Runs asked of the core and its answers, a row for each.

    Attributes
    ----------
    answers : ndarray, shape (rows, 10)
        Of all runs that have been made; columns as `Answer` has them.
    numbers : list of tuple
        Velocity, m/s, gap, m, length of the record, s, and relative tolerance of each row.
    """

    def __init__(self) -> None:
        self._bodies: list[Body] = []
        self._laws: list[ContactLaw] = []
        self._places: dict[int, int] = {}
        self._pairs: list[tuple[int, int, int]] = []
        self._fixed: list[tuple[bool, bool]] = []
        self._rows: list[int] = []
        self.numbers: list[tuple[float, ...]] = []
        self.answers: FloatArray = np.empty((0, len(Answer)))

    def pair(self, bodies: Sequence[BodyModel], law: ContactLaw) -> int:
        """Add two bodies and a law; return their number."""
        first, second = bodies
        places = (self._place(self._bodies, first.modal), self._place(self._bodies, second.modal))
        self._pairs.append((*places, self._place(self._laws, law)))
        self._fixed.append((first.constrained, second.constrained))
        return len(self._pairs) - 1

    def _place(self, of: list[Any], item: Any) -> int:
        """The place of a body or law in the list of them, which keeps its identity."""
        place = self._places.setdefault(id(item), len(of))
        if place == len(of):
            of.append(item)
        return place

    def ask(self, pair: int, velocity: float, gap: float, duration: float, rtol: float) -> int:
        """Add a run of a pair; return its row."""
        self._rows.append(pair)
        self.numbers.append((velocity, gap, duration, rtol))
        return len(self._rows) - 1

    def run(self) -> FloatArray:
        """Run what has been asked since the last time; return all answers."""
        done = len(self.answers)
        new = np.empty((len(self._rows) - done, len(Answer)))
        _core.briefs(
            tuple(body.for_core() for body in self._bodies),
            tuple(body.moving for body in self._bodies),
            tuple(law.for_core() for law in self._laws),
            np.array([self._pairs[pair] for pair in self._rows[done:]], np.int32).reshape(-1, 3),
            np.array(self.numbers[done:]).reshape(-1, 4),
            new,
        )
        self.answers = np.concatenate([self.answers, new])
        return self.answers

    @property
    def events(self) -> Events:
        """The events of the contacts, with columns in place of numbers."""
        at: Any = self.answers.T
        span = at[Answer.START], at[Answer.END]
        return Events(at[Answer.PEAK_FORCE], at[Answer.PEAK_TIME], (span,), at[Answer.IMPULSE])

    @property
    def speeds(self) -> Speeds:
        """The velocities before and after."""
        velocity = np.array([numbers[0] for numbers in self.numbers])
        return Speeds(
            np.array([velocity, np.zeros_like(velocity)]),
            self.answers[:, [Answer.FIRST, Answer.SECOND]].T,
            np.array(self._fixed)[self._rows].T,
        )
