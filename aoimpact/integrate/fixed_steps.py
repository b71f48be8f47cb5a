"""A scene by Newmark's rule: with a given step, or with the step that a tolerance asks for."""

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
    record,
    warn,
)
from ..laws import ContactLaw, check_width
from ..scene import Scenario
from .events import Events, find_contacts, find_peak, find_slips
from .motion import SteppedMotion
from .settings import DRAWN, Newmark
from .steperror import StepError, time_error

# A record larger than this is a mistake in dt more often than a wish.
_MOST_BYTES = 4 * GIB

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


# Contact forces just after t = 0, N, and their rates, N/s; None where the laws determine them.
_Start = tuple[FloatArray | None, FloatArray | None]


@record
class SteppedRecorder(Frozen):
    """A run with fixed steps as a :class:`Recorder`, to be read at those.

    Attributes
    ----------
    plan : Scenario
        What was run.
    rule : Newmark
    dt : float
        s.
    times : ndarray, shape (times,)
        s.
    record : ndarray, shape (rows, times)
        As the core wrote it: :class:`RecordLayout` tells its rows apart.
    seconds : float
        How long the run took, with those that its error is estimated from, s.
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
        """Rows of the record at times, s, on straight lines between the steps."""
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
            # The momentum that average acceleration passes on in each step, exactly.
            impulse = float(np.trapezoid(of.force, t))
            found.append(Events(*find_peak(t, of.force), spans, impulse, slips))
        return tuple(found)

    def rates(self, contact: int) -> FloatArray:
        """Return the rates of a contact's indentation and slides, m/s, shape (size, times)."""
        of = self.plan.contacts[contact]
        one, other = (
            self.plan.layout.body(self.record, body).port_velocities[port : port + of.size]
            for body, port in of.ports
        )
        return one - other

    def motion(self, body: int) -> SteppedMotion:
        return SteppedMotion(self, body, self.dt, self.dt)


def solve_newmark(plan: Scenario, rule: Newmark) -> tuple[SteppedRecorder, float | None]:
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
    began, length, rtol = perf_counter(), plan.duration, rule.rtol
    if rule.dt is None and plan.layout.slides and rtol < 4.0 * DRAWN:
        raise InputError(
            f"Newmark(rtol={rtol:g}): friction is known to {DRAWN:g}; give rtol={4 * DRAWN:g} "
            "or more, or dt"
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
    """Halve the step until three successive ones agree."""
    before = [_trial(step, 0.5 * first), _trial(step, first)]
    for halving in range(2, _MOST_HALVINGS + 2):
        dt = first / 2**halving
        fine = _trial(step, dt, energies=plan.energies)
        error = _error(fine, *before)
        if isinstance(fine, SteppedRecorder):
            if error.share <= rtol:
                return fine, error
            # Coarser runs are needed for their contacts only: the other memory is freed.
            fine = replace(fine, record=plan.layout.of_contacts(fine.record).copy())
        before = [fine, before[0]]
    raise ConvergenceError(
        f"Newmark: with dt={dt:.3g} s the estimated error is still {error.share:.2g}, above "
        f"rtol={rtol:g}: {error.why}; give dt, a larger rtol, or take Adaptive()"
    )


def _trial(
    step: Callable[..., SteppedRecorder], dt: float, *, energies: bool = False
) -> SteppedRecorder | ConvergenceError:
    """Run with steps that may be too long: to be solved, or not to gain energy at a touch."""
    try:
        return step(dt, energies=energies)
    except (IterationError, NotFiniteError) as error:
        return error


def _error(*runs: SteppedRecorder | ConvergenceError) -> StepError:
    """The error of the first of runs with dt, 2 dt and 4 dt."""
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
    """Run the core once: the least whole number of steps of `dt` that covers the record.

    Parameters
    ----------
    plan : Scenario
    rule : Newmark
    dt : float
        s.
    duration : float, optional
        That of the plan by default, s.
    start : (forces, rates), optional
        Contact forces, N, and their rates, N/s, shape (pushes,). By default the laws give them,
        which is wrong where a contact point without mass meets a law that depends on the rate.
    energies : bool, optional
        Whether to record them.

    Raises
    ------
    InputError
        If the record would not fit in memory.
    ConvergenceError
        If the solution leaves the range of numbers; with the time.
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
    """The least number of steps of `dt` that covers `duration`, both in s."""
    steps = duration / dt * (1.0 - ROUNDING)
    needed = 8.0 * plan.layout.rows * (steps + 1.0)
    if needed > _MOST_BYTES:
        given, larger = (
            (f"dt={dt:g} s", "dt") if rule.dt else (f"Newmark(rtol={rule.rtol:g})", "rtol")
        )
        raise InputError(
            f"{given} over duration={duration:g} s makes {steps:.3g} steps and a record of "
            f"{needed / GIB:.3g} GiB: take a larger {larger} or a shorter duration"
        )
    return max(1, math.ceil(steps))


def _start(plan: Scenario, rule: Newmark) -> _Start:
    """The contact forces just after t = 0, and their rates.

    Where a contact point has no mass, the bodies' state does not determine it: its place, or
    under a damper its velocity, follows from the balance of all forces. Two very short steps
    find it: the first contains the jump, if there is one; the second gives the rates. Both are
    shortened until the forces change no more, or only by rounding: a damper's force fades fast.
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
            if apart >= before:  # rounding
                break
            before = apart
        found = forces, (late - early) / instant
        if before <= _SAME_START * float(np.abs(forces).max(initial=0.0)):
            break
        instant *= _SHORTENED
    return found


def first_step(plan: Scenario) -> float:
    """A fiftieth of the shortest contact that rigid bodies would have, s."""
    shortest = plan.duration / 20.0
    if plan.fastest == 0.0:
        return shortest
    times = [
        rigid_contact_time(of.law, plan.reduced_mass(of), plan.fastest) for of in plan.contacts
    ]
    return min([shortest, *(time / _FIRST_STEPS for time in times)])


def rigid_contact_time(law: ContactLaw, mass: float, velocity: float) -> float:
    """Estimate how long a contact of a rigid `mass`, kg, at `velocity`, m/s, lasts, s.

    Three times the largest indentation over the velocity: 2.94 for Hertz (Johnson, Contact
    Mechanics, eq. 11.25), π for a linear law.
    """
    try:
        return 3.0 * law.stroke(0.5 * mass * velocity * velocity) / velocity
    except InputError as error:
        raise InputError(
            f"law={law!r} with velocity={velocity:g} m/s: no contact time can be estimated "
            f"({error}); give dt"
        ) from None
