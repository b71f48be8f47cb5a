"""Static displacements of a body, its motion as a whole, and the forces of its supports.

Reactions follow from the principle of virtual work. If the ground under some nodes moves by a
virtual displacement φ_c, the body follows statically by φ with K φ = 0 on the free dofs. For any
motion X under forces f, the generalised reaction of the ground along φ_c is

    R = φᵀM Ẍ - φᵀf.

This needs no K X: R follows from accelerations weighted by a smooth field (mode acceleration; R. R.
Craig and A. J. Kurdila, *Fundamentals of Structural Dynamics*, section 11.4). If the whole ground
moves as one, φ is a rigid translation and R changes the body's momentum.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import scipy

from ..base import PRINTED, ArrayPair, FloatArray, InputError, IntArray, SingularError, record, sp
from ..linalg import SOLVERS, LinearSolver, linear_solver
from ..mesh import motions_at
from .model import FEModel
from .supports import selected_nodes

# Ratio of s² in K + s²M to ΣK_ii / ΣM_ii, which is about the highest ω². This s² is below ω₁² for
# all but the longest bodies, and large enough that K + s²M is not singular by rounding.
_NEAR_K = 1e-9

# Largest ratio of successive corrections in iterative refinement. Above it, the corrections are
# rounding errors or, unless they are small, some elastic ω² is not far above s².
_SLOW = 0.5


def near_static(body: FEModel) -> float:
    """Return a small s², (rad/s)², for which K + s²M is regular and nearly equal to K."""
    return _NEAR_K * float(body.K.diagonal().sum() / body.M.diagonal().sum())


def displacement(
    body: FEModel,
    b: FloatArray,
    invert: Callable[[float], LinearSolver],
    *,
    tolerance: float | None = None,
) -> FloatArray:
    """Return the static displacement x = K⁻¹ b, shape (n_dofs,).

    For a body with rigid modes, x is M-orthogonal to the modes; b must not excite them.

    Parameters
    ----------
    body : FEModel
    b : ndarray, shape (n_dofs,)
        Load.
    invert : callable
        Function s² ↦ solver of K + s²M.
    tolerance : float, optional
        Sufficient ‖b - K x‖ / ‖b‖ for a body without rigid modes; see `LinearSolver`.
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
    # Iterative refinement: each pass multiplies the error by at most s²/(ω₁² + s²).
    near_k = invert(near_static(body))
    x, before = np.zeros_like(b), np.inf
    while True:
        change = near_k.solve(b - K @ x)
        change -= rigid @ (rigid.T @ (M @ change))
        x += change
        length = np.linalg.norm(x)
        if length == 0.0:  # the load is zero
            return x
        size = float(np.linalg.norm(change) / length)
        if not np.finfo(float).eps < size <= _SLOW * before:  # true for nan as well
            return x if size <= PRINTED else _by_grounding(body, b, near_k)
        before = size


def _by_grounding(body: FEModel, b: FloatArray, solver: LinearSolver) -> FloatArray:
    """Return K⁻¹ b, shape (n_dofs,), of a body with rigid modes, after grounding it by springs.

    There is one spring per rigid mode. Under a load that does not excite rigid modes, such springs
    carry no force and determine only the rigid part of x. The method is that of `solver`, which
    solves K + s²M.
    """
    K, M, rigid = body.K, body.M, body.rigid_modes
    places = scipy.linalg.qr(rigid.T, mode="r", pivoting=True)[1][: rigid.shape[1]]
    springs = np.zeros(len(b))
    springs[places] = K.diagonal()[places]
    pencil = replace(solver.pencil, K=(K + sp.diags_array(springs)).tocsr(), s2=0.0)
    grounded = linear_solver(pencil, solver.name if solver.name in SOLVERS else "auto")
    x = grounded.solve(b - M @ (rigid @ (rigid.T @ b)))
    return np.asarray(x - rigid @ (rigid.T @ (M @ x)))


def whole_motion(model: FEModel) -> ArrayPair:
    """Return functionals from nodal velocities to rigid-body velocities, and M times rigid motions.

    Returns
    -------
    functionals : ndarray, shape (6, n_dofs)
        Rows for the velocity of the centre of mass, and for the angular velocity of a rigid body
        with the same angular momentum; the latter are NaN for a supported body.
    momenta : ndarray, shape (n_dofs, 6)
        M times unit translations and, for an unsupported body, unit rotations about its centre; 0
        otherwise.
    """
    # Added shape functions of a finer body have no positions: use the nodes of `given`.
    body: Any = model if model.shapes is model.mesh else model.given
    centre = np.array([model.com_functional(axis) for axis in np.eye(3)])
    functionals, momenta = np.full((6, model.n_dofs), np.nan), np.zeros((model.n_dofs, 6))
    functionals[:3], momenta[:, :3] = centre, model.mass * centre.T
    if len(body.free) == body.nodes.size and body.springs is None:
        middle = centre @ model.appended(body.on_dofs(body.nodes))
        turned = model.appended(motions_at(body.nodes - middle).reshape(-1, 6)[body.free, 3:])
        momenta[:, 3:] = model.M @ turned
        functionals[3:] = np.linalg.solve(turned.T @ momenta[:, 3:], momenta[:, 3:].T)
    return functionals, momenta


