"""One run of a plan, by the solver that was given or the one that suits its bodies."""

from __future__ import annotations

from ..base import InputTypeError, LawLimitError
from ..integrate import Adaptive, Newmark, solve_adaptive, solve_newmark
from ..laws import wide_enough
from ..scene import FullBody, Plan
from .run import Run

__all__ = ["TimeSolver", "solve"]

TimeSolver = Adaptive | Newmark

_BY_DEFAULT = Adaptive()


def solve(plan: Plan, solver: TimeSolver | None) -> Run:
    """Run a plan; by default to a tolerance, with a full finite-element model by Newmark's rule.

    Raises
    ------
    InputTypeError
        If `solver` is no solver.
    LawLimitError
        If a contact grows wider than its patches, or deeper than its table; with its number.
    """
    if solver is None:
        full = any(isinstance(body, FullBody) for body in plan.bodies)
        solver = Newmark() if full else _BY_DEFAULT
    if not isinstance(solver, (Adaptive, Newmark)):
        raise InputTypeError(f"solver must be Adaptive(...) or Newmark(...), got {solver!r}")
    try:
        if isinstance(solver, Adaptive):
            return Run(plan, *solve_adaptive(plan, solver))
        return Run(plan, *solve_newmark(plan, solver))
    except LawLimitError as error:
        if error.contact is None:
            raise
        contact = plan.contacts[error.contact]
        mass = plan.reduced_mass(contact)
        ends = [plan.bodies[body].model.touched_at(port) for body, port in contact.ports]
        raise wide_enough(error, contact.law, ends, mass, plan.fastest) from None
