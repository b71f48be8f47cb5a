"""Static displacements of a body, its motion as a whole, and the forces of its supports.

The ground under some nodes is moved by a virtual displacement φ_c, and the body follows by its
statics, K φ = 0 on the free dofs. The virtual work of all forces on the body vanishes, so that what
the ground does along φ_c is, of any motion X under forces f,

    R = φᵀM Ẍ - φᵀf,

without K X: R is found from accelerations that are weighted by a smooth field (mode acceleration;
R. R. Craig and A. J. Kurdila, *Fundamentals of Structural Dynamics*, section 11.4). Moving all of
the ground as one moves the body as one, φ = g, and R is what changes its momentum.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import scipy

from ..base import ArrayPair, FloatArray, InputError, IntArray, SingularError, record, sp
from ..linalg import SOLVERS, LinearSolver, linear_solver
from ..mesh import motions_at
from .model import FEModel
from .supports import selected_nodes

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


def whole_motion(model: FEModel) -> ArrayPair:
    """Return the functionals of a body's motion as a whole, and the momenta that make it.

    Returns
    -------
    functionals : ndarray, shape (6, n_dofs)
        Rows of the velocity of the centre of mass and of the mean spin, which has the body's
        angular momentum; spin is NaN where supports take that up.
    momenta : ndarray, shape (n_dofs, 6)
        M times unit translations and, of an unsupported body, unit rotations about its centre.
    """
    # Nodes of added functions are no places.
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
    """The body's static displacement where the ground moves, for m motions of the ground.

    Attributes
    ----------
    ground : ndarray, shape (held, m)
        On the constrained dofs.
    springs : ndarray, shape (n_dofs, m)
        Motions of the ground under the springs, times their stiffness, N/m.
    phi, inertia : ndarrays, shape (n_dofs, m)
        The free dofs that follow, and M φ there.
    weight : ndarray, shape (m, 3)
        Work of the constrained dofs' own inertia in unit accelerations along x, y and z, kg.
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
        Constrained dofs, 3·node + component; rotations, where there are any, after all of these.
    K : scipy.sparse array, shape (held, n_dofs)
        Rows of K of these, over the free dofs.
    M : scipy.sparse array, shape (held, all)
        Rows of M, over all dofs, whose number is its width.

    Raises
    ------
    InputError
        If the body was given by K and M, from which the rows of the supports are missing.
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
        """Return the selected nodes that a support or a spring holds; all such without a selector.

        Raises
        ------
        InputError, InputTypeError
            If there is none, or the selector selects no node.
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
        """Return the ground's translations and rotations about a centre, shape (all dofs, 6)."""
        places = self.body.given.nodes
        motions = np.zeros((2, *places.shape, 6))
        moved = motions_at(places[nodes] - centre, rotations=True)
        motions[:, nodes] = moved.reshape(2, -1, 3, 6)
        every = np.stack([self.body.carried(of) for of in motions])
        return every.reshape(-1, 6)[: self.M.shape[1]]

    def virtual(self, motions: FloatArray) -> VirtualMotion:
        """Return how the body follows motions of the ground, shape (all dofs, m)."""
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
