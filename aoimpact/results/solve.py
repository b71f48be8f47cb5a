"""One run of a plan, for a given time or until its impact is over."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from ..base import InputError, InputTypeError, LawLimitError, held_warnings, warn, with_unit
from ..integrate import Adaptive, Newmark, solve_adaptive, solve_newmark
from ..laws import PatchLaw, wider
from ..reduction import FullModel
from ..scene import Scenario
from .advice import touched
from .run import Result, Run

TimeSolver = Adaptive | Newmark

# With friction to as many digits as its coefficient has.
_BY_DEFAULT, _RUBBING = Adaptive(), Adaptive(rtol=1e-4)


def solve(plan: Scenario, solver: TimeSolver | None) -> Run:
    """Run a plan; by default to a tolerance, with a full model or damped friction in steps.

    Raises
    ------
    InputError
        If `solver` is `Adaptive`, and a damped law has friction.
    InputTypeError
        If `solver` is no solver.
    LawLimitError
        If a contact grows wider than its patches, or deeper than its table; with its number.
    """
    damped = any(contact.law.depends_on_rate for contact in plan.contacts)
    damped_friction = plan.oblique is not None and damped
    if solver is None:
        full = any(isinstance(body, FullModel) for body in plan.bodies)
        solver = _BY_DEFAULT if plan.oblique is None else _RUBBING
        if full or damped_friction:
            solver = Newmark()
    if not isinstance(solver, (Adaptive, Newmark)):
        raise InputTypeError(f"solver must be Adaptive(...) or Newmark(...), got {solver!r}")
    if isinstance(solver, Adaptive) and damped_friction:
        raise InputError(
            f"solver={solver!r} takes friction of elastic laws only, and a law is damped; "
            "take Newmark(), or leave it out"
        )
    try:
        with held_warnings() as said:
            recorder, error = (
                solve_adaptive(plan, solver)
                if isinstance(solver, Adaptive)
                else solve_newmark(plan, solver)
            )
        return (Run if plan.scene else Result)(plan, recorder, error, said=tuple(said))
    except LawLimitError as error:
        contact = None if error.contact is None else plan.contacts[error.contact]
        if contact is None or not isinstance(contact.law, PatchLaw):
            raise
        factor = wider(contact.law, plan.reduced_mass(contact), plan.fastest)
        if factor is None:
            raise
        radii = [tip.patch.radius for _, _, tip in touched(plan, contact) if tip.patch is not None]
        cure = "leave radius out, so that a patch carries the contact"
        if radii:
            cure = f"give the contact points radius={factor * max(radii):.2g} m or more"
        raise LawLimitError(
            f"{error.args[0].partition(': ')[0]}: the compliance of the mesh, "
            f"{contact.law.compliance:.3g} m/N, leaves nothing of the law; {cure}",
            error.contact,
        ) from None


# Longest record in units of the first guess, for contacts that do not end, as under gravity.
_MOST = 4096.0

# Length of the record in units of the time from the first contact's start to the last one's end,
# rounded up to one of so many lengths an octave, which models of little difference share.
AS_LONG_AGAIN, _LENGTHS = 2.0, 16.0


@dataclass
class RecordLength:
    """How long a scene is recorded, s.

    Attributes
    ----------
    length : float
        The duration given, or a first guess.
    given : bool
        Whether it was given.
    margin : float, optional
        By how much it is longer than the impact needs, if it was not given.
    """

    length: float
    given: bool
    margin: float = 0.0

    def __post_init__(self) -> None:
        self._longest = self.length if self.given else _MOST * self.length
        self._settled = self.given
        self._cut = False

    def reopen(self) -> None:
        """Let the next run determine the length of the record, unless it was given."""
        self._settled = self.given

    def run(self, plan: Scenario, solve: Callable[[Scenario], Run], *, last: bool = True) -> Run:
        """Run a plan for this length, or, where that is open, until its impact is over.

        Parameters
        ----------
        plan : Scenario
        solve : callable
        last : bool, optional
            Whether this run determines the length: not one with bodies that are rigid for a trial.
        """
        if self._settled:
            return solve(_lasting(plan, self.length))
        length, longest = self.length, self._longest + self.margin
        while True:
            run = solve(_lasting(plan, length))
            wanted = _until_over(run) + self.margin
            if wanted <= length or length >= longest:
                break
            further = wanted if math.isfinite(wanted) else AS_LONG_AGAIN * length
            length = min(further, longest)
        self._cut = wanted > length and any(events.contacts for events in run.events)
        self.length = min(wanted, length)
        self._settled = last
        return run if self.length == length else solve(_lasting(plan, self.length))

    def warn_if_cut(self) -> None:
        """Warn where the impact was not over after the longest record."""
        if self._cut:
            warn(
                f"duration: it was left out, and after {with_unit(self.length, 's')} the impact is "
                "not over: its numbers are those until then; give duration="
            )


def _lasting(plan: Scenario, length: float) -> Scenario:
    """The plan with that duration, s."""
    return plan if plan.duration == length else replace(plan, duration=length)


def _until_over(run: Run) -> float:
    """How long the record must be, s; infinite where that is not known yet."""
    touching = run.touching
    forced = run.plan.preload or run.plan.weighed or run.plan.loads
    if touching is None and not forced and run.each_contact:
        part = (of.indentation[-1] < of.indentation[0] for of in run.each_contact)
        if all(part):
            return run.duration  # bodies move on as they began: a spin may part them at once
    if touching is None or run.in_contact_at_end:
        return math.inf
    start, end = touching
    lengths = _LENGTHS * math.log2(start + AS_LONG_AGAIN * (end - start))
    return float(2.0 ** (math.ceil(lengths - 1e-9) / _LENGTHS))
