"""Description of a method that solves (K + s²M) x = f: name, needs, cost and abilities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..base import FloatArray
from .dissection import Dissection
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
    """A method of solution.

    Attributes
    ----------
    name : str
        Its name in `solver=`.
    set_up : callable
        Pencil ↦ Inverse. Raises SingularError.
    memory : callable
        Pencil ↦ bytes that it needs besides K and M, estimated.
    seconds : callable
        (Pencil, number of solutions, cost of factors) ↦ its time, s, estimated. Only ratios of such
        times matter.
    iteration : callable or None
        Pencil ↦ the time of one iteration, estimated, of a method that iterates.
    is_installed : callable
        Whether its package is there.
    """

    name: str
    set_up: Callable[[Pencil], Inverse]
    memory: Callable[[Pencil], float]
    seconds: Callable[[Pencil, float, Dissection], float]
    iteration: Callable[[Pencil], float] | None = None
    is_installed: Callable[[], Any] = lambda: True
