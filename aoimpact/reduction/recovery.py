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
from ..fem import FEModel
from ..linalg import ROUGH, SolverBook

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


class SharedSolutions:
    """Solutions that the recoveries of several models of a body share.

    Attributes
    ----------
    solver : SolverBook
        s² ↦ the solver of K + s²M.
    """

    def __init__(self, body: FEModel) -> None:
        self.solver = SolverBook(body.inverse)
        self._duals: dict[tuple[int, float], tuple[Any, FloatArray]] = {}

    def dual(self, rows: Any, s: float) -> FloatArray:
        """Return rows (K + s²M)⁻¹, the same for all models: rows that are kept are solved once."""
        key = id(rows), s
        if key not in self._duals:
            solve = self.solver(s**2).solve_roughly
            self._duals[key] = rows, np.stack([solve(row, SOLVED)[0] for row in rows.toarray()])
        return self._duals[key][1]


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
    shared : SharedSolutions or None
        Where several models of the body are compared.
    """

    model: Body
    loads: FloatArray
    s: float
    shared: SharedSolutions | None = None

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

    def functionals(self, rows: Any) -> ArrayPair:
        """Return how linear functions of X depend on coordinates and forces.

        Parameters
        ----------
        rows : scipy.sparse matrix, shape (m, n_dofs)

        Returns
        -------
        of_coordinates, of_forces : ndarrays, shapes (m, n), (m, p)
            rows @ X = of_coordinates @ q + of_forces @ f.
        """
        n, body = len(self.model.omega), self.model.body
        if self.shared is None:
            shapes, weights = self._correction
            added = (rows @ shapes) @ weights
        else:
            dual = self.shared.dual(rows, self.s)
            inertia = (body.M @ dual.T).T
            strained = (body.K @ dual.T).T @ self.basis
            parts = inertia @ self.basis, dual @ self.loads, inertia @ body.rigid_modes
            added = self._unbalanced(strained, *parts)
        found = rows @ self.basis + added
        return found[:, :n], found[:, n:]

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
        """
        body, loads, s2 = self.model.body, self.loads, self.s**2
        scale = np.sqrt(body.K.diagonal() + s2 * body.M.diagonal())[:, None]
        strained, inertia = body.K @ self.basis, body.M @ self.basis
        r = self._unbalanced(strained, inertia, loads, body.M @ body.rigid_modes)
        parts = strained + s2 * inertia
        parts[:, -loads.shape[1] :] += loads
        size = np.linalg.norm(parts / scale, axis=0)
        size[size == 0.0] = 1.0
        directions, weights = _directions(r / (scale * size))
        if not directions.size:
            return directions, weights
        solver = (
            body.inverse(s2, solutions=len(weights))
            if self.shared is None
            else self.shared.solver(s2)
        )
        shapes = [solver.solve_roughly(load, SOLVED)[0] for load in (scale * directions).T.copy()]
        return np.stack(shapes, axis=1), weights * size

    def _unbalanced(
        self, strained: FloatArray, inertia: FloatArray, loads: FloatArray, rigid: FloatArray
    ) -> FloatArray:
        """r per coordinate and force, (n_dofs, n + p), or what a matrix makes of it from the left.

        Parameters
        ----------
        strained, inertia : ndarrays, shape (n_dofs, n + p)
            K and M times the basis, or what the matrix makes of these,
        loads, rigid : ndarrays, shapes (n_dofs, p), (n_dofs, 0 … 6)
            and so of the loads, and of M times the rigid modes.
        """
        model, rigid_modes, n = self.model, self.model.body.rigid_modes, len(self.model.omega)
        push = model.modes.T @ self.loads
        # Rigid motions that the model does not contain: no force of its ports moves them.
        omitted = rigid_modes.T @ (self.loads - model.body.M @ (model.modes @ push))
        found = -strained
        found[:, :n] += inertia[:, :n] * model.omega**2
        found[:, n:] += loads - inertia[:, :n] @ push - rigid @ omitted
        return found


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
