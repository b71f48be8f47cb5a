"""The fast path for impacts that share a model: numbers and their errors from calls of the core.

As for other plain impacts, each of them touches once and has parted before the record ends, without
a warning. Larger models and altered ones, by which errors are estimated, are run like the model
itself. All others go to `simulate`, which gives plain ones the same numbers, bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .. import _core
from ..accuracy import (
    CONTROLLED,
    Altered,
    Met,
    SharedPoint,
    alterations,
    checked_rtol,
    models_to_compare,
    safety_of,
    time_rule,
)
from ..base import AOImpactError, FloatArray, held_warnings
from ..integrate import Adaptive, Events
from ..laws import Hertz, own_law
from ..reduction import ModalBody
from ..results import QUANTITIES, Speeds, warning_limits
from ..scene import Plan, scene_body
from .plain import ANSWERS, ERROR, Answer
from .shared import SharedCase

__all__ = ["shared_numbers"]

# The first guess of an open record, in contact times of rigid bodies.
_FIRST_LENGTH = 4.0

# The error by elements of first order from which `simulate` may warn of them.
_COARSE = 0.1


@dataclass(eq=False)
class _Impact:
    """An impact that may be plain, and what has been found of it.

    Attributes
    ----------
    plans : list of Plan
        With the models, and with the larger ones.
    rtol : float
        Of its integration.
    length : float
        Of the record, s.
    rows : list of int
        Where its answers stand, as `plans`.
    altered : list of (Altered, int, bool)
        Plans that show other errors, where their answers stand, and whether these are by the mesh.
    """

    case: SharedCase
    plans: list[Plan]
    rtol: float
    length: float
    rows: list[int] = field(default_factory=list)
    altered: list[tuple[Altered, int, bool]] = field(default_factory=list)


@dataclass
class _Calls:
    """What the core is asked for and has answered, a row for each run."""

    bodies: list[ModalBody] = field(default_factory=list)
    laws: list[Any] = field(default_factory=list)
    places: list[tuple[int, int, int]] = field(default_factory=list)
    numbers: list[tuple[float, float, float, float]] = field(default_factory=list)
    plans: list[Plan] = field(default_factory=list)
    answers: list[FloatArray] = field(default_factory=list)
    _known: dict[int, int] = field(default_factory=dict)

    def ask(self, plan: Plan, length: float, rtol: float) -> int:
        """Add a run; return its row."""
        contact = plan.contacts[0]
        first, second = (self._place(body) for body in plan.modal)
        law = self._known.setdefault(id(contact.law), len(self.laws))
        if law == len(self.laws):
            self.laws.append(contact.law.for_core())
        self.places.append((first, second, law))
        self.numbers.append((plan.velocities[0], contact.gap, length, rtol))
        self.plans.append(plan)  # and so no identity is used twice
        return len(self.plans) - 1

    def _place(self, body: ModalBody) -> int:
        place = self._known.setdefault(id(body), len(self.bodies))
        if place == len(self.bodies):
            self.bodies.append(body)
        return place

    def answer(self) -> FloatArray:
        """Run what has been asked since the last time; return all answers, shape (rows, 10)."""
        done = sum(map(len, self.answers))
        new = np.empty((len(self.plans) - done, ANSWERS))
        _core.briefs(
            tuple(body.for_core() for body in self.bodies),
            tuple(body.moving for body in self.bodies),
            tuple(self.laws),
            np.array(self.places[done:], dtype=np.int32).reshape(-1, 3),
            np.array(self.numbers[done:]).reshape(-1, 4),
            new,
        )
        self.answers.append(new)
        return np.concatenate(self.answers)


def shared_numbers(cases: Sequence[Any], names: Iterable[str]) -> dict[int, dict[str, float]]:
    """Return the named numbers of the plain ones among some cases, with their errors.

    Parameters
    ----------
    cases : sequence
        Those that are no `SharedCase` are left out.
    names : iterable of str
        Of PLAIN_NUMBERS.
    """
    wanted = tuple(names)
    started = {i: _started(case) for i, case in enumerate(cases) if isinstance(case, SharedCase)}
    impacts = {i: impact for i, impact in started.items() if impact is not None}
    if not impacts:
        return {}
    calls = _Calls()
    # The largest model determines the length of a record that is left out.
    for impact in impacts.values():
        impact.rows = [calls.ask(impact.plans[-1], impact.length, impact.rtol)]
    answers = calls.answer()
    impacts = {i: of for i, of in impacts.items() if _is_plain(answers[of.rows[0]], of)}
    for impact in impacts.values():
        if not impact.case.impact.record.given:
            start, end = answers[impact.rows[0], Answer.START : Answer.END + 1]
            impact.length = start + 2.0 * (end - start)
        rows = [calls.ask(plan, impact.length, impact.rtol) for plan in impact.plans[:-1]]
        impact.rows = [*rows, *impact.rows]
    answers = calls.answer()
    impacts = {
        i: of
        for i, of in impacts.items()
        if all(_is_plain(answers[row], of) for row in of.rows) and _alter(of, answers, calls)
    }
    answers = calls.answer()
    impacts = {
        i: of
        for i, of in impacts.items()
        if all(_is_plain(answers[row], of) for _, row, _ in of.altered)
    }
    table = _numbers({*wanted, "peak_force"} - {ERROR}, calls, answers)
    kept = ((i, _kept(of, wanted, table)) for i, of in impacts.items())
    return {i: numbers for i, numbers in kept if numbers is not None}


def _started(case: SharedCase) -> _Impact | None:
    """A case as it is begun; None where `simulate` has to look at it."""
    impact, solver, rtol = case.impact, case.case.get("solver"), case.case.get("rtol")
    if not case.plain or not (solver is None or isinstance(solver, Adaptive)):
        return None
    if QUANTITIES[case.proof].is_history or type(own_law(impact.law)) is not Hertz:
        return None
    if impact.numbers.velocity < 0.0:
        return None
    with held_warnings() as messages:
        try:
            models = models_to_compare(impact.bodies)
            plans = [impact.plan(models[0], False)]
            for larger in models[1:]:
                plans.append(_with_models(plans[0], larger))
            rule, _ = time_rule(solver, checked_rtol(rtol), given=rtol is not None)
        except AOImpactError:
            return None
    if messages or not all(body.centre_known for body in plans[0].bodies):
        return None
    length = impact.record.length
    if not impact.record.given:
        length *= _FIRST_LENGTH
    return _Impact(case, plans, rule.rtol, length)


def _is_plain(answer: FloatArray, impact: _Impact) -> bool:
    """Whether a run went well, with one touch that has ended, and force and speed no warning."""
    length = impact.length * (1.0 - 1e-12)
    return bool(
        answer[Answer.STATUS] == 0.0
        and answer[Answer.TOUCHES] == 1.0
        and answer[Answer.LASTING] == 0.0
        and answer[Answer.END] < length
    )


def _alter(impact: _Impact, answers: FloatArray, calls: _Calls) -> bool:
    """Ask for the runs that show the errors by mesh and law; False where they are not known."""
    answer, plan, law = answers[impact.rows[0]], impact.plans[0], impact.case.impact.law
    assert isinstance(law, Hertz)
    force = float(answer[Answer.PEAK_FORCE])
    most_force, most_speed = warning_limits(plan)
    if force > most_force or plan.velocities[0] > most_speed:
        return False
    depth = math.pow(force / law.k, 2.0 / 3.0)
    met = Met(float(answer[Answer.END] - answer[Answer.START]), depth)
    try:
        found = alterations(plan, [met], (impact.case.impact.law_error,))
    except AOImpactError:
        return False
    if found is None:
        return False
    for causes, by_mesh in ((found.mesh, True), (found.contact, False)):
        for first, *_ in causes:
            if first.plan is not None:
                row = calls.ask(first.plan, impact.length, impact.rtol)
                impact.altered.append((first, row, by_mesh))
    return True


def _numbers(names: Iterable[str], calls: _Calls, answers: FloatArray) -> _Table:
    """The named numbers of all runs, a column each."""
    of: Any = answers.T
    velocity = np.array([numbers[0] for numbers in calls.numbers])
    drift = np.array([_drift(plan) for plan in calls.plans])
    speeds = Speeds(
        np.array([velocity, np.zeros_like(velocity)]),
        np.array([of[Answer.FIRST] + drift * velocity, of[Answer.SECOND]]),
        np.array([[body.fixed for body in plan.bodies] for plan in calls.plans]).T,
    )
    events = Events(
        of[Answer.PEAK_FORCE],
        of[Answer.PEAK_TIME],
        ((of[Answer.START], of[Answer.END]),),
        of[Answer.IMPULSE],
    )
    values = {name: QUANTITIES[name].of_plain(events, speeds) for name in names}
    return _Table(values, speeds.before)


def _drift(plan: Plan) -> float:
    """Share of the projectile's velocity that its centre of mass keeps whatever happens."""
    share, mass = plan.bodies[0].omitted
    return share if mass else 0.0


