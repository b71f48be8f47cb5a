"""Errors of a run by its meshes, its contact laws, and of its histories by its models.

The errors of a contact point's compliance (`Compliance`) are put into the models, and one more run
gives the change of any quantity. The error of the compliance beyond the half-space acts like a
spring in series with the law. A mesh that is too stiff makes the whole body too stiff, which the
extraction corrects at one frequency only: all springs of the model are altered, and the compliance
taken out of the law with them, so that the response at that frequency stays as it is. The errors of
two bodies, and of several contacts, act in the same run.

A sensor away from the contact sees other motion than that at the contact, whose error says little
of it: vibration that runs ahead or behind, more with each period. For it, and for all that lasts
after the contact, each mode of the model is softer by its own error (reduction/finer.py).

A law that is not like Hertz's is taken as it is at a node. The indentation of the mesh there is
then part of the result: that of solids doubles where elements are halved. Of what lasts it is the
mesh's error. The force itself has no limit to be compared with, and its error is not known.

A compliance c that changes with the frequency, as that of shells does, also takes energy, as a
dashpot does, which no spring in series shows. If c goes with c' ln s, a force of half a sine of
duration T loses c'/4 ∫|ω||F|²dω = 1.8 c' F², and so a share 1.4 c' F/(v T/2) of the impulse of a
body that rebounds at the velocity v. Where nothing but the contact yields v T/2 is 1.47 δ.

Solid elements longer than bending waves bend no more than their nodes do, and stress that is
averaged between them does not show it. What they lack is put in series, too (`unbent`).

A model that gives the force need not vibrate as its body does afterwards. Its error in any history,
of a displacement, a velocity, a sensor or what follows from these, is estimated by one more run
with models that contain it and what it leaves out first (reduction/finer.py). These have an error
of their own, of which no more is known than that it is smaller. `tools/sensor_errors.py` compares
the errors said of sensors with those by all modes of the full matrices.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..base import AOImpactError, FloatArray, Found, held_warnings
from ..contact import ContactPoint
from ..laws import ContactLaw, Hertz, HertzianLaw, PatchLaw, own_law, removable
from ..reduction import (
    Body,
    BodyModel,
    FullModel,
    finer_model,
    softer_model,
)
from ..results import LeftOut, Quantity, Run, TimeSolver, number_errors, solve
from ..scene import Contact, Scenario, extraction_of
from .hierarchy import model_hierarchy

# A run is repeated with laws and bodies stiffer or softer by no more than this, and the change is
# extrapolated.
_SMALL = 0.1

# Oscillators of a model that replaces the full body where errors of mesh and contact are estimated.
# Its forces have errors of some percent, and so have the estimates.
_IN_PLACE_OF_ALL = 16

# s T at which the error of the mesh's stiffness is evaluated. Errors of peaks on plates and beams
# are 0.6 to 1.15 of those by springs softened by the true error at 6/T; at 4/T 0.4 to 0.9, at 10/T
# 0.65 to 1.45. The energy that stress recovery misses is 0.8 to 1.9 times its estimate. With these
# factors for linear and quadratic elements 96 % of the peaks of docs/calibration.md are within
# their error, those of faceted balls left out.
_SLOW, _SAFETY = 6.0, {False: 1.5, True: 2.0}

# Share of the impulse, in c' F/(v T/2), that is lost to a compliance that lags; and v T/2 over the
# depth of a contact of rigid bodies under Hertz's law.
_LOST, _HALF_WAY = 1.4, 1.47

# Slopes are taken over this share of the indentation.
_DIFFERENCE = 1e-3

# Peaks on sheets of 1 to 4 mm by quadratic bricks and tetrahedra lack up to 1.3 times the
# compliance that stress does not show, by `unbent`; those by linear bricks 1.7 times.
_TWICE = 2.0


def errors_left_out(
    run: Run,
    *,
    interest: Callable[[], Quantity],
    solver: TimeSolver | None,
) -> LeftOut:
    """Return the errors of a run by its meshes and laws; none where a body's are not known.

    Parameters
    ----------
    run : Run
    interest : callable
        Returns a new quantity of interest, so that what it stores while runs are compared is freed.
    solver : Adaptive or Newmark, optional
        As of the run.
    """
    plan = run.plan
    full = [body.body for body in plan.bodies if isinstance(body, FullModel)]
    if full:
        if any(body.mesh is None for body in full) or not any(of.contacts for of in run.events):
            return LeftOut()
        run, solver = _with_models(run), None
        plan = run.plan
    with held_warnings():  # the quantity has had its warnings
        quantity = interest()
    altered = alterations(run, at_nodes=quantity.lasting)
    if altered is None:
        return LeftOut()
    changes, name = _Changes(quantity, run, solver), quantity.name
    mesh, contact = changes.sum(altered.mesh), changes.sum(altered.contact)
    ends = [(own_law(of.law), *end) for of in plan.contacts for end in of.ports]
    tips = [(law, plan.bodies[body].touched_at(port)) for law, body, port in ends]
    if any(tip is not None and _is_bare(law, tip) for law, tip in tips):
        mesh = _Change({}, mesh.when)
    if quantity.lasting:
        series, _, across = altered.mesh
        softer, stiff = changes.sum((series, _softer(plan), across)), mesh.errors.get(name, 0.0)
        size = softer.errors[name]
        if quantity.local is not None:
            # Stress also errs as the force does, which softer modes leave as it is. Stiffer springs
            # show that, but far from the contact mostly how they run ahead: no more counts than
            # the vibration errs, as of another cause.
            size = math.hypot(size, min(size, stiff))
        by_name = Found(mesh.errors.keys, mesh.errors.__getitem__, {name: size})
        mesh = _Change(by_name, softer.when)
    larger = max(mesh, contact, key=lambda change: change.errors.get(name, 0.0))
    local = 0.0 if quantity.local is None else quantity.local(run)

    def by_mesh(each: str) -> float:
        return mesh.errors[each] + altered.lag + (local if each == name else 0.0)

    return LeftOut(Found(lambda: mesh.errors, by_mesh), contact.errors, larger.when)


class _Change(NamedTuple):
    """Relative changes of numbers by name, and when a history changes most, s."""

    errors: Mapping[str, float]
    when: float | None


class _Changes:
    """Changes of a quantity, and of each number, from a run to altered ones, each made once."""

    def __init__(self, quantity: Quantity, run: Run, solver: TimeSolver | None) -> None:
        self._quantity, self._run, self._solver = quantity, run, solver
        self._runs: dict[Scenario | None, Run | None] = {None: run}

    def sum(self, causes: Sequence[Iterable[Altered]]) -> _Change:
        """Return the sum of the changes by several causes."""
        name = self._quantity.name
        changes = [self._first(ways) for ways in causes]
        largest = max(changes, key=lambda change: change.errors[name])
        total = Found(largest.errors.keys, lambda one: math.fsum(of.errors[one] for of in changes))
        return _Change(total, largest.when)

    def _first(self, ways: Iterable[Altered]) -> _Change:
        """The change by the first alteration that can run."""
        for altered in ways:
            change = self._by(altered)
            if math.isfinite(change.errors[self._quantity.name]):
                break
        return change

    def _by(self, altered: Altered) -> _Change:
        quantity, run = self._quantity, self._run
        if altered.plan is not None and altered.plan not in self._runs:
            try:
                self._runs[altered.plan] = solve(altered.plan, self._solver)
            except AOImpactError:  # a contact beyond the range of its law
                self._runs[altered.plan] = None
        other = self._runs[altered.plan]
        if other is run or other is None:
            size = 0.0 if other is run else math.inf
            errors = number_errors(run, (), known={quantity.name: size})
            return _Change(Found(lambda: errors, lambda name: errors[name] + size), None)
        extended = partial(extrapolated, size=altered.size, scale=altered.scale)
        changes = np.abs(quantity.deviation(run, other))
        change = extended(changes.max(initial=0.0))
        when = None
        if quantity.is_history and change:
            when = float(other.t[changes.argmax() % len(other.t)])
        errors = number_errors(run, [(other, 1.0)])
        known = {quantity.name: change}
        return _Change(Found(lambda: errors, lambda name: extended(errors[name]), known), when)


def _with_models(run: Run) -> Run:
    """The run with models in place of the full bodies, of which every run is expensive.

    Errors of mesh and contact change the models' motion as they change the bodies'.
    """
    times = [end - start for events in run.events for start, end in events.contacts]
    shortest = min((time for time in times if time > 0.0), default=run.duration)
    slow = run.duration if run.duration > shortest else None
    made: dict[FullModel, Any] = {}
    bodies: list[BodyModel] = []
    for body in run.plan.bodies:
        if isinstance(body, FullModel):
            if body not in made:
                made[body] = model_hierarchy(body, shortest, slow).finished(_IN_PLACE_OF_ALL)
            body = made[body]
        bodies.append(body)
    plan = replace(run.plan, bodies=tuple(bodies), energies=False)
    return solve(plan, None)


@dataclass(frozen=True)
class _End:
    """Errors of a body at a contact.

    Attributes
    ----------
    body : int
        Its number in the plan.
    error, varying : float
        Errors of the compliance beyond the half-space by the mesh and by the contact's width, m/N.
    softening : float
        Relative error of the stiffness of its springs.
    held : float
        By how much its response changes, m/N, for each unit of that, at the frequency at which it
        is known.
    lagging : float
        See `Compliance`, m/N.
    crosswise : ndarray, shape (2,), or None
        See `Compliance`, m/N; of contacts with friction.
    left : float
        Compliance that is left in the law and may belong to the mesh, m/N.
    """

    body: int
    error: float
    varying: float
    softening: float
    held: float
    lagging: float = 0.0
    crosswise: FloatArray | None = None
    left: float = 0.0


@dataclass(frozen=True, eq=False)
class Altered:
    """A plan with changed laws or bodies.

    Attributes
    ----------
    plan : Scenario or None
        None: unchanged.
    size : float
        The relative change of stiffness that is meant.
    scale : float
        How many times smaller that of the plan is.
    """

    plan: Scenario | None
    size: float = 0.0
    scale: float = 1.0


def extrapolated(change: float, size: float, scale: float) -> float:
    """Return the change for an alteration of that size from one `scale` times smaller.

    Forces go with powers of stiffness below 1, so that (1 + change) does with (1 + size). Other
    quantities go up in proportion at most.
    """
    power = np.log1p(change) / np.log1p(size / scale)
    return float(np.minimum(np.expm1(power * np.log1p(size)), change * scale))


class Met(NamedTuple):
    """Duration, rise and depth that a contact reached.

    Attributes
    ----------
    contact_time : float
        How long the contact of the peak force lasts, s.
    rise : float
        How long the force rises in it, s; on thin sheets a small part of that.
    depth : float
        The largest indentation in its own law, m.
    """

    contact_time: float
    rise: float
    depth: float


class Alterations(NamedTuple):
    """The plans that show the errors of a run, by cause; of each the first that can run counts.

    `lag` is the relative error of all numbers by compliances that change with frequency.
    """

    mesh: tuple[Iterable[Altered], ...]
    contact: tuple[Iterable[Altered], ...]
    lag: float


def alterations(run: Run, *, at_nodes: bool) -> Alterations | None:
    """Return the plans that show the errors of a run by meshes and laws; None if not known.

    Parameters
    ----------
    run : Run
    at_nodes : bool
        True to count the mesh's indentation at nodes as its error under laws that leave it.
    """
    plan, met = run.plan, []
    for number, events in enumerate(run.events):
        start, end = events.peak_contact or (0.0, 0.0)
        met.append(Met(end - start, events.peak_time - start, run.deepest(number)))
    ends: list[list[_End]] = []
    for number, of in enumerate(met):
        found = _of_contact(plan, number, of, at_nodes=at_nodes)
        if found is None:
            return None
        ends.append(found)
    slopes = [
        _slope(contact.law, of.depth) if found else 0.0
        for contact, of, found in zip(plan.contacts, met, ends, strict=True)
    ]
    left = [math.fsum(end.left for end in of) for of in ends]
    # The errors of a compliance that is left in a law are within its two bounds.
    for c, found in zip(left, ends, strict=True):
        if c:
            found[:] = [replace(end, error=0.0, varying=0.0, lagging=0.0) for end in found]
    beyond = [math.fsum(end.error for end in of) for of in ends]
    varying = [math.fsum(end.varying for end in of) for of in ends]
    lags = []
    for contact, of, found in zip(plan.contacts, met, ends, strict=True):
        way = max(0.5 * plan.fastest * of.contact_time, _HALF_WAY * of.depth)
        lagging = math.fsum(end.lagging for end in found)
        force = own_law(contact.law).force(of.depth) if lagging else 0.0
        lags.append(_LOST * lagging * force / way if force else 0.0)
    series, wider = _in_series(plan, slopes, beyond), None
    if len(met) == 1 and varying[0] and beyond[0]:  # the same alteration, but for its size
        ratio = varying[0] / beyond[0]
        wider = replace(series, size=ratio * series.size, scale=ratio * series.scale)
    return Alterations(
        mesh=(
            [series],
            (_stiffer(plan, slopes, ends, sign) for sign in (-1.0, 1.0)),
            [_across(plan, ends)],
        ),
        contact=(
            [wider or _in_series(plan, slopes, varying)],
            [_with_law_error(plan)],
            [_bounded(plan, met, left)],
        ),
        lag=max(lags, default=0.0),
    )


def _of_contact(plan: Scenario, number: int, met: Met, *, at_nodes: bool) -> list[_End] | None:
    """Errors of the compliances at a contact; none for models given by numbers."""
    contact, contact_time = plan.contacts[number], met.contact_time
    if contact_time <= 0.0:
        return []
    law = own_law(contact.law)
    found = []
    for body, port in contact.ports:
        model = plan.bodies[body]
        tip = model.touched_at(port)
        bare = tip is not None and _is_bare(law, tip)
        if tip is None or (bare and not at_nodes):
            continue  # numbers, or a law that does not contain the bodies' indentation
        known = model.extraction_at(port) if bare else extraction_of(law, model, port)
        if known is None:
            return None  # a rigid model leaves out all, and a sharp edge is not known
        if bare:
            found.append(_End(body, abs(known.removed) + known.error, 0.0, 0.0, 0.0))
            continue
        assert isinstance(model, Body)
        assert tip.body.mesh is not None
        safety = _SAFETY[tip.body.mesh.quadratic]
        stiffness = safety * max(
            model.stiffness_error(_SLOW / contact_time, port, axis) for axis in range(contact.size)
        )
        error, crosswise = known.error, None
        fast = _SLOW / (min(2.0 * met.rise, contact_time) or contact_time)
        if known.splitting:
            error += unbent(tip, fast)
        if contact.friction and known.splitting:  # see `Friction.for_core`
            error = max(error, contact.friction.ratio * known.sideways)
            crosswise = known.crosswise
        own = error, known.varying, stiffness, known.strain, known.lagging
        left = 0.0 if isinstance(contact.law, PatchLaw) else known.removed
        found.append(_End(body, *own, crosswise, left))
    return found


def unbent(tip: ContactPoint, s: float) -> float:
    """Return the compliance, m/N, that solid elements lack where bending waves are short.

    Where nothing between its ends moves of its own accord, an element of the edge h lacks the
    vibration of a strip that is supported there, of the lowest frequency ω = π²/h² √(D/m). Its
    compliance, which is in that of the whole plate, goes with 1/(1 + s²/ω²). Stress shows what the
    element lacks at rest, but not s²/ω² = (h/λ)⁴/π⁴.

    Parameters
    ----------
    tip : ContactPoint
    s : float
        rad/s.
    """
    fast = (tip.edge_over_wave(s) / math.pi) ** 4
    return _TWICE * tip.bending_compliance(s) * fast / (1.0 + fast)


def _across(plan: Scenario, ends: Sequence[Sequence[_End]]) -> Altered:
    """The plan with other compliances between the normal force and the slides, by their errors."""
    contacts = []
    for contact, of in zip(plan.contacts, ends, strict=True):
        known = [end.crosswise for end in of if end.crosswise is not None]
        if known and contact.friction and contact.friction.compliance is not None:
            changed = contact.friction.compliance.copy()
            changed[0, 1:] += np.sum(known, axis=0)
            changed[1:, 0] = changed[0, 1:]
            contact = contact._replace(friction=contact.friction._replace(compliance=changed))
        contacts.append(contact)
    altered = any(new is not old for new, old in zip(contacts, plan.contacts, strict=True))
    return Altered(_with(plan, contacts) if altered else None, 1.0)


def _stiffer(
    plan: Scenario, slopes: Sequence[float], ends: Sequence[Sequence[_End]], sign: float
) -> Altered:
    """The plan with bodies stiffer by their errors (softer, for sign 1), and laws to suit."""
    shares: dict[int, float] = {}
    for end in (end for of in ends for end in of):
        shares[end.body] = max(end.softening, shares.get(end.body, 0.0))
    changes = [math.fsum(sign * end.softening * end.held for end in of) for of in ends]
    stiff = [slope * abs(of) for slope, of in zip(slopes, changes, strict=True)]
    largest = max([*shares.values(), *stiff], default=0.0)
    if largest == 0.0:
        return Altered(None)
    # By powers of two, so that many impacts take the same few models.
    scale = 2.0 ** max(0, math.ceil(math.log2(largest / _SMALL)))
    bodies = list(plan.bodies)
    for body, share in shares.items():
        model = bodies[body]
        assert isinstance(model, Body)
        bodies[body] = model.stiffened(1.0 / (1.0 + sign * share / scale))
    contacts = [
        contact._replace(law=_with_compliance(contact.law, -change / scale))
        for contact, change in zip(plan.contacts, changes, strict=True)
    ]
    altered = replace(_with(plan, contacts), bodies=tuple(bodies))
    return Altered(altered, largest, scale)


def _is_bare(law: ContactLaw, tip: ContactPoint) -> bool:
    """True if a solid mesh's indentation at a node stays in series with a law."""
    return not (tip.patch or tip.thin or isinstance(law, HertzianLaw))


