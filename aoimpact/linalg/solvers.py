"""Linear solvers of K + s²M behind one interface: chosen by size and by what is installed.

Whichever solves, it is the residual that vouches for the answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..base import ConvergenceError, FloatArray, InputTypeError, available, choice, require
from . import banded, pardiso
from .fill import entries_by_width
from .multigrid import Multigrid, bytes_needed
from .pencil import Pencil
from .superlu import factorize

__all__ = [
    "FEW_SOLUTIONS",
    "SOLVERS",
    "LinearSolver",
    "Pencil",
    "Solver",
    "SolverBook",
    "checked_solver",
    "linear_solver",
    "solutions_worth",
    "stays_quickest",
    "within_band",
]

Inverse = Callable[[FloatArray], FloatArray]

# What `solver=` may be: a name, or a function that takes the sparse matrix K + s²M and returns one
# that takes f and returns (K + s²M)⁻¹ f, as scipy.sparse.linalg.factorized does.
Solver = str | Callable[[Any], Inverse]

SOLVERS = ("auto", "superlu", "pardiso", "multigrid")

# ‖f - A x‖ / ‖f‖ that is asked for where rounding allows it, and how often a solution is refined.
_TOLERANCE = 1e-10
_REFINEMENTS = 5

# ‖f - A x‖ / (max A_ii ‖x‖) that no solver can be asked to beat: some hundred roundings.
_ROUNDING = 2e-14

# Entries of the factors (by the estimate) up to which SuperLU, always at hand, takes a second or
# two, and up to which PARDISO is no quicker.
_SUPERLU_QUICK, _SUPERLU_QUICKEST = 2e7, 2e6

# Bytes per entry: SuperLU holds L and U with an index each, PARDISO values by supernodes. The rest
# is what the factorisation works in, measured as part of the whole; and PARDISO's copies of K, per
# entry of that.
_BYTES = {"superlu": 16.0, "pardiso": 10.0}
_PARDISO_COPIES = 30.0

# Seconds, to compare and nothing more: of a factorisation per entries²/dofs, of a solution per
# entry; of a solution by multigrid per dof, and without nodes.
_FACTOR, _SWEEP = 6e-11, 1e-9
_MULTIGRID, _WITHOUT_NODES = 5e-6, 1e-4

# Solutions that a factorisation is worth: its ordering and checks, and its work per entries/dofs
# (on factors that are not large it is twice as slow as above). Measured on beams, plates and
# blocks of 7 000 … 64 000 dofs: 26 … 124, within a factor of 1.7 of that.
_ORDERING, _OVER_RATES = 20.0, 0.06

# Solutions that a solver serves, if nothing else is said: those of a model of some oscillators.
FEW_SOLUTIONS = 10


@dataclass(frozen=True, eq=False)
class LinearSolver:
    """(K + s²M)⁻¹, by whatever method, with its residual checked at every solution.

    Attributes
    ----------
    name : str
        "superlu", "pardiso", or the name of the user's own function.
    pencil : Pencil
    tolerance : float
        ‖f - (K + s²M) x‖ / ‖f‖ of every solution, unless rounding alone makes more.
    precondition : callable or None
        About (K + s²M)⁻¹, symmetric and much cheaper, where the solver has such a thing.
    at : callable or None
        s² ↦ the solver at another shift for less than a factorisation, where there is such a thing.
        There are factors for one shift at a time: do not go to and fro.
    """

    name: str
    pencil: Pencil
    _inverse: Inverse
    tolerance: float = _TOLERANCE
    precondition: Inverse | None = None
    at: Callable[[float], LinearSolver] | None = None

    @property
    def s2(self) -> float:
        """The shift s², (rad/s)²."""
        return self.pencil.s2

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return x with (K + s²M) x = `rhs`; `rhs` of shape (n,) or (n, m).

        Raises
        ------
        ConvergenceError
            If the residual stays above the tolerance after refinement, or x is not finite.
        """
        return self.solve_with_products(rhs)[0]

    def solve_with_products(self, rhs: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x as `solve` does, and what its residual was told by: K x and M x."""
        x, before = self.answer(rhs), np.inf
        for _ in range(_REFINEMENTS + 1):
            with np.errstate(over="ignore", invalid="ignore"):
                kx, mx = self.pencil.K @ x, self.pencil.M @ x
                residual = rhs - (kx + self.s2 * mx)
                excess = self._excess(residual, rhs, x)
            if excess <= 1.0:
                return x, kx, mx
            if not excess < 0.5 * before:
                break
            before = excess
            x = x + self.answer(residual)
        raise ConvergenceError(
            f"solver {self.name!r} leaves {excess:.2g} times the residual allowed "
            f"({self.tolerance:g} of the right-hand side) for {self.pencil.what} of "
            f"{self.pencil.n} dofs: the matrix is singular or nearly so (a mechanism, missing "
            "supports), or this solver fails on it; take another one by solver="
        )

    def _excess(self, residual: FloatArray, rhs: FloatArray, x: FloatArray) -> float:
        """The largest residual of all columns, over what is allowed; nan where x is too large."""
        rounding = _ROUNDING * self.pencil.scale * np.linalg.norm(x, axis=0)
        allowed = np.maximum(self.tolerance * np.linalg.norm(rhs, axis=0), rounding)
        size = np.linalg.norm(residual, axis=0)
        return float(np.max(size / np.where(allowed > 0.0, allowed, 1.0)))

    def answer(self, rhs: FloatArray) -> FloatArray:
        """Return (K + s²M)⁻¹ `rhs` as the method gives it, its residual not looked at.

        Enough where something else vouches for the result: as a preconditioner.
        """
        answer = np.asarray(self._inverse(rhs))
        if answer.shape != rhs.shape or answer.dtype.kind != "f":
            raise InputTypeError(
                f"solver {self.name!r} must return a real array of shape {rhs.shape}, as its "
                f"right-hand side has, got {answer.dtype} {answer.shape}"
            )
        if not np.isfinite(answer).all():
            raise ConvergenceError(
                f"solver {self.name!r} returned nan or infinity for {self.pencil.what} "
                f"({self.pencil.n} dofs); take another one by solver="
            )
        return answer.astype(np.float64, copy=False)  # refined, single precision does as well


@dataclass(eq=False)
class SolverBook:
    """Solvers of one body as they are needed: the last one is kept, and what they were is noted.

    Attributes
    ----------
    make : callable
        s² ↦ LinearSolver, e.g. `FEModel.inverse`.
    name : str
        The solver that was used; empty as long as none was.
    """

    make: Callable[[float], LinearSolver]
    name: str = ""
    _last: LinearSolver | None = None

    def __call__(self, s2: float) -> LinearSolver:
        """Return the solver of K + s²M; not set up again if it was the last one asked for."""
        if self._last is None or self._last.s2 != s2:
            self._last = None  # its memory is free before the next one is made
            self._last = self.make(s2)
            self.name = self._last.name
        return self._last


def checked_solver(solver: Solver, *, name: str = "solver") -> Solver:
    """Refuse what is neither the name of a solver nor a function, before any work is done."""
    return solver if callable(solver) else choice(name, solver, SOLVERS)


def linear_solver(
    pencil: Pencil, solver: Solver = "auto", *, solutions: int = FEW_SOLUTIONS
) -> LinearSolver:
    """Set up the solution of (K + s²M) x = f.

    Parameters
    ----------
    pencil : Pencil
    solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        "superlu" comes with SciPy; "pardiso", with ``pip install aoimpact[direct]``, is several
        times faster and takes half the memory; "multigrid" goes on where factors grow too large,
        at its best with the mesh, well with nodes, slowly without. "auto" takes what will be
        quickest and fits into memory. A callable gets K + s²M (`scipy.sparse.csc_array`) and
        returns a callable that solves for a right-hand side (n,), e.g.
        ``scipy.sparse.linalg.factorized``.
    solutions : int, optional
        How many solutions it is to serve, roughly: "auto" factorises sooner for many.

    Raises
    ------
    SingularError
        If the matrix is singular to rounding or not positive definite.
    MemoryLimitError
        If there is not enough memory, by an estimate; nothing is computed then.
    InputError, InputTypeError
        If the name is unknown, its package not installed, or the callable does not return one.
    """
    if callable(solver):
        return _users_own(pencil, solver)
    name = str(checked_solver(solver))
    entries = _entries(pencil)
    needs = _needs(pencil, entries)
    if name == "auto":
        name = _quickest(pencil, entries, needs, solutions)
    require(needs[name], f"solver {name!r} of {pencil.what} ({pencil.n} dofs)", _cure(name, needs))
    if name == "multigrid":
        # Half of it, since the residual in its own right comes out slightly larger.
        multigrid = Multigrid(pencil, 0.5 * _TOLERANCE)
        return LinearSolver(name, pencil, multigrid.solve, precondition=multigrid.precondition)
    if name == "pardiso":
        return _InTurn(pencil).at(pencil.s2)
    return LinearSolver(name, pencil, factorize(pencil.matrix(), what=pencil.what).solve)


def within_band(solver: LinearSolver) -> SolverBook | None:
    """Return what factorises K + s²M of that body in far less time, if SuperLU solves it now.

    That is so for slender bodies. It serves few solutions, at other shifts: no need to name it.
    """
    pencil = solver.pencil
    if solver.name != "superlu" or pencil.width > banded.NARROW:
        return None

    def make(s2: float) -> LinearSolver:
        shifted = pencil.at(s2)
        return LinearSolver("banded", shifted, banded.inverse(shifted.matrix(), shifted.what))

    return SolverBook(make)


def stays_quickest(solver: LinearSolver, solutions: int) -> bool:
    """Whether "auto" would take the same one for so many solutions."""
    entries = _entries(solver.pencil)
    needs = _needs(solver.pencil, entries)
    return _quickest(solver.pencil, entries, needs, solutions) == solver.name


def solutions_worth(solver: LinearSolver) -> float:
    """How many solutions with a direct solver take as long as its factorisation, roughly."""
    name = solver.name if solver.name in _BYTES else "superlu"
    pencil = solver.pencil
    return _ORDERING + _OVER_RATES * entries_by_width(pencil.n, pencil.width, name) / pencil.n


class _InTurn:
    """PARDISO's factors of one K + s²M at a time, with one analysis for all."""

    def __init__(self, pencil: Pencil) -> None:
        self._pencil, self._s2 = pencil, pencil.s2
        self._factors = pardiso.Factors(
            pencil.matrix(), pencil.what, width=pencil.width, diagonal=pencil.diagonal
        )

    def at(self, s2: float) -> LinearSolver:
        """Return the solver of one of them, which has its factors made anew when it needs them."""
        pencil = self._pencil.at(s2)
        return LinearSolver("pardiso", pencil, partial(self._solve, pencil), at=self.at)

    def _solve(self, pencil: Pencil, rhs: FloatArray) -> FloatArray:
        if pencil.s2 != self._s2:
            self._s2 = math.nan  # until the new ones are there
            self._factors.replace(pencil.matrix(), pencil.what, diagonal=pencil.diagonal)
            self._s2 = pencil.s2
        return self._factors.solve(rhs)


def _entries(pencil: Pencil) -> dict[str, float]:
    return {each: entries_by_width(pencil.n, pencil.width, each) for each in _BYTES}


def _needs(pencil: Pencil, entries: dict[str, float]) -> dict[str, float]:
    """Bytes that each solver would need beside K and M."""
    stored = float(pencil.K.nnz)
    needs = {name: _BYTES[name] * entries[name] for name in _BYTES}
    needs["pardiso"] += _PARDISO_COPIES * stored
    return needs | {"multigrid": bytes_needed(stored)}


def _quickest(
    pencil: Pencil, entries: dict[str, float], needs: dict[str, float], solutions: int
) -> str:
    """The solver that will be quickest of those that there are and that fit into memory."""
    if entries["superlu"] <= (_SUPERLU_QUICKEST if pardiso.is_installed() else _SUPERLU_QUICK):
        return "superlu"
    if entries["superlu"] <= _SUPERLU_QUICK:
        return "pardiso"
    seconds = {
        name: _FACTOR * count**2 / pencil.n + solutions * _SWEEP * count
        for name, count in entries.items()
    }
    each = (_WITHOUT_NODES if pencil.nodes is None else _MULTIGRID) * pencil.n
    seconds["multigrid"] = solutions * each
    if not pardiso.is_installed():
        del seconds["pardiso"]
    free = available()
    fitting = [name for name in seconds if needs[name] <= free] or ["multigrid"]
    return min(fitting, key=seconds.__getitem__)


def _cure(name: str, needs: dict[str, float]) -> str:
    if name != "multigrid":
        return f"solver='multigrid' takes {needs['multigrid'] / 2.0**30:.2g} GiB"
    return "take a coarser mesh, free memory, or give a solver of your own by solver="


def _users_own(pencil: Pencil, solver: Callable[[Any], Inverse]) -> LinearSolver:
    name = getattr(solver, "__name__", type(solver).__name__)
    inverse = solver(pencil.matrix().T)  # of a symmetric CSR matrix that is the CSC one, no copy
    if not callable(inverse):
        raise InputTypeError(
            f"solver {name!r} must return a function that takes a right-hand side and returns the "
            f"solution, got {inverse!r}"
        )

    def by_columns(rhs: FloatArray) -> FloatArray:
        if rhs.ndim == 1:
            return inverse(rhs)
        return np.column_stack([inverse(column) for column in rhs.T])

    return LinearSolver(name, pencil, by_columns)
