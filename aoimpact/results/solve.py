"""One run of a plan, by the solver that was given or the one that suits its bodies."""

from __future__ import annotations

from ..base import InputTypeError, LawLimitError
from ..integrate import Adaptive, Newmark, solve_adaptive, solve_newmark
from ..laws import PatchLaw, wider
from ..scene import Contact, FullBody, Plan
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
        if not isinstance(contact.law, PatchLaw):
            raise
        factor = wider(contact.law, plan.reduced_mass(contact), plan.fastest)
        if factor is None:
            raise
        raise _too_narrow(error, plan, contact, factor) from None


def _too_narrow(error: LawLimitError, plan: Plan, contact: Contact, factor: float) -> LawLimitError:
    """The error of a contact that is stiffer than the meshes under it, with the cure."""
    assert isinstance(contact.law, PatchLaw)
    tips = [plan.bodies[body].model.touched_at(port) for body, port in contact.ports]
    radii = [tip.patch.radius for tip in tips if tip is not None and tip.patch is not None]
    cure = "leave radius out, so that a patch carries the contact"
    if radii:
        cure = f"give the contact points radius={factor * max(radii):.2g} m or more"
    return LawLimitError(
        f"{error.args[0].partition(': ')[0]}: the compliance of the mesh, "
        f"{contact.law.compliance:.3g} m/N, leaves nothing of the law; {cure}",
        error.contact,
    )
