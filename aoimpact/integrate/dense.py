"""A run of the adaptive method, and its dense record.

In contact the forces over a step are polynomials through eight Radau nodes. What they do to the
bodies is exact in modes, so only the forces have to be resolved. Between contacts the motion has a
closed form and nothing is stepped.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from .. import _core
from ..base import ArrayPair, FloatArray, MemoryLimitError, record
from ..laws import CoreLaw
from ..scene import Scenario
from .events import Events
from .motion import Motion

# Samples for curves: within each step of contact, and in free motion over the whole record.
_PER_STEP = 8
_IN_FREE_MOTION = 240

# Rates of forces, and accelerations, are central differences over these shares of the shortest
# contact: a smooth force has moved far more than its rounding in the first, and its curve not yet
# bent; with the second, relative errors are 1e-7 by the rates of the forces, and 1e-6 by the curves
# of smooth ones.
_DIFFERENCE, _RESOLUTION = 1e-6, 1e-3

# Curves of more values than these fill the memory, not the screen.
_MOST_VALUES = 2e7


@record
class DenseRecorder:
    """An adaptive run as a :class:`Recorder`: exact at any time.

    Attributes
    ----------
    plan : Scenario
        What was run.
    rtol : float
        The requested tolerance.
    scene : tuple of (bodies, contacts)
        As the core takes them.
    track : object
        The core's own record.
    events : tuple of Events
        Of each contact; an interval that the record cuts off ends with it, one that would begin
        there is none.
    steps, rejected : int
        Steps of contact taken, and rejected.
    seconds : float
        How long the run took, s.
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
        """Times that draw smooth curves and hold the peaks and the ends of contacts."""
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
        """Start and length, s, and number of contacts of each row of the track, shape (3, rows)."""
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
        """Return a body's modes x and their rates v, shape (n, len(times)), at ascending times."""
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
        The run is given up after about as many.

    Raises
    ------
    ConvergenceError
        If the tolerance cannot be met; with the time.
    LawLimitError
        If a contact goes deeper than its law stands for; with its number.
    MemoryLimitError
        If the run's steps, up to a GiB of them, do not fit into memory.
    """
    began = perf_counter()
    laws: dict[int, CoreLaw] = {}
    contacts: list[tuple[Any, ...]] = []
    for contact in plan.contacts:
        if id(contact.law) not in laws:  # each law is packed once
            laws[id(contact.law)] = contact.law.for_core()
        contacts.append(contact.for_core(laws[id(contact.law)]))
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
    """Ascending times, and even ones between any two that are far apart for the record."""
    apart = np.diff(times)
    parts = 1 + (_IN_FREE_MOTION * (apart / duration)).astype(np.intp)
    number = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    inside = np.repeat(times[:-1], parts) + number * np.repeat(apart / parts, parts)
    return np.append(inside, times[-1:])


def _slips(
    track: Any, contacts: Sequence[tuple[float, float]], number: int
) -> tuple[tuple[float, float], ...]:
    """The intervals in which all of a contact slips, by its number.

    The core's rows are a contact, a time, s, and 1 where all of it slips from then on, or 0.
    """
    rows = np.frombuffer(_core.track_slips(track)).reshape(-1, 3)
    _, times, slips = rows[rows[:, 0] == number].T
    ends = np.append(times[1:], np.inf)
    found: list[tuple[float, float]] = []
    for start, end in contacts:
        spans = np.clip(np.stack([times, ends], axis=1)[slips > 0.0], start, end)
        for first, last in spans[spans[:, 1] > spans[:, 0]].tolist():
            if found and found[-1][1] == first > start:  # from one row to the next
                first = found.pop()[0]
            found.append((first, last))
    return tuple(found)


def _most_times(rows: int) -> int:
    """Times of a curve of so many rows, roughly, beyond which they are thinned out."""
    return max(1000, int(_MOST_VALUES / rows))


def _thinned(times: FloatArray, most: int) -> FloatArray:
    """Every so many of the times, at most about so many."""
    return times[:: 1 + len(times) // most]
