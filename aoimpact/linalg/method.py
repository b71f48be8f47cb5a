"""Description of a method that solves (K + s²M) x = f: name, needs, cost and abilities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..base import FloatArray
from .pencil import Pencil

Solve = Callable[[FloatArray], FloatArray]
Iterate = Callable[[FloatArray, float, float], tuple[FloatArray, int]]

# ‖f - A x‖ / ‖f‖ of a rough solution, which is enough for the vectors of a subspace: the error of
# the projected model is the square of theirs. At a node of a plate the receptance is off by 1e-8
# with any number of vectors (with 1e-2, by 2e-7). Rough solutions take 0.4 of the iterations.
# The vectors of a constrained body must be orthogonal to its static mode: otherwise displacements
# and stresses elsewhere stagnate at 3e-4 and 7e-3 on a thick plate.
ROUGH = 1e-3


@dataclass(frozen=True)
class Inverse:
    """(K + s²M)⁻¹ as a method has set it up.

    Attributes
    ----------
    solve : callable
        f, shape (n,) or (n, m), ↦ (K + s²M)⁻¹ f.
    iterate : callable or None
        f, shape (n,), ‖f - A x‖ / ‖f‖ and the most iterations ↦ (K + s²M)⁻¹ f and the iterations
        taken, of a method that iterates. Raises ConvergenceError.
    precondition : callable or None
        About (K + s²M)⁻¹, symmetric and much cheaper, of a method that iterates.
    at : callable or None
        s² ↦ the inverse at another shift, for less than setting up another one: at a smaller shift,
        of a method that iterates, where both remain usable. Factors are for one shift at a time: do
        not alternate.
    """

    solve: Solve
    iterate: Iterate | None = None
    precondition: Solve | None = None
    at: Callable[[float], Inverse] | None = None


@dataclass(frozen=True)
class Method:
    """A method of solution and its cost, which here is that of factors.

    Only ratios of times matter.

    Attributes
    ----------
    name : str
        Its name in `solver=`.
    set_up : callable
        Pencil ↦ Inverse. Raises SingularError.
    per_operation, per_entry, per_solution : float
        Seconds per multiplication and per entry of L of the set-up; per entry of a solution.
    bytes_per_entry, bytes_copied : float
        Bytes per entry of L, and of K.
    is_installed : callable
        Whether its package is there.
    """

    name: str
    set_up: Callable[[Pencil], Inverse]
    per_operation: float
    per_entry: float
    per_solution: float
    bytes_per_entry: float
    bytes_copied: float = 0.0
    is_installed: Callable[[], Any] = lambda: True

    def seconds(self, pencil: Pencil, solutions: float) -> float:
        """Return the estimated time of the set-up and some solutions, s."""
        entries, operations = pencil.fill
        per_entry = self.per_entry + self.per_solution * solutions
        return self.per_operation * operations + per_entry * entries

    def memory(self, pencil: Pencil) -> float:
        """Return the estimated bytes that it needs besides K and M."""
        return self.bytes_per_entry * pencil.fill.entries + self.bytes_copied * float(pencil.K.nnz)