def _softer(plan: Scenario) -> Iterable[Altered]:
    """The plans with bodies whose modes are softer by the errors of their elements.

    First with laws to suit, so that the responses at the frequencies of the extraction stay as they
    are; then, where laws have not as much compliance to give, without.
    """
    bodies = tuple(
        _derived(body, "softer", softer_model)
        if body.tips and body.tips[0].body.mesh is not None
        else body
        for body in plan.bodies
    )
    if bodies == plan.bodies:
        yield Altered(None)
        return
    contacts = []
    for contact in plan.contacts:
        change = 0.0
        for body, port in contact.ports:
            model, softer, tip = plan.bodies[body], bodies[body], plan.bodies[body].touched_at(port)
            known = extraction_of(own_law(contact.law), model, port)
            if known is not None and tip is not None and softer is not model:
                assert isinstance(model, Body)
                assert isinstance(softer, Body)
                moved = softer.deflection(known.s, port) - model.deflection(known.s, port)
                change += float(tip.b @ moved)
        contacts.append(contact._replace(law=_with_compliance(contact.law, -change)))
    yield Altered(replace(_with(plan, contacts), bodies=bodies), size=1.0)
    yield Altered(replace(plan, bodies=bodies, energies=False), size=1.0)


def _in_series(plan: Scenario, slopes: Sequence[float], compliances: Sequence[float]) -> Altered:
    """The plan with these compliances, m/N, in series with the laws."""
    largest = max(
        (slope * change for slope, change in zip(slopes, compliances, strict=True)), default=0.0
    )
    if largest == 0.0:
        return Altered(None)
    scale = max(1.0, largest / _SMALL)
    contacts = [
        contact._replace(law=_with_compliance(contact.law, change / scale))
        for contact, change in zip(plan.contacts, compliances, strict=True)
    ]
    return Altered(_with(plan, contacts), largest, scale)


