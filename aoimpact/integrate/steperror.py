"""Error estimate of a run with fixed steps, from runs with twice and four times its step.

Newmark's rule is of second order for smooth forces. Touches or releases within a step, laws that
jump and massless contact points reduce the order, and errors of two steps may agree by chance.
Therefore runs with three steps are compared, in the peak, the vicinity of the peak and the impulse
of the normal force and of friction. The precision of tangential stretches is proportional to the
square of the step, like the error of the rule. Errors that no comparison shows are bounded
separately: jumps of the force at a touch, touches between steps or in vibration that steps do not
resolve, and changes of loads between steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from ..base import PRINTED, BoolArray, FloatArray
from ..scene import Scenario
from .events import find_peak, parabola_tops
from .settings import DRAWN, LESSER

if TYPE_CHECKING:
    from .fixed_steps import SteppedRecorder

# Largest relative error estimate that is reported; above it the error is set to 1.
_NO_DIGIT = 0.2

# Force relative to its peak above which two runs' forces are compared at each step, since the
# difference of the peaks alone may vanish by chance. Over 1488 impacts the true error exceeds the
# estimate in 0.7 % (at most 1.8 times); with 0.95 in 1.5 % (3.6 times). Comparing all of the force
# makes the median estimate 9 times the error instead of 5.6.
_AROUND_PEAK = 0.8

# Largest force at the touch, relative to the peak, that does not count as a jump. Values a third or
# three times as large change none of 1488 estimates.
_NO_JUMP = 1e-3

# Errors of friction's impulse are relative to at least this share of the integral of the force's
# magnitude: the impulse of a force that reverses may vanish.
_TURNED = 0.1

# Largest ω dt of modes that steps resolve, which is twelve steps per period.
_RESOLVED = 0.5


class StepError(NamedTuple):
    """Estimate of the largest relative error in the peak force and impulse of any contact.

    Friction forces are included.

    Attributes
    ----------
    share : float
        Relative error; 1.0 if no digit is accurate.
    why : str
        Clause that names the main cause.
    """

    share: float
    why: str


_CHANGES = "with twice the step the forces, or when they act, change by more than a fifth"
_FEW = "the record has too few steps to compare"
_SUDDEN = "a force jumps at the touch, or a damper stops the bodies within a step"
_TOUCH = "bodies may touch between two steps, or in vibration that such steps do not resolve"
_LOADS = "a load changes within a step more than its ends show"


def time_error(
    fine: SteppedRecorder, coarse: SteppedRecorder, coarser: SteppedRecorder
) -> StepError:
    """Estimate the largest relative error of peak force and impulse of all contacts.

    Parameters
    ----------
    fine, coarse, coarser : SteppedRecorder
        Runs with steps dt, 2 dt and 4 dt. Errors are relative to at least a hundredth of the
        largest peak or impulse of all contacts.
    """
    plan = fine.plan
    unseen, missed = StepError(_unseen_loads(fine), _LOADS), _missed_forces(fine, coarse)
    forces = [plan.layout.forces(run.record) for run in (fine, coarse, coarser)]
    if not any(force.any() for force in forces):
        return StepError(1.0, _TOUCH) if missed.any() else unseen
    near, far = _changes(fine, coarse), _changes(coarse, coarser)
    if near is None or far is None:
        return StepError(1.0, _FEW)
    peaks = forces[0].max(axis=1)
    if not peaks.any():
        return StepError(1.0, _CHANGES)
    scales = _scales(peaks)
    alone = peaks * [_touch_error(fine, contact) for contact in range(len(peaks))] / scales
    # For an error of second order, `near` is three times the error, and `far` four times `near`.
    found = max(
        StepError(max(near, far / 4.0), _CHANGES),
        StepError(float(alone.max()), _SUDDEN),
        StepError(float((missed / scales).max()), _TOUCH),
    )
    share = unseen.share + found.share + DRAWN * plan.layout.slides
    return StepError(share if share <= _NO_DIGIT else 1.0, max(unseen, found).why)


def _scales(sizes: FloatArray) -> FloatArray:
    """Return the values that errors are divided by: sizes, but at least 1/100 of the largest."""
    least = LESSER * np.maximum(sizes.max(axis=0), np.finfo(float).tiny)
    return np.asarray(np.maximum(sizes, least))


def _changes(ours: SteppedRecorder, theirs: SteppedRecorder) -> float | None:
    """Return the largest relative change of peaks and impulses with twice the step.

    None if the runs have too few steps.
    """
    shared = min(len(theirs.times), (len(ours.times) + 1) // 2)
    if shared < 3:
        return None
    t, pressing, rubbing = ours.times[: 2 * shared - 1], [], []
    for number in range(len(ours.plan.contacts)):
        one, two = (of.plan.layout.contact(of.record, number) for of in (ours, theirs))
        pressing.append(_change(t, one.force[None, : len(t)], two.force[None, :shared]))
        if one.tangential is not None and two.tangential is not None:
            rubbing.append(_change(t, one.tangential[:, : len(t)], two.tangential[:, :shared]))
    change, size = np.moveaxis(np.array(pressing), -1, 0)
    largest = float((change / _scales(size)).max())
    if rubbing:
        change, slid = np.moveaxis(np.array(rubbing), -1, 0)
        scales = np.maximum(_scales(slid), PRINTED * size.max(axis=0))
        largest = max(largest, float((change / scales).max()))
    return largest


def _change(t: FloatArray, ours: FloatArray, theirs: FloatArray) -> tuple[tuple[float, float], ...]:
    """Return (change, size) of a force's peak and impulse in two runs; forces: (axes, times)."""
    every, rubs = t[::2], len(ours) > 1
    size, other = (np.linalg.norm(of, axis=0) if rubs else of[0] for of in (ours, theirs))
    # Friction has a kink at the start of full slip, where a parabola through samples misses the
    # peak.
    peaks = [of.max() if rubs else find_peak(at, of)[0] for at, of in ((t, size), (every, other))]
    around = np.maximum(size[::2], other) >= _AROUND_PEAK * max(peaks)
    away = np.linalg.norm(ours[:, ::2] - theirs, axis=0)
    apart = float(away[around].max(initial=abs(peaks[0] - peaks[1])))
    sums = np.trapezoid(ours, t), np.trapezoid(theirs, every)
    moved = float(np.linalg.norm(sums, axis=1).max())
    if rubs:
        moved = max(moved, _TURNED * float(np.trapezoid(size, t)))
    return (apart, max(peaks)), (float(np.linalg.norm(sums[0] - sums[1])), moved)


