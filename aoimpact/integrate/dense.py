"""A run of the adaptive method, and its dense record.

In contact the forces over a step are polynomials through eight Radau nodes. The modal response to
these polynomials is exact, so that steps need to resolve only the forces. Between contacts the
motion is known in closed form, without steps.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from .. import _core
from ..base import ArrayPair, FloatArray, MemoryLimitError, record
from ..scene import Scenario
from .events import Events
from .motion import Motion

# Numbers of samples of a curve: _PER_STEP: in each step in contact; _IN_FREE_MOTION: in a whole
# record of free motion.
_PER_STEP = 8
_IN_FREE_MOTION = 240

# Intervals of central differences, relative to the shortest contact: _DIFFERENCE: for the rates of
# forces; in this interval a smooth force changes nearly linearly, and by far more than its rounding
# errors. _RESOLUTION: for accelerations; the rates of forces cause relative errors of 1e-7, and the
# curvature of smooth forces 1e-6.
_DIFFERENCE, _RESOLUTION = 1e-6, 1e-3

# Largest number of values in a curve's record, a limit of memory; no screen shows more.
_MOST_VALUES = 2e7


@record
class DenseRecorder:
    """The :class:`Recorder` of an adaptive run, accurate at any time.

    Attributes
    ----------
    plan : Scenario
        Plan of the run.
    rtol : float
        Relative tolerance of the run.
    scene : tuple of (bodies, contacts)
        Core's tuples of the bodies and contacts.
    track : object
        Record of the core.
    events : tuple of Events
        Events of each contact. An interval that the record cuts off ends with the record; an
        interval that would begin at the record's end is left out.
    steps, rejected : int
        Number of accepted and of rejected steps in contact.
    seconds : float
        Computing time of the run, s.
    """

    plan: Scenario
    rtol: float
    scene: tuple[tuple[Any, ...], tuple[Any, ...]]
    track: Any
    events: tuple[Events, ...]
    steps: int
    rejected: int
    seconds: float = 0.0
    dense: ClassVar[bool] = True

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"track": _core.track_bytes(self.track)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        track = _core.track_open(*state["scene"], *state["track"])
        self.__dict__.update(state, track=track)

    @property
    def solver(self) -> str:
        return f"Adaptive(rtol={self.rtol:g}), {self.steps} steps in contact"

    @property
    def duration(self) -> float:
        return self.plan.duration

    # ------------------------------------------------------------------- times

    @property
    def marks(self) -> FloatArray:
        most = _most_times(self.plan.layout.rows)
        known = np.unique(np.append(_thinned(self._steps[0], most), self.duration))
        return known[known <= self.duration]

    @property
    def times(self) -> FloatArray:
        """Times for smooth curves, s; include the times of peaks and of the ends of contacts."""
        start, length, contacts = self._steps
        pressed, most = contacts > 0.0, _most_times(self.plan.layout.rows)
        per_step = min(_PER_STEP, max(1, most // max(1, int(pressed.sum()))))
        shares = np.arange(per_step) / per_step
        inside = start[pressed, None] + length[pressed, None] * shares
        parts = [np.array([0.0, self.duration]), _thinned(inside.ravel(), most)]
        parts += [np.array([event.peak_time]) for event in self.events]
        for event in self.events:
            parts.append(_thinned(np.array(event.contacts).ravel(), most))
        known = np.unique(np.concatenate(parts))
        return _filled(known[known <= self.duration], self.duration)

    @property
    def _steps(self) -> FloatArray:
        """Start, s, length, s, and number of contacts of each interval in the record, (3, n)."""
        return np.frombuffer(_core.track_rows(self.track)).reshape(-1, 3).T

    # ------------------------------------------------------------------- values

    def rows(self, times: FloatArray, energies: bool) -> FloatArray:
        record = np.zeros((self.plan.layout.rows, len(times)))
        _core.track_read(self.track, np.ascontiguousarray(times), int(energies), 0, record)
        return record

    def pushes(self, times: FloatArray) -> FloatArray:
        if self.plan.layout.slides:
            return self.plan.layout.pushes(self.rows(times, energies=False))
        forces = np.zeros((len(self.events), len(times)))
        _core.track_read(self.track, np.ascontiguousarray(times), 2, 0, forces)
        return forces

    def modes(self, times: FloatArray, body: int) -> ArrayPair:
        """Return a body's modal coordinates and rates, (n, len(times)), at ascending times."""
        found = np.empty((len(times), 2, len(self.plan.modal[body].omega)))
        _core.track_read(self.track, np.ascontiguousarray(times), 3, body, found)
        return found[:, 0].T, found[:, 1].T

    def motion(self, body: int) -> Motion:
        lengths = [end - start for of in self.events for start, end in of.contacts]
        shortest = min(lengths, default=self.duration)
        return Motion(self, body, _RESOLUTION * shortest, _DIFFERENCE * shortest)


