"""A scene to a tolerance: one run, and tighter ones where errors grow from touch to touch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..base import ConvergenceError, warn
from ..scene import Plan
from .adaptive import Adaptive
from .comparison import difference, most_touches
from .dense import DenseRecorder, adaptive_run
from .roughness import refuse_rough
from .tolerances import (
    FLOOR,
    FRICTION,
    GAIN,
    LINEAR,
    OTHER_STEPS,
    PATIENCE,
    ROUNDING,
    SEVERAL,
    SPREAD,
)


def solve_adaptive(plan: Plan, rule: Adaptive) -> tuple[DenseRecorder, float | None]:
    """Run a scene to a tolerance; return the run and its relative error, if known.

    Several contacts take a smaller tolerance: two bodies may meet, after others, at a small part of
    their speeds. From the second touch of a contact on, errors grow with each; and a contact that
    pulls may end so slowly that small errors make large ones of its end. Then tighter runs follow
    until one meets the tolerance.

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
    refuse_rough(plan, rule.rtol)  # a run would not end, or end by chance
    share = SEVERAL if len(plan.contacts) > 1 else 1.0
    run = adaptive_run(plan, rtol=share * rule.rtol)
    error: float | None = rule.rtol
    if any(len(of.touches) > 1 for of in run.events):
        _refuse_gain(plan, run)
    touches = most_touches(run)
    if touches > 1 or (touches == 1 and any(contact.law.pulls for contact in plan.contacts)):
        run, error = _confirmed(plan, run, rule.rtol, touches)
        _refuse_gain(plan, run)
    if error is not None and plan.oblique is not None:
        error = max(error, FRICTION)
    return run if run.rtol == rule.rtol else replace(run, rtol=rule.rtol), error


def _refuse_gain(plan: Plan, run: DenseRecorder) -> None:
    """Refuse a run in which bodies got more energy than there was.

    That is what the rounding of time makes of contacts that are over within its last digits.

    Raises
    ------
    ConvergenceError
        With the shortest touch.
    """
    fed = plan.weighed or plan.loads or plan.preload
    if fed or any(contact.law.by_caller for contact in plan.contacts):
        return
    bodies = [body.modal for body in plan.bodies]
    pairs = list(zip(bodies, plan.velocities, strict=True))
    if any(speed and not body.inertia.any() for body, speed in pairs):  # a wall that pushes
        return
    starts = [body.rates(plan.start(number)) for number, body in enumerate(bodies)]
    there = math.fsum(float(of.inertia @ v**2) for of, v in zip(bodies, starts, strict=True))
    rate = np.frombuffer(run.v)
    with np.errstate(over="ignore", invalid="ignore"):
        found = float(np.concatenate([body.inertia for body in bodies]) @ rate**2)
    if found <= GAIN * there:
        return
    shortest = min(end - start for of in run.events for start, end in of.contacts)
    raise ConvergenceError(
        f"adaptive run: at its end the bodies have {found / there:.3g} times the energy that they "
        f"came with; a contact of {shortest:.2g} s is so short that the rounding of time drowns "
        "it: take a softer law, or a larger m0"
    )


def _confirmed(
    plan: Plan, first: DenseRecorder, rtol: float, touches: int
) -> tuple[DenseRecorder, float | None]:
    """Return the run of the smallest tolerance that was needed, and its error, if known."""
    speed = max(map(abs, plan.velocities))
    rounding = ROUNDING * touches
    best, tolerance, error = first, first.rtol, math.inf
    # Errors add up from touch to touch, where they do not multiply.
    wanted = min(rtol / (SPREAD * touches), OTHER_STEPS)
    while True:
        wanted = max(wanted, FLOOR)
        try:
            most = PATIENCE * (first.steps + first.rejected)
            other = adaptive_run(plan, rtol=wanted, most_steps=most)
        except ConvergenceError as failure:
            _warn(rtol, touches, f"a run at rtol={wanted:g}, for comparison, fails: {failure}")
            return best, error if math.isfinite(error) else None
        share, before = wanted / tolerance, error
        apart = difference(best, other, speed)
        error = 1.0 if apart > LINEAR else max(apart * min(1.0, SPREAD * share), rounding)
        best, tolerance = other, wanted
        if error <= rtol:
            return best, rtol
        if tolerance == FLOOR or error >= before or error == rounding:
            _warn_of_error(rtol, touches, tolerance, share, error, rounding)
            return best, error
        wanted = tolerance * min(0.1, rtol / error)


def _warn_of_error(
    rtol: float, touches: int, tolerance: float, share: float, error: float, rounding: float
) -> None:
    """Warn of the error that the run of the smallest tolerance may have, and of its source."""
    source = (
        "by rounding, which adds up over that many contacts"
        if error == rounding
        else f"by comparison with a run at rtol={tolerance / share:.2g}"
    )
    size = "be as large as the result" if error >= 1.0 else f"be {error:.2g} of the result"
    _warn(
        rtol,
        touches,
        f"the error of this run, at rtol={tolerance:.2g}, may {size}, {source}; no smaller rtol "
        "helps, and only the first contacts are reliable",
    )


def _warn(rtol: float, touches: int, text: str) -> None:
    reason = (
        f"over {touches} contacts of the same two bodies, each of which amplifies the errors "
        "before it"
        if touches > 1
        else "by a contact that pulls, and ends slowly"
    )
    warn(f"rtol={rtol:g} cannot be met {reason}: {text}")
