"""Bodies as Newmark's rule steps them: in natural modes, a full model in its degrees of freedom.

A full model whose damping is given by modes is stepped in all of these.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import FloatArray
from ..fem import Rayleigh
from ..reduction import BodyModel, FullModel, Pull, Velocity
from .stepped import PARTS, SteppedBody, SteppedFull


def stepped(
    model: BodyModel,
    velocity: Velocity = 0.0,
    *,
    gravity: Pull = 0.0,
    load: tuple[FloatArray, FloatArray] | None = None,
    rest: FloatArray | None = None,
) -> SteppedBody:
    """Return a body as a run with fixed steps takes it.

    Parameters
    ----------
    model : BodyModel
    velocity : float or ndarray, shape (6,), optional
        As of `Body.rates`.
    gravity : float or ndarray, shape (3,), optional
        m/s², along the direction of travel or in three directions.
    load : (times, forces), optional
        As `Plan.load_on` gives it.
    rest : ndarray, shape (n,), optional
        Displacements of its modes (`modal`) at the start; undeformed if not given.
    """
    if isinstance(model, FullModel):
        return _stepped_full(model, velocity, gravity, load, rest)
    modal = model.modal
    parts = dict(zip(PARTS, modal.for_core(gravity, load), strict=True))
    return SteppedBody(
        parts, np.zeros(len(modal.omega)) if rest is None else rest, modal.rates(velocity)
    )


def coordinates(model: BodyModel, values: FloatArray) -> FloatArray:
    """Return a model's coordinates (or rates) from those that are stepped."""
    modes = model.damped_modes if isinstance(model, FullModel) else None
    return values if modes is None else modes.modes @ values


def _stepped_full(
    model: FullModel,
    velocity: Velocity,
    gravity: Pull,
    load: tuple[FloatArray, FloatArray] | None,
    rest: FloatArray | None,
) -> SteppedBody:
    body, modes = model.body, model.damped_modes
    u = np.zeros(model.dofs) if rest is None else model.modal.expand(rest)
    v = model.rates(velocity)
    B = np.ascontiguousarray([tip.b for tip in model.tips])
    times, forces = (None, None) if load is None else load
    parts: dict[str, Any] = {"shape": B, "push": B, "load_time": times, "load_force": forces}
    parts["gravity"] = model.weight(gravity) if np.any(gravity) else None
    parts["centre"] = np.ascontiguousarray(model.centre_of_mass[0])
    if modes is None:
        damping = body.damping if isinstance(body.damping, Rayleigh) else Rayleigh()
        return SteppedFull(parts, u, v, body.K, body.M, damping)
    phi, omega = modes.modes, modes.omega
    assert body.damping is not None
    shape = np.ascontiguousarray(B @ phi)
    parts |= {"omega": omega, "decay": body.damping.decay(omega), "shape": shape, "push": shape}
    parts |= {"centre": phi.T @ parts["centre"], "inertia": np.ones_like(omega)}
    if parts["gravity"] is not None:
        parts["gravity"] = phi.T @ parts["gravity"]
    return SteppedBody(parts, phi.T @ (body.M @ u), phi.T @ (body.M @ v))
