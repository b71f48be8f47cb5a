"""A tolerance instead of a step: contact by collocation on the force, flight in closed form.

The forces over a step are polynomials through eight Radau nodes. What they do to the bodies is
exact in modes, so only the forces have to be resolved; between contacts nothing is stepped.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .. import _core
from ..base import FloatArray, InputError, positive
from .band import IntArray, narrow_order
from .events import Events

__all__ = ["TIGHTEST", "Adaptive", "Track", "adaptive_run"]

CoreBody = tuple[Any, ...]  # as ModalBody.for_core makes it
CoreJoint = tuple[int, int, int, int, float, tuple[Any, ...]]

# Double precision carries no more digits.
TIGHTEST = 1e-13

# Columns of a row of the track (enum aoi_track).
_START, _LENGTH, _CONTACTS = 0, 1, 3

# Samples for curves: within each step of contact, and in flight over the whole record.
_PER_STEP = 8
_IN_FLIGHT = 240

# Curves of more values than these fill the memory, not the screen.
_MOST_VALUES = 2e7


@dataclass(frozen=True, kw_only=True)
class Adaptive:
    """Integrate to a tolerance.

    Parameters
    ----------
    rtol : float, optional
        Relative error of peak force, contact times and impulse, and of velocities relative to the
        largest initial one; from 1e-13 up to, not including, 1.

    Raises
    ------
    InputError
        If `rtol` is out of range.

    Notes
    -----
    The peak force and the impulse are those of each contact over the record; of one that has less
    than a hundredth of the largest contact's, the error is relative to that hundredth. Contacts
    start and end at times that are right relative to the end's own time; velocities are those of
    the centres of mass after contacts, relative to the largest initial one or, where gravity and
    loads make greater ones, to those. A velocity or displacement at a given time of a long record
    suffers from the error of that time as well: g rtol t for a ball that bounces under gravity g.

    From the second touch of a contact on, errors grow with each. Then the scene is run again with a
    smaller tolerance, in most cases once, until two runs agree to `rtol`; the last of them is the
    answer. Where rounding, or bodies that make chaos of it, leave no tolerance small enough,
    a warning says so, and `error.time` how far the answer may be off; 1.0 stands for no digit.
    Touches that have together less than a hundredth of the impulse of a contact's largest one do
    not count. Bodies at rest side by side begin to press each other at no certain time when a wave
    reaches them: the start of such a touch is when its force is no longer rounding.
    """

    rtol: float = 1e-8

    def __post_init__(self) -> None:
        object.__setattr__(self, "rtol", positive("rtol", self.rtol))
        if not TIGHTEST <= self.rtol < 1.0:
            raise InputError(
                f"rtol must be from {TIGHTEST:g} to below 1, got {self.rtol:g}: double precision "
                "carries no more digits"
            )


class Track(NamedTuple):
    """The dense record of an adaptive run: exact between its rows at any time.

    Attributes
    ----------
    bodies, joints : tuples
        The scene, as the core takes it.
    order : ndarray, shape (contacts,), or None
        Which contact each of the joints is, where the core takes them in another order. All else
        is by contacts.
    duration : float
        s.
    events : tuple of Events
        Of each contact; an interval that the record cuts off ends with it, one that would begin
        there is none.
    touches : tuple of lists of (impulse, pace)
        Of each contact, for each of its intervals: the impulse, N s, and the rate at which it
        begins, times its length, relative to how deep it goes.
    steps, rejected : int
        Steps of contact taken, and tried in vain.
    table, places : bytes
        The rows as the core wrote them, and where each begins.
    x, v : bytes
        The modes of all bodies, and their rates, where the last row ends.
    """

    bodies: tuple[CoreBody, ...]
    joints: tuple[CoreJoint, ...]
    order: IntArray | None
    duration: float
    events: tuple[Events, ...]
    touches: tuple[list[tuple[float, float]], ...]
    steps: int
    rejected: int
    table: bytes
    places: bytes
    x: bytes
    v: bytes

    @property
    def rows(self) -> int:
        """Number of rows of a record."""
        ports = sum(len(body[2]) for body in self.bodies)
        return 4 * len(self.joints) + 6 * len(self.bodies) + 2 * ports

    @property
    def marks(self) -> FloatArray:
        """When steps end: what the run hands on from one to the next is most exact there."""
        table, index = np.frombuffer(self.table), np.frombuffer(self.places, dtype=np.uintp)
        start = table[index + _START]
        most = max(1000, int(_MOST_VALUES / self.rows))
        return np.unique(np.append(start[:: 1 + len(start) // most], self.duration))

    @property
    def times(self) -> FloatArray:
        """Times that draw smooth curves and hold the peaks and the ends of contacts."""
        table, index = np.frombuffer(self.table), np.frombuffer(self.places, dtype=np.uintp)
        start, length = table[index + _START], table[index + _LENGTH]
        touching = table[index + _CONTACTS] > 0.0
        begin, lasting = start[touching], length[touching]
        most = max(1000, int(_MOST_VALUES / self.rows))
        per_step = min(_PER_STEP, max(1, most // max(1, len(begin))))
        inside = np.add.outer(begin, np.zeros(per_step)) + np.outer(
            lasting, np.arange(per_step) / per_step
        )
        inside = inside.ravel()
        inside = inside[:: 1 + len(inside) // most]
        parts = [np.array([0.0, self.duration]), inside]
        parts += [np.array([event.peak_time]) for event in self.events]
        for event in self.events:
            ends = np.array(event.contacts).ravel()
            parts.append(ends[:: 1 + len(ends) // most])
        known = np.unique(np.concatenate(parts))
        wide = np.flatnonzero(np.diff(known) > self.duration / _IN_FLIGHT)
        gaps = [
            np.linspace(known[i], known[i + 1], 2 + int(_IN_FLIGHT * (gap / self.duration)))
            for i in wide
            if (gap := known[i + 1] - known[i])
        ]
        times = np.unique(np.concatenate([known, *gaps]))
        return times[times <= self.duration]

    def sample(self, times: FloatArray, *, energies: bool = True) -> FloatArray:
        """Return the rows of a record, shape (rows, len(times)), at ascending times, s."""
        record = np.zeros((self.rows, len(times)))
        _core.track_sample(
            self.bodies,
            self.joints,
            np.frombuffer(self.table),
            self.places,
            np.ascontiguousarray(times),
            record,
            energies,
        )
        if self.order is not None:
            contacts = record[: 4 * len(self.joints)].reshape(len(self.joints), 4, -1)
            contacts[self.order] = contacts.copy()
        return record

    def forces(self, times: FloatArray) -> FloatArray:
        """Return the contact forces, N, shape (contacts, len(times)), at ascending times, s.

        They are the rows of `sample` for little of what those cost: no body's motion is computed.
        """
        forces = np.zeros((len(self.joints), len(times)))
        _core.track_forces(
            self.bodies,
            self.joints,
            np.frombuffer(self.table),
            self.places,
            np.ascontiguousarray(times),
            forces,
        )
        if self.order is not None:
            forces[self.order] = forces.copy()
        return forces

    def states(self, times: FloatArray, body: int) -> tuple[FloatArray, FloatArray]:
        """Return a body's modes x and their rates v, shape (n, len(times)), at ascending times."""
        wanted = np.ascontiguousarray(times, dtype=np.float64)
        found = np.empty((len(wanted), 2, len(self.bodies[body][0])))
        _core.track_states(
            self.bodies,
            self.joints,
            np.frombuffer(self.table),
            self.places,
            wanted,
            body,
            found,
        )
        return found[:, 0].T, found[:, 1].T


