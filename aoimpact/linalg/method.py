"""Description of a method that solves (K + s²M) x = f: name, needs, cost and abilities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

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
    solve : callable or None
        f, shape (n,) or (n, m), ↦ (K + s²M)⁻¹ f, of a method that does not iterate.
    iterate : callable or None
        f, shape (n,) or (n, m), ‖f - A x‖ / ‖f‖ and the most iterations ↦ (K + s²M)⁻¹ f and the
        residuals preconditioned, of a method that iterates. Raises ConvergenceError.
    precondition : callable or None
        About (K + s²M)⁻¹, of shape (n, m), symmetric and much cheaper, of a method that iterates.
    at : callable or None
        s² ↦ the inverse at another shift, for less than setting up another one: at a smaller shift,
        of a method that iterates, where both remain usable. Factors are for one shift at a time: do
        not alternate.
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
        Bytes that it needs besides K and M.
    steps : float
        Iterations of a solution.
    """

    set_up: float
    step: float
    memory: float
    steps: float = 1.0


class Method(NamedTuple):
    """A method of solution.

    Attributes
    ----------
    name : str
        Its name in `solver=`.
    set_up : callable
        Pencil ↦ Inverse. Raises SingularError.
    cost : callable
        Pencil ↦ Cost.
    is_installed : callable
        Whether its package is there.
    """

    name: str
    set_up: Callable[[Pencil], Inverse]
    cost: Callable[[Pencil], Cost]
    is_installed: Callable[[], Any] = lambda: True

    def seconds(self, pencil: Pencil, solutions: float) -> float:
        """Return the estimated time of the set-up and some solutions, s."""
        set_up, step, _, steps = self.cost(pencil)
        return set_up + solutions * steps * step


def of_factors(times: tuple[float, float, float], stored: float, copied: float) -> Any:
    """Return the cost of factors, as of `Method`.

    Parameters
    ----------
    times : tuple of float
        Seconds per multiplication and per entry of L of the set-up; per entry of a solution.
    stored, copied : float
        Bytes per entry of L, and of K.
    """

    def cost(pencil: Pencil) -> Cost:
        entries, operations = pencil.fill
        set_up = times[0] * operations + times[1] * entries
        memory = stored * entries + copied * float(pencil.K.nnz)
        return Cost(set_up, times[2] * entries, memory)

    return cost
