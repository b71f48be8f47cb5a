"""A body of a scene in its natural modes, the coordinates in which its motion has a closed form.

Mode j of a star is measured by its share x_j in the displacement of the contact coordinate, so that
masses of any size stay apart; modes of a body with several ports are mass-normalised.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from .. import _core
from ..base import FloatArray, InputError
from .interface import InterfaceModel
from .star import AOModel
from .starmodes import StarModes, star_modes

__all__ = ["ModalBody", "modal_body"]


_PARTS = _core.MODES.split()  # of a body as the core takes it, in its order


@dataclass(frozen=True, eq=False)
class ModalBody:
    """ẍ_j + 2σ_j ẋ_j + ω_j² x_j = g_j + Σ_p push_pj f_p, u_p = Σ_j shape_pj x_j + Σ_q R_pq f_q.

    Attributes
    ----------
    omega : ndarray, shape (n,)
        rad/s, ascending.
    decay : ndarray, shape (n,), or None
        σ, 1/s; None where nothing is damped.
    shape, push : ndarrays, shape (p, n)
    residual : ndarray, shape (p, p), or None
        Compliance that no mode has (of a massless contact), m/N.
    weight : ndarray, shape (n,)
        Acceleration g_j under unit gravity along the direction of travel.
    inertia : ndarray, shape (n,)
        Kinetic energy is Σ inertia ẋ²/2; zero for a wall.
    centre : ndarray, shape (n,)
        Displacement of the centre of mass by modes.
    centre_residual : ndarray, shape (p,), or None
        And by forces, m/N.
    moving : ndarray, shape (n,)
        ẋ of the body moving undeformed with unit velocity.
    modes : StarModes or InterfaceModel
        Where they come from.
    """

    omega: FloatArray
    decay: FloatArray | None
    shape: FloatArray
    push: FloatArray
    residual: FloatArray | None
    weight: FloatArray
    inertia: FloatArray
    centre: FloatArray
    centre_residual: FloatArray | None
    moving: FloatArray
    modes: StarModes | InterfaceModel
    _still: tuple[Any, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_still", self._tuple(None, None, None))

    @property
    def n(self) -> int:
        """Number of modes."""
        return len(self.omega)

    @property
    def ports(self) -> int:
        """Number of contact functionals."""
        return len(self.shape)

    @property
    def model(self) -> AOModel | InterfaceModel:
        """The model whose natural modes these are."""
        return self.modes if isinstance(self.modes, InterfaceModel) else self.modes.star

    def for_core(
        self, gravity: float = 0.0, load: tuple[FloatArray, FloatArray] | None = None
    ) -> tuple[Any, ...]:
        """Return the core's tuple (aoi_modes).

        Parameters
        ----------
        gravity : float, optional
            m/s².
        load : (times, forces), optional
            Shapes (m,) and (m, p); forces on the ports, N, straight between the times, s.
        """
        if gravity == 0.0 and load is None:
            return self._still
        pulled = gravity * self.weight if gravity and self.weight.any() else None
        return self._tuple(pulled, *(load if load is not None else (None, None)))

    def _tuple(
        self, gravity: FloatArray | None, times: FloatArray | None, forces: FloatArray | None
    ) -> tuple[Any, ...]:
        acting = {"gravity": gravity, "load_time": times, "load_force": forces}
        parts = vars(self) | acting
        return tuple(parts[name] for name in _PARTS)

    def coordinates(self, x: FloatArray) -> FloatArray:
        """Return the model's own coordinates (or rates) of the modes', shape (n,) or (n, times).

        Without what a massless contact moves under the force of the moment.
        """
        if isinstance(self.modes, InterfaceModel):
            return x
        return np.concatenate([x.sum(axis=0, keepdims=True), self.modes.gain @ x])


def modal_body(model: AOModel | InterfaceModel) -> ModalBody:
    """Return a model in its natural modes; found once for each model.

    Raises
    ------
    InputError
        If an interface model's centre of mass is not known.
    """
    known = vars(model).get(_KEPT)
    if known is None:
        known = _of_star(model) if isinstance(model, AOModel) else _of_interface(model)
        vars(model)[_KEPT] = known
    return cast(ModalBody, known)


# Where a model keeps its modes: models do not change, and serve many impacts.
_KEPT = "_modal_body"


def _of_star(star: AOModel) -> ModalBody:
    modes = star_modes(copy.copy(star))  # not the model that will keep these: no cycle
    omega, push = modes.omega, modes.participation**2
    n = len(omega)
    if math.isinf(star.m0):
        still = np.zeros(n)
        return ModalBody(
            omega, None, np.ones((1, n)), np.zeros((1, n)), None, still, still, np.ones(n), None,
            np.ones(n), modes,
        )  # fmt: skip
    centre, centre_residual = modes.centre
    moving = push * star.k0 / omega**2 if star.k0 > 0.0 else np.where(omega == 0.0, 1.0, 0.0)
    # Its own weight acts on a star's coordinates by their share in the centre of mass; on a free
    # one's as a whole: exactly, or what falls side by side would press by rounding. What holds a
    # star given by numbers is not known, so neither is what its weight does to it.
    weight = np.zeros(n) if star.constrained else moving
    if star.constrained and not star.weightless:
        weight = star.mass * push * centre
    massless = modes.residual > 0.0
    return ModalBody(
        omega=omega,
        decay=None if star.damping is None else np.ascontiguousarray(star.damping.decay(omega)),
        shape=np.ones((1, n)),
        push=push[None, :],
        residual=np.array([[modes.residual]]) if massless else None,
        weight=weight,
        inertia=1.0 / push,
        centre=np.ascontiguousarray(centre),
        centre_residual=np.array([centre_residual * modes.residual]) if massless else None,
        moving=moving,
        modes=modes,
    )


def _of_interface(model: InterfaceModel) -> ModalBody:
    mass = model.mass
    if mass is None:
        raise InputError(
            "the mass of a body touched in several places is not known: make it with nodes"
        )
    centre = np.ascontiguousarray(model.centre_weights)
    damping = model.body.damping
    return ModalBody(
        omega=model.omega,
        decay=None if damping is None else np.ascontiguousarray(damping.decay(model.omega)),
        shape=np.ascontiguousarray(model.participation),
        push=np.ascontiguousarray(model.participation),
        residual=model.residual if model.residual.any() else None,
        weight=mass * centre,
        inertia=np.ones(model.n),
        centre=centre,
        centre_residual=None,
        moving=mass * centre,
        modes=model,
    )
