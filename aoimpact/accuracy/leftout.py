"""Errors of a run by its meshes, its contact laws, and of its histories by its models.

A run is the answer of the finer bodies, and the change of any quantity from the bodies as they are
meshed is its error by the mesh. What the contact laws may be off is put into the laws, and one more
run for each cause gives the change: a compliance in series for what changes while the contact
grows, a stiffer law by the error of the curvatures, and the law that is left whole on a shell.

A law that is not like Hertz's is taken as it is at a node. The indentation of the mesh there is
then part of the result: that of solids doubles where elements are halved. So the result has no
limit to be compared with, and its error is not known.

A model that gives the force need not vibrate as its body does afterwards. Its error in any history,
of a displacement, a velocity, a sensor or what follows from these, is estimated by the same two
runs. The finer models contain what others leave out first (reduction/finer.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import compress
from typing import Any

import numpy as np

from ..base import AOImpactError, Found, held_warnings
from ..contact import ContactPoint
from ..fem import Layers
from ..laws import ContactLaw, Hertz, HertzianLaw, PatchLaw, own_law, removable
from ..linalg import Solver
from ..reduction import Body, BodyModel, FullModel, finer_model
from ..results import LeftOut, Quantity, Run, TimeSolver, number_errors, outgrown, solve
from ..scene import Contact, Scenario, extraction_of
from .hierarchy import model_hierarchy

# Oscillators of a model that replaces the full body where errors of mesh and contact are estimated.
# Its forces have errors of some percent, and so have the estimates.
_IN_PLACE_OF_ALL = 16


def errors_left_out(
    run: Run, *, interest: Callable[[], Sequence[Quantity]], solver: TimeSolver | None
) -> LeftOut:
    """Return the errors of a run by its meshes and laws; none where a body's are not known.

    Parameters
    ----------
    run : Run
    interest : callable
        Returns new quantities of interest, so that what they store while runs are compared is
        freed.
    solver : Adaptive or Newmark, optional
        As of the run.
    """
    meshed = run.beside or run
    full = [body.body for body in run.plan.bodies if isinstance(body, FullModel)]
    if full:
        if any(body.mesh is None for body in full) or not any(of.contacts for of in run.events):
            return LeftOut()
        run = meshed = _with_models(meshed)
        solver = None
    bodies = [of.body for of in meshed.plan.bodies if of.tips]
    if any(of.mesh is not None and of.finer is None for of in bodies):
        return LeftOut()  # of elements that cannot be made finer, or are so already
    others = compared_runs(run, solver)
    with held_warnings():  # the quantities have had their warnings
        wanted = interest()
    altered = _altered_laws(run)
    if altered is None:
        return LeftOut()
    softer = replace(run.plan, contacts=altered)
    changed = altered != tuple(run.plan.contacts)
    by_contact = _tried(lambda: softer, run, solver) if changed else []
    # Where the bodies as meshed leave nothing of a law, they were run with all of it.
    whole = meshed.plan.bounded != run.plan.bounded
    unknown = [math.inf] * (whole or any(outgrown(run)))
    mesh = _changes(wanted, run, [*others, *unknown])
    contact = _changes(wanted, run, by_contact)
    touched = [(of.law, tip) for of in run.plan.contacts for *_, tip in run.plan.touched(of)]
    # Shells beside solids are not cut, so that nothing is known of them.
    mixed = any(of.mesh and len({b.element.thin for b in of.mesh.blocks}) > 1 for of in bodies)
    if mixed or any(_is_bare(*of) for of in touched):
        mesh = {}
    return LeftOut(mesh, contact, _worst_time(wanted[0], run, others + by_contact))


def _changes(
    wanted: Sequence[Quantity], run: Run, others: Sequence[Run | float]
) -> Mapping[str, float]:
    """Relative changes of the quantities, and of each number, to all other runs, by name."""
    runs = [of for of in others if isinstance(of, Run)]
    if len(runs) < len(others):
        return Found(lambda: run.numbers, lambda _: math.inf)
    each = [number_errors(run, [(of, 1.0)], on_the_way=True) for of in runs]

    def change(name: str) -> float:
        return sum(of[name] for of in each)

    known = {
        of.name: sum(of.difference(other, run) for other in runs)
        if of.is_history
        # In a scene of each contact or body.
        else max(map(change, of.names(run)), default=0.0)
        for of in wanted
    }
    return Found(lambda: number_errors(run, ()), change, known)


def _worst_time(quantity: Quantity, run: Run, others: Sequence[Run | float]) -> float | None:
    """When a history changes most from a run to others, s; None of a number."""
    runs = [of for of in others if isinstance(of, Run) and quantity.is_history]
    changes = [np.abs(quantity.deviation(of, run)) for of in runs]
    largest = max(changes, key=np.max, default=None)
    return None if largest is None else float(run.t[largest.argmax() % len(run.t)])


def _with_models(run: Run) -> Run:
    """The run with models in place of the full bodies, of which every run is expensive.

    Errors of mesh and contact change the models' motion as they change the bodies'.
    """
    times = [end - start for events in run.events for start, end in events.contacts]
    shortest = min((time for time in times if time > 0.0), default=run.duration)
    slow = run.duration if run.duration > shortest else None

    @cache
    def model(body: FullModel) -> Body:
        return model_hierarchy(body, shortest, slow).finished(_IN_PLACE_OF_ALL)

    bodies = tuple(model(of) if isinstance(of, FullModel) else of for of in run.plan.bodies)
    return solve(replace(run.plan, bodies=bodies, energies=False), None)


def _altered_laws(run: Run) -> tuple[Contact, ...] | None:
    """Return the contacts with laws that are off by what is not known; None where that is not.

    The compliance that changes with the width of the contact is taken out of the law, or that which
    is left in it although it may belong to the mesh.
    """
    plan = run.plan
    contacts = list[Contact]()
    for number, (contact, events) in enumerate(zip(plan.contacts, run.events, strict=True)):
        law = own_law(contact.law)
        varying = left = 0.0
        for body, port in contact.ports if events.peak_force else ():
            tip = plan.bodies[body].touched_at(port)
            if tip is None or _is_bare(law, tip):
                continue  # numbers, or a law that does not contain the bodies' indentation
            known = extraction_of(law, plan.bodies[body], port)
            if known is None:
                return None  # a rigid model leaves out all, and a sharp edge is not known
            if known.removed and not isinstance(contact.law, PatchLaw):
                left += known.removed  # the errors of one that is left are within its two bounds
            else:
                varying += known.varying
        most = min(left, removable(law, run.deepest(number))) if left else -varying
        contacts.append(contact._replace(law=_altered(contact.law, most, contact.law_error)))
    return tuple(contacts)


def _is_bare(law: ContactLaw, tip: ContactPoint) -> bool:
    """True if a solid mesh's indentation at a node stays in series with a law."""
    return not (tip.patch or tip.thin or isinstance(own_law(law), HertzianLaw))


