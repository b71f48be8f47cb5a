"""K⁻¹ b by the factors of K + s²M: a held body's static mode without a factorisation of K.

Conjugate gradients preconditioned by (K + s²M)⁻¹ find at once all that is stiff beside s²M, and the
motions slower than s one after the other: few in compact bodies, many in slender ones. Those are
smooth. On elements of second order the linear ones on their corners, some tenth of the work to
factorise, take nearly all of them away.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray, SingularError
from ..linalg import (
    QUADRATIC,
    LinearSolver,
    check_condition,
    corner_interpolation,
    factorize,
    pardiso,
    solutions_worth,
)
from ..mesh import Mesh
from .contact import Body

__all__ = ["static_by_dynamic"]

Operator = Callable[[FloatArray], FloatArray]

# ‖b - Kx‖/‖b‖ in the end. The error of bᵀx goes with its square: 4e-9 at most of what was measured
# (a plate; compact bodies 4e-13), and 5e-10 of a slender one is rounding of K itself.
_REACHED = 1e-6

# With the corners, where no slow motion can hide, it is also enough that the energy of the error is
# this share of the whole (bars were at 7e-11 or less, x itself at 3e-7); and the residual this.
_ENERGY, _RESIDUAL = 1e-10, 1e-2

# Steps after which a compact body's residual is below that, and steps from there to the end.
_FIRST, _PROMISING, _LAST = 2, 0.1, 6

# Steps without the corners: so many, and this share of what a factorisation is worth. With them a
# step costs about two solutions; a factorisation is worth trying for as much as it costs itself.
# Bars on their corners, and plates of elements that are not long, are promising after three.
_FEW, _SHARE, _SHARE_WITH_CORNERS, _AT_LEAST = 8, 0.3, 0.5, 9

# What a factorisation costs of one from the beginning where its pattern is known.
_AGAIN = 0.4

# Linear elements that are longer than a few times the body's thickness are too stiff in bending to
# take its slow motions away: a plate of elements 3.3 times as long took 12 steps, 1.5 times 6.
_LONG = 2.0


def static_by_dynamic(
    body: Body, b: FloatArray, dynamic: LinearSolver, *, start: FloatArray | None = None
) -> FloatArray | None:
    """Return K⁻¹ b (M-orthogonal to rigid motions), or None where to factorise K is no dearer.

    Parameters
    ----------
    body : FEModel
    b : ndarray, shape (n_dofs,)
        At right angles to the rigid motions.
    dynamic : LinearSolver
        A direct one, of K + s²M.
    start : ndarray, shape (n_dofs,), optional
        The best of what some solutions with it span.
    """
    search = _Search(body.K, b, dynamic.answer, start)
    if start is None:
        search.run(_FIRST)
    worth = solutions_worth(dynamic) * (1.0 if dynamic.at is None else _AGAIN)
    most = _FEW + int(_SHARE * worth)
    if start is not None and search.left > _PROMISING:
        most = _LAST  # slow motions are left of the start, too many for single steps
    if search.left > _PROMISING and (slow := _on_corners(body, dynamic)) is not None:
        most = max(int(_SHARE_WITH_CORNERS * worth), _AT_LEAST)
        start = search.x + slow(b - body.K @ search.x)
        search = _Search(body.K, b, _deflated(body, dynamic.answer, slow), start, _ENERGY)
    search.run(most - _LAST)
    if search.left <= _PROMISING:
        search.run(_LAST)
    if not search.done:
        return None
    rigid = body.rigid_modes
    found: FloatArray = search.x - rigid @ (rigid.T @ (body.M @ search.x))
    return found


class _Search:
    """Preconditioned conjugate gradients for K x = b, as far as asked for.

    Attributes
    ----------
    x : ndarray, shape (n_dofs,)
    left : float
        ‖b - K x‖ / ‖b‖.
    error : float
        The error's energy over that of x, if it goes on to fall as it did: inf at first.
    """

    def __init__(
        self,
        K: sp.csr_array,
        b: FloatArray,
        precondition: Operator,
        start: FloatArray | None = None,
        least: float = 0.0,
    ) -> None:
        self._K, self._precondition, self._least = K, precondition, least
        self.x = np.zeros_like(b) if start is None else start
        self._r = b - K @ self.x
        self._load = float(np.linalg.norm(b))
        self.left = float(np.linalg.norm(self._r)) / self._load
        self._p, self._rz = np.zeros_like(b), np.inf
        self._b, self._gain, self.error = b, np.inf, np.inf
        self._failed = False

    @property
    def done(self) -> bool:
        """Whether the residual is as small as it has to be, or, if asked for, the error."""
        return self.left <= (_RESIDUAL if self.error <= self._least else _REACHED)

    def run(self, steps: int) -> None:
        """Take so many steps, or fewer if that will do."""
        for _ in range(steps):
            if self.done or self._failed:
                return
            self._step()

    def _step(self) -> None:
        z = self._precondition(self._r)
        before, self._rz = self._rz, float(self._r @ z)
        self._p = z + self._rz / before * self._p
        product = self._K @ self._p
        curvature = float(self._p @ product)
        if not (self._rz > 0.0 and curvature > 0.0):
            self._failed = True
            return
        self.x = self.x + self._rz / curvature * self._p
        # The energy that a step takes off the error (Hestenes and Stiefel 1952); the next, as far
        # below it as this one is below the last.
        gain, last = self._rz**2 / curvature, self._gain
        self._gain = gain
        rate = min(1.0, gain / last) if np.isfinite(last) else 1.0
        self.error = rate * gain / abs(float(self._b @ self.x))
        self._r = self._r - self._rz / curvature * product
        self.left = float(np.linalg.norm(self._r)) / self._load


def _deflated(body: Body, fast: Operator, slow: Operator) -> Operator:
    """Both operators, one on what the other leaves.

    A-DEF2 of Tang, Nabben, Vuik and Erlangga, J. Sci. Comput. 39 (2009): from a start without a
    residual that `slow` sees, conjugate gradients find what they would with its motions taken out.
    """

    def both(r: FloatArray) -> FloatArray:
        z = fast(r)
        return z + slow(r - body.K @ z)

    return both


@dataclass(frozen=True, eq=False)
class _Corners:
    """r ↦ P (Pᵀ K P)⁻¹ Pᵀ r."""

    prolongation: sp.csr_array
    restriction: sp.csr_array
    inverse: Operator

    def __call__(self, r: FloatArray) -> FloatArray:
        found: FloatArray = self.prolongation @ self.inverse(self.restriction @ r)
        return found


def _on_corners(body: Body, dynamic: LinearSolver) -> _Corners | None:
    """The linear elements on the corners; None where there are none or they have no static mode."""
    mesh, free = body.mesh, body.free
    if mesh is None or free is None or mesh.kind not in QUADRATIC or body.rigid_modes.shape[1]:
        return None
    if dynamic.at is not None and not _bends_on_corners(mesh):
        return None
    weights, corners = corner_interpolation(mesh)
    moving = np.isin((3 * corners[:, None] + np.arange(3)).ravel(), free)
    every = sp.kron(weights, sp.eye_array(3), format="csr")
    prolongation = every[free][:, moving]
    restriction = prolongation.T.tocsr()
    K, what = (restriction @ body.K @ prolongation).tocsr(), "K on the corners"
    try:
        if dynamic.name == "pardiso":
            return _Corners(prolongation, restriction, pardiso.inverse(K, what))
        inverse = factorize(K, what=what, checked=False).solve
        check_condition(K, inverse, what)
        return _Corners(prolongation, restriction, inverse)
    except SingularError:
        return None  # what is wrong with K shows, and is named, where it is factorised


def _bends_on_corners(mesh: Mesh) -> bool:
    """Whether a body of straight shape is thick enough for its linear elements."""
    spread = np.linalg.eigvalsh(np.cov(mesh.nodes.T))
    lengths = np.ptp(mesh.nodes[mesh.cells], axis=1).max(axis=1)
    return float(lengths.mean()) <= _LONG * float(np.sqrt(12.0 * max(spread[0], 0.0)))
