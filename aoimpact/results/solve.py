"""One run of a plan, for a given duration or until its impact is over."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from ..base import (
    AOImpactError,
    InputError,
    InputTypeError,
    LawLimitError,
    held_warnings,
    warn,
    with_unit,
)
from ..integrate import Adaptive, Newmark, solve_adaptive, solve_newmark
from ..laws import PatchLaw, removable
from ..reduction import FullModel
from ..scene import Scenario
from .run import Result, Run

TimeSolver = Adaptive | Newmark

# _BY_DEFAULT: default solver. _RUBBING: default solver with friction, whose coefficient is known to
# few digits.
_BY_DEFAULT, _RUBBING = Adaptive(), Adaptive(rtol=1e-4)


def time_solver(plan: Scenario, solver: TimeSolver | None) -> TimeSolver:
    """Return the checked solver; by default `Newmark` for a full model or friction with damping.

    The default for all other plans is `Adaptive`.

    Raises
    ------
    InputError
        If `solver` is `Adaptive`, and a rate-dependent law has friction.
    InputTypeError
        If `solver` is no solver.
    """
    damped_friction = plan.oblique is not None and any(
        contact.law.depends_on_rate for contact in plan.contacts
    )
    if solver is None:
        if damped_friction or FullModel in map(type, plan.bodies):
            return Newmark()
        return _BY_DEFAULT if plan.oblique is None else _RUBBING
    if not isinstance(solver, (Adaptive, Newmark)):
        raise InputTypeError(f"solver must be Adaptive(...) or Newmark(...), got {solver!r}")
    if isinstance(solver, Adaptive) and damped_friction:
        raise InputError(
            f"solver={solver!r} takes friction of elastic laws only, and a law is damped; "
            "take Newmark(), or leave it out"
        )
    return solver


def solve(plan: Scenario, solver: TimeSolver | None) -> Run:
    """Run a plan; see `time_solver`.

    Raises
    ------
    InputError, InputTypeError
        As for `time_solver`.
    LawLimitError
        If a contact grows wider than its patches, or an indentation exceeds the table of its law;
        the error has the contact's number.
    """
    solver = time_solver(plan, solver)
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
        radii = [tip.patch.radius for *_, tip in plan.touched(contact) if tip.patch is not None]
        cure = "leave radius out, so that a patch carries the contact"
        if radii and plan.fastest > 0.0:
            # Rigid bodies give an upper bound of the indentation. The compliance of a patch is
            # inversely proportional to its radius.
            own, mass = contact.law.law, plan.reduced_mass(contact)
            most = removable(own, own.stroke(0.5 * mass * plan.fastest**2))
            wider = 1.2 * max(contact.law.compliance / most, 1.0) * max(radii)
            cure = f"give the contact points radius={wider:.2g} m or more, or take smaller elements"
        raise LawLimitError(
            f"{error.args[0].partition(': ')[0]}: the compliance of the mesh, "
            f"{contact.law.compliance:.3g} m/N, leaves nothing of the law; {cure}",
            error.contact,
        ) from None


# Longest record, in units of the first guess of its length, for contacts that never end, such as
# under gravity.
_MOST = 4096.0

# AS_LONG_AGAIN: ratio of the record's length, from the first touch on, to the time between first
# touch and last release. _LENGTHS: number of values per octave to which the length is rounded up,
# so that runs of models that hardly differ have records of the same length.
AS_LONG_AGAIN, _LENGTHS = 2.0, 16.0


@dataclass
class RecordLength:
    """Duration of a scene's record, given or determined by the impact.

    Attributes
    ----------
    length : float
        Duration given or, if none was given, its first guess, s.
    given : bool
        True if the duration was given.
    margin : float, optional
        Time added to the duration that the impact needs, if no duration was given, s.
    settled : bool, optional
        False to let the next run determine a duration that was not given.
    """

    length: float
    given: bool
    margin: float = 0.0
    settled: bool = False
    _longest: float = 0.0
    _cut: bool = False

    def run(self, plan: Scenario, solver: TimeSolver | None) -> Run:
        """Run a plan for the given or settled duration, or else until the impact is over."""
        if self.given or self.settled:
            return solve(_lasting(plan, self.length), solver)
        self._longest = self._longest or _MOST * self.length
        length, longest = self.length, self._longest + self.margin
        run = _ahead(plan, length, solver)
        while True:
            found = _shortened(run, length)
            wanted = _until_over(found) + self.margin
            if wanted <= length or length >= longest:
                break
            further = wanted if math.isfinite(wanted) else AS_LONG_AGAIN * length
            length = min(further, longest)
            run = run if run.duration >= length else _ahead(plan, length, solver)
        self._cut = wanted > length and found.touching is not None
        self.length = min(wanted, length)
        self.settled = True
        found = _shortened(run, self.length)
        whole = found.duration == self.length and found.events == run.events
        return found if whole else solve(_lasting(plan, self.length), solver)

    def warn_if_cut(self) -> None:
        """Warn if the impact was not over at the end of the longest record."""
        if self._cut:
            warn(
                f"duration: it was left out, and after {with_unit(self.length, 's')} the impact is "
                "not over: its numbers are values up to this time; give duration="
            )


def _lasting(plan: Scenario, length: float) -> Scenario:
    """Return the plan with the duration `length`, s."""
    return plan if plan.duration == length else replace(plan, duration=length)


def _ahead(plan: Scenario, length: float, solver: TimeSolver | None) -> Run:
    """Return a run of at least `length`, s; longer with `Adaptive`, where free motion is cheap."""
    if isinstance(time_solver(plan, solver), Adaptive):
        with suppress(AOImpactError):  # an error may come from a contact after `length`
            return solve(_lasting(plan, AS_LONG_AGAIN * 2.0 ** (1.0 / _LENGTHS) * length), solver)
    return solve(_lasting(plan, length), solver)


def _shortened(run: Run, length: float) -> Run:
    """Return the part of a run up to `length`, s; the whole run if it has fixed steps.

    Peak force and impulse of each contact remain those of the whole run.
    """
    if not run.recorder.dense or run.duration <= length:
        return run
    plan, events = _lasting(run.plan, length), []
    for of in run.events:
        spans = tuple([(start, min(end, length)) for start, end in of.contacts if start < length])
        events.append(of._replace(contacts=spans))
    recorder: Any = run.recorder
    return replace(run, plan=plan, recorder=replace(recorder, plan=plan, events=tuple(events)))


def _until_over(run: Run) -> float:
    """Return the duration that the record must have, s; infinite while it is not known."""
    touching = run.touching
    forced = run.plan.preload or run.plan.weighed or run.plan.loads
    if touching is None and not forced and run.each_contact:
        part = (of.indentation[-1] < of.indentation[0] for of in run.each_contact)
        if all(part):
            return run.duration  # bodies part from the start, for instance due to a spin
    if touching is None or run.in_contact_at_end:
        return math.inf
    start, end = touching
    lengths = _LENGTHS * math.log2(start + AS_LONG_AGAIN * (end - start))
    return float(2.0 ** (math.ceil(lengths - 1e-9) / _LENGTHS))
