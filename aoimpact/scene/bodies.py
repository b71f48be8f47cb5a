"""Bodies as Newmark's rule steps them: their state at the start, weight, and coordinates.

A star and a full model are stepped in their own coordinates, a body touched in several places in
its modes; so is a star, or a full model, whose damping is given by modes.
"""

from __future__ import annotations

import math

import numpy as np

from ..base import FloatArray
from ..fem import Rayleigh
from ..reduction import AOModel, BodyModel, FullModel
from .stepped import SteppedBody, SteppedFull, SteppedModes, SteppedStar

__all__ = ["State", "coordinates", "preloaded", "stepped", "undeformed", "weight"]

State = tuple[FloatArray, FloatArray]


def undeformed(model: BodyModel, velocity: float) -> State:
    """Return the state, as `stepped` takes it, of a body that moves as a whole, at m/s."""
    if isinstance(model, FullModel):
        still = np.zeros(model.dofs)
        return still, velocity * model.moving if velocity else still.copy()
    if isinstance(model, AOModel):
        return np.zeros(model.n + 1), np.full(model.n + 1, velocity)
    return np.zeros(model.modal.n), velocity * model.modal.moving


def preloaded(model: BodyModel, velocity: float, x: FloatArray, beside: FloatArray) -> State:
    """Return the state, as `stepped` takes it, moving from modes `x` with its velocity.

    `beside`, shape (p,), is what the modes leave out of the displacements of massless ports, m.
    """
    u = model.modal.coordinates(x)
    if isinstance(model, FullModel):
        u = model.whole.expand(u)
    elif isinstance(model, AOModel):
        u[0] += beside[0]
    return u, undeformed(model, velocity)[1]


def weight(model: BodyModel, gravity: float) -> FloatArray | None:
    """Return the forces of gravity, m/s², on the coordinates that `stepped` takes them for."""
    if isinstance(model, FullModel):
        return model.weight(gravity)
    if not isinstance(model, AOModel):
        return gravity * model.modal.weight
    if math.isinf(model.m0) or model.weightless:
        return None
    forces: FloatArray = gravity * model.mass * model.centre_weights
    return forces


def stepped(
    model: BodyModel,
    velocity: float = 0.0,
    *,
    gravity: FloatArray | None = None,
    state: State | None = None,
    ports: FloatArray | None = None,
) -> SteppedBody:
    """Return a body as a run with fixed steps takes it.

    Parameters
    ----------
    model : BodyModel
    velocity : float, optional
        m/s.
    gravity : ndarray, optional
        Constant forces on the model's coordinates, N.
    state : (u, v), optional
        The model's coordinates and rates at the start; moving undeformed if not given.
    ports : ndarray, shape (2, p), optional
        Displacements of the ports just after the start, m, and their rates, m/s: the state does
        not determine them where a port has no mass.
    """
    u, v = (of.copy() for of in (undeformed(model, velocity) if state is None else state))
    if isinstance(model, FullModel):
        return _stepped_full(model, gravity, u, v)
    if not isinstance(model, AOModel) or _in_modes(model):
        return _stepped_modes(model, gravity, u, v, ports)
    if ports is not None and model.massless:
        u[0], v[0] = ports[:, 0]
    return SteppedStar(
        m0=model.m0,
        k0=model.k0,
        m=model.m,
        k=model.k,
        damping=model.damping if isinstance(model.damping, Rayleigh) else Rayleigh(),
        gravity=gravity,
        centre=np.ascontiguousarray(model.centre_weights),
        u=u,
        v=v,
    )


def coordinates(model: BodyModel, values: FloatArray) -> FloatArray:
    """Return a model's coordinates (or rates) from those that the core steps."""
    if isinstance(model, FullModel):
        modes = model.damped_modes
        return values if modes is None else modes.modes @ values
    if isinstance(model, AOModel) and _in_modes(model):
        scale = np.sqrt(model.modal.push[0])
        return model.modal.coordinates((scale * values.T).T)
    return values


def _in_modes(star: AOModel) -> bool:
    """Whether the core cannot step the star itself."""
    if star.damping is None or math.isinf(star.m0):
        return False
    return star.massless or not isinstance(star.damping, Rayleigh)


def _stepped_modes(
    model: BodyModel,
    gravity: FloatArray | None,
    u: FloatArray,
    v: FloatArray,
    ports: FloatArray | None,
) -> SteppedBody:
    modal = model.modal
    scale = np.ones(modal.n)
    if isinstance(model, AOModel):  # modes of unit mass, and forces on them
        scale, masses = np.sqrt(modal.push[0]), np.concatenate([[model.m0], model.m])
        place = u[:1]

        def on_modes(forces: FloatArray) -> FloatArray:
            found: FloatArray = scale * (forces[0] + forces[1:] @ modal.gain)
            return found

        u, v = on_modes(masses * u), on_modes(masses * v)
        gravity = None if gravity is None else on_modes(gravity)
        if ports is None:  # displaced by more than the modes are: something presses on it
            ports = np.array([place, [scale @ v]])
    shape = np.ascontiguousarray(scale * modal.shape)
    residual = np.zeros((model.ports, model.ports)) if modal.residual is None else modal.residual
    residual_forces = None
    if modal.residual is not None and ports is not None:
        beyond = ports.T - shape @ np.column_stack([u, v])  # N, and their rates, N/s, (2, p)
        residual_forces = np.ascontiguousarray(np.linalg.lstsq(residual, beyond)[0].T)
    return SteppedModes(
        omega=modal.omega,
        decay=np.zeros(modal.n) if modal.decay is None else modal.decay,
        shape=shape,
        residual=residual,
        residual_forces=residual_forces,
        gravity=gravity,
        centre=scale * modal.centre,
        u=u,
        v=v,
    )


def _stepped_full(
    model: FullModel, gravity: FloatArray | None, u: FloatArray, v: FloatArray
) -> SteppedBody:
    body, modes = model.body, model.damped_modes
    centre, ports = model.centre[0], np.ascontiguousarray([tip.b for tip in model.tips])
    if modes is None:
        return SteppedFull(
            K=body.K,
            M=body.M,
            B=ports,
            damping=body.damping if isinstance(body.damping, Rayleigh) else Rayleigh(),
            gravity=gravity,
            centre=np.ascontiguousarray(centre),
            u=u,
            v=v,
        )
    phi, omega = modes.modes, modes.angular_frequencies
    assert body.damping is not None
    return SteppedModes(
        omega=omega,
        decay=body.damping.decay(omega),
        shape=np.ascontiguousarray(ports @ phi),
        residual=np.zeros((model.ports, model.ports)),
        residual_forces=None,
        gravity=None if gravity is None else phi.T @ gravity,
        centre=phi.T @ centre,
        u=phi.T @ (body.M @ u),
        v=phi.T @ (body.M @ v),
    )
