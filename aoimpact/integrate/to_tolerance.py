"""A scene to a tolerance, read where and when it is asked for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..base import ConvergenceError, warn
from ..laws import UserLaw
from ..scene import Plan
from .adaptive import TIGHTEST, Adaptive
from .comparison import difference, most_touches
from .dense import DenseRecorder, adaptive_run
from .roughness import refuse_rough

__all__ = ["solve_adaptive"]

# Of two runs the one with the smaller tolerance errs less: by as much as that is smaller, but for
# this factor, by which single contacts miss or exceed their tolerance.
_SCATTER = 30.0

# Where runs differ by more than this, errors do not grow as their causes do.
_LINEAR = 1e-2

# As far down tighter runs still err less: they show how well a run at TIGHTEST does.
_FLOOR = 0.01 * TIGHTEST

# Steps that a run under a smooth law seldom takes.
_LONG = 500

# A tighter run that takes so many times the steps, and a few, is given up.
_PATIENCE, _FEW = 20, 1000

# Where runs differ by more than this, nothing is right.
_NOTHING = 0.1

# An error is to be less than allowed by this factor.
_RESERVE = 3.0

# More energy than there was, by this factor, is no error of a tolerance.
_GAIN = 1.5

# What rounding alone does to a contact: where each is like the last, it adds up, and tighter runs
# share it. 1.7e-15 a bounce was the most seen, of a ball on a floor against its closed form.
_ROUNDING = 12.0 * float(np.finfo(float).eps)

# Where a tighter run does not bring the estimate down by this, no tolerance will.
_HOPELESS = 0.3


def solve_adaptive(plan: Plan, rule: Adaptive) -> tuple[DenseRecorder, float | None]:
    """Run a scene to a tolerance; return the run and its relative error, if known.

    From the second touch of a contact on, errors grow with each; then tighter runs tell how far,
    until one is as exact as asked.

    Raises
    ------
    ConvergenceError
        If the tolerance cannot be met, with the time; a user's law scatters by more; or contacts
        are too short for the clock.

    Warns
    -----
    AOImpactWarning
        If no tighter run brings the estimated error down to the tolerance.
    """
    run = _first_run(plan, rule.rtol)
    error: float | None = rule.rtol
    if max(map(len, run.touches), default=0) > 1:
        _refuse_gain(plan, run)
    touches = most_touches(run)
    if touches > 1:
        run, error = _confirmed(plan, run, rule.rtol, touches)
    return replace(run, rtol=rule.rtol), error


def _refuse_gain(plan: Plan, run: DenseRecorder) -> None:
    """Refuse a run in which bodies got more energy than there was.

    That is what the rounding of time makes of contacts that are over within its last digits.

    Raises
    ------
    ConvergenceError
        With the shortest touch.
    """
    driven = plan.gravity or plan.loads or plan.preload
    if driven or any(isinstance(joint.law, UserLaw) for joint in plan.joints):
        return
    bodies = [body.modal for body in plan.bodies]
    pairs = list(zip(bodies, plan.velocities, strict=True))
    if any(speed and not body.inertia.any() for body, speed in pairs):  # a wall that pushes
        return
    there = math.fsum(float(body.inertia @ (body.moving * speed) ** 2) for body, speed in pairs)
    rate = np.frombuffer(run.v)
    with np.errstate(over="ignore", invalid="ignore"):
        found = float(np.concatenate([body.inertia for body in bodies]) @ rate**2)
    if found <= _GAIN * there:
        return
    shortest = min(end - start for of in run.events for start, end in of.contacts)
    raise ConvergenceError(
        f"adaptive run: at its end the bodies have {found / there:.3g} times the energy that they "
        f"came with; a contact of {shortest:.2g} s is so short that the rounding of time drowns "
        "it: take a softer law, or a larger m0"
    )


def _first_run(plan: Plan, rtol: float) -> DenseRecorder:
    """The run itself; under a law that scatters it would not end, or end by chance."""
    if not any(isinstance(joint.law, UserLaw) for joint in plan.joints):
        return adaptive_run(plan, rtol=rtol)
    try:
        run = adaptive_run(plan, rtol=rtol, most_steps=_LONG)
    except ConvergenceError:
        refuse_rough(plan, rtol)
        return adaptive_run(plan, rtol=rtol)
    refuse_rough(plan, rtol)
    return run


def _confirmed(
    plan: Plan, first: DenseRecorder, rtol: float, touches: int
) -> tuple[DenseRecorder, float | None]:
    """Return the run of the smallest tolerance that was needed, and its error, if known."""
    speed = max(map(abs, plan.velocities))
    best, tolerance, error = first, rtol, math.inf
    # Errors add up from touch to touch, where they do not multiply.
    wanted = rtol / (10.0 * touches)
    while True:
        # One more may have to be tighter yet by enough to tell how much this one errs.
        wanted = max(wanted, 10.0 * _FLOOR if tolerance > 50.0 * _FLOOR else _FLOOR)
        try:
            most = _PATIENCE * (first.steps + first.rejected) + _FEW
            other = adaptive_run(plan, rtol=wanted, most_steps=most)
        except ConvergenceError as failure:
            _warn(rtol, touches, f"a run with rtol={wanted:g}, to see how far, fails: {failure}")
            return best, error if math.isfinite(error) else None
        apart, before = difference(best, other, speed), error
        share = wanted / tolerance
        rounding = _ROUNDING * touches
        error = max(_estimate(apart, share), rounding)
        best, tolerance = other, wanted
        if error <= rtol:
            return best, rtol
        if tolerance == _FLOOR or error > _HOPELESS * before or error == rounding:
            shows = (
                "by which rounding may add up over that many contacts"
                if error == rounding
                else f"as one with rtol={tolerance / share:.2g} shows"
            )
            _warn(
                rtol,
                touches,
                f"this run, with rtol={tolerance:.2g}, may be wrong by {error:.2g}, {shows}, and "
                "no smaller rtol helps; trust the first contacts only",
            )
            return best, error
        wanted = tolerance * min(0.1, rtol / (_RESERVE * error))


def _estimate(apart: float, share: float) -> float:
    """Error of a run that differs by `apart` from one whose tolerance it has a `share` of."""
    if apart > _NOTHING:
        return 1.0
    return apart * min(1.0, _SCATTER * share) if apart < _LINEAR else apart


def _warn(rtol: float, touches: int, text: str) -> None:
    warn(
        f"rtol={rtol:g} is not kept over {touches} contacts, each of which enlarges the errors "
        f"before: {text}"
    )