def _touch_error(run: SteppedRecorder, contact: int) -> float:
    """Return a bound of the relative error of peak and impulse if the force jumps at touches.

    A step detects a touch only at its end, so that up to one step of the force after a jump is
    missing: the momentum of this force and, if the jump is the peak, the decrease of the force
    since the jump. Two runs may miss the same amount, so that their difference does not show it.
    """
    law, bodies = run.plan.contacts[contact].law, run.plan.bodies
    force, indentation = run.plan.layout.contact(run.record, contact)[:2]
    peak = float(force.max())
    first = 1 + np.flatnonzero((force[1:] > 0.0) & (force[:-1] == 0.0))
    if force[0] == peak > 0.0 and not force[1:2].any():
        return 1.0  # a damper stops the bodies within the first step, in all runs alike
    if len(first) == 0:
        return 0.0
    # A body with mass arrives with its previous velocity, and a step may remove most of this
    # velocity.
    before = np.zeros(len(first))
    if not any(bodies[body].massless for body, _ in run.plan.contacts[contact].ports):
        before = np.maximum(run.rates(contact)[0][first - 1], 0.0)
    missed = law.force(np.minimum(before * run.dt, law.limit), before).max() - peak
    worst = [float(missed) / peak]
    rate = (indentation[first] - indentation[first - 1]) / run.dt
    jump = law.force(np.full(len(first), np.finfo(float).eps * indentation.max()), rate)
    if (jump > _NO_JUMP * peak).any():
        impulse = run.dt * float(np.add.reduceat(force, first).max())
        worst.append(2.0 * float(jump.max()) * run.dt / impulse)
        top = int(force.argmax())
        if top in first or top - 1 in first:  # the first force may be a rounding error
            worst.append(abs(float(force[min(top + 1, len(force) - 1)]) - peak) / peak)
    return min(1.0, max(0.0, *worst))