def _slope(law: ContactLaw, depth: float) -> float:
    """dF/dδ of a contact's own law at its largest indentation, N/m, from below."""
    low, high = own_law(law).force(np.array([1.0 - _DIFFERENCE, 1.0 - 1e-12]) * depth)
    return float(high - low) / (_DIFFERENCE * depth)


def _with_compliance(law: ContactLaw, change: float) -> ContactLaw:
    """The law with a compliance in series reduced by `change`, or, where it has less, increased."""
    if change == 0.0:
        return law
    if not isinstance(law, PatchLaw):
        return PatchLaw(law, abs(change))
    if 0.0 < law.compliance <= change:
        change = -change
    # Beyond its limit the law goes on as a straight line, which is enough to show a change.
    return replace(law, compliance=law.compliance - change, limit=math.inf)


def _with_law_error(plan: Scenario) -> Altered:
    """The plan with Hertz's laws stiffer by their errors."""
    errors = [contact.law_error for contact in plan.contacts]
    if not any(errors):
        return Altered(None)
    scale = max(1.0, max(errors) / _SMALL)
    contacts = []
    for contact, error in zip(plan.contacts, errors, strict=True):
        law = own_law(contact.law)
        if error and isinstance(law, Hertz):
            law = replace(law, k=law.k * (1.0 + error / scale))
        if isinstance(contact.law, PatchLaw):
            law = replace(contact.law, law=law)
        contacts.append(contact._replace(law=law))
    return Altered(_with(plan, contacts), max(errors), scale)


