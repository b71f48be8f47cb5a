"""A scene by Newmark's rule: with a given step, or with the step that a tolerance asks for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .errors import ConvergenceError, InputError, warn
from .events import Events, FloatArray, find_peak
from .laws import ContactLaw
from .newmark import Newmark, Record, newmark_scene
from .patchlaw import check_width
from .plan import CONTACT_ROWS, Plan
from .recall import recall_stepped
from .response import Response
from .run import Run

__all__ = ["Recorded", "rigid_contact_time", "solve_newmark"]

# The steps of a first attempt within a contact, when the caller leaves dt to us.
_FIRST_STEPS = 100

_MOST_HALVINGS = 16

# Above this relative change between two steps, second order is not in sight yet.
_NOT_ASYMPTOTIC = 0.2

# A law that gives more than this share of the peak at next to no indentation jumps there.
_AT_TOUCH, _NO_JUMP = 1e-16, 1e-3

# Share of the peak force above which the force is compared between two steps.
_AROUND_PEAK = 0.9


@dataclass(frozen=True, eq=False)
class Recorded:
    """A run with fixed steps as a :class:`Recorder`, to be read at those.

    Attributes
    ----------
    plan : Plan
        What was run.
    rule : Newmark
    record : Record
    events, dense
        It locates none, and knows nothing between its steps.
    """

    plan: Plan
    rule: Newmark
    record: Record
    events: ClassVar[tuple[Events, ...] | None] = None
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
        return self.record.rows[: 4 * len(self.plan.joints) : 4].copy()

    def state(self, body: int) -> tuple[FloatArray, FloatArray]:
        player, (u, v) = self.plan.players[body], self.record.final[body]
        return player.coordinates(u), player.coordinates(v)

    def response(self, body: int) -> Response | None:
        return recall_stepped(self.plan, body, self.rule, self.record)


def solve_newmark(plan: Plan, rule: Newmark) -> Run:
    """Run a scene with fixed steps, estimating their error from a run with twice the step.

    Raises
    ------
    ConvergenceError
        If the step cannot be solved or the error estimate cannot be brought down to `rtol`.

    Warns
    -----
    AOImpactWarning
        If the step is too large for any digit to be right.
    """
    run = _Stepping(plan, rule)
    record, error = run.with_step(rule.dt) if rule.dt is not None else run.with_tolerance()
    if error == 1.0:
        warn(
            f"dt={record.dt:g} s is far too large: with 2dt the peak force changes by more than a "
            "fifth, or a damper stops the bodies within a step; no digit is right. Take a "
            "smaller dt, or Newmark() without dt"
        )
    for i, joint in enumerate(plan.joints):
        check_width(joint.law, record.rows[CONTACT_ROWS * i + 1])
    return Run(plan, Recorded(plan, rule, record), error)


@dataclass(frozen=True, eq=False)
class _Stepping:
    """One scene, to be run with different steps."""

    plan: Plan
    rule: Newmark

    def once(self, dt: float, *, energies: bool) -> Record:
        plan = self.plan
        bodies = [
            player.for_core(self.rule, dt, gravity=plan.weight_of(i), state=plan.start_of(i))
            for i, player in enumerate(plan.players)
        ]
        return newmark_scene(
            bodies,
            [(j.first, j.first_port, j.second, j.second_port, j.law, j.gap) for j in plan.joints],
            [(load.body, load.port, load.times, load.forces) for load in plan.loads],
            rule=self.rule,
            dt=dt,
            duration=plan.duration,
            energies=energies,
        )

    def with_step(self, dt: float) -> tuple[Record, float | None]:
        """Run with a given step, and with twice that step for the error estimate."""
        record = self.once(dt, energies=self.plan.energies)
        if not self.rule.estimate:
            return record, None
        return record, self.error(record, self.once(2.0 * dt, energies=False))

    def with_tolerance(self) -> tuple[Record, float]:
        """Halve the step until two successive ones agree."""
        dt = self.first_step()
        coarse = self.once(dt, energies=False)
        for _ in range(_MOST_HALVINGS):
            dt *= 0.5
            fine = self.once(dt, energies=self.plan.energies)
            error = self.error(fine, coarse)
            if error <= self.rule.rtol:
                return fine, error
            coarse = fine
        raise ConvergenceError(
            f"Newmark: with dt={dt:.3g} s the estimated error of the peak force is still "
            f"{error:.2g}, above rtol={self.rule.rtol:g}; give dt, or a larger rtol"
        )

    def first_step(self) -> float:
        """A hundredth of the shortest contact that rigid bodies would have."""
        plan, shortest = self.plan, self.plan.duration / 20.0
        if plan.fastest == 0.0:
            return shortest
        for joint in plan.joints:
            masses = plan.players[joint.first].static_mass, plan.players[joint.second].static_mass
            mass = 1.0 / sum(1.0 / mass for mass in masses)
            time = rigid_contact_time(joint.law, mass, plan.fastest)
            shortest = min(shortest, time / _FIRST_STEPS)
        return shortest

    def error(self, fine: Record, coarse: Record) -> float:
        """The largest of all contacts."""
        return max(
            (
                max(step_error(fine, coarse, contact), touch_error(fine, joint.law, contact))
                for contact, joint in enumerate(self.plan.joints)
            ),
            default=0.0,
        )


def rigid_contact_time(law: ContactLaw, mass: float, velocity: float) -> float:
    """Estimate how long a contact of a rigid `mass`, kg, at `velocity`, m/s, lasts, s.

    Three times the largest indentation over the velocity: 2.94 for Hertz, π for a linear law.
    """
    try:
        return 3.0 * law.stroke(0.5 * mass * velocity**2) / velocity
    except InputError as error:
        raise InputError(
            f"law={law!r} with velocity={velocity:g} m/s: no contact time can be estimated "
            f"({error}); give dt"
        ) from None


def step_error(fine: Record, coarse: Record, contact: int = 0) -> float:
    """Richardson's estimate of the relative error of a peak force from steps dt and 2dt.

    A third of the largest change of the force around its peak, not only of the peak itself: where
    light masses ring, two peaks may agree by chance. Where the change is more than a fifth, second
    order is not in sight, and no digit is claimed; nor where the first step ends the contact.
    """
    row = CONTACT_ROWS * contact
    shared = min(len(coarse.t), (len(fine.t) + 1) // 2)
    ours, theirs = fine.rows[row][: 2 * shared : 2], coarse.rows[row][:shared]
    (peak, _), (coarse_peak, _) = find_peak(fine.t, fine.rows[row]), find_peak(coarse.t, theirs)
    largest = max(peak, coarse_peak)
    if largest == 0.0:
        return 0.0
    if fine.rows[row][0] == peak and not fine.rows[row][1:2].any():
        return 1.0  # a damper's force at the touch, the same for every step, thrown back too far
    around = np.maximum(ours, theirs) >= _AROUND_PEAK * largest
    change = float(np.abs(ours - theirs)[around].max(initial=abs(peak - coarse_peak))) / largest
    return change / 3.0 if change <= _NOT_ASYMPTOTIC else 1.0


def touch_error(record: Record, law: ContactLaw, contact: int = 0) -> float:
    """Bound the relative error of a peak force from touches at which the force jumps.

    A step knows of a touch only at its end. Up to one step of the jump is then missing: as momentum
    of the touch, and, where the jump is the peak, as what the force has lost since. Two runs may
    miss the same, so their difference does not tell.
    """
    force, indentation = record.rows[CONTACT_ROWS * contact : CONTACT_ROWS * contact + 2]
    first = 1 + np.flatnonzero((force[1:] > 0.0) & (force[:-1] == 0.0))
    if len(first) == 0:
        return 0.0
    rate = (indentation[first] - indentation[first - 1]) / record.dt
    jump = law.force(np.full(len(first), _AT_TOUCH * indentation.max()), rate)
    peak, impulse = float(force.max()), record.dt * float(np.add.reduceat(force, first).max())
    top = int(force.argmax())
    if not (jump > _NO_JUMP * peak).any():
        return 0.0
    at_touch = top in first or top - 1 in first  # a first sample at rounding has no force yet
    lost = abs(float(force[min(top + 1, len(force) - 1)]) - peak) if at_touch else 0.0
    return min(1.0, max(2.0 * float(jump.max()) * record.dt / impulse, lost / peak))
