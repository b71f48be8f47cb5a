"""The quantities of interest: what an impact or a scene is summed up by.

`QUANTITIES` is the only table of them. `simulate(quantity=)`, the errors of a result, the names
that a sweep keeps, the units of its columns and the comparison of models all read it.
CONTRIBUTING.md says what goes with a new one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from ..base import FloatArray, InputError
from ..results import LEAST_REBOUND, Result, Run

__all__ = [
    "COLUMNS",
    "IMPACT_CHOICES",
    "QUANTITIES",
    "SCENE_CHOICES",
    "SCENE_QUANTITIES",
    "Quantity",
    "R",
    "number_errors",
    "quantity_unit",
    "recorded",
]

# What runs of one search are.
R = TypeVar("R", Result, Run)

# Times, s, to values of shape (rows, times).
History = Callable[[Run, FloatArray], FloatArray]

# The least scale of a relative error, as a share of the largest contact of a scene: one that only
# grazes has no digits of its own.
_LEAST_CONTACT = 0.1


def recorded(rows: Callable[[Run], FloatArray]) -> History:
    """Return a history from rows that a run has at its own times, shape (rows, times)."""

    def history(run: Run, times: FloatArray) -> FloatArray:
        if run.t is times:
            return rows(run)
        try:
            return rows(run.at(times))
        except InputError:  # of a run with fixed steps, known at these only
            return np.array([np.interp(times, run.t, row) for row in rows(run)])

    return history


@dataclass(frozen=True)
class Quantity:
    """A number or a history of a run.

    Attributes
    ----------
    name, unit : str
    number : callable, optional
        Of a `Result`; if `of_contacts` of the `Events` of one contact as well. NaN where there is
        no such number.
    history : callable, optional
        Of a `Run` and times, s: shape (rows, times). A quantity has either this or `number`.
    compared : callable, optional
        Stands for `number` where two runs are compared, if that may be NaN.
    least : callable, optional
        Of the more exact `Result` (with `of_scene` `Run`): errors are relative to no less.
    of_contacts : bool
        Whether each contact of a scene has it, or only an impact of two bodies.
    selectable : bool
        Whether models can be chosen for it, by ``quantity=name``.
    column : bool
        Whether a sweep keeps it if it is not told what to keep.
    lasting : bool
        Whether the motion after the last contact is part of it.
    of_scene : callable, optional
        Of a `Run`: numbers of all of it, shape (any,), in place of those of its contacts.
    local : callable, optional
        Of a `Run`: what the elements leave out of it where it is taken, relative, though the force
        be right.
    """

    name: str
    unit: str
    number: Callable[[Any], float] | None = None
    history: History | None = None
    compared: Callable[[Any], float] | None = None
    least: Callable[[Any], float] | None = None
    of_contacts: bool = False
    selectable: bool = True
    column: bool = False
    lasting: bool = False
    of_scene: Callable[[Run], FloatArray] | None = None
    local: Callable[[Run], float] | None = None

    @property
    def is_history(self) -> bool:
        """Whether it is a history, or several, rather than numbers."""
        return self.history is not None

    def difference(self, run: R, exact: R) -> float:
        """Return how far a run is from a more exact one: the largest `deviation`."""
        return float(np.abs(self.deviation(run, exact)).max(initial=0.0))

    def deviation(self, run: R, exact: R) -> FloatArray:
        """Return by how much a run gives more than a more exact one, relative.

        Flat, contact by contact, of histories at the times of the more exact run. Relative to the
        largest value of the history, or to the number; in a scene to no less than a tenth of the
        largest of all contacts.
        """
        if self.history is not None:
            ours, theirs = (self.history(_run_of(one), exact.t) for one in (run, exact))
            size = np.abs(theirs).max(axis=1)
        else:
            ours, theirs = self._values(run), self._values(exact)
            size = np.abs(theirs)
        scales = np.maximum(size, _LEAST_CONTACT * size.max(initial=0.0))
        if self.least is not None:
            scales = np.maximum(scales, self.least(exact))
        return _relative(ours - theirs, scales).ravel()

    def change(self, one: Any, exact: Any) -> float:
        """Return by how much this number of a result or contact differs from a more exact one."""
        value = self._compared(exact)
        scale = abs(value) if self.least is None else max(abs(value), self.least(exact))
        apart = float(abs(self._compared(one) - value))
        if apart == 0.0:
            return 0.0
        return apart / float(scale) if scale > 0.0 else math.inf

    def span(self, run: Result | Run) -> float:
        """Return how long, s, the motion must be right for this quantity to be so.

        What nothing drives moves without deforming until the first contact.
        """
        touched = [of.contacts for of in _events(run) if of.contacts]
        plan = _run_of(run).plan
        driven = plan.preload or plan.gravity or plan.loads
        first = 0.0 if driven else min((each[0][0] for each in touched), default=0.0)
        if self.lasting:
            return run.duration - first
        return max((each[-1][1] for each in touched), default=first) - first

    def contact_time(self, run: Result | Run) -> float | None:
        """Return the duration of the first contact, s, or None where none ends in the record.

        Of a scene that of the shortest of the hard contacts, where its force is largest.
        """
        if isinstance(run, Result):
            return run.contact_duration or None
        hardest = max((of.peak_force for of in run.events), default=0.0)
        lasting = [
            next(end - start for start, end in of.contacts if of.peak_time <= end)
            for of in run.events
            if of.contacts and of.peak_force >= _LEAST_CONTACT * hardest
        ]
        return min((time for time in lasting if time > 0.0), default=None)

    def _values(self, run: Result | Run) -> FloatArray:
        if self.of_scene is not None:
            return self.of_scene(_run_of(run))
        return np.array([self._compared(part) for part in _parts(run)])

    def _compared(self, of: Any) -> float:
        read = self.compared or self.number
        assert read is not None
        return read(of)


def number_errors(
    run: Result | Run, larger: Sequence[Result | Run], safety: float = 1.0
) -> dict[str, float]:
    """Return by how much each number that sums up a run may be wrong, relative.

    The largest of its changes to more exact runs, times `safety`, by the names by which the numbers
    are kept, such as "peak_force" or, of a scene, "contacts.0.peak_force". NaN of a number that
    there is not. "contacts" ("contacts.0.intervals") is infinite where the runs have not as many of
    them.
    """
    runs = run, *larger
    if isinstance(run, Result):
        return dict(_number_errors("", "contacts", runs, safety))
    scenes = zip(*(_events(one) for one in runs), strict=True)
    return {
        name: error
        for i, contacts in enumerate(scenes)
        for name, error in _number_errors(f"contacts.{i}.", "intervals", contacts, safety)
    }


def _number_errors(
    prefix: str, count: str, runs: tuple[Any, ...], safety: float
) -> Iterator[tuple[str, float]]:
    """Of runs, or of one contact of each."""
    run, *larger = runs
    for quantity in QUANTITIES.values():
        if quantity.number is None or (prefix and not quantity.of_contacts):
            continue
        error = safety * float(np.max([quantity.change(run, one) for one in larger], initial=0.0))
        yield prefix + quantity.name, math.nan if math.isnan(quantity.number(run)) else error
    as_many = len({len(run.contacts) for run in runs}) == 1
    yield prefix + count, 0.0 if as_many else math.inf


def _run_of(run: Result | Run) -> Run:
    return run if isinstance(run, Run) else run.run


def _events(run: Result | Run) -> tuple[Any, ...]:
    return _run_of(run).events


def _parts(run: Result | Run) -> tuple[Any, ...]:
    """What has the numbers: an impact itself, of a scene each contact."""
    return (run,) if isinstance(run, Result) else run.events


def _relative(difference: FloatArray, scales: FloatArray) -> FloatArray:
    """Rows over their scales; of a scale of 0 a difference is infinite."""
    scales = scales.reshape(-1, *(1,) * (difference.ndim - 1))
    relative = np.where(difference == 0.0, 0.0, np.copysign(np.inf, difference))
    np.divide(difference, scales, out=relative, where=np.broadcast_to(scales > 0.0, relative.shape))
    return relative


def _contacts(of: Any) -> tuple[tuple[float, float], ...]:
    """Start and end, s, of every contact of an impact, or of a contact of a scene or its events."""
    contacts: tuple[tuple[float, float], ...] = getattr(of, "events", of).contacts
    return contacts


def _first_duration(of: Any) -> float:
    """Of the first contact, s; 0 without one."""
    contacts = _contacts(of)
    return contacts[0][1] - contacts[0][0] if contacts else 0.0


_ALL = (
    Quantity("force", "N", history=recorded(lambda run: run.forces), of_contacts=True),
    Quantity("peak_force", "N", lambda hit: hit.peak_force, of_contacts=True, column=True),
    Quantity(
        "peak_time",
        "s",
        lambda hit: hit.peak_time,
        of_contacts=True,
        column=True,
    ),
    Quantity("contact_duration", "s", _first_duration, of_contacts=True, column=True),
    Quantity("contact_count", "", lambda hit: len(_contacts(hit)), of_contacts=True),
    Quantity("impulse", "N s", lambda hit: hit.impulse, of_contacts=True, column=True),
    Quantity(
        "rebound_velocity",
        "m/s",
        lambda hit: hit.rebound_velocity,
        compared=lambda hit: hit.parting[0],
        least=lambda hit: LEAST_REBOUND * abs(hit.velocity),
        column=True,
    ),
    Quantity(
        "restitution",
        "",
        lambda hit: hit.restitution,
        compared=lambda hit: hit.parting_speed / hit.velocity,
        least=lambda hit: LEAST_REBOUND,
        column=True,
    ),
    Quantity(
        "projectile_displacement",
        "m",
        history=recorded(lambda run: run.bodies[0].port_displacements),
        lasting=True,
    ),
    Quantity(
        "target_displacement",
        "m",
        history=recorded(lambda run: run.bodies[1].port_displacements),
        lasting=True,
    ),
)


def _rebounds(run: Run) -> FloatArray:
    """Of all bodies that nothing holds, or of all, m/s."""
    free = [i for i, body in enumerate(run.plan.bodies) if not body.fixed]
    return run.parting[free] if free else run.parting


def _restitution(run: Run) -> FloatArray:
    """Of the only contact: how fast its bodies part over how fast they came."""
    ends = run.plan.contacts[0].ports
    came, part = (
        sum(sign * speeds[body] for sign, (body, _) in zip((1.0, -1.0), ends, strict=True))
        for speeds in (
            run.plan.velocities,
            [
                0.0 if body.fixed else v
                for body, v in zip(run.plan.bodies, run.parting, strict=True)
            ],
        )
    )
    return np.array([-part / came])


# What an impact has as well, but not each contact of a scene.
_OF_SCENES = (
    Quantity(
        "rebound_velocity",
        "m/s",
        of_scene=_rebounds,
        least=lambda run: LEAST_REBOUND * max(map(abs, run.plan.velocities)),
    ),
    Quantity("restitution", "", of_scene=_restitution, least=lambda _: LEAST_REBOUND),
)

QUANTITIES = {quantity.name: quantity for quantity in _ALL}

# What ``quantity=`` may be in an impact and in a scene, and what a sweep keeps by default.
IMPACT_CHOICES = tuple(one.name for one in _ALL if one.selectable)
SCENE_QUANTITIES = {
    one.name: one
    for one in (*_ALL, *_OF_SCENES)
    if one.selectable and (one.of_contacts or one.of_scene)
}
SCENE_CHOICES = tuple(SCENE_QUANTITIES)
COLUMNS = tuple(one.name for one in _ALL if one.column)


def quantity_unit(name: str) -> str:
    """Return the unit of a number by its name, dotted or not; "" where none is known."""
    quantity = QUANTITIES.get(name.rpartition(".")[2])
    return "" if quantity is None or quantity.is_history else quantity.unit
