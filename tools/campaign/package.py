"""The package's own ways through a scene: a run at a tolerance, and Newmark's rule extrapolated."""

from __future__ import annotations

import math
import time as clock
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import aoimpact as ao

from .case import Case
from .outcome import Outcome, Touch

FloatArray = npt.NDArray[np.float64]

# Warnings that say nothing of how right an answer is.
_NEUTRAL = ("gravity has no effect",)

# Newmark's steps over the record: at first, and at most.
_FIRST_STEPS, _MOST_STEPS = 1000, 2_000_000


@dataclass(frozen=True)
class Answer:
    """A run of the package, or why there is none.

    error: the class name and the message of what it raised; bare: whether that is not one of the
    package's own. faults: what is wrong with the run by itself.
    """

    outcome: Outcome | None
    warned: tuple[str, ...] = ()
    error: str = ""
    bare: bool = False
    faults: tuple[str, ...] = ()
    claimed: float | None = None
    seconds: float = 0.0


def run(case: Case, solver: Any = None) -> Answer:
    """Run a scene by public API."""
    begin = clock.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            scene = case.build()
            done = scene.simulate(
                duration=case.duration,
                preload=case.preload,
                solver=solver or ao.Adaptive(rtol=case.rtol),
            )
            outcome, faults = _outcome(case, done), _faults(case, done)
            claimed = done.error.time
        except ao.AOImpactError as error:
            return Answer(
                None, error=f"{type(error).__name__}: {error}", seconds=clock.perf_counter() - begin
            )
        except Exception as error:
            return Answer(None, error=f"{type(error).__name__}: {error}", bare=True)
    told = tuple(
        str(one.message) for one in caught if not any(word in str(one.message) for word in _NEUTRAL)
    )
    return Answer(
        outcome, told, faults=faults, claimed=claimed, seconds=clock.perf_counter() - begin
    )


def _outcome(case: Case, done: Any) -> Outcome:
    return Outcome(
        np.array([contact.peak_force for contact in done.contacts]),
        np.array([contact.peak_time for contact in done.contacts]),
        np.array([contact.impulse for contact in done.contacts]),
        tuple(tuple(Touch(*ends) for ends in contact.intervals) for contact in done.contacts),
        np.array([float(body.centre_velocity[-1]) for body in done.bodies]),
    )


def _faults(case: Case, done: Any) -> tuple[str, ...]:
    """What a run shows to be wrong by itself: its ledger, momentum, signs and order."""
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
        least = float(contact.force.min(initial=0.0))
        if not pulls and least < -limit * largest:
            faults.append(f"sign: contact {c} pulls with {least:.2g} N")
        if float(contact.force.max(initial=0.0)) > contact.peak_force + limit * largest:
            faults.append(
                f"peak: contact {c} has {float(contact.force.max()):.6g} N on its curve and "
                f"{contact.peak_force:.6g} N as its peak"
            )
        off = _off_its_curve(done, c, largest)
        if off > limit:
            faults.append(
                f"peak: contact {c} has {contact.peak_force:.6g} N as its peak, and "
                f"{contact.peak_force - off * largest:.6g} N on its curve then"
            )
        ends = np.array(contact.intervals).ravel()
        if (
            (np.diff(ends) < -1e-14 * done.duration).any()
            or (ends < 0.0).any()
            or (ends > done.duration).any()
        ):
            faults.append(f"order: contact {c} has intervals {contact.intervals[:3]}")
    return tuple(faults)


def _off_its_curve(done: Any, c: int, largest: float) -> float:
    """By how much a contact's peak is above the force at its time, or just before or after."""
    contact = done.contacts[c]
    if contact.peak_force <= 0.0:
        return 0.0
    beside = contact.peak_time * (1.0 + np.array([-1.0, 0.0, 1.0]) * 1e-12)
    times = np.unique(np.clip(beside, 0.0, done.duration))
    force = float(done.at(times).contacts[c].force.max())
    return (contact.peak_force - max(force, float(contact.force.max(initial=0.0)))) / largest


def _momentum(case: Case, done: Any, i: int, impulses: FloatArray) -> float | None:
    """By how much a free body's momentum has changed otherwise than by its forces, relative."""
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
            times = np.unique(
                [0.0, case.duration, *(t for t in load.times if 0 < t < case.duration)]
            )
            amount = float(np.trapezoid(np.interp(times, load.times, load.forces), times))
            given += amount
            sizes.append(abs(amount))
    velocity = done.bodies[i].centre_velocity
    changed = body.mass * float(velocity[-1] - velocity[0])
    sizes.append(body.mass * float(np.abs(velocity[[0, -1]]).max()))
    largest = max(sizes)
    return abs(changed - given) / largest if largest > 0.0 else None


@dataclass(frozen=True)
class Extrapolated:
    """Newmark's rule with its error taken off: peaks, impulses and velocities, and what is left of
    it.
    """

    peaks: FloatArray
    impulses: FloatArray
    velocities: FloatArray
    error: float


def newmark(case: Case, wanted: float, longest: float = 2.0) -> Extrapolated | None:
    """Halve the step until Richardson's extrapolation settles to `wanted`, or time is up."""
    end = clock.perf_counter() + longest
    rows: list[FloatArray] = []
    tables: list[FloatArray] = []
    error, steps = math.inf, _FIRST_STEPS
    contacts, bodies = len(case.contacts), len(case.bodies)
    while steps <= _MOST_STEPS:
        begin = clock.perf_counter()
        answer = run(case, ao.Newmark(dt=case.duration / steps, estimate=False))
        if answer.outcome is None:
            return None
        of = answer.outcome
        rows.append(np.concatenate([of.peaks, of.impulses, of.velocities]))
        if len(rows) > 1:
            tables.append(rows[-1] + (rows[-1] - rows[-2]) / 3.0)
        if len(tables) > 1:
            error = _apart(tables[-1], tables[-2], contacts)
            if error < wanted:
                break
        spent = clock.perf_counter() - begin
        if clock.perf_counter() + 2.5 * spent > end:
            break
        steps *= 2
    if not tables:
        return None
    last = tables[-1]
    return Extrapolated(
        last[:contacts],
        last[contacts : 2 * contacts],
        last[2 * contacts : 2 * contacts + bodies],
        error,
    )


def _apart(one: FloatArray, other: FloatArray, contacts: int) -> float:
    found = 0.0
    for part in (slice(0, contacts), slice(contacts, 2 * contacts), slice(2 * contacts, None)):
        size = float(np.abs(one[part]).max(initial=0.0))
        if size > 0.0:
            found = max(found, float(np.abs(one[part] - other[part]).max()) / size)
    return found