@dataclass(frozen=True)
class _Table:
    """Numbers of many runs, by name, and the velocities at the start, shape (2, runs)."""

    values: dict[str, FloatArray]
    before: FloatArray

    def change(self, name: str, row: int, others: Sequence[int]) -> float:
        """By how much a number of a run differs from those of others, at most."""
        value, before = self.values[name], self.before[:, others]
        changes = QUANTITIES[name].relative_changes(value[row], value[others], before)
        return float(changes.max(initial=0.0))


def _kept(impact: _Impact, names: Sequence[str], table: _Table) -> dict[str, float] | None:
    """The numbers of an impact with their errors, as `Named` keeps them; None if not plain."""
    points = [body for body in impact.case.impact.bodies if isinstance(body, SharedPoint)]
    quantity = QUANTITIES[impact.case.case.get("quantity") or "force"]
    safety = safety_of(quantity, exact=all(point.exact for point in points))
    row, *larger = impact.rows

    def of_mesh(name: str) -> float:
        return math.fsum(
            altered.scale * table.change(name, row, [at])
            for altered, at, by_mesh in impact.altered
            if by_mesh
        )

    if safety * table.change(impact.case.proof, row, larger) > points[0].rtol:
        return None
    quadratic = all(point.body.mesh is None or point.body.mesh.quadratic for point in points)
    if not quadratic and of_mesh("peak_force") > _COARSE:
        return None
    kept: dict[str, float] = {}
    for name in names:
        if name == ERROR:
            kept[name] = impact.rtol
            continue
        model = safety * table.change(name, row, larger)
        contact = math.fsum(
            altered.scale * table.change(name, row, [at])
            for altered, at, by_mesh in impact.altered
            if not by_mesh
        )
        kept[name] = float(table.values[name][row])
        kept[f"{name}_error"] = of_mesh(name) + contact + model + impact.rtol
        kept[f"{name}{CONTROLLED}"] = float(model <= points[0].rtol)
    return kept


def _with_models(plan: Plan, models: Sequence[Any]) -> Plan:
    """A plan with larger models of its bodies; its law is the same."""
    bodies = [
        body if model is body.model else scene_body("body", model, body.velocity)
        for body, model in zip(plan.bodies, models, strict=True)
    ]
    return replace(plan, bodies=tuple(bodies))
