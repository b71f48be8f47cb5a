"""Whether a model that was fitted to a blow has met one of that kind.

A model fitted to a contact of duration T knows how its body answers at the frequency i s, s ~ 10/T.
What it leaves unbalanced at that of the contact it has met tells how much it knows of that one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .contact import ContactPoint
from .errors import warn
from .events import Events
from .interface import InterfaceModel
from .krylov import SHIFT_TIMES_DURATION
from .star import AOModel
from .units import quantity

if TYPE_CHECKING:
    from .plan import Plan
    from .run import Run

__all__ = ["fitted_times", "knows", "unbalanced", "warn_of_later_motion", "warn_of_misfit"]

FloatArray = npt.NDArray[np.float64]

# Factor by which a contact may be shorter than what was fitted before it is looked at: measured on
# twelve impacts with three and eight oscillators, down to there the force is hardly worse.
_SHORTER = 3.0

# And by which the times grow at which longer ones are looked at: of three oscillators a contact 1.5
# times as long may have a fifth of the force wrong, where eight know one of three times.
_LONGER = 1.15

# Unbalanced share at which the force of one contact begins to be worse than what a good fit would
# give: on the same impacts it was wrong by .02 to .9 where this was above .01, and hardly worse
# than fitted below .005.
_BALANCED = 5e-3

# And at which later contacts do: on five bodies that ring between two to four contacts the impulse
# was wrong by .02 to .45 above 6e-5, and by less than .001 below 2e-5.
_BALANCED_AGAIN = 3e-5

# And its displacement after a contact: on the twelve it was wrong by .15 to 1.3 above this, but for
# a light body that moves as a whole, and by less than .1 below a tenth of this.
_BALANCED_AFTER = 1e-3


def warn_of_misfit(plan: Plan, run: Run, names: Sequence[str]) -> None:
    """Say so where a model was fitted to quite another time than it was touched for.

    What counts is how long the contact of the peak force lasts, and how long the body is touched in
    all: of what it does between one contact and the next the force of the next is made.

    Parameters
    ----------
    plan : Plan
    run : Run
        Of the plan.
    names : sequence of str
        What to call the bodies.
    """
    models: list[Any] = [getattr(body, "model", None) for body in plan.players]
    if not any(map(_fitted_time, models)):
        return
    said = set()
    for joint, events in zip(plan.joints, run.events, strict=True):
        for body, port in (joint.ends_at[:2], joint.ends_at[2:]):
            fitted = _fitted_time(models[body])
            if fitted is None or body in said or not events.contacts:
                continue
            lasted = _lasting(events, run.duration, fitted)
            if not knows(models[body], lasted, port):
                said.add(body)
                warn(
                    f"{names[body]} was fitted to a contact of {quantity(fitted, 's')}, but the "
                    f"one of the peak force lasts {quantity(lasted, 's')}: of that time scale the "
                    "model knows too little for its force to be right; make it with contact_time="
                    f"{lasted:.2g}, or give the finite-element body itself and rtol"
                )
            elif not knows(models[body], span := _span(plan, run, body), port, _BALANCED_AGAIN):
                said.add(body)
                warn(
                    f"{names[body]} was fitted to a contact of {quantity(fitted, 's')}, but is "
                    f"touched again and again for {quantity(span, 's')}: of what it does in "
                    "between the model knows too little for the later forces, impulse and rebound "
                    f"to be right; make it with duration={span:.2g} and some more oscillators, or "
                    "give the finite-element body itself and rtol"
                )


def warn_of_later_motion(plan: Plan, run: Run, body: int) -> None:
    """Say so where a fitted model is asked for motion long after what it was fitted to.

    Parameters
    ----------
    plan : Plan
    run : Run
        Of the plan, at the times asked for.
    body : int
        Its number.
    """
    model = getattr(plan.players[body], "model", None)
    fitted, touches = _fitted_time(model), _touches(plan, run, body)
    if fitted is None or not touches or not len(run.t):
        return
    start = min(touches)[0]
    since = float(run.t[-1]) - start
    ports = {joint.port_of(body) for joint in plan.joints if joint.touches(body)}
    if since > fitted and not all(knows(model, since, port, _BALANCED_AFTER) for port in ports):
        warn(
            f"displacement and velocity of a body that was fitted to a contact of "
            f"{quantity(fitted, 's')} may be wrong by tens of percent until t = "
            f"{quantity(float(run.t[-1]), 's')}: the model gives the force, but not how the body "
            f"swings on; make it with duration={since:.2g} and more oscillators, or give the "
            "finite-element body itself and its displacement as quantity"
        )


def fitted_times(models: Sequence[Any]) -> tuple[float, float]:
    """Return between which durations of a contact the models need not be looked at, s."""
    fitted = [time for time in map(_fitted_time, models) if time is not None]
    return max(fitted, default=0.0) / _SHORTER, min(fitted, default=math.inf)


def knows(model: Any, lasted: float, port: int = 0, most: float = _BALANCED) -> bool:
    """Return whether a model knows enough of its body for forces that act for so long, s.

    It leaves no more than `most` unbalanced at any time from the one fitted to up to this; what was
    found is kept with the model.
    """
    fitted = _fitted_time(model)
    if fitted is None or fitted / _SHORTER <= lasted <= fitted or lasted == 0.0:
        return True
    if lasted < fitted:
        return unbalanced(model, SHIFT_TIMES_DURATION / lasted, port) <= most
    wanted = math.ceil(math.log(lasted / fitted) / math.log(_LONGER))
    kept: dict[int, list[float]] = vars(model).setdefault(_KEPT, {})
    found = kept.setdefault(port, [])
    while len(found) < wanted and max(found, default=0.0) <= most:
        shift = SHIFT_TIMES_DURATION / (fitted * _LONGER ** (len(found) + 1))
        found.append(unbalanced(model, shift, port))
    return max(found[:wanted], default=0.0) <= most


# Models do not change: where they keep for how long forces may act.
_KEPT = "_known_times"


def unbalanced(model: AOModel | InterfaceModel, s: float, port: int = 0) -> float:
    """Return what a model leaves unbalanced at i s under a force at a port, relative.

    √(rᵀD⁻¹r / bᵀX) of the residual r = b - (K + s²M) X, D the diagonal of K + s²M.
    """
    tip, x = _answer(model, s, port)
    body = tip.body
    K, M, rigid = body.K, body.M, body.rigid_modes
    left = tip.b - K @ x - s**2 * (M @ x)
    left -= M @ (rigid @ (rigid.T @ left))
    stiffness = K.diagonal() + s**2 * M.diagonal()
    return math.sqrt(float(left @ (left / stiffness)) / float(tip.b @ x))


def _answer(
    model: AOModel | InterfaceModel, s: float, port: int
) -> tuple[ContactPoint, FloatArray]:
    """The place and the model's displacement of the body under a unit force there, at i s."""
    if isinstance(model, InterfaceModel):
        return model.tips[port], model.modes @ (model.participation[port] / (model.omega**2 + s**2))
    assert model.origin is not None
    follow = model.k / (model.k + s**2 * model.m)
    force = model.k0 + s**2 * model.m0 + float(model.k @ (1.0 - follow))
    return model.origin.tip, model.expand(np.concatenate([[1.0], follow]) / force)


def _fitted_time(model: Any) -> float | None:
    """The contact time that a model was fitted to, s."""
    if isinstance(model, InterfaceModel):
        return model.contact_time
    if isinstance(model, AOModel) and model.origin is not None:
        return model.origin.contact_time
    return None


def _lasting(events: Events, duration: float, fitted: float) -> float:
    """How long the contact of the peak force lasts, s; as fitted if it is cut off before."""
    start, end = next(
        (of for of in events.contacts if of[0] <= events.peak_time <= of[1]), events.contacts[0]
    )
    return max(end - start, fitted) if end >= duration else end - start


def _span(plan: Plan, run: Run, body: int) -> float:
    """From a body's first touch to the end of its last, s; 0 if none begins after one has ended."""
    starts, ends = zip(*_touches(plan, run, body), strict=True)
    return max(ends) - min(starts) if max(starts) > min(ends) else 0.0


def _touches(plan: Plan, run: Run, body: int) -> list[tuple[float, float]]:
    """Start and end of every contact of a body, s."""
    return [
        touch
        for joint, of in zip(plan.joints, run.events, strict=True)
        if joint.touches(body)
        for touch in of.contacts
    ]
