"""Errors of a run by its meshes, its contact laws, and of its histories by its models.

A run is the answer of the finer bodies, and the change of any quantity from the bodies as they are
meshed is its error by the mesh. What the contact laws may be off is put into the laws, and one more
run for each cause gives the change: a compliance in series for what changes while the contact
grows, a stiffer law by the error of the curvatures, and the law that is left whole on a shell.

A law that is not like Hertz's is taken as it is at a node. The indentation of the mesh there is
then part of the result: that of solids doubles where elements are halved. Of what lasts it is the
mesh's error. The force itself has no limit to be compared with, and its error is not known.

A model that gives the force need not vibrate as its body does afterwards. Its error in any history,
of a displacement, a velocity, a sensor or what follows from these, is estimated by one more run
with models that contain it and what it leaves out first (reduction/finer.py). These have an error
of their own, of which no more is known than that it is smaller. `tools/sensor_errors.py` compares
the errors said of sensors with those by all modes of the full matrices.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..base import AOImpactError, Found, held_warnings
from ..contact import ContactPoint
from ..laws import ContactLaw, Hertz, HertzianLaw, PatchLaw, own_law, removable
from ..linalg import Solver
from ..reduction import (
    Body,
    BodyModel,
    FullModel,
    finer_model,
)
from ..results import LeftOut, Quantity, Run, TimeSolver, number_errors, outgrown, solve
from ..scene import Contact, Scenario, extraction_of
from .hierarchy import model_hierarchy

# Oscillators of a model that replaces the full body where errors of mesh and contact are estimated.
# Its forces have errors of some percent, and so have the estimates.
_IN_PLACE_OF_ALL = 16


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
    plan, beside = run.plan, run.beside
    full = [body.body for body in plan.bodies if isinstance(body, FullModel)]
    if full:
        if any(body.mesh is None for body in full) or not any(of.contacts for of in run.events):
            return LeftOut()
        run, solver = _with_models(run), None
        plan = run.plan
    bodies = [body.body for body in plan.bodies if body.tips]
    if any(of.mesh is not None and (of.coarse or of.finer) is None for of in bodies):
        return LeftOut()  # of elements that cannot be made finer
    other: Run | float | None
    other = finer_run(run, solver) if beside is None else over_the_same_time(beside, run, solver)
    with held_warnings():  # the quantity has had its warnings
        quantity = interest()
    plans = alterations(run, at_nodes=quantity.lasting)
    if plans is None:
        return LeftOut()
    changes, name = _Changes(quantity, run, solver), quantity.name
    too_long = math.inf if any(outgrown(run)) else None
    mesh = changes.sum([too_long, other, changes.of(plans.mesh)])
    contact = changes.sum([changes.of(plan) for plan in plans.contact])
    ends = [(own_law(of.law), *end) for of in plan.contacts for end in of.ports]
    tips = [(law, plan.bodies[body].touched_at(port)) for law, body, port in ends]
    if any(tip is not None and _is_bare(law, tip) for law, tip in tips):
        known = {name: mesh.errors[name]} if quantity.lasting else {}
        mesh = _Change(known, mesh.when)
    larger = max(mesh, contact, key=lambda change: change.errors.get(name, 0.0))
    return LeftOut(mesh.errors, contact.errors, larger.when)


class _Change(NamedTuple):
    """Relative changes of numbers by name, and when a history changes most, s."""

    errors: Mapping[str, float]
    when: float | None


class _Changes:
    """Changes of a quantity, and of each number, from a run to others."""

    def __init__(self, quantity: Quantity, run: Run, solver: TimeSolver | None) -> None:
        self._quantity, self._run, self._solver = quantity, run, solver

    def of(self, plan: Scenario | None) -> Run | float | None:
        """Return the run of a plan; infinite where it cannot be run, and None of no plan."""
        try:
            return None if plan is None else solve(plan, self._solver)
        except AOImpactError:  # a contact beyond the range of its law
            return math.inf

    def sum(self, others: Sequence[Run | float | None]) -> _Change:
        """Return the sum of the changes to some runs."""
        name = self._quantity.name
        changes = [self._to(other) for other in others]
        largest = max(changes, key=lambda change: change.errors[name])
        total = Found(largest.errors.keys, lambda one: math.fsum(of.errors[one] for of in changes))
        return _Change(total, largest.when)

    def _to(self, other: Run | float | None) -> _Change:
        quantity, run = self._quantity, self._run
        if not isinstance(other, Run):
            size = other or 0.0
            errors = number_errors(run, (), known={quantity.name: size})
            return _Change(Found(lambda: errors, lambda name: errors[name] + size), None)
        find = partial(number_errors, run, [(other, 1.0)], on_the_way=True)
        if quantity.is_history:
            changes = np.abs(quantity.deviation(other, run))
            when = float(run.t[changes.argmax() % len(run.t)])
        else:  # in a scene of each contact or body
            each, when = find(), None
            changes = np.array([each[name] for name in quantity.names(run)])
        return _Change(find({quantity.name: float(changes.max(initial=0.0))}), when)


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


class _End(NamedTuple):
    """What is not known of a body's compliance at a contact, m/N.

    Attributes
    ----------
    varying : float
        Its error by the contact's width.
    left : float
        That is left in the law and may belong to the mesh.
    bare : float
        That of the mesh under a law that does not contain the body's indentation.
    """

    varying: float = 0.0
    left: float = 0.0
    bare: float = 0.0


class Alterations(NamedTuple):
    """The plans that show the errors of a run, by cause; None where there is none."""

    mesh: Scenario | None
    contact: tuple[Scenario | None, ...]


def alterations(run: Run, *, at_nodes: bool) -> Alterations | None:
    """Return the plans that show the errors of a run by its contacts; None if not known.

    Parameters
    ----------
    run : Run
    at_nodes : bool
        True to count the mesh's indentation at nodes as its error under laws that leave it.
    """
    plan, ends = run.plan, list[list[_End]]()
    for number, events in enumerate(run.events):
        start, end = events.peak_contact or (0.0, 0.0)
        found = _of_contact(plan, number, at_nodes=at_nodes) if end > start else []
        if found is None:
            return None
        ends.append(found)
    varying, left, bare = (
        [math.fsum(end[part] for end in found) for found in ends] for part in range(3)
    )
    return Alterations(
        _in_series(plan, bare),
        (_in_series(plan, varying), _with_law_error(plan), _bounded(run, left)),
    )


def _of_contact(plan: Scenario, number: int, *, at_nodes: bool) -> list[_End] | None:
    """What is not known at a contact; nothing of models given by numbers."""
    contact = plan.contacts[number]
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
            found.append(_End(bare=abs(known.removed)))
            continue
        left = 0.0 if isinstance(contact.law, PatchLaw) else known.removed
        # The errors of a compliance that is left in a law are within its two bounds.
        found.append(_End(left=left) if left else _End(known.varying))
    return found


def _is_bare(law: ContactLaw, tip: ContactPoint) -> bool:
    """True if a solid mesh's indentation at a node stays in series with a law."""
    return not (tip.patch or tip.thin or isinstance(law, HertzianLaw))


