"""A scene to a tolerance, read where and when it is asked for."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..base import ConvergenceError, FloatArray, warn
from ..laws import UserLaw
from ..scene import Plan
from .adaptive import TIGHTEST, Adaptive, Track, adaptive_run
from .comparison import difference, most_touches
from .events import Events
from .roughness import refuse_rough

__all__ = ["Sampled", "solve_adaptive"]

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


@dataclass(frozen=True, eq=False)
class Sampled:
    """An adaptive run as a :class:`Recorder`, to be read at any times.

    Attributes
    ----------
    plan : Plan
        What was run.
    track : Track
        The core's rows of the run, from which every curve is computed when it is asked for.
    rule : Adaptive
    dense
        What lies between two rows has a closed form or a polynomial.
    """

    plan: Plan
    track: Track
    rule: Adaptive
    dense: ClassVar[bool] = True

    @property
    def solver(self) -> str:
        return f"Adaptive(rtol={self.rule.rtol:g}), {self.track.steps} steps in contact"

    @property
    def duration(self) -> float:
        return self.track.duration

    @property
    def times(self) -> FloatArray:
        return self.track.times

    @property
    def marks(self) -> FloatArray:
        return self.track.marks

    @property
    def events(self) -> tuple[Events, ...]:
        return self.track.events

    def rows(self, times: FloatArray, energies: bool) -> FloatArray:
        return self.track.sample(times, energies=energies)

    def forces(self, times: FloatArray) -> FloatArray:
        return self.track.forces(times)

    def state(self, body: int) -> tuple[FloatArray, FloatArray]:
        modal, ours = self.plan.modal[body], slice(*self.plan.first_modes[body : body + 2])
        x, v = (np.frombuffer(of)[ours] for of in (self.track.x, self.track.v))
        return modal.coordinates(x), modal.coordinates(v)


def solve_adaptive(plan: Plan, rule: Adaptive) -> tuple[Sampled, float | None]:
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
    track = _first_track(plan, rule.rtol)
    error: float | None = rule.rtol
    if max(map(len, track.touches), default=0) > 1:
        _refuse_gain(plan, track)
    touches = most_touches(track)
    if touches > 1:
        track, error = _confirmed(plan, track, rule.rtol, touches)
    return Sampled(plan, track, rule), error


def _refuse_gain(plan: Plan, track: Track) -> None:
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
    rate = np.frombuffer(track.v)
    with np.errstate(over="ignore", invalid="ignore"):
        found = float(np.concatenate([body.inertia for body in bodies]) @ rate**2)
    if found <= _GAIN * there:
        return
    shortest = min(end - start for of in track.events for start, end in of.contacts)
    raise ConvergenceError(
        f"adaptive run: at its end the bodies have {found / there:.3g} times the energy that they "
        f"came with; a contact of {shortest:.2g} s is so short that the rounding of time drowns "
        "it: take a softer law, or a larger m0"
    )


def _first_track(plan: Plan, rtol: float) -> Track:
    """The run itself; under a law that scatters it would not end, or end by chance."""
    if not any(isinstance(joint.law, UserLaw) for joint in plan.joints):
        return _track(plan, rtol)
    try:
        track = _track(plan, rtol, _LONG)
    except ConvergenceError:
        refuse_rough(plan, rtol)
        return _track(plan, rtol)
    refuse_rough(plan, rtol)
    return track


def _confirmed(plan: Plan, first: Track, rtol: float, touches: int) -> tuple[Track, float | None]:
    """Return the run of the smallest tolerance that was needed, and its error, if known."""
    speed = max(map(abs, plan.velocities))
    best, tolerance, error = first, rtol, math.inf
    # Errors add up from touch to touch, where they do not multiply.
    wanted = rtol / (10.0 * touches)
    while True:
        # One more may have to be tighter yet by enough to tell how much this one errs.
        wanted = max(wanted, 10.0 * _FLOOR if tolerance > 50.0 * _FLOOR else _FLOOR)
        try:
            other = _track(plan, wanted, _PATIENCE * (first.steps + first.rejected) + _FEW)
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


def _track(plan: Plan, rtol: float, most_steps: int = sys.maxsize) -> Track:
    # A law is taken once, however many contacts it acts in.
    laws = {id(joint.law): joint.law.for_core() for joint in plan.joints}
    bodies = [body.modal for body in plan.bodies]
    return adaptive_run(
        [body.for_core(plan.gravity, plan.load_on(i)) for i, body in enumerate(bodies)],
        [
            (j.first, j.first_port, j.second, j.second_port, j.gap, laws[id(j.law)])
            for j in plan.joints
        ],
        [body.moving for body in bodies],
        plan.velocities,
        rtol=rtol,
        duration=plan.duration,
        x=np.concatenate(plan.at_rest) if plan.preload else None,
        most_steps=most_steps,
    )
