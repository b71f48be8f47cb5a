"""Runs of a scene by the package, and checks of a run without a reference."""

from __future__ import annotations

import math
import signal
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

import aoimpact as ao

from .case import Case
from .outcome import FloatArray, Outcome, Touch

T = TypeVar("T")

# Words of a warning that does not concern the accuracy of an answer.
_NEUTRAL = "gravity has no effect"

# Distance from a peak's time, over the record, within which the peak force must be on the curve.
_BESIDE = 1e-12


@dataclass(frozen=True)
class Answer:
    """Outcome of a run of the package, or its error.

    `error`: class name and message of the exception. `bare`: whether that is no AOImpactError.
    `faults`: see `faults_of`. `claimed`: estimated error of time integration.
    """

    outcome: Outcome | None
    warned: tuple[str, ...] = ()
    error: str = ""
    bare: bool = False
    faults: tuple[str, ...] = ()
    claimed: float = math.nan


def run(case: Case, solver: Any = None) -> Answer:
    """Run a scene by the public API."""
    solver = solver or ao.Adaptive(rtol=case.rtol)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            done = case.build().simulate(
                duration=case.duration, preload=case.preload, solver=solver
            )
            outcome, faults = _outcome(case, done), faults_of(case, done)
            claimed = done.error.time
        except Exception as error:
            bare = not isinstance(error, ao.AOImpactError)
            return Answer(None, error=f"{type(error).__name__}: {error}", bare=bare)
    told = tuple(str(one.message) for one in caught if _NEUTRAL not in str(one.message))
    return Answer(outcome, told, faults=faults, claimed=math.nan if claimed is None else claimed)


def _outcome(case: Case, done: Any) -> Outcome:
    return Outcome(
        np.array([contact.peak_force for contact in done.contacts]),
        np.array([contact.peak_time for contact in done.contacts]),
        np.array([contact.impulse for contact in done.contacts]),
        tuple(tuple(Touch(*ends) for ends in contact.intervals) for contact in done.contacts),
        np.array([float(body.centre_velocity[-1]) for body in done.bodies]),
    )


def faults_of(case: Case, done: Any) -> tuple[str, ...]:
    """Return errors of a run in its own energy balance, momentum, signs, peaks and order."""
    faults = []
    limit = 10.0 * max(case.rtol, 1e-12)
    energy = done.error.energy
    if energy is not None and energy > limit:
        faults.append(f"ledger: energy off by {energy:.2g}")
    impulses = np.array([contact.impulse for contact in done.contacts])
    for i in range(len(case.bodies)):
        off = _momentum(case, done, i, impulses)
        if off is not None and off > limit:
            faults.append(f"momentum: body {i} off by {off:.2g}")
    largest = max((contact.peak_force for contact in done.contacts), default=0.0)
    for c, (contact, joint) in enumerate(zip(done.contacts, case.contacts, strict=True)):
        pulls = joint.law.arguments.get("end") == "indentation"
        least, most = contact.force.min(initial=0.0), contact.force.max(initial=0.0)
        there, peak = _force_about(case, done, c), contact.peak_force
        if not pulls and least < -limit * largest:
            faults.append(f"sign: contact {c} pulls with {least:.2g} N")
        if most > peak + limit * largest or peak > there + limit * largest:
            faults.append(
                f"peak: contact {c} has {peak:.6g} N as its peak, {there:.6g} N on its curve "
                f"there, and {most:.6g} N at most"
            )
        ends = np.array([0.0, *np.ravel(contact.intervals), done.duration])
        if (np.diff(ends) < -1e-14 * done.duration).any():
            faults.append(f"order: contact {c} has intervals {contact.intervals[:3]}")
    return tuple(faults)


def _force_about(case: Case, done: Any, c: int) -> float:
    """Return the largest force of a contact's curve at its peak, or just beside it at a jump."""
    try:
        when = done.contacts[c].peak_time
        beside = when + _BESIDE * case.duration * np.array([-1.0, 0.0, 1.0])
        times = np.unique(np.clip(beside, 0.0, case.duration))
        return float(done.at(times).contacts[c].force.max())
    except ao.InputError:  # a run of fixed steps has forces at its times only
        return math.inf


def _momentum(case: Case, done: Any, i: int, impulses: FloatArray) -> float | None:
    """Return the relative error of a free body's momentum balance; None for other bodies."""
    body = case.bodies[i]
    if body.held or (body.damping and body.damping[0] == "Rayleigh" and body.damping[1] > 0.0):
        return None
    given = body.mass * case.gravity * case.duration
    sizes = [abs(given)]
    for joint, impulse in zip(case.contacts, impulses, strict=True):
        share = float(joint.b == i) - float(joint.a == i)
        given += share * impulse
        sizes.append(abs(share * impulse))
    for load in case.loads:
        if load.body == i:
            times = np.unique(np.clip([0.0, *load.times, case.duration], 0.0, case.duration))
            amount = float(np.trapezoid(np.interp(times, load.times, load.forces), times))
            given += amount
            sizes.append(abs(amount))
    velocity = done.bodies[i].centre_velocity
    changed = body.mass * float(velocity[-1] - velocity[0])
    sizes.append(body.mass * float(np.abs(velocity[[0, -1]]).max()))
    largest = max(sizes)
    return abs(changed - given) / largest if largest > 0.0 else None


def in_time(work: Callable[[], T], longest: float) -> T | None:
    """Return the result of `work`, or None if it takes longer than `longest`, s."""
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, longest)
    try:
        return work()
    except KeyboardInterrupt:
        return None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