def _in_series(plan: Scenario, compliances: Sequence[float]) -> Scenario | None:
    """The plan with these compliances, m/N, in series with the laws."""
    contacts = [
        contact._replace(law=_with_compliance(contact.law, change))
        for contact, change in zip(plan.contacts, compliances, strict=True)
    ]
    return _with(plan, contacts) if any(compliances) else None


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


def _with_law_error(plan: Scenario) -> Scenario | None:
    """The plan with Hertz's laws stiffer by their errors."""
    contacts = []
    for contact in plan.contacts:
        law = own_law(contact.law)
        if isinstance(law, Hertz):
            law = replace(law, k=law.k * (1.0 + contact.law_error))
        if isinstance(contact.law, PatchLaw):
            law = replace(contact.law, law=law)
        contacts.append(contact._replace(law=law))
    return _with(plan, contacts) if any(of.law_error for of in plan.contacts) else None


def _bounded(run: Run, left: Sequence[float]) -> Scenario | None:
    """The plan without the compliances, m/N, that are left in laws."""
    contacts = []
    for number, (contact, c) in enumerate(zip(run.plan.contacts, left, strict=True)):
        most = min(c, removable(own_law(contact.law), run.deepest(number))) if c else 0.0
        contacts.append(contact._replace(law=_with_compliance(contact.law, -most)))
    return _with(run.plan, contacts) if any(left) else None


def _with(plan: Scenario, contacts: Sequence[Contact]) -> Scenario:
    return replace(plan, contacts=tuple(contacts), energies=False)


def finer_plan(plan: Scenario, solver: Solver = "auto", *, every: bool = False) -> Scenario | None:
    """Return the plan with models of the bodies with finer elements; None where none has any.

    Parameters
    ----------
    plan : Scenario
    solver : str or callable, optional
        The linear solver; see `FEModel.inverse`.
    every : bool, optional
        True to take models of more vectors of bodies without finer elements.
    """
    make = partial(finer_model, linear=solver)
    bodies = tuple(
        _derived(body, "finer", make)
        if isinstance(body, Body) and body.tips and (every or body.body.finer)
        else body
        for body in plan.bodies
    )
    if all(one is other for one, other in zip(bodies, plan.bodies, strict=True)):
        return None
    contacts = []
    for contact in plan.contacts:
        law = own_law(contact.law) if any(contact.removed) else contact.law
        known = contact._replace(law=law, removed=(0.0, 0.0))
        contacts.append(known.of_models(bodies, bounded=plan.bounded))
    return replace(plan, bodies=bodies, contacts=tuple(contacts))


def finer_run(run: Run, solver: TimeSolver | None, *, every: bool = False) -> Run | float | None:
    """Return the run of `finer_plan` over the same time.

    None where there is none, and infinite where it cannot be run.
    """
    try:
        with held_warnings():
            plan = finer_plan(run.plan, every=every)
            return None if plan is None else solve(replace(plan, energies=False), solver)
    except AOImpactError:  # e.g. a contact wider than its patch
        return math.inf


def over_the_same_time(other: Run, run: Run, solver: TimeSolver | None) -> Run:
    """Return another run over the time of this one, with histories to compare."""
    if other.duration == run.duration:
        return other
    return solve(replace(other.plan, duration=run.duration), solver)


def larger_run(run: Run, solver: TimeSolver | None) -> Run | None:
    """Return the run with which the histories of a run are compared.

    The one with smaller models of the bodies as they are meshed, where there is one, or with larger
    models; None where no body has one, or it cannot be run.
    """
    if run.smaller is not None:
        return over_the_same_time(run.smaller, run, solver)
    found = finer_run(run, solver, every=True)
    return found if isinstance(found, Run) else None


def _derived(model: BodyModel, name: str, make: Callable[[Any], BodyModel]) -> BodyModel:
    """A model that is made of another once, and of one that was turned round by turning it."""
    of, ports = model.kept.get("turned", (model, ()))
    if name not in of.kept:
        of.kept[name] = make(of)
    found: BodyModel = of.kept[name].turned(ports)
    return found