def adaptive_run(plan: Scenario, *, rtol: float, most_steps: int = sys.maxsize) -> DenseRecorder:
    """Run a scene to a tolerance.

    Parameters
    ----------
    plan : Scenario
    rtol : float
    most_steps : int, optional
        Approximate number of steps after which the run fails.

    Raises
    ------
    ConvergenceError
        If the tolerance cannot be met; the error states the time.
    LawLimitError
        If a contact exceeds the largest indentation of its law; the error has its number.
    MemoryLimitError
        If the run's steps, up to 1 GiB, do not fit into memory.
    """
    began = perf_counter()
    contacts = [contact.for_core(contact.law.for_core()) for contact in plan.contacts]
    bodies, moving, oblique, pull = [], [], plan.oblique is not None, plan.pull
    for i, body in enumerate(plan.modal):
        bodies.append(body.for_core(pull, plan.load_on(i) if plan.loads else None))
        moving.append(body.rates(plan.start(i)) if oblique else body.whole.moving)
    scene = tuple(bodies), tuple(contacts)
    velocities = (1.0,) * len(bodies) if oblique else tuple(plan.velocities)
    rest = None if plan.rest is None else np.concatenate(plan.rest.modes)
    try:
        track, found, steps, rejected = _core.adaptive(
            *scene, rtol, plan.duration, rest, tuple(moving), velocities, most_steps
        )
    except MemoryError:
        raise MemoryLimitError(
            f"the steps of a run of {plan.duration:g} s to rtol={rtol:g} do not fit into the "
            "memory that is left; take a shorter duration, a larger rtol, or Newmark(dt=...)"
        ) from None
    events = []
    for number, (contact, of) in enumerate(zip(plan.contacts, found, strict=True)):
        peak, peak_time, impulse, spans, touches = of
        slips = None if contact.friction is None else _slips(track, spans, number)
        events.append(Events(peak, peak_time, tuple(spans), impulse, slips, touches))
    took = perf_counter() - began
    return DenseRecorder(plan, rtol, scene, track, tuple(events), steps, rejected, took)


def _filled(times: FloatArray, duration: float) -> FloatArray:
    """Return ascending times, with evenly spaced times added between those that are far apart."""
    apart = np.diff(times)
    parts = 1 + (_IN_FREE_MOTION * (apart / duration)).astype(np.intp)
    number = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    inside = np.repeat(times[:-1], parts) + number * np.repeat(apart / parts, parts)
    return np.append(inside, times[-1:])


def _slips(
    track: Any, contacts: Sequence[tuple[float, float]], number: int
) -> tuple[tuple[float, float], ...]:
    """Return the intervals of full slip of the contact `number`.

    Each row of the core's record is the number of a contact, a time, s, and 1 if full slip begins
    then, or 0 if it ends.
    """
    rows = np.frombuffer(_core.track_slips(track)).reshape(-1, 3)
    _, times, slips = rows[rows[:, 0] == number].T
    ends = np.append(times[1:], np.inf)
    found: list[tuple[float, float]] = []
    for start, end in contacts:
        spans = np.clip(np.stack([times, ends], axis=1)[slips > 0.0], start, end)
        for first, last in spans[spans[:, 1] > spans[:, 0]].tolist():
            if found and found[-1][1] == first > start:  # continues the last interval
                first = found.pop()[0]
            found.append((first, last))
    return tuple(found)


def _most_times(rows: int) -> int:
    """Return the approximate largest number of times that a record with `rows` rows may have."""
    return max(1000, int(_MOST_VALUES / rows))


def _thinned(times: FloatArray, most: int) -> FloatArray:
    """Return every k-th time; k is the smallest number that leaves about `most` times or fewer."""
    return times[:: 1 + len(times) // most]
