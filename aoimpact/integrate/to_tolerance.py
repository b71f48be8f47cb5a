"""A scene to a tolerance: one run, and tighter ones where errors grow from touch to touch."""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np

from ..base import ConvergenceError, warn
from ..scene import Scenario
from .comparison import difference, most_touches
from .dense import DenseRecorder, adaptive_run
from .settings import TIGHTEST, Adaptive

# The smallest with which a run still errs less than with a larger one: it shows how well a run at
# TIGHTEST does.
FLOOR = 0.01 * TIGHTEST

# Where two adaptive runs differ by more than this, errors do not grow as their causes do, and no
# digit is claimed. With a third of this 1.3 % more steps are taken; with seven times as much a
# scene of 784 touches is given up that another run confirms. Chaos is seen with three times as
# much, too; with 1, an error of 0.07 is claimed where two runs differ by 0.27.
LINEAR = 0.03

# Safety factor of two adaptive runs. The one with the smaller tolerance errs less, in proportion to
# the tolerance but for this factor, by which single contacts miss or exceed theirs. A second run
# with a tolerance smaller by this factor, and by the number of touches, confirms itself unless
# errors multiply. Over 61 scenes of 2 to 58 touches and five tolerances the largest true error is
# 0.19 of the tolerance; with 3 it is 1.7, and 30 costs 8 % more steps.
SPREAD = 10.0

# The share of the tolerance with which a scene of several contacts is run. Bodies that meet after
# other contacts, at a twentieth of their speeds, make twenty times the error of theirs: two of 6000
# scenes were 11 and 17 tolerances off. It costs 13 % more steps over 306 such scenes;
# 0.1 costs 22 %, and in one of 30 scenes of dashpots on a massless point no step meets it at 1e-9.
SEVERAL = 0.3

# Error of a contact by rounding. It adds up over like contacts, and tighter runs share it. The most
# found was 2.0e-15 a bounce, of 200 balls on a floor against their closed form.
ROUNDING = 12.0 * float(np.finfo(float).eps)

# A tighter run has this tolerance at most. Two that are looser may take the same steps through a
# first touch, which is hardly longer than a step; they agree in its error then, which the touches
# after it multiply: in one of 3000 scenes by 1e5. It costs 13 % more steps over 1200 scenes to a
# tolerance of 6e-5, and none from 1e-6 down.
OTHER_STEPS = 1e-7

# A tighter run that takes this many times the steps of the first is ended: twice what a method of
# order 15 needs for fifteen digits. With 3, six of 305 results are lost that another run gives;
# more waits longer for runs that confirm nothing, in proportion.
PATIENCE = 20

# How well friction is followed under any tolerance, as a share of its bound, where directions turn:
# the core draws the stretches of a contact to 4e-6. Of 40 impacts on four bodies, the velocities of
# runs at 1e-6 and at 1e-8 differ by at most 3e-7 of the speed; of a ball that begins to slip at the
# touch itself by 7e-6.
FRICTION = 1e-5

# Steps up to which a run with a user's law is followed, 200 contacts or more. One takes 10 to 100,
# and 6000 where the force scatters by 1e-3 of the tolerance. Where that is as large as the
# tolerance, the contact is not over after 20 000, which take five seconds.
MOST_CALLED = 20_000

# Energy growth above this factor means a faulty law or run, not integration error.
GAIN = 1.5


def solve_adaptive(plan: Scenario, rule: Adaptive) -> tuple[DenseRecorder, float | None]:
    """Run a scene to a tolerance; return the run and its relative error, if known.

    Several contacts take a smaller tolerance: two bodies may meet, after others, at a small part of
    their speeds. From the second touch of a contact on, errors grow with each; and a contact that
    pulls may end so slowly that small errors make large ones of its end. Then tighter runs follow
    until one meets the tolerance.

    Raises
    ------
    ConvergenceError
        If the tolerance cannot be met, with the time, as under a user's law that scatters by more;
        or contacts are too short for the clock.

    Warns
    -----
    AOImpactWarning
        If no tighter run brings the estimated error down to the tolerance.
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
        error = max(error, FRICTION)
    return run if run.rtol == rule.rtol else replace(run, rtol=rule.rtol), error


def _refuse_gain(plan: Scenario, run: DenseRecorder) -> None:
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
    moving = zip(plan.modal, plan.velocities, strict=True)
    if any(speed and not body.inertia.any() for body, speed in moving):  # a wall that pushes
        return
    rows = run.rows(np.array([0.0, run.duration]), energies=True)
    bodies = [plan.layout.body(rows, number) for number in range(len(plan.bodies))]
    there, found = np.sum([of.kinetic for of in bodies], axis=0).tolist()
    if found <= GAIN * there:
        return
    shortest = min(end - start for of in run.events for start, end in of.contacts)
    raise ConvergenceError(
        f"adaptive run: at its end the bodies have {found / there:.3g} times their energy, since a "
        f"contact of {shortest:.2g} s is drowned by rounding; take a softer law, or a larger m0"
    )


def _confirmed(
    plan: Scenario, first: DenseRecorder, rtol: float, touches: int
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
