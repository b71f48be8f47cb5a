"""A run of the adaptive method, and its dense record.

In contact the forces over a step are polynomials through eight Radau nodes. What they do to the
bodies is exact in modes, so only the forces have to be resolved. Between contacts the motion has a
closed form and nothing is stepped.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from .. import _core
from ..base import FloatArray, IntArray, LawLimitError, MemoryLimitError
from ..scene import Plan
from .band import narrow_order
from .events import Events
from .motion import DenseMotion

# Samples for curves: within each step of contact, and in free motion over the whole record.
_PER_STEP = 8
_IN_FREE_MOTION = 240

# Curves of more values than these fill the memory, not the screen.
_MOST_VALUES = 2e7


class Touch(NamedTuple):
    """One interval of a contact.

    Attributes
    ----------
    impulse : float
        N s.
    pace : float
        The rate at which it begins, times its length, relative to how deep it goes.
    """

    impulse: float
    pace: float


class Track:
    """The record of a run of the core, to be read at any time.

    Parameters
    ----------
    bodies, contacts : tuples
        The scene, as the core takes it.
    handle : object
        The core's own.
    """

    def __init__(self, bodies: tuple[Any, ...], contacts: tuple[Any, ...], handle: object) -> None:
        self._scene, self._handle = (bodies, contacts), handle

    def __reduce__(self) -> tuple[Any, ...]:
        return _opened, (*self._scene, *_core.track_bytes(self._handle))

    @cached_property
    def rows(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Start and length, s, and number of contacts of each row."""
        start, length, contacts = np.frombuffer(_core.track_rows(self._handle)).reshape(-1, 3).T
        return start, length, contacts

    @cached_property
    def slips(self) -> FloatArray:
        """Contact, time, s, and 1 where all of it slips from then on, or 0, shape (k, 3)."""
        return np.frombuffer(_core.track_slips(self._handle)).reshape(-1, 3)

    def record(self, times: FloatArray, rows: int, energies: bool) -> FloatArray:
        """Return the record at ascending times, s, shape (rows, times)."""
        record = np.zeros((rows, len(times)))
        _core.track_sample(self._handle, _ascending(times), record, energies)
        return record

    def forces(self, times: FloatArray) -> FloatArray:
        """Return the contact forces, N, shape (contacts, times)."""
        forces = np.zeros((len(self._scene[1]), len(times)))
        _core.track_forces(self._handle, _ascending(times), forces)
        return forces

    def states(self, times: FloatArray, body: int, n: int) -> FloatArray:
        """Return the `n` modes of a body and their rates, shape (times, 2, n)."""
        found = np.empty((len(times), 2, n))
        _core.track_states(self._handle, _ascending(times), body, found)
        return found


def _opened(bodies: Any, contacts: Any, values: bytes, places: bytes) -> Track:
    """A track that was pickled."""
    return Track(bodies, contacts, _core.track_open(bodies, contacts, values, places))


def _ascending(times: FloatArray) -> FloatArray:
    return np.ascontiguousarray(times, dtype=np.float64)


class _Found(NamedTuple):
    """Intervals, peak and impulse of a contact, as the core found them."""

    peak_force: float
    peak_time: float
    impulse: float
    intervals: list[tuple[float, float]]
    touches: list[tuple[float, float]]


