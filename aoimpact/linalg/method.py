"""What is known of a method that solves (K + s²M) x = f: its name, needs, cost and abilities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..base import FloatArray
from .pencil import Pencil

__all__ = ["ROUGH", "Inverse", "Method", "Solve"]

Solve = Callable[[FloatArray], FloatArray]

# ‖f - A x‖ / ‖f‖ of a rough solution. For vectors of a subspace that is enough, since the model is
# projected on the vectors that there are: its error is the square of what they lack. At a node of a
# plate the receptance is off by 1e-8, however many vectors there are (1e-2 leaves 2e-7). Above that
# errors are those on vectors solved to 1e-9, even with 1e-2: 3 to 64 vectors of plates, a disc, a
# sphere, bars and a sheet, in .35 to .45 of the iterations. Of a held body they must be across its
# static mode: else displacements and stresses elsewhere stagnate at 3e-4 and 7e-3 on a thick plate,
# which 180 vectors across it give to 5e-5 and 2e-3, as exact ones do. Where multigrid is slow they
# may be larger: of a block of ν = .499 by 1.6 with 60 vectors, so that more vectors are taken.
ROUGH = 1e-3


def _always() -> bool:
    return True


def _as_estimated() -> float:
    return 1.0


def _none() -> str:
    return ""


@dataclass(frozen=True)
class Inverse:
    """(K + s²M)⁻¹ as a method has set it up.

    Attributes
    ----------
    solve : callable
        f, shape (n,) or (n, m), ↦ (K + s²M)⁻¹ f.
    roughly : callable or None
        f, shape (n,), and ‖f - A x‖ / ‖f‖ ↦ (K + s²M)⁻¹ f, of a method that iterates.
    precondition : callable or None
        About (K + s²M)⁻¹, symmetric and much cheaper, of a method that iterates.
    at : callable or None
        s² ↦ the inverse at another shift, for less than setting up another one. There are factors
        for one shift at a time: do not alternate.
    below : callable or None
        s² ↦ the inverse at a smaller shift, for much less than setting up another one. Both serve
        from then on.
    within : callable or None
        Seconds ↦ the inverse that gives a solution up by ConvergenceError once it has taken so
        many, as `Method.seconds` estimates them: in so many iterations, the same at every run.
    pace : callable
        How many times as long as `Method.seconds` estimates a solution takes, by the last one; 1
        before the first.
    successor : callable
        The name of the method that has taken over from the one that was set up; empty before.
    """

    solve: Solve
    roughly: Callable[[FloatArray, float], FloatArray] | None = None
    precondition: Solve | None = None
    at: Callable[[float], Inverse] | None = None
    below: Callable[[float], Inverse] | None = None
    within: Callable[[float], Inverse] | None = None
    pace: Callable[[], float] = _as_estimated
    successor: Callable[[], str] = _none


@dataclass(frozen=True)
class Method:
    """A method of solution.

    Attributes
    ----------
    name : str
        What `solver=` calls it.
    set_up : callable
        Pencil ↦ Inverse. Raises SingularError.
    memory : callable
        Pencil ↦ bytes that it needs beside K and M, estimated.
    seconds : callable
        (Pencil, number of solutions) ↦ its time, estimated; infinite where it should not be taken.
    direct : bool
        Whether it factorises; else it iterates.
    is_installed : callable
        Whether its package is there.
    """

    name: str
    set_up: Callable[[Pencil], Inverse]
    memory: Callable[[Pencil], float]
    seconds: Callable[[Pencil, int], float]
    direct: bool = True
    is_installed: Callable[[], Any] = _always
