"""Impacts on the same contact point: it is reduced once, for the hardest of them.

The patch is that of the widest contact, the vectors suit the shortest contact and the longest
record. The number of vectors is that which the shortest and the longest contact need. Every impact
is then run with this model and with larger ones, so that its error by the model is its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from ..accuracy import KrylovHierarchy, SharedPoint, larger_orders
from ..base import AOImpactError, boolean, held_warnings, warn
from ..fem import ContactPoint
from ..impact import Impact, Meeting, fitted, simulate
from ..integrate import Adaptive
from ..linalg import LinearSolver
from ..reduction import AOModel, BodyModel, body_model
from ..results import Result, TimeSolver

_NAMES = ("projectile", "target")

# Arguments that must be the same for impacts that share a model; all others may differ.
_ALIKE = ("quantity", "rtol", "solver", "linear_solver")

# The widest contact of impacts that share a patch over the narrowest: patches with a radius of up
# to five times that of the contact give the same force to 0.1 %, and the widest has 1.4.
_AS_WIDE = 3.5

# Records of more than so many of the shortest contacts need vectors for slow motion as well.
_LONG = 4.0

# Error of time integration over that of the models, where no tolerance is given: a tenth of
# this would take 20 to 60 % more time.
_SHARE_OF_TIME = 0.05


@dataclass(frozen=True, eq=False)
class SharedCase:
    """An impact whose contact points have models that it shares with others.

    Attributes
    ----------
    case : mapping
        As its user gave it.
    impact : Impact
        With the shared points for bodies.
    solver : Adaptive, Newmark or None
        As given; if left out, one that suits the models' tolerance.
    plain : bool
        True if the hardest impacts had no warnings.
    """

    case: Mapping[str, Any]
    impact: Impact
    solver: TimeSolver | None
    plain: bool

    @property
    def quantity(self) -> Any:
        """The quantity whose error by the models must be within the tolerance.

        The peak force stands for the force if neither is given.
        """
        if self.case.get("rtol") is None and self.case.get("quantity") in (None, "force"):
            return "peak_force"
        return self.case.get("quantity") or "force"

    def simulate(self) -> Result:
        """Return the result with the shared models, or with its own where these are not enough."""
        with held_warnings() as messages:
            hit = self._within_tolerance()
        if hit is None:
            return simulate(**self.case)
        for message in messages:
            warn(message)
        return hit

    def _within_tolerance(self) -> Result | None:
        try:
            hit = simulate(**_with(self.case, self.impact.bodies) | {"solver": self.solver})
        except AOImpactError:
            return None
        chosen = hit.chosen
        assert chosen is not None
        name = "peak_force" if self.quantity == "peak_force" else chosen.quantity
        return hit if chosen.numbers[name] <= chosen.rtol else None


class _Foreseen(NamedTuple):
    """An impact among some cases, and its contact as rigid bodies foresee it."""

    number: int
    impact: Impact
    met: Meeting

    @property
    def radius(self) -> float:
        """Radius of the contact, m; 0 where the law has no surface."""
        return self.met.contact_radius or 0.0

    @property
    def length(self) -> float:
        """Length of the motion that matters, s."""
        impact = self.impact
        if impact.record.given:
            return max(impact.record.length - impact.gap / abs(impact.velocity), 0.0)
        return 2.0 * self.met.contact_time


def share_models(
    cases: Sequence[Any], keywords: Sequence[str], required: Sequence[str]
) -> list[Any]:
    """Return cases, in place of those on one contact point ones that share its model.

    Parameters
    ----------
    cases : sequence
        As of `simulate_many`.
    keywords, required : sequence of str
        Those of `simulate`, and which of them it needs.
    """
    found = list(cases)
    groups: dict[tuple[Any, ...], list[int]] = {}
    for i, case in enumerate(cases):
        complete = isinstance(case, Mapping) and set(required) <= case.keys() <= set(keywords)
        if complete and (key := _key(case)) is not None:
            groups.setdefault(key, []).append(i)
    for members in groups.values():
        if len(members) > 1:
            bodies = [cases[members[0]][name] for name in _NAMES]
            points = {id(of): SharedPoint((of,)) for of in bodies if isinstance(of, ContactPoint)}
            foreseen = [_foreseen(i, cases[i], points) for i in members]
            for alike in _as_wide([of for of in foreseen if of is not None]):
                if len(alike) > 1:
                    _share(cases, alike, found)
    return found


def _key(case: Mapping[str, Any]) -> tuple[Any, ...] | None:
    """Key that cases with the same models have in common; None for a case that shares none."""
    bodies = [case.get(name) for name in _NAMES]
    points = [id(body) if isinstance(body, ContactPoint) else None for body in bodies]
    if case.get("friction") is not None:  # models with three functionals are not shared
        return None
    if not any(points) or not all(isinstance(body, ContactPoint | AOModel) for body in bodies):
        return None
    # By value where equal values are the same; the cases outlive the identities of all others.
    options = [case.get(name) for name in _ALIKE]
    return (
        *points,
        *(repr(of) if isinstance(of, str | float | TimeSolver) else id(of) for of in options),
    )


def _foreseen(
    number: int, case: Mapping[str, Any], points: Mapping[int, SharedPoint]
) -> _Foreseen | None:
    """An impact as its rigid bodies foresee it; None of one that is refused or warned of.

    points: its contact points, by their identity.
    """
    with held_warnings() as messages:
        try:
            bodies = _bodies(case, (False, False), lambda tip, _: points[id(tip)])
            given = {name: case[name] for name in ("gap", "duration") if name in case}
            boolean("energies", case.get("energies", True))
            impact = Impact(*bodies, case["velocity"], **given)
            impact.touch(case.get("law"))
        except AOImpactError:
            return None
    met = impact.met
    return None if messages or met is None else _Foreseen(number, impact, met)


def _bodies(
    case: Mapping[str, Any],
    turns: Sequence[bool],
    shared: Callable[[ContactPoint, bool], BodyModel],
) -> tuple[BodyModel, BodyModel]:
    """The bodies of a case; a contact point by a function of it and whether it must be turned."""
    first, second = (
        shared(body, turn) if isinstance(body, ContactPoint) else body_model(name, body)
        for name, body, turn in zip(_NAMES, map(case.__getitem__, _NAMES), turns, strict=True)
    )
    return first, second


def _as_wide(foreseen: Sequence[_Foreseen]) -> list[list[_Foreseen]]:
    """Impacts by the width of their contacts, which is about the same in each list."""
    widest = max((of.radius for of in foreseen), default=0.0)
    alike: dict[int, list[_Foreseen]] = {}
    for of in foreseen:
        narrow = int(math.log(widest / of.radius) / math.log(_AS_WIDE)) if of.radius else -1
        alike.setdefault(narrow, []).append(of)
    return list(alike.values())


def _share(cases: Sequence[Any], alike: Sequence[_Foreseen], found: list[Any]) -> None:
    """Reduce the contact points of impacts that are alike, and put their cases into `found`."""
    shortest = min(of.met.contact_time for of in alike)
    longest = max(of.length for of in alike)
    widest = max(of.radius for of in alike)
    met = Meeting(shortest, widest or None)
    slow = longest if longest > _LONG * shortest else None
    linear_solver = cases[alike[0].number].get("linear_solver") or "auto"
    factors: dict[Any, LinearSolver] = {}
    points: dict[tuple[int, bool], SharedPoint] = {}
    chosen: dict[tuple[int, bool], list[Any]] = {}

    def fresh(tip: ContactPoint, turn: bool) -> SharedPoint:
        if (key := (id(tip), turn)) not in points:
            whole = fitted(body_model("body", tip.reversed() if turn else tip), 0, met, factors)
            (there,) = whole.contact_points
            factor = factors.get(there.body) if linear_solver == "auto" else None
            hierarchy = KrylovHierarchy((there,), shortest, slow, linear_solver, factor)
            points[key] = SharedPoint((there,), hierarchy=hierarchy)
        return points[key]

    rtol = 0.0
    try:
        with held_warnings() as messages:
            for i, impact, _ in _hardest(alike):
                hit = simulate(**_with(cases[i], _bodies(cases[i], impact.turned, fresh)))
                _ = hit.error  # which may warn
                assert hit.chosen is not None
                rtol = max(rtol, hit.chosen.rtol)
                if hit.chosen.numbers[hit.chosen.quantity] > rtol:
                    return  # no models meet it; each is as good as it can be by itself
                for name, turn, model in zip(_NAMES, impact.turned, hit.models, strict=True):
                    chosen.setdefault((id(cases[i][name]), turn), []).append(model)
    except AOImpactError:
        return  # each by itself, with its own message
    settled = {key: _settled(point, chosen[key], rtol) for key, point in points.items()}
    for i, impact, _ in alike:
        bodies = _bodies(cases[i], impact.turned, lambda tip, turn: settled[id(tip), turn])
        shared = impact.with_bodies(bodies)
        solver = cases[i].get("solver")
        if solver is None and cases[i].get("rtol") is None:
            solver = Adaptive(rtol=_SHARE_OF_TIME * rtol)
        found[i] = SharedCase(cases[i], shared, solver, not messages)


def _with(case: Mapping[str, Any], bodies: Sequence[BodyModel]) -> dict[str, Any]:
    """A case with other bodies."""
    return {**case, **dict(zip(_NAMES, bodies, strict=True))}


def _hardest(alike: Sequence[_Foreseen]) -> list[_Foreseen]:
    """The impacts with the shortest and the longest contact, and with the longest record."""

    def speed(of: _Foreseen) -> float:
        return abs(of.impact.velocity)

    by_time = sorted(alike, key=lambda of: (of.met.contact_time, speed(of)))
    by_length = max(alike, key=lambda of: (of.length, speed(of)))
    return list({of.number: of for of in (by_time[0], by_time[-1], by_length)}.values())


def _settled(point: SharedPoint, chosen: Sequence[Any], rtol: float) -> SharedPoint:
    """A contact point with the largest of some models that were chosen for it."""
    hierarchy = point.hierarchy
    assert isinstance(hierarchy, KrylovHierarchy)
    order = max(0 if math.isinf(one.m0) else one.n + hierarchy.first for one in chosen)
    larger = [of for (of,) in larger_orders((hierarchy,), (order,))]
    models = tuple(map(hierarchy.finished, (order, *larger)))
    exact = hierarchy.is_whole(larger[-1])
    return replace(point, hierarchy=None, models=models, exact=exact, rtol=rtol)
