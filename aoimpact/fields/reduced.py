"""A reduced model as motion of its body: shapes, and what accelerates them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import FloatArray
from ..fem import Body
from ..reduction import AOModel, InterfaceModel

__all__ = ["Reduced", "reduced_interface", "reduced_star"]


@dataclass(frozen=True, eq=False)
class Reduced:
    """X_r = basis q with mass q̈ + stiffness q = basisᵀ loads f.

    Attributes
    ----------
    body : FEModel
    basis : ndarray, shape (n_dofs, n)
    mass : ndarray, shape (n,)
        Diagonal; may have zeros, whose coordinates have no inertia.
    stiffness : ndarray, shape (n, n)
    loads : ndarray, shape (n_dofs, p)
        What each of the forces f, N, does to the dofs: the functionals b of the ports; under
        gravity the weight, N, after them.
    """

    body: Body
    basis: FloatArray
    mass: FloatArray
    stiffness: FloatArray
    loads: FloatArray

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.mass)

    @property
    def accelerations(self) -> tuple[FloatArray, FloatArray]:
        """q̈ of the coordinates, shape (n, n), and of the forces, (n, p), without damping."""
        with np.errstate(divide="ignore"):
            inverse = np.where(self.mass > 0.0, 1.0 / self.mass, 0.0)[:, None]
        return -inverse * self.stiffness, inverse * (self.basis.T @ self.loads)


def reduced_star(star: AOModel, gravity: float = 0.0) -> Reduced:
    """Return a star made from a body as motion of that body, eq. (8); q = λ, contact first.

    Parameters
    ----------
    star : AOModel
    gravity : float, optional
        m/s², along the direction of travel.
    """
    origin = star.origin
    assert origin is not None
    loads = origin.tip.b[:, None]
    if gravity:
        weight = np.zeros_like(origin.centre) if star.weightless else origin.mass * origin.centre
        loads = np.column_stack([loads, gravity * weight])
    stiffness = np.diag(np.concatenate([[star.k0 + star.k.sum()], star.k]))
    stiffness[0, 1:] = stiffness[1:, 0] = -star.k
    basis = np.column_stack([origin.static_mode - origin.shapes.sum(axis=1), origin.shapes])
    mass = np.concatenate([[star.m0], star.m])
    return Reduced(origin.tip.body, basis, mass, stiffness, loads)


def reduced_interface(model: InterfaceModel, gravity: float = 0.0) -> Reduced:
    """Return a model with several ports as motion of its body; q are its modes.

    Parameters
    ----------
    model : InterfaceModel
    gravity : float, optional
        m/s², along the direction of travel.
    """
    loads = np.stack([tip.b for tip in model.tips], axis=1)
    direction = model.tips[0].direction
    if gravity and direction is not None and model.mass is not None:
        weight = gravity * model.mass * model.body.com_functional(direction)
        loads = np.column_stack([loads, weight])
    return Reduced(model.body, model.modes, np.ones(model.n), np.diag(model.omega**2), loads)