@dataclass(frozen=True, eq=False)
class DenseRecorder:
    """An adaptive run as a :class:`Recorder`: exact at any time.

    Attributes
    ----------
    plan : Plan
        What was run.
    rtol : float
        The requested tolerance.
    order : ndarray, shape (contacts,), or None
        Which contact of the scene each is, where the core takes them in another order. All else
        is by contacts.
    events : tuple of Events
        Of each contact; an interval that the record cuts off ends with it, one that would begin
        there is none.
    touches : tuple of lists of Touch
        Of each contact, for each of its intervals.
    steps, rejected : int
        Steps of contact taken, and rejected.
    track : Track
    x, v : bytes
        The modes of all bodies, and their rates, where the last row ends.
    seconds : float
        How long the run took, s.
    """

    plan: Plan
    rtol: float
    order: IntArray | None
    events: tuple[Events, ...]
    touches: tuple[list[Touch], ...]
    steps: int
    rejected: int
    track: Track
    x: bytes
    v: bytes
    seconds: float = 0.0
    dense: ClassVar[bool] = True

    @property
    def solver(self) -> str:
        return f"Adaptive(rtol={self.rtol:g}), {self.steps} steps in contact"

    @property
    def duration(self) -> float:
        return self.plan.duration

    # ------------------------------------------------------------------- times

    @property
    def marks(self) -> FloatArray:
        start = _thinned(self.track.rows[0], self._most_times)
        return np.unique(np.append(start, self.duration))

    @property
    def times(self) -> FloatArray:
        """Times that draw smooth curves and hold the peaks and the ends of contacts."""
        parts = [np.array([0.0, self.duration]), self._times_in_contact()]
        parts += [np.array([event.peak_time]) for event in self.events]
        for event in self.events:
            parts.append(_thinned(np.array(event.contacts).ravel(), self._most_times))
        known = np.unique(np.concatenate(parts))
        return _filled(known[known <= self.duration], self.duration)

    def _times_in_contact(self) -> FloatArray:
        """Times within the steps of contact."""
        start, length, contacts = self.track.rows
        begin, lasting = start[contacts > 0.0], length[contacts > 0.0]
        per_step = min(_PER_STEP, max(1, self._most_times // max(1, len(begin))))
        inside = np.add.outer(begin, np.zeros(per_step)) + np.outer(
            lasting, np.arange(per_step) / per_step
        )
        return _thinned(inside.ravel(), self._most_times)

    @property
    def _most_times(self) -> int:
        """Times of a curve, roughly, beyond which they are thinned out."""
        return max(1000, int(_MOST_VALUES / self.plan.layout.rows))

    # ------------------------------------------------------------------- values

    def rows(self, times: FloatArray, energies: bool) -> FloatArray:
        layout = self.plan.layout
        record = self.track.record(times, layout.rows, energies)
        if self.order is not None:
            layout.reordered(record, self.order)
        return record

    def forces(self, times: FloatArray) -> FloatArray:
        forces = self.track.forces(times)
        if self.order is not None:
            forces[self.order] = forces.copy()
        return forces

    def pushes(self, times: FloatArray) -> FloatArray:
        if self.plan.oblique is None:
            return self.forces(times)
        return self.plan.layout.pushes(self.rows(times, energies=False))

    def modes(self, times: FloatArray, body: int) -> tuple[FloatArray, FloatArray]:
        """Return a body's modes x and their rates v, shape (n, len(times)), at ascending times."""
        found = self.track.states(times, body, len(self.plan.modal[body].omega))
        return found[:, 0].T, found[:, 1].T

    def state(self, body: int) -> tuple[FloatArray, FloatArray]:
        ours = slice(*self.plan.first_modes[body : body + 2])
        return np.frombuffer(self.x)[ours], np.frombuffer(self.v)[ours]

    def motion(self, body: int) -> DenseMotion:
        return DenseMotion(self, body)


def adaptive_run(plan: Plan, *, rtol: float, most_steps: int = sys.maxsize) -> DenseRecorder:
    """Run a scene to a tolerance.

    Parameters
    ----------
    plan : Plan
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
    order = _order(plan) if len(plan.contacts) > 2 else None
    laws = {id(of.law): of.law.for_core() for of in plan.contacts}  # each of them once
    bodies = tuple([body.for_core(plan.pull, plan.load_on(i)) for i, body in enumerate(plan.modal)])
    joined = [of.for_core(laws[id(of.law)]) for of in plan.contacts]
    contacts = tuple(joined if order is None else [joined[i] for i in order])
    rest = None if plan.rest is None else np.concatenate(plan.rest.modes)
    moving, velocities = tuple([body.moving for body in plan.modal]), tuple(plan.velocities)
    if plan.oblique is not None:
        moving = tuple([body.rates(plan.start(i)) for i, body in enumerate(plan.modal)])
        velocities = (1.0,) * len(moving)
    try:
        track, x, v, intervals, steps, rejected = _core.adaptive(
            bodies, contacts, rtol, plan.duration, rest, moving, velocities, most_steps
        )
    except LawLimitError as error:
        if order is not None and error.contact is not None:
            error.contact = int(order[error.contact])
        raise
    except MemoryError:
        raise MemoryLimitError(
            f"the steps of a run of {plan.duration:g} s to rtol={rtol:g} do not fit into the "
            "memory that is left; take a shorter duration, a larger rtol, or Newmark(dt=...)"
        ) from None
    if order is not None:
        intervals = tuple([intervals[i] for i in np.argsort(order)])
    found = [_Found(*of) for of in intervals]
    if len(found) > 1:
        found = [_pressed(contact) for contact in found]
    record = Track(bodies, contacts, track)
    places = range(len(found)) if order is None else np.argsort(order).tolist()
    slips = [
        None if contact.friction is None else _slips(record, of, at)
        for contact, of, at in zip(plan.contacts, found, places, strict=True)
    ]
    return DenseRecorder(
        plan=plan,
        rtol=rtol,
        order=order,
        events=tuple(
            [
                Events(of.peak_force, of.peak_time, tuple(of.intervals), of.impulse, slip)
                for of, slip in zip(found, slips, strict=True)
            ]
        ),
        touches=tuple([[Touch(*touch) for touch in of.touches] for of in found]),
        steps=steps,
        rejected=rejected,
        track=record,
        x=x,
        v=v,
        seconds=perf_counter() - began,
    )


def _filled(times: FloatArray, duration: float) -> FloatArray:
    """Ascending times, and even ones between any two that are far apart for the record."""
    apart = np.diff(times)
    parts = 1 + (_IN_FREE_MOTION * (apart / duration)).astype(np.intp)
    number = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    inside = np.repeat(times[:-1], parts) + number * np.repeat(apart / parts, parts)
    return np.append(inside, times[-1:])


def _pressed(contact: _Found) -> _Found:
    """The contact without intervals in which no force acted: of bodies that separate at once."""
    felt = [i for i, touch in enumerate(contact.touches) if Touch(*touch).impulse != 0.0]
    return contact._replace(
        intervals=[contact.intervals[i] for i in felt], touches=[contact.touches[i] for i in felt]
    )


def _slips(track: Track, of: _Found, contact: int) -> tuple[tuple[float, float], ...]:
    """The intervals in which all of a contact slips, by its number in the core."""
    _, times, slips = track.slips[track.slips[:, 0] == contact].T
    ends = np.append(times[1:], np.inf)
    found: list[tuple[float, float]] = []
    for start, end in of.intervals:
        spans = np.clip(np.stack([times, ends], axis=1)[slips > 0.0], start, end)
        for first, last in spans[spans[:, 1] > spans[:, 0]].tolist():
            if found and found[-1][1] == first > start:  # from one row to the next
                first = found.pop()[0]
            found.append((first, last))
    return tuple(found)


def _order(plan: Plan) -> IntArray | None:
    """A better order of the contacts; a wall hands the force of none on to the others."""
    couples = [body.residual is not None or bool(body.push.any()) for body in plan.modal]
    return narrow_order([(contact.first, contact.second) for contact in plan.contacts], couples)


def _thinned(times: FloatArray, most: int) -> FloatArray:
    """Every so many of the times, at most about so many."""
    return times[:: 1 + len(times) // most]
