"""Bodies as Newmark's rule steps them: in natural modes, a full model in its degrees of freedom."""

from __future__ import annotations

import numpy as np

from ..base import ArrayPair, FloatArray
from ..fem import Rayleigh
from ..reduction import BodyModel, FullModel, Pull, Velocity
from .stepped import PARTS, SteppedBody, SteppedFull


def stepped(
    model: BodyModel,
    velocity: Velocity = 0.0,
    *,
    gravity: Pull = 0.0,
    load: ArrayPair | None = None,
    rest: FloatArray | None = None,
    pressed: FloatArray | None = None,
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
        As `Scenario.load_on` gives it.
    rest : ndarray, shape (n,), optional
        Displacements of its modes (`modal`) at the start; undeformed if not given.
    pressed : ndarray, shape (p,), optional
        Forces on its ports at rest, N, which a massless contact follows at once.
    """
    if not isinstance(model, FullModel) or model.in_modes:
        modal = model.modal
        parts = dict(zip(PARTS, modal.for_core(gravity, load), strict=True))
        start = np.zeros(len(modal.omega)) if rest is None else rest
        return SteppedBody(parts, start, modal.rates(velocity))
    body = model.body
    u = np.zeros(model.dofs) if rest is None else model.modal.expand(rest)
    if pressed is not None and model.modal.following is not None:
        u = u + model.modal.following @ pressed
    v = model.rates(velocity)
    B = np.ascontiguousarray([tip.b for tip in model.tips])
    times, forces = (None, None) if load is None else load
    parts = {"shape": B, "push": B, "load_time": times, "load_force": forces}
    parts["gravity"] = model.weight(gravity) if np.any(gravity) else None
    parts["centre"] = np.ascontiguousarray(model.centre_of_mass[0])
    damping = body.damping if isinstance(body.damping, Rayleigh) else Rayleigh()
    return SteppedFull(parts, u, v, body.K, body.M, damping)
