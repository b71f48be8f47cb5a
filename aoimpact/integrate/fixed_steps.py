"""Newmark's rule: with a given step, or with a step that meets a tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from time import perf_counter
from typing import ClassVar

import numpy as np

from .. import _core
from ..base import (
    GIB,
    ROUNDING,
    ConvergenceError,
    FloatArray,
    Frozen,
    InputError,
    IterationError,
    NotFiniteError,
    available,
    record,
    warn,
)
from ..laws import ContactLaw, check_width
from ..scene import Scenario
from .events import Events, find_contacts, find_peak, find_slips
from .motion import SteppedMotion
from .settings import DRAWN, Newmark
from .steperror import StepError, time_error

# Number of steps within a contact in the first attempt, if no dt is given.
_FIRST_STEPS = 50

# Relative tolerance of the stretches of the springs that represent friction (see DRAWN).
# _PRECISION: tolerance with the first step; _ROUGHEST: largest value that the core accepts. The
# tolerance is proportional to the square of the step, so that the error estimate includes the error
# of the stretches, a hundredth of the rule's error. With _PRECISION = 0.02 the error of the
# stretches would be a third of the rule's error, and springs that are left out would give back 4e-8
# of the energy.
_PRECISION, _ROUGHEST = 4e-4, 0.1

# Largest number of halvings of the step. An error of second order falls by a factor of 4^16 = 4e9;
# an error that is still too large does not converge.
_MOST_HALVINGS = 16

# Step that finds the forces at t = 0, relative to the run's step: so short that coordinates with
# mass do not move.
_INSTANT = 2.0**-10

# _SHORTENED: factor on the step that finds the forces at t = 0; _MOST_SHORTENED: largest number of
# shortenings; _SAME_START: relative change of the forces at which shortening ends; the change is
# proportional to the square of the step. Of 132 random runs with massless points 104 need no second
# shortening, 19 up to five, and 9 all six.
_SHORTENED, _MOST_SHORTENED, _SAME_START = 2.0**-4, 6, 1e-6


# Contact forces just after t = 0, N, and their rates, N/s; None where the laws determine them.
_Start = tuple[FloatArray | None, FloatArray | None]


@record
class SteppedRecorder(Frozen):
    """The :class:`Recorder` of a run with fixed steps.

    Attributes
    ----------
    plan : Scenario
        Plan of the run.
    rule : Newmark
    dt : float
        Time step, s.
    times : ndarray, shape (times,)
        Times of the steps, s.
    record : ndarray, shape (rows, times)
        Record of the core, with the rows of :class:`RecordLayout`.
    seconds : float
        Computing time, including the runs for the error estimate, s.
    """

    plan: Scenario
    rule: Newmark
    dt: float
    times: FloatArray
    record: FloatArray
    seconds: float = 0.0
    dense: ClassVar[bool] = False

    @property
    def solver(self) -> str:
        rule, steps = self.rule, len(self.times) - 1
        return f"Newmark(dt={self.dt:.6g}, beta={rule.beta:g}, gamma={rule.gamma:g}), {steps} steps"

    @property
    def duration(self) -> float:
        return float(self.times[-1])

    @property
    def marks(self) -> FloatArray:
        return self.times

    def rows(self, times: FloatArray, energies: bool) -> FloatArray:
        return self._between(self.record, times)

    def pushes(self, times: FloatArray) -> FloatArray:
        return self._between(self.plan.layout.pushes(self.record), times)

    def _between(self, rows: FloatArray, times: FloatArray) -> FloatArray:
        """Return rows of the record at times, s, interpolated linearly between the steps."""
        found = [np.interp(times, self.times, row) for row in rows]
        return np.array(found).reshape(len(rows), len(times))

    @cached_property
    def events(self) -> tuple[Events, ...]:
        t, found = self.times, []
        for number, contact in enumerate(self.plan.contacts):
            of, slips = self.plan.layout.contact(self.record, number), None
            rate, *slide = self.rates(number)
            spans = find_contacts(t, of.force, of.indentation, rate)
            if contact.friction is not None and of.stuck is not None and of.tangential is not None:
                mu, ratio, _ = contact.friction
                size = np.maximum(np.linalg.norm(of.tangential, axis=0), np.finfo(float).tiny)
                ahead = (of.tangential * slide).sum(axis=0) / size - mu / ratio * rate
                slips = find_slips(t, spans, of.stuck, mu * of.force - size, ahead)
            # For average acceleration, this is exactly the momentum that the steps transfer.
            impulse = float(np.trapezoid(of.force, t))
            found.append(Events(*find_peak(t, of.force), spans, impulse, slips))
        return tuple(found)

    def rates(self, contact: int) -> FloatArray:
        """Return the relative velocities of a contact's ports, m/s, shape (contact.size, times)."""
        of = self.plan.contacts[contact]
        one, other = (
            self.plan.layout.body(self.record, body).port_velocities[port : port + of.size]
            for body, port in of.ports
        )
        return one - other

    def motion(self, body: int) -> SteppedMotion:
        return SteppedMotion(self, body, self.dt, self.dt)


