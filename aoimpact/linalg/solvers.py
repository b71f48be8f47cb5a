"""Linear solvers of K + s²M behind one interface: chosen by size and by what is installed.

Whichever solves, each solution is accepted by its residual. To add a solver, write a file with its
`Method` beside the others and name it in `METHODS`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..base import (
    GIB,
    ConvergenceError,
    FloatArray,
    InputTypeError,
    advance,
    available,
    bar,
    choice,
    require,
    warn,
)
from .method import ROUGH, Inverse, Method, Solve
from .multigrid import MULTIGRID
from .pardiso import PARDISO
from .pencil import Pencil
from .superlu import SUPERLU

__all__ = [
    "FEW_SOLUTIONS",
    "METHODS",
    "SOLVERS",
    "LinearSolver",
    "Solver",
    "SolverBook",
    "checked_solver",
    "linear_solver",
    "stays_quickest",
]

# What `solver=` may be: a name, or a function that takes the sparse matrix K + s²M and returns one
# that takes f and returns (K + s²M)⁻¹ f, as scipy.sparse.linalg.factorized does.
Solver = str | Callable[[Any], Solve]

METHODS = {method.name: method for method in (SUPERLU, PARDISO, MULTIGRID)}

# Taken where nothing fits into memory by the estimates: it needs the least for large bodies.
_LAST_RESORT = MULTIGRID

SOLVERS = ("auto", *METHODS)

# ‖f - A x‖ / ‖f‖ of a solution, where rounding allows it, and how often one is refined.
_TOLERANCE = 1e-10
_REFINEMENTS = 5

# ‖f - A x‖ / (max A_ii ‖x‖) that rounding leaves in any solution: some hundred roundings.
_ROUNDING = 2e-14

# Estimated seconds for each solution, of `FEW_SOLUTIONS` at most, up to which factors are taken
# though iterations may be as quick: they serve any number, and cannot fail to converge.
_PROMPT = 0.2

# The default number of solutions: those of a model of some oscillators. Fewer are for a shift far
# above what is slow in the body, for which iterations arrive.
FEW_SOLUTIONS = 10


@dataclass(frozen=True, eq=False)
class LinearSolver:
    """(K + s²M)⁻¹, by whatever method, with its residual checked at every solution.

    Attributes
    ----------
    method : str
        Which was set up, or the name of the user's own function.
    pencil : Pencil
    inverse : Inverse
        What the method has set up.
    """

    method: str
    pencil: Pencil
    inverse: Inverse

    @property
    def name(self) -> str:
        """Of what solves: the method, or the one that has taken over from it."""
        return self.inverse.successor() or self.method

    @property
    def s2(self) -> float:
        """The shift s², (rad/s)²."""
        return self.pencil.s2

    @property
    def precondition(self) -> Solve | None:
        """About (K + s²M)⁻¹, symmetric and much cheaper, of a method that iterates."""
        return self.inverse.precondition

    @property
    def at(self) -> Callable[[float], LinearSolver] | None:
        """s² ↦ the solver at another shift for less than a factorisation; see `Inverse.at`."""
        return self._by(self.inverse.at)

    @property
    def below(self) -> Callable[[float], LinearSolver] | None:
        """s² ↦ the solver at a smaller shift for much less than this one; see `Inverse.below`."""
        return self._by(self.inverse.below)

    def _by(
        self, shift: Callable[[float], Inverse] | None
    ) -> Callable[[float], LinearSolver] | None:
        if shift is None:
            return None
        return lambda s2: replace(self, pencil=self.pencil.at(s2), inverse=shift(s2))

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Return x with (K + s²M) x = `rhs`; `rhs` of shape (n,) or (n, m).

        Raises
        ------
        ConvergenceError
            If the residual stays above the tolerance after refinement, or x is not finite.
        """
        return self._solve(rhs, self.inverse.solve, _TOLERANCE)[0]

    def solve_roughly(
        self, rhs: FloatArray, tolerance: float = ROUGH
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, K x and M x, each (n,), for a subspace, with ‖f - A x‖ ≤ `tolerance` ‖f‖.

        For one `rhs` of shape (n,), as `solve` does where the method does not iterate.

        Raises
        ------
        ConvergenceError
        """
        if self.inverse.roughly is None:
            return self._solve(rhs, self.inverse.solve, _TOLERANCE)
        roughly = self.inverse.roughly
        return self._solve(rhs, lambda f: roughly(f, tolerance), tolerance)

    def _solve(
        self, rhs: FloatArray, inverse: Solve, tolerance: float
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x and the products K x and M x, which its residual needs."""
        x, before = self._unchecked(rhs, inverse), np.inf
        for _ in range(_REFINEMENTS + 1):
            with np.errstate(over="ignore", invalid="ignore"):
                kx, mx = self.pencil.products(x)
                residual = rhs - (kx + self.s2 * mx)
                excess = self._excess(residual, rhs, x, tolerance)
            if excess <= 1.0:
                advance("solution", x.size // len(x))
                return x, kx, mx
            if not excess < 0.5 * before:
                break
            before = excess
            x = x + self._unchecked(residual, inverse)
        raise ConvergenceError(
            f"solver {self.name!r} leaves {excess:.2g} times the residual allowed "
            f"({tolerance:g} of the right-hand side) for {self.pencil.what} of "
            f"{self.pencil.n} dofs: the matrix is singular or nearly so (a mechanism, missing "
            "supports), or this solver fails on it; take another one by solver="
        )

    def _excess(
        self, residual: FloatArray, rhs: FloatArray, x: FloatArray, tolerance: float
    ) -> float:
        """The largest residual of all columns, over what is allowed; nan where x is too large."""
        rounding = _ROUNDING * self.pencil.scale * np.linalg.norm(x, axis=0)
        allowed = np.maximum(tolerance * np.linalg.norm(rhs, axis=0), rounding)
        size = np.linalg.norm(residual, axis=0)
        return float(np.max(size / np.where(allowed > 0.0, allowed, 1.0)))

    def _unchecked(self, rhs: FloatArray, inverse: Solve) -> FloatArray:
        x = np.asarray(inverse(rhs))
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
        return x.astype(np.float64, copy=False)  # refined, single precision does as well


@dataclass(eq=False)
class SolverBook:
    """Solvers of one body as they are needed: the last one is kept, and what they were is noted.

    Attributes
    ----------
    make : callable
        s² ↦ LinearSolver, e.g. `FEModel.inverse`.
    """

    make: Callable[[float], LinearSolver]
    _last: LinearSolver | None = None

    def __call__(self, s2: float) -> LinearSolver:
        """Return the solver of K + s²M; not set up again if it is the last one used."""
        if self._last is None or self._last.s2 != s2:
            self._last = None  # its memory is free before the next one is made
            self._last = self.make(s2)
        return self._last

    @property
    def name(self) -> str:
        """The solver that was used last; empty as long as none was."""
        return self._last.name if self._last is not None else ""


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
        times faster and takes half the memory; "multigrid" goes on where factors grow too large, at
        its best with the mesh, well with nodes, slowly without. "auto" takes what will be quickest
        and fits into memory. A callable gets K + s²M (`scipy.sparse.csc_array`) and returns a
        callable that solves for a right-hand side (n,), e.g. ``scipy.sparse.linalg.factorized``.
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
    method = _quickest(pencil, solutions) if name == "auto" else METHODS[name]
    what = f"solver {method.name!r} of {pencil.what} ({pencil.n} dofs)"
    require(method.memory(pencil), what, _cure(pencil, method))
    with bar(f"{method.name}, {pencil.n} dofs"):
        if name == "auto" and not method.direct:
            inverse = _or_factors(pencil, lambda: method.set_up(pencil))
        else:
            inverse = method.set_up(pencil)
    return LinearSolver(method.name, pencil, inverse)


def _or_factors(pencil: Pencil, iterations: Callable[[], Inverse]) -> Inverse:
    """Return an inverse that factorises where iterations do not arrive, and from then on.

    They are given up once a single solution has taken as long as factors would: both together take
    at most twice that.
    """
    try:
        inverse = iterations()
    except ConvergenceError as error:
        return _instead(pencil, error)
    factors: list[Inverse] = []
    limit = _direct(pencil)
    if limit is not None and inverse.within is not None:
        inverse = inverse.within(limit.seconds(pencil, FEW_SOLUTIONS))
    roughly, below = inverse.roughly, inverse.below

    def first(iterate: Callable[[], FloatArray], rhs: FloatArray) -> FloatArray:
        if not factors:
            try:
                return iterate()
            except ConvergenceError as error:
                factors.append(_instead(pencil, error))
        return factors[0].solve(rhs)

    def smaller(iterate: Callable[[float], Inverse], s2: float) -> Inverse:
        there = pencil.at(s2)
        method = _direct(there) if factors else None
        return _named(method, there) if method else _or_factors(there, lambda: iterate(s2))

    return replace(
        inverse,
        solve=lambda rhs: first(lambda: inverse.solve(rhs), rhs),
        roughly=roughly and (lambda rhs, to: first(lambda: roughly(rhs, to), rhs)),
        below=below and partial(smaller, below),
        pace=lambda: 0.0 if factors else inverse.pace(),  # with factors there, no others are made
        successor=lambda: factors[0].successor() if factors else "",
    )


def _instead(pencil: Pencil, error: ConvergenceError) -> Inverse:
    """Factors where iterations have failed; raises their error where no factors fit."""
    method = _direct(pencil)
    if method is None:
        raise error
    warn(f"solver {method.name!r} takes over: {error}")
    return _named(method, pencil)


def _named(method: Method, pencil: Pencil) -> Inverse:
    return replace(method.set_up(pencil), successor=lambda: method.name)


def _direct(pencil: Pencil) -> Method | None:
    """The method that factorises quickest, of those that fit into memory."""
    fitting = [method for method in _fitting(pencil) if method.direct]
    return min(fitting, key=lambda m: m.seconds(pencil, FEW_SOLUTIONS), default=None)


def stays_quickest(solver: LinearSolver, solutions: int) -> bool:
    """Whether no factors would be quicker for so many more, which take as long as its last one."""
    pencil, own = solver.pencil, METHODS[solver.name]
    left = solver.inverse.pace() * (own.seconds(pencil, solutions) - own.seconds(pencil, 0))
    return all(m.seconds(pencil, solutions) >= left for m in _fitting(pencil) if m.direct)


def _fitting(pencil: Pencil) -> list[Method]:
    free = available()
    return [m for m in METHODS.values() if m.is_installed() and m.memory(pencil) <= free]


def _quickest(pencil: Pencil, solutions: int) -> Method:
    """The method that will be quickest of those that are installed and fit into memory."""
    fitting, count = _fitting(pencil), min(solutions, sys.maxsize)  # no overflow as a float
    if not fitting:
        return _LAST_RESORT
    seconds = {method.name: method.seconds(pencil, count) for method in fitting}
    soon = _PROMPT * min(count, FEW_SOLUTIONS)
    prompt = [m for m in fitting if m.direct and seconds[m.name] <= soon]
    return min(prompt or fitting, key=lambda method: seconds[method.name])


def _cure(pencil: Pencil, method: Method) -> str:
    if method is not _LAST_RESORT:
        memory = _LAST_RESORT.memory(pencil) / GIB
        return f"solver={_LAST_RESORT.name!r} takes {memory:.2g} GiB"
    return "take a coarser mesh, free memory, or give a solver of your own by solver="


def _users_own(pencil: Pencil, solver: Callable[[Any], Solve]) -> LinearSolver:
    name = getattr(solver, "__name__", type(solver).__name__)
    inverse = solver(pencil.matrix().T)  # of a symmetric CSR matrix that is the CSC one, no copy
    if not callable(inverse):
        raise InputTypeError(
            f"solver {name!r} must return a function that takes a right-hand side and returns the "
            f"solution, got {inverse!r}"
        )

    def of_one(rhs: FloatArray) -> FloatArray:
        return np.array(inverse(rhs.copy()))  # it may overwrite what it gets, or what it gave

    def by_columns(rhs: FloatArray) -> FloatArray:
        return of_one(rhs) if rhs.ndim == 1 else np.column_stack([of_one(b) for b in rhs.T])

    return LinearSolver(name, pencil, Inverse(by_columns))