def _bounded(plan: Scenario, met: Sequence[Met], left: Sequence[float]) -> Altered:
    """The plan without the compliances, m/N, that are left in laws."""
    contacts = []
    for contact, of, c in zip(plan.contacts, met, left, strict=True):
        most = min(c, removable(own_law(contact.law), of.depth)) if c else 0.0
        contacts.append(contact._replace(law=_with_compliance(contact.law, -most)))
    return Altered(_with(plan, contacts) if any(left) else None, 1.0)


def _with(plan: Scenario, contacts: Sequence[Contact]) -> Scenario:
    return replace(plan, contacts=tuple(contacts), energies=False)


def finer_run(run: Run, solver: TimeSolver | None) -> Run | None:
    """Return the same run with finer models; None where no body has one, or it cannot be run."""
    plan = run.plan
    if any(isinstance(body, FullModel) for body in plan.bodies):
        return None
    try:
        with held_warnings():
            if not any(body.tips for body in plan.bodies):
                return None
            bodies = tuple(
                _derived(body, "finer", finer_model) if body.tips else body for body in plan.bodies
            )
            return solve(replace(plan, bodies=bodies, energies=False), solver)
    except AOImpactError:  # e.g. a contact wider than its patch
        return None


def _derived(model: BodyModel, name: str, make: Callable[[Any], BodyModel]) -> BodyModel:
    """A model that is made of another once."""
    if name not in model.kept:
        model.kept[name] = make(model)
    found: BodyModel = model.kept[name]
    return found
