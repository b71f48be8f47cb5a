"""The generalized coordinates of a reduced model: what its body does by them, eq. (8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import FloatArray
from ..fem import Body

__all__ = ["GeneralizedCoordinates"]


@dataclass(frozen=True, eq=False)
class GeneralizedCoordinates:
    """X = basis q with mass q̈ + stiffness q = basisᵀ loads f.

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
