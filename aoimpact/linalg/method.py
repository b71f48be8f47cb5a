"""Description of a method that solves (K + s²M) x = f: name, needs, cost and abilities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..base import FloatArray
from .pencil import Pencil

Solve = Callable[[FloatArray], FloatArray]
Iterate = Callable[[FloatArray, float, float], tuple[FloatArray, int]]

# Default ‖f - A x‖ / ‖f‖ of `solve_roughly`. It suffices for the vectors of a subspace, since the
# projected model's error is the square of the vectors' error: the receptance at a node of a
# plate is off by 1e-8 with any number of vectors (by 2e-7 with a tolerance of 1e-2). A solution
# takes 0.4 of the iterations of `solve`. The vectors of a constrained body must be orthogonal to
# its static mode: otherwise the errors of displacements and stresses away from the contact stagnate
# at 3e-4 and 7e-3 on a thick plate.
ROUGH = 1e-3


@dataclass(frozen=True)
class Inverse:
    """(K + s²M)⁻¹ as set up by a method, direct or iterative.

    Attributes
    ----------
    solve : callable or None
        Solution (K + s²M)⁻¹ f by a direct method, from f, shape (n,) or (n, m).
    iterate : callable or None
        Solution (K + s²M)⁻¹ f by an iterative method, and the number of preconditioned residuals,
        from f, shape (n,) or (n, m), the tolerance of ‖f - A x‖ / ‖f‖, and the maximum number of
        iterations. Raises ConvergenceError.
    precondition : callable or None
        Approximation of (K + s²M)⁻¹ r by an iterative method, from r, shape (n, m); symmetric and
        positive definite, and much cheaper than a solution.
    at : callable or None
        s² ↦ the inverse at another shift by a direct method, for less than a new set-up. The method
        holds factors for one shift at a time: do not alternate between shifts.
    """

    solve: Solve | None = None
    iterate: Iterate | None = None
    precondition: Solve | None = None
    at: Callable[[float], Inverse] | None = None


class Cost(NamedTuple):
    """Estimated cost of a method for a matrix; only ratios of times matter.

    Attributes
    ----------
    set_up : float
        Time of the set-up, s.
    step : float
        Time of a solution, or of an iteration, s.
    memory : float
        Memory needed besides K and M, bytes.
    steps : float
        Number of iterations of a solution; 1 for a direct method.
    """

    set_up: float
    step: float
    memory: float
    steps: float = 1.0


class Method(NamedTuple):
    """A method that solves (K + s²M) x = f.

    Attributes
    ----------
    name : str
        Name of the method in `solver=`.
    set_up : callable
        Function that sets up the method: Pencil ↦ Inverse. Raises SingularError.
    cost : callable
        Function that estimates the cost: Pencil ↦ Cost.
    is_installed : callable
        Function that returns whether the method's package is installed.
    """

    name: str
    set_up: Callable[[Pencil], Inverse]
    cost: Callable[[Pencil], Cost]
    is_installed: Callable[[], Any] = lambda: True

    def seconds(self, pencil: Pencil, solutions: float) -> float:
        """Return the estimated time of the set-up and of a number of solutions, s."""
        set_up, step, _, steps = self.cost(pencil)
        return set_up + solutions * steps * step


def of_factors(times: tuple[float, float, float], stored: float, copied: float) -> Any:
    """Return the `cost` function of a direct `Method`.

    Parameters
    ----------
    times : tuple of float
        Time of the set-up per multiplication and per entry of L, and time of a solution per entry
        of L, s.
    stored, copied : float
        Memory per entry of L, and per entry of K, bytes.
    """

    def cost(pencil: Pencil) -> Cost:
        entries, operations = pencil.fill
        set_up = times[0] * operations + times[1] * entries
        memory = stored * entries + copied * float(pencil.K.nnz)
        return Cost(set_up, times[2] * entries, memory)

    return cost