def _altered(law: ContactLaw, change: float, error: float = 0.0) -> ContactLaw:
    """The law with more compliance, m/N, taken out, and Hertz's stiffness changed by its error.

    Both in one sense, so that their changes add up. Beyond its limit a law goes on as a straight
    line, which is enough to show a change.
    """
    if not change and not error:
        return law
    c = law.compliance if isinstance(law, PatchLaw) else 0.0
    own = own_law(law)
    if isinstance(own, Hertz):
        own = replace(own, k=own.k * (1.0 + math.copysign(error, change)))
    return PatchLaw(own, c + change) if c + change else own


def finer_plan(
    plan: Scenario,
    solver: Solver = "auto",
    *,
    made: Sequence[bool] = (),
    every: bool = False,
) -> Scenario | None:
    """Return the plan with models of the bodies with finer elements; None where none has any.

    Parameters
    ----------
    plan : Scenario
    solver : str or callable, optional
        The linear solver; see `FEModel.inverse`.
    made : sequence of bool, optional
        Whether the model of each body was made for the impact; given ones stay. All, if left out.
    every : bool, optional
        True to return one as well where no body has finer elements; their models have more vectors.
    """
    make = partial(finer_model, linear=solver)
    models = compress(plan.bodies, made) if made else plan.bodies
    of = {b for b in models if isinstance(b, Body) and b.tips and not b.body.coarse}
    if not any(every or body.body.finer for body in of):
        return None
    bodies = tuple(_finer(body, make) if body in of else body for body in plan.bodies)
    bounded = frozenset(
        number
        for number in plan.bounded
        if any(isinstance(tip.thin, Layers) for *_, tip in plan.touched(plan.contacts[number]))
    )
    contacts = []
    for number, contact in enumerate(plan.contacts):
        law = own_law(contact.law) if any(contact.removed) else contact.law
        known = contact._replace(law=law, removed=(0.0, 0.0))
        known = known.of_models(bodies, bounded=number in bounded)
        more = 0.0  # a node's indentation, under a law that leaves it, is that of the mesh as given
        for body, port in known.ports:
            tip = plan.bodies[body].touched_at(port)
            if tip is not None and _is_bare(law, tip):
                one, other = (own[body].extraction_at(port) for own in (bodies, plan.bodies))
                more += one.removed - other.removed if one and other else 0.0
        contacts.append(known._replace(law=_altered(known.law, more)))
    return replace(plan, bodies=bodies, contacts=tuple(contacts), bounded=bounded)


def compared_runs(run: Run, solver: TimeSolver | None, *, every: bool = False) -> list[Run | float]:
    """Return the runs to which changes add up to the error by the meshes.

    The run with the bodies as they are meshed where this one has finer ones, and that of
    `finer_plan`; infinite where one cannot be run.
    """
    beside = run.beside
    finer = _tried(partial(finer_plan, run.plan, every=every and beside is None), run, solver)
    if beside is None:
        return finer
    lasts = beside.duration == run.duration
    return [*([beside] if lasts else _tried(lambda: beside.plan, run, solver)), *finer]


def _tried(
    plan: Callable[[], Scenario | None], run: Run, solver: TimeSolver | None
) -> list[Run | float]:
    """The run of a plan, as long as another; infinite where it cannot be run, none of no plan."""
    try:
        with held_warnings():
            if (wanted := plan()) is None:
                return []
            return [solve(replace(wanted, duration=run.duration, energies=False), solver)]
    except AOImpactError:  # e.g. a contact wider than its patch, or beyond the range of its law
        return [math.inf]


def _finer(model: BodyModel, make: Callable[[Any], BodyModel]) -> BodyModel:
    """The finer model of another, made once, and of one that was turned round by turning it."""
    of, ports = model.kept.get("turned", (model, ()))
    if "finer" not in of.kept:
        of.kept["finer"] = make(of)
    found: BodyModel = of.kept["finer"].turned(ports)
    return found
