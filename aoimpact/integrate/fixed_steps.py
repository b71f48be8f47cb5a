"""A scene by Newmark's rule: with a given step, or with the step that a tolerance asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import ClassVar, NamedTuple

import numpy as np

from ..base import ConvergenceError, FloatArray, InputError, warn
from ..laws import ContactLaw, check_width
from ..scene import Plan
from .events import Events, find_events
from .motion import ForcedMotion
from .newmark import Newmark, Record, newmark_scene, steps_of
from .steperror import time_error

__all__ = ["SteppedRecorder", "rigid_contact_time", "solve_newmark"]

# Steps within a contact of the first attempt, where no dt is given.
_FIRST_STEPS = 50

# These make an error of second order 4^16 = 4e9 times smaller: what is left does not converge.
_MOST_HALVINGS = 16

# A very short step, relative to one of the run: nothing that has mass moves.
_INSTANT = 2.0**-10


@dataclass(frozen=True, eq=False)
class SteppedRecorder:
    """A run with fixed steps as a :class:`Recorder`, to be read at those.

    Attributes
    ----------
    plan : Plan
        What was run.
    rule : Newmark
    record : Record
    ports : sequence of ndarrays, shape (2, p), or None
        Of each body, as in `Start`; empty where nothing depends on them.
    seconds : float
        How long the run took, with those that its error is estimated from, s.
    """

    plan: Plan
    rule: Newmark
    record: Record
    ports: Sequence[FloatArray | None] = ()
    seconds: float = 0.0
    dense: ClassVar[bool] = False

    @property
    def solver(self) -> str:
        rule, steps = self.rule, len(self.times) - 1
        return (
            f"Newmark(dt={self.record.dt:.6g}, beta={rule.beta:g}, gamma={rule.gamma:g}), "
            f"{steps} steps"
        )

    @property
    def duration(self) -> float:
        return float(self.times[-1])

    @property
    def times(self) -> FloatArray:
        return self.record.t

    @property
    def marks(self) -> FloatArray:
        return self.record.t

    def rows(self, times: FloatArray, energies: bool) -> FloatArray:
        return self.record.rows.copy()

    def forces(self, times: FloatArray) -> FloatArray:
        return self.plan.layout.forces(self.record.rows).copy()

    def state(self, body: int) -> tuple[FloatArray, FloatArray]:
        model, (u, v) = self.plan.bodies[body], self.record.final[body]
        return model.coordinates(u), model.coordinates(v)

    @cached_property
    def events(self) -> tuple[Events, ...]:
        layout, rows = self.plan.layout, self.record.rows
        found = []
        for number, contact in enumerate(self.plan.contacts):
            of = layout.contact(rows, number)
            one, other = (layout.body(rows, i).port_velocities[port] for i, port in contact.ports)
            found.append(find_events(self.times, of.force, of.indentation, one - other))
        return tuple(found)

    def motion(self, body: int) -> ForcedMotion:
        plan, model = self.plan, self.plan.bodies[body]
        start = model.stepped(
            gravity=plan.weight_of(body),
            state=plan.start_of(body),
            ports=self.ports[body] if self.ports else None,
        )
        forces = plan.port_forces(body, self.times, plan.layout.forces(self.record.rows))
        return ForcedMotion(start.equations, self.rule, self.record.dt, forces, model.coordinates)


def solve_newmark(plan: Plan, rule: Newmark) -> tuple[SteppedRecorder, float | None]:
    """Run a scene with fixed steps; return the run and its error, from runs with larger steps.

    Raises
    ------
    ConvergenceError
        If the step cannot be solved or the error estimate cannot be brought down to `rtol`.

    Warns
    -----
    AOImpactWarning
        If the step is too large for any digit to be right.
    """
    began = perf_counter()
    run = _Stepping(plan, rule)
    record, error = run.with_step(rule.dt) if rule.dt is not None else run.with_tolerance()
    if error == 1.0:
        warn(
            f"dt={record.dt:g} s is far too large: with 2dt the peak force changes by more than a "
            "fifth, a damper stops the bodies within a step, or vibration that such steps do not "
            "resolve may close a gap; no digit is right. Take a smaller dt, or Newmark() without dt"
        )
    for i, contact in enumerate(plan.contacts):
        check_width(contact.law, plan.layout.contact(record.rows, i).indentation, i)
    took = perf_counter() - began
    return SteppedRecorder(plan, rule, record, run.start.ports, took), error


class Start(NamedTuple):
    """What acts just after t = 0.

    Attributes
    ----------
    forces : ndarray, shape (contacts,), or None
        Contact forces, N; None where the laws determine them.
    ports : sequence of ndarrays, shape (2, p), or None
        Of each body its ports' displacements, m, and rates, m/s; None where the state determines
        them.
    """

    forces: FloatArray | None
    ports: Sequence[FloatArray | None]


@dataclass(frozen=True, eq=False)
class _Stepping:
    """One scene, to be run with different steps."""

    plan: Plan
    rule: Newmark

    def once(self, dt: float, *, energies: bool) -> Record:
        """Run with steps of `dt` to the end of the record, or beyond it by less than a step."""
        return self._run(dt, self.plan.duration, self.start, energies=energies)

    @cached_property
    def start(self) -> Start:
        """What acts just after t = 0.

        Where a contact point has no mass, the bodies' state does not determine it: its place, or
        under a damper its velocity, follows from the balance of all forces. Two very short steps
        find it: the first makes the jump, if there is one, the second gives the rates.
        """
        plan = self.plan
        rest = Start(None, [plan.ports_at_rest(i) for i in range(len(plan.bodies))])
        if not any(body.massless for body in plan.bodies):
            return rest
        instant = _INSTANT * (self.rule.dt or self.first_step())
        rows = self._run(instant, 2.0 * instant, rest, energies=False).rows
        ports = []
        for number in range(len(plan.bodies)):
            body = plan.layout.body(rows, number)
            places, rates = body.port_displacements[:, 2], body.port_velocities[:, 2]
            ports.append(np.stack([places - 2.0 * instant * rates, rates]))
        early, late = plan.layout.forces(rows).T[1:]
        forces = 2.0 * early - late
        pressed = np.minimum(early, late) >= 0.0
        return Start(np.where(pressed, np.maximum(forces, 0.0), forces), ports)

    def _run(self, dt: float, duration: float, start: Start, *, energies: bool) -> Record:
        plan = self.plan
        bodies = [
            body.stepped(
                gravity=plan.weight_of(i),
                state=plan.start_of(i),
                ports=start.ports[i],
            )
            for i, body in enumerate(plan.bodies)
        ]
        return newmark_scene(
            bodies,
            plan.contacts,
            plan.loads,
            rule=self.rule,
            dt=dt,
            duration=duration,
            energies=energies,
            start_force=start.forces,
        )

    def with_step(self, dt: float) -> tuple[Record, float | None]:
        """Run with a step given, and with twice and four times that for the error estimate."""
        steps = steps_of(
            dt, self.plan.duration, self.plan.layout.rows, f"dt={dt:g} s", "take a larger dt"
        )
        dt = self.plan.duration / steps
        record = self.once(dt, energies=self.plan.energies)
        if not self.rule.estimate:
            return record, None
        coarse, coarser = (self.once(more * dt, energies=False) for more in (2.0, 4.0))
        return record, time_error(self.plan, record, coarse, coarser)

    def with_tolerance(self) -> tuple[Record, float]:
        """Halve the step until three successive ones agree."""
        rtol, length = self.rule.rtol, self.plan.duration
        given, cure = f"Newmark(rtol={rtol:g})", "take a larger rtol"
        steps = steps_of(self.first_step(), length, self.plan.layout.rows, given, cure)
        before = [self.once(length / (more * steps), energies=False) for more in (1, 2)]
        for halving in range(2, _MOST_HALVINGS + 2):
            dt = length / (2**halving * steps)
            steps_of(dt, length, self.plan.layout.rows, given, cure)
            fine = self.once(dt, energies=self.plan.energies)
            error = time_error(self.plan, fine, before[1], before[0])
            if error <= rtol:
                return fine, error
            # Of coarser runs only the contacts are needed: the rest of their memory is given back.
            kept = self.plan.layout.of_contacts(fine.rows).copy()
            before = [before[1], replace(fine, rows=kept.reshape(-1, len(fine.t)))]
        raise ConvergenceError(
            f"Newmark: with dt={dt:.3g} s the estimated error is still "
            f"{error:.2g}, above rtol={rtol:g}; give dt, a larger rtol, or take Adaptive()"
        )

    def first_step(self) -> float:
        """A fiftieth of the shortest contact that rigid bodies would have."""
        plan, shortest = self.plan, self.plan.duration / 20.0
        if plan.fastest == 0.0:
            return shortest
        for contact in plan.contacts:
            time = rigid_contact_time(contact.law, plan.reduced_mass(contact), plan.fastest)
            shortest = min(shortest, time / _FIRST_STEPS)
        return shortest


def rigid_contact_time(law: ContactLaw, mass: float, velocity: float) -> float:
    """Estimate how long a contact of a rigid `mass`, kg, at `velocity`, m/s, lasts, s.

    Three times the largest indentation over the velocity: 2.94 for Hertz (Johnson, Contact
    Mechanics, eq. 11.25), π for a linear law.
    """
    try:
        return 3.0 * law.stroke(0.5 * mass * velocity**2) / velocity
    except InputError as error:
        raise InputError(
            f"law={law!r} with velocity={velocity:g} m/s: no contact time can be estimated "
            f"({error}); give dt"
        ) from None
