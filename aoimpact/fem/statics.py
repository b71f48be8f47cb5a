"""The static mode of a body at its contact: eqs. (1)-(3) and (11) of the paper."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
import scipy.sparse as sp

from ..base import FloatArray, InputTypeError, SingularError
from ..linalg import SOLVERS, LinearSolver, linear_solver
from ..mesh import motions_at
from .contact import ContactPoint
from .contacttime import near_static
from .model import FEModel

# rᵀb/|r||b| of a motion r that b moves. Less is rounding: beside springs to the ground that are
# just distinguished from none (1e-9 of the diagonal of K) motions are known to some 1e-16/1e-9.
_MOVED = 1e-7

# Rounding of a null space: deviation of a motion that is 0 or 1 everywhere.
_AS_ONE = 1e-6

# A pass that leaves more than this of the last change shows motions too soft for passes.
_SLOW = 0.5

# Passes end when the change relative to the solution is below the first value, or below the second
# and above the third times the last change.
_AT_ROUNDING, _NEAR_ROUNDING, _STALLED = 1e-14, 1e-10, 0.9


@dataclass(frozen=True, eq=False)
class StaticMode:
    """The static mode of a body at a contact functional, eqs. (1)-(3), (11).

    Attributes
    ----------
    phi : ndarray, shape (n_dofs,)
        φ_st with bᵀφ_st = 1.
    k0 : float
        φ_stᵀ K φ_st, N/m; exactly 0 where b moves the body rigidly.
    m_phi : ndarray, shape (n_dofs,)
        M φ_st.
    mass : float
        m_st = φ_stᵀ M φ_st, kg.
    unobservable : ndarray, shape (n_dofs, r)
        The M-orthonormal rigid motions that do not move the contact point.
    """

    phi: FloatArray
    k0: float
    m_phi: FloatArray
    mass: float
    unobservable: FloatArray


def static_mode(
    tip: ContactPoint, *, invert: Callable[[float], LinearSolver] | None = None
) -> StaticMode:
    """Return the static mode; for a body that b can move rigidly, that rigid motion.

    Parameters
    ----------
    tip : ContactPoint
    invert : callable, optional
        s² ↦ the solver of K + s²M of its body; `FEModel.inverse` if left out.

    Raises
    ------
    SingularError
        If K is singular though the body has no rigid motion: a mechanism.
    """
    if not isinstance(tip, ContactPoint):
        raise InputTypeError(f"tip must come from FEModel.contact(...), got {tip!r}")
    rigid, b = tip.body.rigid_modes, tip.b
    reach = rigid.T @ b
    if moves_rigidly(tip):
        phi, k0 = rigid @ reach / (reach @ reach), 0.0
        rigid = rigid @ scipy.linalg.qr(reach[:, None])[0][:, 1:]
    else:
        phi = displacement(tip.body, b, invert or tip.body.inverse)
        k0 = 1.0 / float(b @ phi)
        phi = k0 * phi
    m_phi = tip.body.M @ phi
    return StaticMode(phi, k0, m_phi, float(phi @ m_phi), rigid)


def moves_rigidly(tip: ContactPoint) -> bool:
    """True if a force at the contact moves the body as a whole: for that force it is free."""
    rigid = tip.body.rigid_modes
    reach = float(np.linalg.norm(rigid.T @ tip.b))
    return reach > _MOVED * float(np.linalg.norm(tip.b) * np.linalg.norm(rigid))


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
    pencil = replace(solver.pencil, K=(K + sp.diags_array(springs)).tocsr(), s2=0.0, diagonals=None)
    grounded = linear_solver(pencil, solver.name if solver.name in SOLVERS else "auto")
    x = grounded.solve(b - M @ (rigid @ (rigid.T @ b)))
    found: FloatArray = x - rigid @ (rigid.T @ (M @ x))
    return found


def centre_of(tip: ContactPoint, phi: Callable[[], FloatArray]) -> tuple[FloatArray, float, bool]:
    """Return the centre of mass's functional, the body's mass, kg, and whether these are right.

    Without nodes, the mean over the static mode stands for the centre, and its mass for
    the body's. That is right if the mode is a translation: all that moves moves as the contact.

    Parameters
    ----------
    tip : ContactPoint
    phi : callable
        Returns φ_st, shape (n_dofs,).
    """
    if tip.direction is not None and tip.body.mass is not None:
        return tip.body.com_functional(tip.direction), tip.body.mass, True
    static = phi()
    momentum = tip.body.M @ static
    mass = float(static @ momentum)
    as_one = bool((np.abs(static * (1.0 - static)) <= _AS_ONE).all())
    return momentum / mass, mass, as_one


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


def refuse_mechanism(tips: Sequence[ContactPoint]) -> None:
    """Refuse contact points from which part of their body is a mechanism.

    A mechanism that no force there moves is accepted: its motion takes no part in the response.

    Raises
    ------
    SingularError
    """
    mechanism = tips[0].body.mechanism
    if mechanism is None:
        return
    for tip in tips:
        if mechanism.moved_by(tip.b):
            raise SingularError(
                "part of the body is a mechanism that the contact moves without any elastic force: "
                f"{mechanism.where(tip.b)}; join the parts by whole sides of elements (merge the "
                "nodes of both), or hold them by supports"
            )