def adaptive_run(
    bodies: Sequence[CoreBody],
    joints: Sequence[CoreJoint],
    moving: Sequence[FloatArray],
    velocities: Sequence[float],
    *,
    rtol: float,
    duration: float,
    x: FloatArray | None = None,
    most_steps: int = sys.maxsize,
) -> Track:
    """Run the core to a tolerance.

    Parameters
    ----------
    bodies, joints : sequences
        As `ModalBody.for_core` and :class:`CoreJoint` have them.
    moving : sequence of ndarrays
        Rates of each body's modes when it moves as a whole, at unit velocity.
    velocities : sequence of float
        At which they do at the start, m/s.
    rtol : float
    duration : float
        s.
    x : ndarray, optional
        Modes of all bodies at the start; undeformed if left out.
    most_steps : int, optional
        It gives up after about as many.

    Raises
    ------
    ConvergenceError
        If the tolerance cannot be met; with the time.
    """
    order = _order(bodies, joints) if len(joints) > 2 else None
    scene = tuple(bodies), tuple(joints if order is None else (joints[i] for i in order))
    table, places, x_end, v_end, contacts, steps, rejected = _core.adaptive(
        *scene, rtol, duration, x, tuple(moving), tuple(velocities), most_steps
    )
    if order is not None:
        contacts = tuple(contacts[i] for i in np.argsort(order))
    if len(joints) > 1:
        contacts = tuple(map(_felt, contacts))
    return Track(
        *scene,
        order,
        duration,
        tuple([Events(peak, at, tuple(of), impulse) for peak, at, impulse, of, _ in contacts]),
        tuple([touches for *_, touches in contacts]),
        steps,
        rejected,
        table,
        places,
        x_end,
        v_end,
    )


def _felt(contact: tuple[Any, ...]) -> tuple[Any, ...]:
    """A contact without touches that no force came of: bodies beside a blow that part from zero."""
    peak, at, impulse, spans, touches = contact
    felt = [i for i, (passed, _) in enumerate(touches) if passed != 0.0]
    return peak, at, impulse, [spans[i] for i in felt], [touches[i] for i in felt]


def _order(bodies: Sequence[CoreBody], joints: Sequence[CoreJoint]) -> IntArray | None:
    """Return a better order of the contacts; a wall hands the force of none on to the others."""
    couples = [residual is not None or push.any() for _, _, _, push, residual, *_ in bodies]
    return narrow_order([(joint[0], joint[2]) for joint in joints], couples)