@record
class VirtualMotion:
    """Static displacements φ of a body for m motions of the ground.

    Attributes
    ----------
    ground : ndarray, shape (held, m)
        Displacements of the constrained dofs.
    springs : ndarray, shape (n_dofs, m)
        Forces, N: spring stiffness times the displacement of the ground under the spring.
    phi, inertia : ndarrays, shape (n_dofs, m)
        φ and M φ on the free dofs.
    weight : ndarray, shape (m, 3)
        Sum of φᵀM a over the constrained dofs, for unit accelerations a along x, y and z, kg.
    """

    ground: FloatArray
    springs: FloatArray
    phi: FloatArray
    inertia: FloatArray
    weight: FloatArray


class Grounding:
    """Supports of a body, and its springs to the ground.

    Attributes
    ----------
    body : FEModel
    held : ndarray of int, shape (held,)
        Constrained dofs: displacements 3·node + component, then rotations, if any.
    K : scipy.sparse array, shape (held, n_dofs)
        Rows of K for the constrained dofs, columns for the free dofs.
    M : scipy.sparse array, shape (held, all)
        Rows of M for the constrained dofs, columns for all dofs.

    Raises
    ------
    InputError
        If the body was given by K and M, which lack the rows of constrained dofs.
    """

    def __init__(self, body: Any) -> None:
        if not body.assembled:
            why = "reactions need the rows of K and M of the supports, which this body lacks"
            raise InputError(f"{why}: make it with FEModel.from_mesh(mesh, material, fixed=...)")
        self.body = body
        self.held, K, M = body.held
        if body.masses is not None:
            M = M + body.masses[:, self.held]
        self.K = sp.csr_array(K[body.free].T)
        self.M = sp.csr_array(M.T)

    def nodes(self, name: str, selector: Any) -> IntArray:
        """Return the nodes held by supports or springs, restricted to a selector unless it is None.

        Raises
        ------
        InputError, InputTypeError
            If there is no such node, or the selector selects no node.
        """
        body, springs = self.body.given, self.body.given.springs
        sprung = np.empty(0, np.int64) if springs is None else body.free[np.flatnonzero(springs)]
        grounded = np.union1d(body.held[0], sprung) // 3 % len(body.nodes)
        if selector is not None:
            sets = body.mesh.node_sets
            chosen = selected_nodes(name, selector, body.nodes, sets, body.node_labels)
            grounded = np.intersect1d(grounded, chosen)
        if not len(grounded):
            of = "of the body" if selector is None else f"of {name}={selector!r}"
            raise InputError(f"no node {of} is held: give the nodes of fixed= or springs=")
        return np.unique(grounded)

    def resultants(self, nodes: IntArray, centre: FloatArray) -> FloatArray:
        """Return unit translations of the nodes, and rotations about a centre, (all dofs, 6)."""
        places = self.body.given.nodes
        motions = np.zeros((2, *places.shape, 6))
        moved = motions_at(places[nodes] - centre, rotations=True)
        motions[:, nodes] = moved.reshape(2, -1, 3, 6)
        every = np.stack([self.body.carried(of) for of in motions])
        return every.reshape(-1, 6)[: self.M.shape[1]]

    def virtual(self, motions: FloatArray) -> VirtualMotion:
        """Return the body's static displacements for `motions` of the ground, (all dofs, m)."""
        body = self.body
        axes = self.resultants(np.arange(len(body.given.nodes)), np.zeros(3))[:, :3]
        ground = motions[self.held]
        springs = np.zeros((len(body.free), motions.shape[1]))
        if body.springs is not None:
            springs = body.springs[:, None] * motions[body.free]
        loads = springs - self.K.T @ ground
        phi = np.zeros_like(loads)
        for load, column in zip(loads.T, phi.T, strict=True):
            if load.any():
                column[:] = displacement(body, load.copy(), body.inverse)
        inertia = body.M @ phi + (self.M[:, body.free].T @ ground)
        return VirtualMotion(ground, springs, phi, inertia, ground.T @ (self.M @ axes))
