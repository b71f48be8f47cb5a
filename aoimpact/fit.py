"""Whether a model that was fitted to a blow has met one of that kind.

A model fitted to a contact of duration T knows how its body answers at the frequency i s, s ~ 10/T.
What it leaves unbalanced at that of the contact it has met tells how much it knows of that one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .contact import ContactPoint
from .errors import warn
from .events import Events
from .interface import InterfaceModel
from .krylov import SHIFT_TIMES_DURATION
from .plan import Plan
from .run import Run
from .star import AOModel
from .units import quantity

__all__ = ["fitted_times", "unbalanced", "warn_of_misfit"]

FloatArray = npt.NDArray[np.float64]

# Factor between the contact time and the one fitted to up to which nothing is said: measured on
# seven impacts, twice as far costs an oscillator or two, three times as far an error of the force
# up to ten times as large where the body has slow modes.
_NEAR = 3.0

# Unbalanced share at which the force begins to be worse than what a good fit would give.
_BALANCED = 3e-3


def warn_of_misfit(plan: Plan, run: Run, names: Sequence[str]) -> None:
    """Say so where a model was fitted to quite another contact time, and does not know this one.

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
            lasted = _lasting(events, run.duration, fitted)
            if fitted is None or lasted is None or body in said:
                continue
            if unbalanced(models[body], SHIFT_TIMES_DURATION / lasted, port) > _BALANCED:
                said.add(body)
                warn(
                    f"{names[body]} was fitted to a contact of {quantity(fitted, 's')}, but the "
                    f"one of the peak force lasts {quantity(lasted, 's')}: of that time scale the "
                    "model knows too little for its force to be right; make it with contact_time="
                    f"{lasted:.2g}, or give the finite-element body itself and rtol"
                )


def fitted_times(models: Sequence[Any]) -> tuple[float, float]:
    """Return between which durations of a contact nothing would be said of the models, s."""
    fitted = [time for time in map(_fitted_time, models) if time is not None]
    return max(fitted, default=0.0) / _NEAR, min(fitted, default=math.inf) * _NEAR


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


def _lasting(events: Events, duration: float, fitted: float | None) -> float | None:
    """How long the contact of the peak force lasts, s, if that is far from what was fitted."""
    for start, end in events.contacts:
        if fitted is not None and start <= events.peak_time <= end:
            lasts = end - start
            if lasts > _NEAR * fitted or (lasts < fitted / _NEAR and end < duration):
                return lasts
    return None
