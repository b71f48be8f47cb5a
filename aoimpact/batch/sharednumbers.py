"""The fast path for impacts that share a model: numbers and their errors from calls of the core.

As for other plain impacts, each of them touches once and has parted before the record ends, without
a warning. Larger models and altered ones, by which errors are estimated, are run like the model
itself. All others go to `simulate`, which gives plain ones the same numbers, bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..accuracy import (
    CONTROLLED,
    Met,
    SharedPoint,
    alterations,
    checked_rtol,
    extrapolated,
    models_to_compare,
    safety_of,
    time_rule,
)
from ..base import AOImpactError, FloatArray, held_warnings
from ..integrate import Adaptive
from ..laws import Hertz, own_law
from ..reduction import BodyModel
from ..results import AS_LONG_AGAIN, MESH_LIMIT, QUANTITIES, warning_limits
from ..scene import Contact, Plan
from .briefs import Answer, Briefs
from .plain import ERROR
from .shared import SharedCase

_PLAIN = [name for name, one in QUANTITIES.items() if one.is_plain]

# The first guess of an open record, in contact times of rigid bodies.
_FIRST_LENGTH = 4.0

# Error of the peak force by the mesh from which `simulate` may warn of that of the force over the
# record. Of 51 impacts of docs/calibration.md with a warning it was 0.075 or more.
_COARSE = 0.5 * MESH_LIMIT


@dataclass(eq=False)
class _Impact:
    """An impact that may be plain, and what has been found of it.

    Attributes
    ----------
    plan : Plan
    larger : list of tuple of BodyModel
        The bodies with larger models.
    safety : float
        An error by the models is at most so many times the largest change by larger ones.
    most_model : float
        The tolerance of the models.
    rtol : float
        Relative tolerance of its integration.
    length : float
        Length of the record, s.
    rows : list of int
        Rows of the answers for the model and for larger ones.
    altered : list of ((float, float), int, bool)
        Scales of the changes that show other errors, where these answers stand, and whether the
        errors are by the mesh.
    """

    case: SharedCase
    plan: Plan
    larger: Sequence[tuple[BodyModel, ...]]
    safety: float
    most_model: float
    rtol: float
    length: float
    rows: list[int] = field(default_factory=list)
    altered: list[tuple[tuple[float, float], int, bool]] = field(default_factory=list)
    lag: float = 0.0

    def asked(
        self, bodies: Sequence[BodyModel], calls: Briefs, contact: Contact | None = None
    ) -> int:
        """Ask for a run with other bodies, or another contact; return its row."""
        joint = contact or self.plan.contacts[0]
        numbers = self.plan.velocities[0], joint.gap, self.length, self.rtol
        return calls.ask(calls.pair(bodies, joint.law), *numbers)

    def plain_at(self, answer: FloatArray) -> bool:
        """True if a run went well, with one touch that has ended."""
        return bool(
            answer[Answer.STATUS] == 0.0
            and answer[Answer.TOUCHES] == 1.0
            and answer[Answer.LASTING] == 0.0
            and answer[Answer.END] < self.length * (1.0 - 1e-12)
        )


def shared_numbers(cases: Sequence[Any], names: Iterable[str]) -> dict[int, dict[str, float]]:
    """Return the named numbers of the plain ones among some cases, with their errors.

    Parameters
    ----------
    cases : sequence
        Those that are no `SharedCase` are left out.
    names : iterable of str
        Names in PLAIN_NUMBERS.
    """
    started = {i: _started(case) for i, case in enumerate(cases) if isinstance(case, SharedCase)}
    impacts = {i: of for i, of in started.items() if of is not None}
    if not impacts:
        return {}
    calls = Briefs()
    # The largest model determines the length of a record that is left out.
    for of in impacts.values():
        of.rows = [of.asked(of.larger[-1], calls)]
    answers = calls.run()
    impacts = {i: of for i, of in impacts.items() if of.plain_at(answers[of.rows[0]])}
    for of in impacts.values():
        if not of.case.impact.record.given:
            start, end = answers[of.rows[0], Answer.START : Answer.END + 1].tolist()
            of.length = start + AS_LONG_AGAIN * (end - start)
        others = [of.plan.bodies, *of.larger[:-1]]
        of.rows = [*(of.asked(bodies, calls) for bodies in others), *of.rows]
    answers = calls.run()
    impacts = {
        i: of
        for i, of in impacts.items()
        if all(of.plain_at(answers[row]) for row in of.rows)
        and _alter(of, answers[of.rows[0]], calls)
    }
    answers = calls.run()
    plain = [
        i for i, of in impacts.items() if all(of.plain_at(answers[row]) for _, row, _ in of.altered)
    ]
    found = _kept([impacts[i] for i in plain], tuple(names), calls)
    return {i: kept for i, kept in zip(plain, found, strict=True) if kept is not None}


def _started(case: SharedCase) -> _Impact | None:
    """A case as it is begun; None where `simulate` has to look at it."""
    impact, solver, rtol = case.impact, case.solver, case.case.get("rtol")
    if not case.plain or not (solver is None or isinstance(solver, Adaptive)):
        return None
    if type(own_law(impact.law)) is not Hertz or impact.velocity < 0.0:
        return None
    if case.quantity not in _PLAIN:
        return None
    models = models_to_compare(impact.bodies)
    with held_warnings() as messages:
        try:
            plan = impact.plan(models[0], impact.record.length)
            rule, _ = time_rule(solver, checked_rtol(rtol), given=rtol is not None)
        except AOImpactError:
            return None
    if messages or not all(body.centre_known for body in plan.bodies):
        return None
    larger = models[1:]
    points = [body for body in impact.bodies if isinstance(body, SharedPoint)]
    quantity = QUANTITIES[case.case.get("quantity") or "force"]
    safety = safety_of(quantity, exact=all(point.exact for point in points))
    length = impact.record.length * (1.0 if impact.record.given else _FIRST_LENGTH)
    return _Impact(case, plan, larger, safety, points[0].rtol, rule.rtol, length)


def _alter(of: _Impact, answer: FloatArray, calls: Briefs) -> bool:
    """Ask for the runs that show the errors by mesh and law; False where `simulate` must look.

    answer: that for the model.
    """
    law, force = own_law(of.case.impact.law), float(answer[Answer.PEAK_FORCE])
    most_force, most_speed = warning_limits(of.plan)
    if force > most_force or of.plan.velocities[0] > most_speed:
        return False
    assert isinstance(law, Hertz)
    depth = math.pow(force / law.k, 2.0 / 3.0)
    end, peak = (float(answer[at] - answer[Answer.START]) for at in (Answer.END, Answer.PEAK_TIME))
    met = Met(end, peak, depth)
    try:
        found = alterations(of.plan, [met], (of.case.impact.law_error,))
    except AOImpactError:
        return False
    if found is None:
        return False
    of.lag = found.lag
    rows: dict[int, int] = {}
    for causes, by_mesh in ((found.mesh, True), (found.contact, False)):
        for altered in (next(iter(ways)) for ways in causes):
            if (plan := altered.plan) is not None:
                if id(plan) not in rows:
                    rows[id(plan)] = of.asked(plan.bodies, calls, plan.contacts[0])
                size = altered.size, altered.scale
                of.altered.append((size, rows[id(plan)], by_mesh))
    return True


def _kept(
    impacts: Sequence[_Impact], names: Sequence[str], calls: Briefs
) -> list[dict[str, float] | None]:
    """The numbers of impacts with their errors, as `Named` keeps them; None of one not plain."""
    count, speeds, events = len(impacts), calls.speeds, calls.events
    rows = np.array([of.rows[0] for of in impacts], dtype=np.intp)
    # Impacts and rows of the runs that theirs are compared with.
    pairs = [(i, at) for i, of in enumerate(impacts) for at in of.rows[1:]]
    safety = np.array([of.safety for of in impacts])
    lag = np.array([of.lag for of in impacts])
    of_mesh, of_law = (
        [
            (i, at, *size)
            for i, of in enumerate(impacts)
            for size, at, by_mesh in of.altered
            if by_mesh is kind
        ]
        for kind in (True, False)
    )

    def parts(name: str) -> tuple[FloatArray, list[FloatArray]]:
        """A number of all impacts, and its errors by model, mesh and law."""
        values, errors = QUANTITIES[name].of_plain(events, speeds), []
        for some, add in ((pairs, np.maximum), (of_mesh, np.add), (of_law, np.add)):
            error = np.zeros(count)
            if some:
                which, at, *size = (np.array(column) for column in zip(*some, strict=True))
                changes = QUANTITIES[name].relative_changes(
                    values[rows[which]], values[at], speeds.before[:, at]
                )
                scaled = extrapolated(changes, *size) if size else safety[which] * changes
                add.at(error, which, scaled)
            errors.append(error + lag if some is of_mesh else error)
        return values[rows], errors

    rtol = np.array([of.rtol for of in impacts])
    tolerance = np.array([of.most_model for of in impacts])
    columns: dict[str, FloatArray] = {}
    for name in names:
        if name == ERROR:
            columns[name] = rtol
            continue
        columns[name], (model, mesh, law) = parts(name)
        columns[f"{name}_error"] = mesh + law + model + rtol
        columns[f"{name}{CONTROLLED}"] = (model <= tolerance).astype(np.float64)
    proofs = {name: parts(name)[1][0] for name in {of.case.quantity for of in impacts}}
    coarse = parts("peak_force")[1][1] > _COARSE
    table = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [
        None
        if proofs[of.case.quantity][i] > of.most_model or coarse[i]
        else dict(zip(columns, row, strict=True))
        for i, (of, row) in enumerate(zip(impacts, table, strict=True))
    ]
