"""Static displacements of a body, and its motion as a whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy
import scipy.sparse as sp

from ..base import FloatArray, SingularError
from ..linalg import SOLVERS, LinearSolver, linear_solver
from ..mesh import motions_at
from .model import FEModel

# s² of a nearly static K + s²M, as a share of the mean of K_ii over that of M_ii, which is near the
# highest ω²: below ω₁² of all but the longest bodies, and above what rounding takes for a singular
# matrix.
_NEAR_K = 1e-9

# A pass that leaves more than this of the last change shows motions too soft for passes.
_SLOW = 0.5

# Passes end when the change relative to the solution is below the first value, or below the second
# and above the third times the last change.
_AT_ROUNDING, _NEAR_ROUNDING, _STALLED = 1e-14, 1e-10, 0.9


def near_static(body: FEModel) -> float:
    """Return s² of a K + s²M that has factors and is as good as K, (rad/s)²."""
    return _NEAR_K * float(body.K.diagonal().sum() / body.M.diagonal().sum())


def displacement(
    body: FEModel,
    b: FloatArray,
    invert: Callable[[float], LinearSolver],
    *,
    tolerance: float | None = None,
) -> FloatArray:
    """Return K⁻¹ b; with rigid modes that b does not move, the one M-orthogonal to them.

    Parameters
    ----------
    body : FEModel
    b : ndarray, shape (n_dofs,)
    invert : callable
        s² ↦ the solver of K + s²M.
    tolerance : float, optional
        ‖b - K x‖ / ‖b‖ that will do, of a body without rigid modes: see `LinearSolver`.
    """
    K, M, rigid = body.K, body.M, body.rigid_modes
    if rigid.shape[1] == 0:
        try:
            solver = invert(0.0)
            return solver.solve(b) if tolerance is None else solver.solve_roughly(b, tolerance)[0]
        except SingularError as error:
            raise SingularError(
                f"{error}, though the body has no rigid motion left: part of it is a mechanism "
                "(a piece not connected, an element without stiffness), or K has too few digits; "
                "see body.frequencies(10)"
            ) from None
    # Each pass leaves s²/(ω₁² + s²) of the error.
    near_k = invert(near_static(body))
    x, before = np.zeros_like(b), np.inf
    while True:
        change = near_k.solve(b - K @ x)
        change -= rigid @ (rigid.T @ (M @ change))
        x += change
        length = np.linalg.norm(x)
        if length == 0.0:  # without a load
            return x
        size = float(np.linalg.norm(change) / length)
        if size <= _AT_ROUNDING or (size <= _NEAR_ROUNDING and size > _STALLED * before):
            return x
        if not size <= _SLOW * before:  # nan, too
            return _by_grounding(body, b, near_k)
        before = size


def _by_grounding(body: FEModel, b: FloatArray, solver: LinearSolver) -> FloatArray:
    """Return K⁻¹ b, shape (n_dofs,), of a partly free body grounded by springs in its free motions.

    `solver` is one of its K + s²M: the same kind factorises K. At no more places than there are
    such motions the springs take no force, for a b that does not move the body as a whole, and
    change nothing but where it is.
    """
    K, M, rigid = body.K, body.M, body.rigid_modes
    places = scipy.linalg.qr(rigid.T, mode="r", pivoting=True)[1][: rigid.shape[1]]
    springs = np.zeros(len(b))
    springs[places] = K.diagonal()[places]
    pencil = replace(solver.pencil, K=(K + sp.diags_array(springs)).tocsr(), s2=0.0)
    grounded = linear_solver(pencil, solver.name if solver.name in SOLVERS else "auto")
    x = grounded.solve(b - M @ (rigid @ (rigid.T @ b)))
    return np.asarray(x - rigid @ (rigid.T @ (M @ x)))


def whole_motion(body: FEModel) -> tuple[FloatArray, FloatArray]:
    """Return the functionals of a body's motion as a whole, and the momenta that make it.

    Returns
    -------
    functionals : ndarray, shape (6, n_dofs)
        Rows of the velocity of the centre of mass and of the mean spin, which has the body's
        angular momentum; spin is NaN where supports take that up.
    momenta : ndarray, shape (n_dofs, 6)
        M times unit translations and, of an unsupported body, unit rotations about its centre.
    """
    assert body.nodes is not None
    assert body.free is not None
    assert body.mass is not None
    centre = np.array([body.com_functional(axis) for axis in np.eye(3)])
    functionals, momenta = np.full((6, body.n_dofs), np.nan), np.zeros((body.n_dofs, 6))
    functionals[:3], momenta[:, :3] = centre, body.mass * centre.T
    if len(body.free) == body.nodes.size and body.springs is None:
        middle = centre @ body.on_dofs(body.nodes)
        turned = motions_at(body.nodes - middle).reshape(-1, 6)[body.free, 3:]
        momenta[:, 3:] = body.M @ turned
        functionals[3:] = np.linalg.solve(turned.T @ momenta[:, 3:], momenta[:, 3:].T)
    return functionals, momenta
