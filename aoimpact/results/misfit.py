"""Whether a model that was fitted to a contact of some duration has met one like it.

A model fitted to a contact of duration T has the receptance of its body at the frequency i s,
s ~ 10/T. The forces that it leaves unbalanced at the frequency of the contact that it has met show
how exact it is for that one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..base import warn, with_unit
from ..fem import Rayleigh
from ..integrate import Events
from ..reduction import is_valid_for

if TYPE_CHECKING:
    from ..scene import Plan
    from .run import Run

__all__ = ["follows", "warn_of_lag", "warn_of_misfit"]


# Unbalanced force, relative, up to which later contacts are right: on five bodies that ring between
# two to four contacts the impulse was wrong by .02 to .45 above 6e-5, and by less than .001 below
# 2e-5.
_BALANCED_AGAIN = 3e-5

# Unbalanced force, relative, up to which the displacement after a contact is right: on twelve
# bodies it was wrong by .15 to 1.3 above this, but for a light body that moves as a whole, and by
# less than .1 below a tenth of this.
_BALANCED_AFTER = 1e-3


# β over the duration of the contact from which dashpots at a massless contact count: a body of one
# oscillator is wrong by 2e-4 in the peak and 9e-4 in the rebound velocity there.
_LAGS = 1e-4
# Share of the body's mass that changes the force by about as much.
_LIGHT = 1e-6


def warn_of_lag(plan: Plan, run: Run, names: Sequence[str]) -> None:
    """Warn where stiffness-proportional damping would hold a massless contact back.

    The dashpots β k on a contact without mass let it follow its force with the time constant β;
    the compliance of such a contact is taken without them (`Rayleigh`).

    Parameters
    ----------
    plan : Plan
    run : Run
        Of the plan.
    names : sequence of str
        What to call the bodies.
    """
    for number, body in enumerate(plan.bodies):
        if not isinstance(damping := body.model.damping, Rayleigh):
            continue
        touches = _touches(plan, run, number)
        if not (body.massless and touches):
            continue
        longest = max(end - start for start, end in touches)
        if damping.beta > _LAGS * longest:
            warn(
                f"{names[number]} has no mass at its contact (m0 = 0), where damping with beta = "
                f"{with_unit(damping.beta, 's')} does not act: in a contact of "
                f"{with_unit(longest, 's')} force and rebound are not those of a light contact "
                f"mass; give one, m0={_LIGHT * body.static_mass:.1g}"
            )


def warn_of_misfit(plan: Plan, run: Run, names: Sequence[str]) -> None:
    """Warn where a model was fitted to quite another duration than that of its contact.

    What counts is how long the contact of the peak force lasts, and how long the body is touched in
    all: its motion between two contacts makes the force of the second.

    Parameters
    ----------
    plan : Plan
    run : Run
        Of the plan.
    names : sequence of str
        What to call the bodies.
    """
    models = [body.model for body in plan.bodies]
    if not any(model.contact_time for model in models):
        return
    said = set()
    for contact, events in zip(plan.contacts, run.events, strict=True):
        for body, port in contact.ports:
            fitted = models[body].contact_time
            if fitted is None or body in said or not events.contacts:
                continue
            contact_time = _contact_time(events, run.duration, fitted)
            touched_for = _time_touched(plan, run, body)
            if not is_valid_for(models[body], contact_time, port):
                said.add(body)
                warn(
                    f"{names[body]} was fitted to a contact of {with_unit(fitted, 's')}, but the "
                    f"one of the peak force lasts {with_unit(contact_time, 's')}: at that time "
                    "scale the model is not exact enough for its force to be right; make it with "
                    f"contact_time={contact_time:.2g}, or give the finite-element body itself and "
                    "rtol"
                )
            elif not is_valid_for(models[body], touched_for, port, _BALANCED_AGAIN):
                said.add(body)
                warn(
                    f"{names[body]} was fitted to a contact of {with_unit(fitted, 's')}, but is "
                    f"touched again and again for {with_unit(touched_for, 's')}: its motion in "
                    "between is not exact enough for the later forces, impulse and rebound to be "
                    f"right; make it with duration={touched_for:.2g} and some more oscillators, or "
                    "give the finite-element body itself and rtol"
                )


def follows(plan: Plan, run: Run, body: int) -> bool:
    """Return whether a body's displacement is known to be right after the contact.

    By what its model leaves unbalanced at that time scale. This costs a few products with K and M;
    the error itself costs another run.

    Parameters
    ----------
    plan : Plan
    run : Run
        Of the plan, at the given times.
    body : int
        Its number.
    """
    model, touches = plan.bodies[body].model, _touches(plan, run, body)
    if model.contact_time is None or not touches or not len(run.t):
        return not touches
    since = float(run.t[-1]) - min(touches)[0]
    ports = {contact.port_of(body) for contact in plan.contacts if contact.touches(body)}
    return since <= model.contact_time or all(
        is_valid_for(model, since, port, _BALANCED_AFTER) for port in ports
    )


def _contact_time(events: Events, duration: float, fitted: float) -> float:
    """How long the contact of the peak force lasts, s; as fitted if it is cut off before."""
    start, end = events.peak_contact or (0.0, 0.0)
    return max(end - start, fitted) if end >= duration else end - start


def _time_touched(plan: Plan, run: Run, body: int) -> float:
    """From a body's first touch to the end of its last, s; 0 if none begins after one has ended."""
    starts, ends = zip(*_touches(plan, run, body), strict=True)
    return max(ends) - min(starts) if max(starts) > min(ends) else 0.0


def _touches(plan: Plan, run: Run, body: int) -> list[tuple[float, float]]:
    """Start and end of every contact of a body, s."""
    return [
        touch
        for contact, of in zip(plan.contacts, run.events, strict=True)
        if contact.touches(body)
        for touch in of.contacts
    ]