def solve_newmark(plan: Scenario, rule: Newmark) -> tuple[SteppedRecorder, float | None]:
    """Run a scene with fixed steps; return the run and its error estimate, if there is one.

    Raises
    ------
    ConvergenceError
        If a step cannot be solved, or the error estimate does not fall to `rtol`.

    Warns
    -----
    AOImpactWarning
        If the step is too large for any accurate digit.
    """
    began, length, rtol = perf_counter(), plan.duration, rule.rtol
    if rule.dt is None and plan.layout.slides and rtol < 4.0 * DRAWN:
        raise InputError(
            f"Newmark(rtol={rtol:g}): friction has errors of {DRAWN:g}; give "
            f"rtol={4 * DRAWN:g} or more, or dt"
        )
    dt = length / _steps(plan, rule, rule.dt or first_step(plan), length)
    step = partial(newmark_run, plan, rule, start=_start(plan, rule))
    error: StepError | None = None
    if rule.dt is None:
        run, error = _to_tolerance(step, dt, rtol, plan)
    else:
        run = step(dt, energies=plan.energies)
        if rule.estimate:
            error = _error(run, _trial(step, 2.0 * dt), _trial(step, 4.0 * dt))
    if error is not None and error.share == 1.0:
        warn(
            f"dt={run.dt:g} s is far too large, no digit is right: {error.why}; take a smaller "
            "dt, or Newmark() without dt"
        )
    for i, contact in enumerate(plan.contacts):
        check_width(contact.law, plan.layout.contact(run.record, i).indentation, i)
    run = replace(run, seconds=perf_counter() - began)
    return run, None if error is None else error.share


def _to_tolerance(
    step: Callable[..., SteppedRecorder], first: float, rtol: float, plan: Scenario
) -> tuple[SteppedRecorder, StepError]:
    """Halve the step until a run agrees with the last two; return this run and its error."""
    before = [_trial(step, 0.5 * first), _trial(step, first)]
    for halving in range(2, _MOST_HALVINGS + 2):
        dt = first / 2**halving
        fine = _trial(step, dt, energies=plan.energies)
        error = _error(fine, *before)
        if isinstance(fine, SteppedRecorder):
            if error.share <= rtol:
                return fine, error
            # Only rows of contacts are kept: comparisons with coarser runs use no others.
            fine = replace(fine, record=plan.layout.of_contacts(fine.record).copy())
        before = [fine, before[0]]
    raise ConvergenceError(
        f"Newmark: with dt={dt:.3g} s the estimated error is still {error.share:.2g}, above "
        f"rtol={rtol:g}: {error.why}; give dt, a larger rtol, or take Adaptive()"
    )


def _trial(
    step: Callable[..., SteppedRecorder], dt: float, *, energies: bool = False
) -> SteppedRecorder | ConvergenceError:
    """Return a run or, if its step is too long to be solved, the exception that it raised."""
    try:
        return step(dt, energies=energies)
    except (IterationError, NotFiniteError) as error:
        return error


def _error(*runs: SteppedRecorder | ConvergenceError) -> StepError:
    """Return the error estimate of the first of three runs, with steps dt, 2 dt and 4 dt."""
    solved = [run for run in runs if isinstance(run, SteppedRecorder)]
    if len(solved) < len(runs):
        failed = next(run for run in runs if isinstance(run, ConvergenceError))
        return StepError(1.0, f"with such steps, or twice or four times as long ones, {failed}")
    return time_error(*solved)