def _unseen_loads(run: SteppedRecorder) -> float:
    """Return the error due to load changes within steps, relative to the largest impulse or peak.

    A step uses the load at its ends. All compared runs miss a pulse within a step: its impulse and,
    at a massless contact point, which transfers the pulse at once, its excess over the values at
    the ends. If a contact has a damper, the effect of a load decays, and a jump between the ends is
    missed, too.
    """
    t, plan, sums = run.times, run.plan, scipy.integrate.cumulative_trapezoid
    forces = plan.layout.forces(run.record)
    impulse = float(np.abs(np.trapezoid(forces, t)).max(initial=0.0))
    missed = beside = 0.0
    for load in plan.loads:
        within = load.times[(load.times > t[0]) & (load.times < t[-1])]
        every = np.union1d(t, within)
        acting, at_steps = (np.interp(of, load.times, load.forces) for of in (every, t))
        exact = sums(acting, every, initial=0.0)[np.searchsorted(every, t)]
        missed = max(missed, float(np.abs(exact - sums(at_steps, t, initial=0.0)).max()))
        impulse = max(impulse, float(np.abs(exact).max()))
        if plan.bodies[load.body].massless:
            step = np.clip(np.searchsorted(t, every, side="right") - 1, 0, len(t) - 2)
            ends = np.stack([at_steps[step], at_steps[step + 1]])
            seen = np.clip(acting, ends.min(axis=0), ends.max(axis=0))
            touching = [of.law for of in plan.contacts if of.touches(load.body)]
            if any(law.depends_on_rate for law in touching):
                seen = np.interp(every, t, at_steps)
            beside = max(beside, float(np.abs(acting - seen).max()))
    peak = float(forces.max(initial=0.0))
    shares = (missed / impulse if missed else 0.0, beside / peak if peak else 0.0)
    return min(1.0, max(shares))


def _missed_forces(fine: SteppedRecorder, coarse: SteppedRecorder) -> FloatArray:
    """Return bounds of each contact's force between steps minus its largest force at a step, N.

    Between steps the indentation follows the parabola through three steps. Its error is at most the
    difference of the indentations with steps dt and 2 dt. A load f displaces a mode of
    participation factor r by r f / ω². The amplitude of the vibration caused by the load is at most
    r / ω² times the sum of changes of f, and at most r / ω³ times the sum of changes of its slope.
    Steps longer than the mode's period show only the displacement.
    """
    plan, missed = fine.plan, np.zeros(len(fine.plan.contacts))
    size = [_unresolved(plan, body, fine.dt) for body in range(len(plan.bodies))]
    for number, contact in enumerate(plan.contacts):
        law, (force, indentation) = contact.law, plan.layout.contact(fine.record, number)[:2]
        vibration = 2.0 * sum(float(size[body][port]) for body, port in contact.ports)
        coarser = plan.layout.contact(coarse.record, number)[1]
        depth = [_highest_crest(force == 0.0, indentation, coarser), indentation.max() + vibration]
        crest, most = law.force(np.minimum(depth, law.limit)) - [0.0, force.max()]
        missed[number] = max(crest, most) if vibration > 0.0 else crest
    return missed


def _highest_crest(free: BoolArray, ours: FloatArray, coarse: FloatArray) -> float:
    """Return the largest indentation, m, from which an open contact recedes or the record ends.

    `free` is True at steps without force; `ours` and `coarse` are the indentations with the steps
    dt and 2 dt.
    """
    before, here, after = ours[:-2], ours[1:-1], ours[2:]
    turns = free[:-2] & free[1:-1] & free[2:] & (here > before) & (here >= after)
    where = 1 + np.flatnonzero(turns)
    tops = parabola_tops(ours, where)[0]
    if free[-2:].all() and ours[-1] > ours[-2]:
        tops, where = np.append(tops, ours[-1]), np.append(where, len(ours) - 1)
    if not len(tops):
        return 0.0
    shared = np.minimum(where // 2, min(len(coarse), (len(ours) + 1) // 2) - 1)
    return float((tops + np.abs(ours[2 * shared] - coarse[shared])).max())


def _unresolved(plan: Scenario, body: int, dt: float) -> FloatArray:
    """Return the largest vibration of a body's ports in modes that steps do not resolve, m."""
    model, load, slowest = plan.bodies[body], plan.load_on(body), _RESOLVED / dt
    pull = 0.0 if plan.preload else float(np.linalg.norm(plan.pull))
    if model.wall or (load is None and pull == 0.0):
        return np.zeros(model.ports)
    changes = np.zeros(model.ports)
    if load is not None:
        times, forces = load
        steps = np.diff(forces, axis=0)
        bends = np.diff(steps / np.diff(times)[:, None], axis=0, prepend=0.0, append=0.0)
        changes += np.minimum(np.abs(steps).sum(axis=0), np.abs(bends).sum(axis=0) / slowest)
        changes += 0.0 if plan.preload else np.abs(forces[0])
    by_forces, by_weight = model.fast_compliance(slowest, weighed=pull > 0.0)
    found: FloatArray = by_forces @ changes + by_weight * pull
    return found
