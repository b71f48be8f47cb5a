"""From a reduced model's few coordinates back to the whole body, with the correction they need.

X_r = λ₀ φ_st + Σ (λ_i - λ₀) Ψ_i, eq. (8), is only a part of the displacement. The rest responds to
the forces that the reduced motion leaves unbalanced, r = b F - K X_r - M Ẍ_r with the acceleration
Ẍ_r that F and the model's springs give:

    X = X_r + (K + s²M)⁻¹ r.

This is exact where everything grows as e^{st}. With s = 0 it is the textbooks' static correction,
with inertia relief for free bodies ("mode acceleration"; R. R. Craig and A. J. Kurdila,
Fundamentals of Structural Dynamics, 2nd ed., section 11.4), right if all omitted modes are fast.
But among the oscillators omitted for their small mass there are slow ones, and Krylov vectors
resolve slow modes last. These have no time to follow a contact of duration T, and K⁻¹ would
exaggerate them without bound. With s = 10/T they stay where they are, and fast ones follow as
before.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base import FloatArray
from ..fem import Body
from ..linalg import LinearSolver
from ..reduction import AOModel, InterfaceModel

__all__ = ["PACE", "Recovery", "Reduced", "reduced_interface", "reduced_star"]


# s T for a contact of duration T. Measured on beams struck at midspan and at the end, supported and
# free: between 3 and 20 errors hardly change, below they grow where slow modes are left out.
PACE = 10.0


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
        Forces on the dofs per unit of each of the forces f: the functionals b of the ports; under
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


@dataclass(frozen=True, eq=False)
class Recovery:
    """The map from a reduced model's coordinates and the forces on it to its body's displacement.

    It is linear and the same at all times, so rates q̇ and ḟ go the same way to velocities.

    Attributes
    ----------
    reduced : Reduced
    s : float
        Of the correction, rad/s; positive.
    """

    reduced: Reduced
    s: float

    def __getstate__(self) -> dict[str, Any]:
        # Factors cannot be pickled; they are made again where they are needed.
        return {"reduced": self.reduced, "s": self.s}

    @cached_property
    def _solver(self) -> LinearSolver:
        return self.reduced.body.inverse(self.s**2)

    @cached_property
    def _unbalanced(self) -> tuple[FloatArray, FloatArray]:
        """r per coordinate and per force, shapes (n_dofs, n), (n_dofs, p)."""
        body, reduced = self.reduced.body, self.reduced
        springs, push = reduced.accelerations
        inertia = body.M @ reduced.basis
        of_coordinates: FloatArray = -(body.K @ reduced.basis) - inertia @ springs
        of_forces = reduced.loads - inertia @ push
        # Weight on rigid modes that the model does not contain: their motion is `OmittedMotion`.
        rigid = body.rigid_modes
        return of_coordinates, of_forces - body.M @ (rigid @ (rigid.T @ of_forces))

    def solve(self, loads: FloatArray) -> FloatArray:
        """Return (K + s²M)⁻¹ loads, shape (n_dofs, m)."""
        return self._solver.solve(np.ascontiguousarray(loads))

    def displacement(self, coordinates: FloatArray, forces: FloatArray) -> FloatArray:
        """Return X on the free dofs, m.

        Parameters
        ----------
        coordinates : ndarray, shape (n, times)
        forces : ndarray, shape (p, times)
            On the ports, along their directions, N.

        Returns
        -------
        ndarray, shape (n_dofs, times)
        """
        if coordinates.shape[1] > sum(self._sizes):
            of_coordinates, of_forces = self._map
            return of_coordinates @ coordinates + of_forces @ forces
        return self._corrected(coordinates, forces)

    def functionals(self, rows: Any) -> tuple[FloatArray, FloatArray]:
        """Return how linear functions of X depend on coordinates and forces.

        Parameters
        ----------
        rows : scipy.sparse matrix, shape (m, n_dofs)

        Returns
        -------
        of_coordinates, of_forces : ndarrays, shapes (m, n), (m, p)
            rows @ X = of_coordinates @ q + of_forces @ f.
        """
        if rows.shape[0] > sum(self._sizes):
            of_coordinates, of_forces = self._map
            return rows @ of_coordinates, rows @ of_forces
        compliance = self._solver.solve(np.ascontiguousarray(rows.toarray().T)).T
        r_of_coordinates, r_of_forces = self._unbalanced
        of_coordinates = rows @ self.reduced.basis + compliance @ r_of_coordinates
        return of_coordinates, compliance @ r_of_forces

    @property
    def _sizes(self) -> tuple[int, int]:
        return self.reduced.n, self.reduced.loads.shape[1]

    @cached_property
    def _map(self) -> tuple[FloatArray, FloatArray]:
        """X per coordinate and per force, shapes (n_dofs, n), (n_dofs, p)."""
        n, p = self._sizes
        columns = self._corrected(np.eye(n, n + p), np.eye(p, n + p, k=n))
        return columns[:, :n], columns[:, n:]

    def _corrected(self, coordinates: FloatArray, forces: FloatArray) -> FloatArray:
        of_coordinates, of_forces = self._unbalanced
        left = of_coordinates @ coordinates + of_forces @ forces
        corrected: FloatArray = self.reduced.basis @ coordinates + self._solver.solve(left)
        return corrected


def reduced_star(star: AOModel, gravity: float = 0.0) -> Reduced:
    """Return an AO model of a body as motion of that body, eq. (8); q = λ, contact first.

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
