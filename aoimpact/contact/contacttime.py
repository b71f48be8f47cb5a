"""The contact time that a body's models are fitted to, and the shifts s of K + s²M that follow."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..base import ROUNDING, InputError, positive
from ..fem import near_static
from .point import SHIFT_TIMES_DURATION, ContactPoint, own_contact_time, quadratic


def fitted_shifts(
    tips: Sequence[ContactPoint], contact_time: float | None, duration: float | None
) -> list[float]:
    """Return the shifts s, rad/s, for that contact time at any of the places, and duration."""
    if contact_time is None:
        contact_time = min(own_contact_time(tip) for tip in tips)
        if math.isinf(contact_time):
            raise InputError(
                "no contact_time can be estimated where K gives b no stiffness; give it"
            )
    else:
        positive("contact_time", contact_time, unit="s")
        shortest = max(shortest_contact_time(tip) for tip in tips)
        if contact_time < shortest:
            raise InputError(
                f"contact_time={contact_time:g} s is shorter than what the mesh resolves at the "
                f"contact, {shortest:.2g} s: give the duration of the contact in seconds, or "
                "refine the mesh"
            )
    shifts = [SHIFT_TIMES_DURATION / contact_time]
    if duration is not None and (slow := slow_shift(tips[0], duration)) < shifts[0]:
        shifts.append(slow)
    return shifts


def slow_shift(tip: ContactPoint, duration: float) -> float:
    """Return the shift for motion of that duration, rad/s; of an infinite one a static shift."""
    wanted = SHIFT_TIMES_DURATION / positive("duration", duration, unit="s", infinite=True)
    return max(wanted, math.sqrt(near_static(tip.body)))


def shortest_contact_time(tip: ContactPoint) -> float:
    """The shortest contact that the mesh resolves, s: a shorter wave is shorter than an element.

    0 where K gives b no stiffness, and so no waves.
    """
    highest = highest_shift(tip)
    return SHIFT_TIMES_DURATION / highest if highest > 0.0 else 0.0


def highest_shift(tip: ContactPoint) -> float:
    """The frequency of the elements at the contact, rad/s: it bounds from below the highest."""
    refuse_massless([tip])
    body, b = tip.body, tip.b
    return math.sqrt(max(0.0, quadratic(body.K, b) / quadratic(body.M, b)))


def refuse_massless(tips: Sequence[ContactPoint]) -> None:
    """Refuse contact on dofs without mass: no mode of a truncated model has their compliance.

    Raises
    ------
    InputError
    """
    for tip in tips:
        loaded = np.abs(tip.b) > ROUNDING * np.abs(tip.b).max(initial=0.0)
        touched = np.flatnonzero(loaded & (tip.body.M.diagonal() == 0.0))
        if len(touched):
            raise InputError(
                f"the contact acts on {len(touched)} dofs without mass, the first is {touched[0]}, "
                "and modes leave their compliance out; take antioscillators(tip, "
                "method='eigen') or full(tip), or give the dofs mass"
            )
