"""Adaptive runs to a tolerance, repeated with smaller ones if errors grow from touch to touch."""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np

from ..base import ConvergenceError, warn
from ..scene import Scenario
from .comparison import difference, most_touches
from .dense import DenseRecorder, adaptive_run
from .settings import DRAWN, TIGHTEST, Adaptive

# Smallest tolerance at which the error of a run still decreases. A run with this tolerance shows
# the error of a run with TIGHTEST.
FLOOR = 0.01 * TIGHTEST

# Largest relative difference of two runs up to which errors are assumed proportional to tolerances;
# above it the error is set to 1. A third of this value costs 1.3 % more steps. With seven times
# this value, a scene of 784 touches fails although a further run confirms its result. Three times
# this value still detects chaos; with a value of 1, the estimate is 0.07 where two runs differ by
# 0.27.
LINEAR = 0.03

# Safety factor of the comparison of two adaptive runs: errors are proportional to the tolerance,
# except that errors of single contacts may be larger by this factor. A second run, whose tolerance
# is smaller by this factor times the number of touches, meets the tolerance unless errors multiply.
# Over 61 scenes of 2 to 58 touches and five tolerances the largest true error is 0.19 of the
# tolerance; with a factor of 3 it is 1.7; a factor of 30 costs 8 % more steps. In units of the
# machine epsilon, it also bounds the rounding error of a contact: the largest one found was 9 units
# per bounce, for 200 balls on a floor with a closed form.
SPREAD = 10.0

# Share of the tolerance to which a scene of several contacts is run. Bodies that after other
# contacts meet at a twentieth of their speeds multiply the errors of these contacts by twenty: with
# a share of 1, errors of two of 6000 scenes were 11 and 17 times the tolerance. The share of 0.3
# costs 13 % more steps over 306 such scenes. A share of 0.1 costs 22 %, and no step meets this
# share of a tolerance of 1e-9 in one of 30 scenes of dashpots on a massless point.
SEVERAL = 0.3

# Largest tolerance of a repeated run. With a larger tolerance two runs may take the same steps
# through a first touch that is hardly longer than a step. Both then have the same error, which
# later touches multiply: in one of 3000 scenes by 1e5. This limit costs 13 % more steps over 1200
# scenes with a tolerance of 6e-5, and none with tolerances of 1e-6 or less.
OTHER_STEPS = 1e-7

# Ratio of the largest number of steps of a repeated run to the steps of the first run: twice what a
# method of order 15 needs for fifteen digits. With a value of 3, six of 305 results that another
# run confirms are lost. Larger values waste proportionally more time on runs that do not reach
# agreement.
PATIENCE = 20

# Largest number of steps of a run with a user's law, enough for 200 contacts. A contact takes 10 to
# 100 steps, and 6000 if the force scatters by 1e-3 of the tolerance. If the force scatters by as
# much as the tolerance, the contact does not end within 20 000 steps, which take five seconds.
MOST_CALLED = 20_000

# Energy growth above this factor means a faulty law or run, not integration error.
GAIN = 1.5


def solve_adaptive(plan: Scenario, rule: Adaptive) -> tuple[DenseRecorder, float | None]:
    """Run a scene to a tolerance; return the run and its relative error, if known.

    Scenes of several contacts are run to a smaller tolerance: after other contacts, two bodies may
    meet at a small part of their speeds. From the second touch of a contact on, errors grow with
    each touch. A contact that pulls may end so slowly that its end is ill-conditioned. With several
    touches or such a contact, the run is repeated with smaller tolerances until it meets `rtol`.

    Raises
    ------
    ConvergenceError
        If the tolerance cannot be met, as with a user's law whose force scatters by more, or if
        contacts are too short for the resolution of time.

    Warns
    -----
    AOImpactWarning
        If no repeated run brings the estimated error down to the tolerance.
    """
    share = SEVERAL if len(plan.contacts) > 1 else 1.0
    most = MOST_CALLED if any(of.law.by_caller for of in plan.contacts) else sys.maxsize
    run = adaptive_run(plan, rtol=share * rule.rtol, most_steps=most)
    error: float | None = rule.rtol
    touches, pulls = 0, False
    for contact, of in zip(plan.contacts, run.events, strict=True):
        touches, pulls = max(touches, len(of.touches)), pulls or contact.law.pulls
    if touches > 1:
        _refuse_gain(plan, run)
        touches = most_touches(run)
    if touches > 1 or (touches == 1 and pulls):
        run, error = _confirmed(plan, run, rule.rtol, touches)
        _refuse_gain(plan, run)
    if error is not None and plan.oblique is not None:
        error = max(error, DRAWN)
    return run if run.rtol == rule.rtol else replace(run, rtol=rule.rtol), error


def _refuse_gain(plan: Scenario, run: DenseRecorder) -> None:
    """Raise if the bodies have gained energy, due to contacts as short as rounding errors of time.

    Raises
    ------
    ConvergenceError
        If the final energy exceeds `GAIN` times the initial one.
    """
    fed = plan.weighed or plan.loads or plan.preload
    if fed or any(contact.law.by_caller for contact in plan.contacts):
        return
    moving = zip(plan.modal, plan.velocities, strict=True)
    if any(speed and not body.inertia.any() for body, speed in moving):  # a moving wall adds energy
        return
    rows = run.rows(np.array([0.0, run.duration]), energies=True)
    bodies = [plan.layout.body(rows, number) for number in range(len(plan.bodies))]
    there, found = np.sum([of.kinetic for of in bodies], axis=0).tolist()
    if found <= GAIN * there:
        return
    shortest = min(end - start for of in run.events for start, end in of.contacts)
    raise ConvergenceError(
        f"adaptive run: at its end the bodies have {found / there:.3g} times their energy, since "
        f"a contact of {shortest:.2g} s is too short to resolve; take a softer law, or a larger m0"
    )


def _confirmed(
    plan: Scenario, first: DenseRecorder, rtol: float, touches: int
) -> tuple[DenseRecorder, float | None]:
    """Run with smaller tolerances until two runs agree; return the last run and its error."""
    speed = max(map(abs, plan.velocities))
    rounding = SPREAD * touches * float(np.finfo(float).eps)  # smaller tolerances do not reduce it
    best, tolerance, error = first, first.rtol, math.inf
    # The tolerance is divided by the number of touches, as errors at least add up over touches.
    wanted = min(rtol / (SPREAD * touches), OTHER_STEPS)
    while True:
        wanted = max(wanted, FLOOR)
        try:
            most = PATIENCE * (first.steps + first.rejected)
            other = adaptive_run(plan, rtol=wanted, most_steps=most)
        except ConvergenceError as failure:
            text = f"a run at rtol={wanted:g}, for comparison, fails: {failure}"
            break
        before, share = error, min(1.0, SPREAD * wanted / tolerance)
        apart = difference(best, other, speed)
        error = 1.0 if apart > LINEAR else max(apart * share, rounding)
        best, tolerance = other, wanted
        if error <= rtol:
            return best, rtol
        if tolerance == FLOOR or error >= before or error == rounding:
            text = (
                f"the error of this run, at rtol={tolerance:.2g}, may be {error:.2g}, "
                "and only the first contacts are reliable"
            )
            break
        wanted = tolerance * min(0.1, rtol / error)
    reason = "by a contact that pulls, and ends slowly"
    if touches > 1:
        reason = f"over {touches} contacts of two bodies, each of which amplifies errors before it"
    warn(f"rtol={rtol:g} cannot be met {reason}: {text}")
    return best, error if math.isfinite(error) else None
