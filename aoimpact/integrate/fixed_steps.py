"""A scene by Newmark's rule: with a given step, or with the step that a tolerance asks for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import ClassVar

import numpy as np

from ..base import (
    ConvergenceError,
    FloatArray,
    InputError,
    IterationError,
    NotFiniteError,
    warn,
)
from ..laws import ContactLaw, check_width
from ..scene import Plan
from .events import Events, find_events, find_slips
from .motion import ForcedMotion
from .newmark import Newmark, Record, Start, newmark_run, steps_of
from .steperror import StepError, time_error
from .tolerances import DRAWN

# Steps within a contact of the first attempt, where no dt is given.
_FIRST_STEPS = 50

# The precision of friction's stretches with the first step; it goes with the square of a step, so
# that its error is seen with that of the rule, of which it is a hundredth. With 0.02, a third,
# springs that are left out give back 4e-8 of the energy. Most: curves are drawn at all.
_PRECISION, _ROUGHEST = 4e-4, 0.1

# These make an error of second order 4^16 = 4e9 times smaller: what is left does not converge.
_MOST_HALVINGS = 16

# Length of the step that finds the forces at t = 0, relative to the run's: nothing that has mass
# moves in it.
_INSTANT = 2.0**-10

# Factor by which that step is shortened, maximum number of shortenings, and relative change of the
# forces at which to stop: they change with the square of its length. Of 132 random runs on
# massless points 104 need no second shortening, 19 up to five, and 9 take all six.
_SHORTENED, _MOST_SHORTENED, _SAME_START = 2.0**-4, 6, 1e-6


@dataclass(frozen=True, eq=False)
class SteppedRecorder:
    """A run with fixed steps as a :class:`Recorder`, to be read at those.

    Attributes
    ----------
    plan : Plan
        What was run.
    rule : Newmark
    record : Record
    seconds : float
        How long the run took, with those that its error is estimated from, s.
    """

    plan: Plan
    rule: Newmark
    record: Record
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
        return self.record.rows[:, np.searchsorted(self.times, times)]

    def forces(self, times: FloatArray) -> FloatArray:
        return self.plan.layout.forces(self.rows(times, energies=False))

    def pushes(self, times: FloatArray) -> FloatArray:
        return self.plan.layout.pushes(self.rows(times, energies=False))

    def state(self, body: int) -> tuple[FloatArray, FloatArray]:
        return self.record.final[body]

    @cached_property
    def events(self) -> tuple[Events, ...]:
        layout, rows = self.plan.layout, self.record.rows
        found = []
        for number, contact in enumerate(self.plan.contacts):
            of = layout.contact(rows, number)
            one, other = (
                layout.body(rows, i).port_velocities[port : port + contact.size]
                for i, port in contact.ports
            )
            rate, *slide = one - other
            events = find_events(self.times, of.force, of.indentation, rate)
            if contact.friction is not None and of.stuck is not None and of.tangential is not None:
                mu, ratio, _ = contact.friction
                size = np.maximum(np.linalg.norm(of.tangential, axis=0), np.finfo(float).tiny)
                ahead = (of.tangential * slide).sum(axis=0) / size - mu / ratio * rate
                left = mu * of.force - size
                slips = find_slips(self.times, events.contacts, of.stuck, left, ahead)
                events = events._replace(slips=slips)
            found.append(events)
        return tuple(found)

    def motion(self, body: int) -> ForcedMotion:
        plan = self.plan
        forces = plan.port_forces(body, self.times, plan.layout.pushes(self.record.rows))
        equations = plan.stepped(body).equations
        return ForcedMotion(
            equations,
            self.rule,
            self.record.dt,
            forces[: equations.B.shape[1]],  # a wall has no weight
        )


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
    if error is not None and error.share == 1.0:
        warn(
            f"dt={record.dt:g} s is far too large, no digit is right: {error.why}; take a smaller "
            "dt, or Newmark() without dt"
        )
    for i, contact in enumerate(plan.contacts):
        check_width(contact.law, plan.layout.contact(record.rows, i).indentation, i)
    took = perf_counter() - began
    recorder = SteppedRecorder(plan, rule, record, took)
    return recorder, None if error is None else error.share


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
        """The forces just after t = 0.

        Where a contact point has no mass, the bodies' state does not determine it: its place, or
        under a damper its velocity, follows from the balance of all forces. Two very short steps
        find it: the first contains the jump, if there is one; the second gives the rates. Both are
        shortened until the forces change no more, or only by rounding: a damper's force fades fast.
        """
        plan = self.plan
        if not any(body.massless for body in plan.bodies):
            return Start()
        rest = Start(plan.forces_at_rest)
        instant = _INSTANT * (self.rule.dt or self.first_step())
        (forces, rates), before = self._start_after(instant, rest), np.inf
        for _ in range(_MOST_SHORTENED):
            instant *= _SHORTENED
            shorter, moving = self._start_after(instant, rest)
            apart = float(np.abs(shorter - forces).max(initial=0.0))
            if apart >= before:  # rounding
                break
            forces, rates, before = shorter, moving, apart
            if apart <= _SAME_START * float(np.abs(forces).max(initial=0.0)):
                break
        return Start(forces, rates)

    def _start_after(self, instant: float, rest: Start) -> tuple[FloatArray, FloatArray]:
        """The forces and their rates, from two steps of that length."""
        rows = self._run(instant, 2.0 * instant, rest, energies=False).rows
        early, late = self.plan.layout.pushes(rows).T[1:]
        forces = 2.0 * early - late
        pressed = (np.minimum(early, late) >= 0.0) & self.plan.layout.normal
        return np.where(pressed, np.maximum(forces, 0.0), forces), (late - early) / instant

    def _run(self, dt: float, duration: float, start: Start, *, energies: bool) -> Record:
        plan = self.plan
        precision = DRAWN
        if plan.slides:
            precision += _PRECISION * (dt / self.first_step()) ** 2
        return newmark_run(
            [plan.stepped(i) for i in range(len(plan.bodies))],
            plan.contacts,
            rule=self.rule,
            dt=dt,
            duration=duration,
            energies=energies,
            start=start,
            precision=min(precision, _ROUGHEST),
        )

    def with_step(self, dt: float) -> tuple[Record, StepError | None]:
        """Run with a step given, and with twice and four times that for the error estimate."""
        steps = steps_of(
            dt, self.plan.duration, self.plan.layout.rows, f"dt={dt:g} s", "take a larger dt"
        )
        dt = self.plan.duration / steps
        record = self.once(dt, energies=self.plan.energies)
        if not self.rule.estimate:
            return record, None
        return record, self._error(record, self._trial(2.0 * dt), self._trial(4.0 * dt))

    def _trial(self, dt: float, *, energies: bool = False) -> Record | ConvergenceError:
        """Run with steps that may be too long: to be solved, or not to gain energy at a touch."""
        try:
            return self.once(dt, energies=energies)
        except (IterationError, NotFiniteError) as error:
            return error

    def _error(self, *runs: Record | ConvergenceError) -> StepError:
        """The error of the first of runs with dt, 2 dt and 4 dt."""
        records = [run for run in runs if isinstance(run, Record)]
        if len(records) < len(runs):
            failed = next(run for run in runs if isinstance(run, ConvergenceError))
            return StepError(1.0, f"with such steps, or twice or four times as long ones, {failed}")
        return time_error(self.plan, *records)

    def with_tolerance(self) -> tuple[Record, StepError]:
        """Halve the step until three successive ones agree."""
        rtol, length = self.rule.rtol, self.plan.duration
        if self.plan.slides and rtol < 4.0 * DRAWN:
            raise InputError(
                f"Newmark(rtol={rtol:g}): friction is known to {DRAWN:g}; give rtol={4 * DRAWN:g} "
                "or more, or dt"
            )
        given, cure = f"Newmark(rtol={rtol:g})", "take a larger rtol"
        steps = steps_of(self.first_step(), length, self.plan.layout.rows, given, cure)
        before = [self._trial(length / (more * steps)) for more in (2, 1)]
        for halving in range(2, _MOST_HALVINGS + 2):
            dt = length / (2**halving * steps)
            steps_of(dt, length, self.plan.layout.rows, given, cure)
            fine = self._trial(dt, energies=self.plan.energies)
            error = self._error(fine, *before)
            if isinstance(fine, Record):
                if error.share <= rtol:
                    return fine, error
                # Coarser runs are needed for their contacts only: the other memory is freed.
                kept = self.plan.layout.of_contacts(fine.rows).copy()
                fine = replace(fine, rows=kept)
            before = [fine, before[0]]
        raise ConvergenceError(
            f"Newmark: with dt={dt:.3g} s the estimated error is still {error.share:.2g}, above "
            f"rtol={rtol:g}: {error.why}; give dt, a larger rtol, or take Adaptive()"
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