def newmark_run(
    plan: Scenario,
    rule: Newmark,
    dt: float,
    *,
    duration: float | None = None,
    start: _Start = (None, None),
    energies: bool = False,
) -> SteppedRecorder:
    """Run the core once, with the least number of steps of `dt` that covers the record.

    Parameters
    ----------
    plan : Scenario
    rule : Newmark
    dt : float
        Time step, s.
    duration : float, optional
        Duration of the record, s; by default that of the plan.
    start : (forces, rates), optional
        Contact forces at t = 0, N, and their rates, N/s, shape (pushes,). The default, which
        follows from the laws, is wrong for a massless contact point with a rate-dependent law.
    energies : bool, optional
        True to record energies.

    Raises
    ------
    InputError
        If the record would not fit in memory.
    ConvergenceError
        If the solution overflows.
    """
    duration = plan.duration if duration is None else duration
    steps = _steps(plan, rule, dt, duration)
    precision = DRAWN
    if plan.layout.slides:
        precision = min(DRAWN + _PRECISION * (dt / first_step(plan)) ** 2, _ROUGHEST)
    bodies = [plan.stepped(i) for i in range(len(plan.bodies))]
    rows = np.zeros((plan.layout.rows, steps + 1))
    x, v = (np.concatenate(parts) for parts in zip(*((b.x, b.v) for b in bodies), strict=True))
    _core.newmark(
        tuple(body.for_core(dt, rule.beta, rule.gamma) for body in bodies),
        tuple(contact.for_core(contact.law.for_core(), precision) for contact in plan.contacts),
        dt,
        rule.beta,
        rule.gamma,
        x,
        v,
        *start,
        rows,
        energies,
    )
    if not (np.isfinite(x).all() and np.isfinite(v).all()):
        raise ConvergenceError(
            f"Newmark step: the solution grew without bound (dt={dt:g} s, beta={rule.beta:g}, "
            f"gamma={rule.gamma:g}); take 2 beta >= gamma, or a smaller dt"
        )
    t = dt * np.arange(steps + 1, dtype=np.float64)
    if abs(t[-1] - duration) <= ROUNDING * duration:
        t[-1] = duration
    return SteppedRecorder(plan, rule, dt, t, rows)


def _steps(plan: Scenario, rule: Newmark, dt: float, duration: float) -> int:
    """Return the least number of steps `dt`, s, that covers `duration`, s; check the memory."""
    steps = duration / dt * (1.0 - ROUNDING)
    needed = 8.0 * plan.layout.rows * (steps + 1.0)
    if needed > min(4.0 * GIB, available()):  # more than 4 GiB most likely come from a wrong dt
        given, larger = (
            (f"dt={dt:g} s", "dt") if rule.dt else (f"Newmark(rtol={rule.rtol:g})", "rtol")
        )
        raise InputError(
            f"{given} over duration={duration:g} s makes {steps:.3g} steps and a record of "
            f"{needed / GIB:.3g} GiB: take a larger {larger} or a shorter duration"
        )
    return max(1, math.ceil(steps))


def _start(plan: Scenario, rule: Newmark) -> _Start:
    """Return contact forces just after t = 0, and their rates; None if the laws determine them.

    The bodies' state does not determine the displacement of a massless contact point, or with a
    damper its velocity: these follow from the balance of all forces. They are found by two very
    short steps, of which the first contains the jump, if there is one, and the second gives the
    rates. Since a damper's force may decay fast, both steps are shortened until the forces no
    longer change, or change only by rounding errors.
    """
    found: _Start = None, None
    if not any(body.massless for body in plan.bodies):
        return found
    rest, before = (None if plan.rest is None else plan.rest.forces, None), np.inf
    instant = _INSTANT * (rule.dt or first_step(plan))
    for _ in range(1 + _MOST_SHORTENED):
        run = newmark_run(plan, rule, instant, duration=2.0 * instant, start=rest)
        early, late = run.pushes(run.times).T[1:]
        forces = 2.0 * early - late
        pressed = (np.minimum(early, late) >= 0.0) & plan.layout.normal
        forces = np.where(pressed, np.maximum(forces, 0.0), forces)
        if found[0] is not None:
            apart = float(np.abs(forces - found[0]).max(initial=0.0))
            if apart >= before:  # only rounding errors remain
                break
            before = apart
        found = forces, (late - early) / instant
        if before <= _SAME_START * float(np.abs(forces).max(initial=0.0)):
            break
        instant *= _SHORTENED
    return found


def first_step(plan: Scenario) -> float:
    """Return the first step, s: at most a fiftieth of the shortest contact of rigid bodies."""
    shortest = plan.duration / 20.0
    if plan.fastest == 0.0:
        return shortest
    times = [
        rigid_contact_time(of.law, plan.reduced_mass(of), plan.fastest) for of in plan.contacts
    ]
    return min([shortest, *(time / _FIRST_STEPS for time in times)])


def rigid_contact_time(law: ContactLaw, mass: float, velocity: float) -> float:
    """Return the estimated duration of the contact of a rigid `mass`, kg, at `velocity`, m/s; in s.

    The duration is 3 times the ratio of largest indentation to velocity; the factor is 2.94 for
    Hertz's law (Johnson, Contact Mechanics, eq. 11.25) and π for a linear law.
    """
    try:
        return 3.0 * law.stroke(0.5 * mass * velocity * velocity) / velocity
    except InputError as error:
        raise InputError(
            f"law={law!r} with velocity={velocity:g} m/s: no contact time can be estimated "
            f"({error}); give dt"
        ) from None
