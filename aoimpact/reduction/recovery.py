"""Displacement of the whole body from the coordinates of a reduced model, with a correction.

X_r = Σ q_j φ_j, eq. (8) in other coordinates, is only a part of the displacement. The rest is the
response to the forces that the reduced motion leaves unbalanced, r = b F - K X_r - M Ẍ_r with the
acceleration Ẍ_r due to F and the model's springs:

    X = X_r + (K + s²M)⁻¹ r.

The correction is exact for motions proportional to e^{st}. With s = 0 it is the standard static
correction, with inertia relief for free bodies ("mode acceleration"; R. R. Craig and A. J. Kurdila,
Fundamentals of Structural Dynamics, 2nd ed., section 11.4), which is accurate if all omitted modes
are fast. But some of the oscillators omitted for their small mass are slow, and Krylov vectors
resolve slow modes last. Slow modes hardly respond during a contact of duration T, and K⁻¹ would
exaggerate them without bound. With s = 10/T slow modes stay at rest, and fast modes follow
statically. On beams struck at midspan and at the end, supported and free, errors hardly change for
products s T between 3 and 20; below 3, they grow if the model leaves slow modes out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import ArrayPair, FloatArray
from ..linalg import ROUGH

if TYPE_CHECKING:
    from .body import Body

# Relative residual ‖f - A x‖ / ‖f‖ to which an iterative solver computes a correction or a static
# mode. Relative errors of stresses in a disc, a plate, a bracket and a flange, 20 mm from the
# contact, are then at most 2e-7 (4e-8 with 1e-6). With static modes solved to 1e-6, models of a
# clamped plate of up to 180 vectors have the same errors.
SOLVED = 1e-4

# Largest unbalanced force, relative to its parts, that is left uncorrected. Vectors found by
# approximate solutions leave such a force each, all in different directions; exact solutions leave
# one direction for each load, and rounding errors of 1e-12. Without a correction of such forces a
# probe is five times as fast. This causes relative errors of at most 9e-5 (3e-5 with a third of
# this limit) in stresses of the bodies named at SOLVED and of a beam, for 9 … 67 oscillators.
_BALANCED = ROUGH


@dataclass(frozen=True, eq=False)
class Recovery:
    """The map from a reduced model's coordinates and the forces on it to its body's displacement.

    The map is linear and constant, so that it also maps the rates q̇ and ḟ to velocities.

    Attributes
    ----------
    model : Body
    loads : ndarray, shape (n_dofs, p)
        Forces on the dofs per unit of each force f; see `Body.loads`.
    s : float
        Frequency of the correction, rad/s; positive.
    """

    model: Body
    loads: FloatArray
    s: float

    def __getstate__(self) -> dict[str, Any]:
        # Caches are dropped, as they are cheap to recompute.
        return {"model": self.model, "loads": self.loads, "s": self.s}

    def displacement(self, coordinates: FloatArray, forces: FloatArray) -> FloatArray:
        """Return the displacement X of the free dofs, m.

        Parameters
        ----------
        coordinates : ndarray, shape (n, times)
            Modal coordinates q.
        forces : ndarray, shape (p, times)
            Forces on the ports, along their directions, N.

        Returns
        -------
        ndarray, shape (n_dofs, times)
        """
        found: FloatArray = self.basis @ np.vstack([coordinates, forces])
        found += self.shapes @ self.amounts(coordinates, forces)
        return found

    @cached_property
    def basis(self) -> FloatArray:
        """Displacements per unit coordinate, and immediate ones per unit force, (n_dofs, n + p)."""
        at_once = np.zeros_like(self.loads)
        if (following := self.model.following) is not None:
            at_once[:, : following.shape[1]] = following
        return np.hstack([self.model.modes, at_once])

    @property
    def shapes(self) -> FloatArray:
        """Displacements that the correction is a combination of, (n_dofs, k)."""
        return self._correction[0]

    def amounts(self, coordinates: FloatArray, forces: FloatArray) -> FloatArray:
        """Return the coefficients of the correction on `shapes`, (k, times)."""
        amounts: FloatArray = self._correction[1] @ np.vstack([coordinates, forces])
        return amounts

    @cached_property
    def _correction(self) -> ArrayPair:
        """Correction (K + s²M)⁻¹ r per unit q and force: shapes (n_dofs, k), weights (k, n + p).

        Unbalanced forces r are orthogonal to the model's shapes. With any number of
        anti-oscillators or Krylov vectors, r has only one direction for each force, since K times
        their space lies in the span of M times that space and the loads. One solution for each
        force is therefore sufficient.

        Models of refined bodies need no correction: their vectors contain the response to r.
        """
        body, loads, s2 = self.model.body, self.loads, self.s**2
        if body.coarse is not None:
            return np.zeros((body.n_dofs, 0)), np.zeros((0, self.basis.shape[1]))
        scale = np.sqrt(body.K.diagonal() + s2 * body.M.diagonal())[:, None]
        strained, inertia = body.K @ self.basis, body.M @ self.basis
        model, n = self.model, len(self.model.omega)
        push = model.modes.T @ loads
        # The loads, such as the weight, also act on rigid motions that the model does not contain.
        omitted = body.rigid_modes.T @ (loads - inertia[:, :n] @ push)
        r = -strained
        r[:, :n] += inertia[:, :n] * model.omega**2
        r[:, n:] += loads - inertia[:, :n] @ push - body.M @ (body.rigid_modes @ omitted)
        parts = strained + s2 * inertia
        parts[:, -loads.shape[1] :] += loads
        size = np.linalg.norm(parts / scale, axis=0)
        size[size == 0.0] = 1.0
        directions, weights = _directions(r / (scale * size))
        if not directions.size:
            return directions, weights
        solver = body.inverse(s2, solutions=len(weights))
        shapes = [solver.solve_roughly(load, SOLVED)[0] for load in (scale * directions).T.copy()]
        return np.stack(shapes, axis=1), weights * size


def _directions(columns: FloatArray) -> ArrayPair:
    """Return an orthonormal basis of the span of columns, (n, k), and their coordinates, (k, m).

    The method is a QR factorisation with column pivoting by Gram-Schmidt. The method ends when the
    remainders of all columns are negligible.
    """
    directions, weights = [], []
    while (sizes := np.linalg.norm(columns, axis=0)).max(initial=0.0) > _BALANCED:
        direction = columns[:, sizes.argmax()] / sizes.max()
        directions.append(direction)
        weights.append(direction @ columns)
        columns = columns - np.outer(direction, weights[-1])
    n, m = columns.shape
    return np.array(directions).reshape(-1, n).T.copy(), np.array(weights).reshape(-1, m)
