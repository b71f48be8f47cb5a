"""Linear solvers of K + s²M behind one interface, chosen by size and by the installed packages.

The solutions of every method are checked by their residual. To add a solver, write a file with its
`Method` beside the others and name it in `METHODS`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import (
    GIB,
    ConvergenceError,
    FloatArray,
    InputError,
    InputTypeError,
    advance,
    available,
    bar,
    choice,
    require,
)
from .method import ROUGH, Inverse, Method, Solve
from .multigrid import MULTIGRID
from .pardiso import PARDISO
from .pencil import Pencil
from .superlu import SUPERLU

# Values of `solver=`: a name, or a function that takes the sparse matrix K + s²M and returns a
# function f ↦ (K + s²M)⁻¹ f, as scipy.sparse.linalg.factorized does.
Solver = str | Callable[[Any], Solve]

METHODS: dict[str, Method] = {method.name: method for method in (SUPERLU, PARDISO, MULTIGRID)}

SOLVERS = ("auto", *METHODS)

# Limit of ‖f - A x‖ / ‖f‖, unless rounding leaves more.
_TOLERANCE = 1e-10

# Largest ‖f - A x‖ / (max A_ii ‖x‖) that counts as due to rounding: some hundred times the unit
# roundoff.
_LEFT_BY_ROUNDING = 2e-14

# Estimated time of a factorisation, s, up to which it is preferred even to quicker iterations:
# factors serve any number of solutions, and cannot fail to converge.
_PROMPT = 0.2

# Default number of solutions: enough for a reduced model of a few oscillators. Callers give a
# smaller number for a shift s² far above the lowest ω², where iterations converge quickly.
FEW_SOLUTIONS = 10


@dataclass(eq=False)
class LinearSolver:
    """(K + s²M)⁻¹ by any method, with the residual of every solution checked.

    If "auto" chose an iterative method, a factorisation replaces it for good as soon as the
    iterations of all solutions have taken the estimated time of a factorisation. Iterations and
    factorisation together then take at most about twice that time.

    Attributes
    ----------
    name : str
        The method in use, or the name of the user's own function.
    pencil : Pencil
    inverse : Inverse
    most : float
        Iterations left before a factorisation replaces them; infinite if none does.
    rough : float
        Relative residual ‖f - (K + s²M) x‖ / ‖f‖ that `solve_roughly` allows by default.
    """

    name: str
    pencil: Pencil
    inverse: Inverse
    most: float = np.inf
    rough: float = ROUGH

    @property
    def s2(self) -> float:
        """The shift s², (rad/s)²."""
        return self.pencil.s2

    @property
    def precondition(self) -> Solve | None:
        """Symmetric approximation of (K + s²M)⁻¹, much cheaper to apply; None: a direct method."""
        return self.inverse.precondition

    @property
    def at(self) -> Callable[[float], LinearSolver] | None:
        """s² ↦ the solver at another shift, for less than a new set-up; see `Inverse.at`."""
        if (shift := self.inverse.at) is None:
            return None
        return lambda s2: LinearSolver(self.name, self.pencil.at(s2), shift(s2), self.most)

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return x with (K + s²M) x = `rhs`; `rhs` of shape (n,) or (n, m).

        Raises
        ------
        ConvergenceError
            If the residual stays above the tolerance after refinement, or x is not finite.
        """
        return self._solve(rhs, _TOLERANCE)[0]

    def solve_roughly(
        self, rhs: FloatArray, tolerance: float | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, K x and M x for a subspace, with ‖f - A x‖ ≤ `tolerance` ‖f‖.

        A direct method solves to the tolerance of `solve`.

        Raises
        ------
        ConvergenceError
        """
        tolerance = self.rough if tolerance is None else tolerance
        return self._solve(rhs, _TOLERANCE if self.inverse.iterate is None else tolerance)

    def factorise(self) -> None:
        """Replace iterations by a factorisation for good; ConvergenceError if none fits memory."""
        method = _direct(self.pencil)
        if method is None:
            raise ConvergenceError(
                f"solver {self.name!r} does not converge, and factors of {self.pencil.n} dofs do "
                "not fit into memory; take a coarser mesh or another solver"
            )
        with bar(f"{method.name}, {self.pencil.n} dofs"):
            self.name, self.inverse, self.most = method.name, method.set_up(self.pencil), np.inf

    def _solve(
        self, rhs: FloatArray, tolerance: float
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x and the products K x and M x, which its residual needs."""
        x, before = self._unchecked(rhs, tolerance), np.inf
        while True:
            with np.errstate(over="ignore", invalid="ignore"):
                kx, mx = self.pencil.products(x)
                residual = rhs - (kx + self.s2 * mx)
                rounding = _LEFT_BY_ROUNDING * self.pencil.scale * np.linalg.norm(x, axis=0)
                allowed = np.maximum(tolerance * np.linalg.norm(rhs, axis=0), rounding)
                size = np.linalg.norm(residual, axis=0)
                # Maximum over the columns; nan if x overflows.
                excess = float(np.max(size / np.where(allowed > 0.0, allowed, 1.0)))
            if excess <= 1.0:
                advance("solution", x.size // len(x))
                return x, kx, mx
            if not excess < 0.5 * before:
                break
            before = excess
            x = x + self._unchecked(residual, tolerance)
        raise ConvergenceError(
            f"solver {self.name!r} leaves {excess:.2g} times the residual allowed "
            f"({tolerance:g} of the right-hand side) for {self.pencil.what} of "
            f"{self.pencil.n} dofs: the matrix is singular or nearly so (a mechanism, missing "
            "supports), or this solver fails on it; take another one by solver="
        )

    def _unchecked(self, rhs: FloatArray, tolerance: float) -> FloatArray:
        x = np.asarray(self._iterated(rhs, tolerance))
        if x.shape != rhs.shape or x.dtype.kind != "f":
            raise InputTypeError(
                f"solver {self.name!r} must return a real array of shape {rhs.shape}, as its "
                f"right-hand side has, got {x.dtype} {x.shape}"
            )
        if not np.isfinite(x).all():
            raise ConvergenceError(
                f"solver {self.name!r} returned nan or infinity for {self.pencil.what} "
                f"({self.pencil.n} dofs); take another one by solver="
            )
        return x.astype(np.float64, copy=False)  # refinement makes up for single precision

    def _iterated(self, rhs: FloatArray, tolerance: float) -> FloatArray:
        """Solve by iterations until `most` is used up, and by a factorisation from then on."""
        if self.inverse.solve is not None:
            return self.inverse.solve(rhs)
        assert self.inverse.iterate is not None
        try:
            x, taken = self.inverse.iterate(rhs, tolerance, self.most)
            self.most -= taken
            return x
        except ConvergenceError:
            if self.most == np.inf:
                raise
        self.factorise()
        return self._iterated(rhs, tolerance)


def checked_solver(solver: Solver, *, name: str = "solver") -> Solver:
    """Return `solver`, a solver's name or a function; refuse others before any work is done."""
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
        times faster and takes half the memory; "multigrid" is for bodies whose factors grow too
        large, at its best with the mesh, well with nodes, slowly without. "auto" takes the quickest
        that fits into memory. A callable gets K + s²M (`scipy.sparse.csc_array`) and returns a
        callable that solves for a right-hand side (n,), e.g. ``scipy.sparse.linalg.factorized``.
    solutions : int, optional
        Approximate number of solutions needed: for many, "auto" is more likely to factorise.

    Raises
    ------
    SingularError
        If the matrix is singular to rounding or not positive definite.
    MemoryLimitError
        If there is not enough memory, by an estimate; nothing is computed then.
    InputError, InputTypeError
        If the name is unknown, its package not installed, or the callable returns no callable.
    """
    if callable(solver):
        return _users_own(pencil, solver)
    name = str(checked_solver(solver))
    if pencil.rotates and name == MULTIGRID.name:
        raise InputError(f"solver={name!r} is for solids; leave it out for shells and beams")
    method = _quickest(pencil, solutions) if name == "auto" else METHODS[name]
    what = f"solver {method.name!r} of {pencil.what} ({pencil.n} dofs)"
    cure = "take a coarser mesh, free memory, or give a solver of your own by solver="
    if method is not MULTIGRID and not pencil.rotates:
        cure = f"solver={MULTIGRID.name!r} takes {MULTIGRID.cost(pencil).memory / GIB:.2g} GiB"
    cost, most = method.cost(pencil), np.inf
    require(cost.memory, what, cure)
    direct = _direct(pencil) if name == "auto" else None
    if method is MULTIGRID and direct is not None:  # iterations in the time of a factorisation
        most = direct.cost(pencil).set_up / cost.step
    with bar(f"{method.name}, {pencil.n} dofs"):
        try:
            inverse = method.set_up(pencil)
        except ConvergenceError:
            if direct is None:
                raise
            method, inverse, most = direct, direct.set_up(pencil), np.inf
    return LinearSolver(method.name, pencil, inverse, most)


def _quickest(pencil: Pencil, solutions: int) -> Method:
    """Return the method estimated to be quickest that is installed and fits into memory."""
    direct = _direct(pencil)
    if pencil.rotates:  # multigrid is for blocks of three displacements
        return direct or SUPERLU
    if direct is None:
        return MULTIGRID
    count = float(min(solutions, sys.maxsize))
    limit = max(_PROMPT, MULTIGRID.seconds(pencil, count))
    if direct.seconds(pencil, count) <= limit or MULTIGRID.cost(pencil).memory > available():
        return direct
    return MULTIGRID


def _direct(pencil: Pencil) -> Method | None:
    """Return the direct method with the quickest set-up, or None if none fits into memory."""
    free = available()
    fitting = [m for m in (SUPERLU, PARDISO) if m.is_installed() and m.cost(pencil).memory <= free]
    return min(fitting, key=lambda m: m.cost(pencil).set_up, default=None)


def _users_own(pencil: Pencil, solver: Callable[[Any], Solve]) -> LinearSolver:
    name = getattr(solver, "__name__", type(solver).__name__)
    inverse = solver(pencil.matrix().T)  # the CSC form of a symmetric CSR matrix, without a copy
    if not callable(inverse):
        raise InputTypeError(
            f"solver {name!r} must return a function that takes a right-hand side and returns the "
            f"solution, got {inverse!r}"
        )

    def solve(rhs: FloatArray) -> FloatArray:
        if rhs.ndim == 2:
            return np.column_stack([solve(column) for column in rhs.T])
        return np.array(inverse(rhs.copy()))  # `inverse` may overwrite its argument and results

    return LinearSolver(name, pencil, Inverse(solve))
