"""From a model's few modes back to the whole body, with the correction that they need.

X_r = Σ q_j φ_j, eq. (8) in other coordinates, is only a part of the displacement. The rest responds
to the forces that the reduced motion leaves unbalanced, r = b F - K X_r - M Ẍ_r with the
acceleration Ẍ_r that F and the model's springs give:

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
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import ArrayPair, FloatArray
from ..linalg import ROUGH

if TYPE_CHECKING:
    from .body import Body

# s T for a contact of duration T. Measured on beams struck at midspan and at the end, supported and
# free: between 3 and 20 errors hardly change, below they grow where slow modes are left out.
PACE = 10.0

# ‖f - A x‖ / ‖f‖ of a correction by a solver that iterates: stresses of a disc, a plate, a bracket
# and a flange, 20 mm from where they are struck, are off by 4e-8 at most (2e-7 with 1e-4).
SOLVED = 1e-6

# Unbalanced force, over its parts, up to which it is not corrected. Rough solutions leave each
# vector that much, in a direction of its own; without them one direction for each force stands out,
# and rounding leaves 1e-12. Those stresses, and a beam's, are off by 9e-5 at most for it (models of
# 9 … 67 oscillators; 3e-5 with a third of it), and a probe takes a fifth of the time.
_BALANCED = ROUGH


@dataclass(frozen=True, eq=False)
class Recovery:
    """The map from a reduced model's coordinates and the forces on it to its body's displacement.

    It is linear and the same at all times, so rates q̇ and ḟ go the same way to velocities.

    Attributes
    ----------
    model : Body
    loads : ndarray, shape (n_dofs, p)
        Forces on the dofs per unit of each of the forces f: see `Body.loads`.
    s : float
        Frequency of the correction, rad/s; positive.
    """

    model: Body
    loads: FloatArray
    s: float

    def __getstate__(self) -> dict[str, Any]:
        # Do not pickle what is cheap to recompute.
        return {"model": self.model, "loads": self.loads, "s": self.s}

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
        found: FloatArray = self.basis @ np.vstack([coordinates, forces])
        found += self.shapes @ self.amounts(coordinates, forces)
        return found

    @cached_property
    def basis(self) -> FloatArray:
        """Displacement by coordinates, and at once by forces, shape (n_dofs, n + p)."""
        at_once = np.zeros_like(self.loads)
        if (following := self.model.following) is not None:
            at_once[:, : following.shape[1]] = following
        return np.hstack([self.model.modes, at_once])

    @property
    def shapes(self) -> FloatArray:
        """The few shapes that the correction is made of, (n_dofs, k)."""
        return self._correction[0]

    def amounts(self, coordinates: FloatArray, forces: FloatArray) -> FloatArray:
        """How much of each of the `shapes` the correction adds, (k, times)."""
        amounts: FloatArray = self._correction[1] @ np.vstack([coordinates, forces])
        return amounts

    @cached_property
    def _correction(self) -> ArrayPair:
        """(K + s²M)⁻¹ r per coordinate and force, as shapes (n_dofs, k) times weights (k, n + p).

        Unbalanced forces are orthogonal to the model's shapes. Anti-oscillators and Krylov vectors
        leave only one direction of it for each force, however many they are: K times their space
        lies in M times it and the loads. So one solution for each force serves all.

        The models of finer bodies have what is corrected among their vectors.
        """
        body, loads, s2 = self.model.body, self.loads, self.s**2
        if body.coarse is not None:
            return np.zeros((body.n_dofs, 0)), np.zeros((0, self.basis.shape[1]))
        scale = np.sqrt(body.K.diagonal() + s2 * body.M.diagonal())[:, None]
        strained, inertia = body.K @ self.basis, body.M @ self.basis
        model, n = self.model, len(self.model.omega)
        push = model.modes.T @ loads
        # Rigid motions that the model does not contain: no force of its ports moves them.
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
    """The few directions that columns have, orthonormal, (n, k), and the columns on them, (k, m).

    By Gram and Schmidt, the largest of what is left of the columns first, as in a QR factorisation
    with pivoting, but only as far as anything is left.
    """
    directions, weights = [], []
    while (sizes := np.linalg.norm(columns, axis=0)).max(initial=0.0) > _BALANCED:
        direction = columns[:, sizes.argmax()] / sizes.max()
        directions.append(direction)
        weights.append(direction @ columns)
        columns = columns - np.outer(direction, weights[-1])
    n, m = columns.shape
    return np.array(directions).reshape(-1, n).T.copy(), np.array(weights).reshape(-1, m)
