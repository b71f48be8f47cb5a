"""Error estimates of a run from its meshes and contact laws, and of its histories from its models.

The run that is returned has finer elements. The error of any quantity from the mesh is its change
from the bodies as the user meshed them.

The error from the contact laws is the change in one more run, with laws altered by their
uncertainty: a compliance in series for the part that varies as the contact grows, Hertz's stiffness
by the error of the curvatures, and on a shell the compliance that may belong to the mesh.

A law that is not like Hertz's is not corrected at a node of solid elements. The indentation of the
mesh there is then part of the result. This indentation doubles if elements are halved, so that the
result does not converge and its error is not known.

A model that gives the force accurately need not vibrate as its body does after the contact. The
error of any history, such as a displacement, velocity or sensor, is estimated by the same two runs.
The finer models contain the motions that the given models lack most (reduction/finer.py).
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

# Number of oscillators of the model that replaces a full body in the estimate of errors from mesh
# and contact. Its forces, and so the estimates, have relative errors of some percent.
_IN_PLACE_OF_ALL = 16


def errors_left_out(
    run: Run, *, interest: Callable[[], Sequence[Quantity]], solver: TimeSolver | None
) -> LeftOut:
    """Return the errors of a run due to meshes and laws; empty if a body's errors are not known.

    Parameters
    ----------
    run : Run
    interest : callable
        Creates the quantities of interest anew, so that the responses that they cache are freed
        when this function returns.
    solver : Adaptive or Newmark, optional
        Solver of the run.
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
        return LeftOut()  # elements cannot be refined, or have been refined already
    others = compared_runs(run, solver)
    with held_warnings():  # `interest` has issued its warnings before
        wanted = interest()
    altered = _altered_laws(run)
    if altered is None:
        return LeftOut()
    softer = replace(run.plan, contacts=altered)
    changed = altered != tuple(run.plan.contacts)
    by_contact = _tried(lambda: softer, run, solver) if changed else []
    # If different contacts keep their whole laws in the two runs (see `Contact.of_models`), the
    # difference of the runs is no error estimate.
    whole = meshed.plan.bounded != run.plan.bounded
    unknown = [math.inf] * (whole or any(outgrown(run)))
    mesh = _changes(wanted, run, [*others, *unknown])
    contact = _changes(wanted, run, by_contact)
    touched = [(of.law, tip) for of in run.plan.contacts for *_, tip in run.plan.touched(of)]
    # Shells on a body with solids are not refined, so that their error is not known.
    mixed = any(of.mesh and len({b.element.thin for b in of.mesh.blocks}) > 1 for of in bodies)
    if mixed or any(_is_bare(*of) for of in touched):
        mesh = {}
    return LeftOut(mesh, contact, _worst_time(wanted[0], run, others + by_contact))


def _changes(
    wanted: Sequence[Quantity], run: Run, others: Sequence[Run | float]
) -> Mapping[str, float]:
    """Return by name the sum of each quantity's or number's relative differences from `others`."""
    runs = [of for of in others if isinstance(of, Run)]
    if len(runs) < len(others):
        return Found(lambda: run.numbers, lambda _: math.inf)
    each = [number_errors(run, [(of, 1.0)], on_the_way=True) for of in runs]

    def change(name: str) -> float:
        return sum(of[name] for of in each)

    def there(name: str) -> bool:
        return not math.isnan(run.numbers[name])

    known = {
        of.name: sum(of.difference(other, run) for other in runs)
        if of.is_history
        # In a scene, the value is the largest of all contacts or bodies.
        else max((change(at) for at in of.names(run) if there(at)), default=0.0)
        for of in wanted
    }
    return Found(lambda: number_errors(run, ()), change, known)


def _worst_time(quantity: Quantity, run: Run, others: Sequence[Run | float]) -> float | None:
    """Return the time, s, at which a history differs most between runs; None for a number."""
    runs = [of for of in others if isinstance(of, Run) and quantity.is_history]
    changes = [np.abs(quantity.deviation(of, run)) for of in runs]
    largest = max(changes, key=np.max, default=None)
    return None if largest is None else float(run.t[largest.argmax() % len(run.t)])


def _with_models(run: Run) -> Run:
    """Return the same run with reduced models, with which further runs for the estimate are cheap.

    Errors of mesh and contact affect the motion of reduced models in the same way as the motion of
    full bodies.
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
    """Return the contacts with laws altered by their uncertainty; None if one is not known.

    The law is altered by the compliance that varies with the width of the contact, or by a
    compliance that was left in the law although it may belong to the mesh.
    """
    plan = run.plan
    contacts = list[Contact]()
    for number, (contact, events) in enumerate(zip(plan.contacts, run.events, strict=True)):
        law = own_law(contact.law)
        varying = left = 0.0
        for body, port in contact.ports if events.peak_force else ():
            tip = plan.bodies[body].touched_at(port)
            if tip is None or _is_bare(law, tip):
                continue  # a body given by numbers, or a law without the bodies' indentation
            known = extraction_of(law, plan.bodies[body], port)
            if known is None:
                return None  # uncertainty unknown: a rigid model or a sharp edge
            if known.removed and not isinstance(contact.law, PatchLaw):
                left += known.removed  # runs with and without this removal bound the motion
            else:
                varying += known.varying
        most = min(left, removable(law, run.deepest(number))) if left else -varying
        contacts.append(contact._replace(law=_altered(contact.law, most, contact.law_error)))
    return tuple(contacts)


def _is_bare(law: ContactLaw, tip: ContactPoint) -> bool:
    """Return whether a solid mesh's own indentation at a node adds to the law's indentation.

    Only a law like Hertz's contains that indentation already; see `extraction_of`.
    """
    return not (tip.patch or tip.thin or isinstance(own_law(law), HertzianLaw))


def _altered(law: ContactLaw, change: float, error: float = 0.0) -> ContactLaw:
    """Return a law with a further compliance `change`, m/N, taken out, and k changed by `error`.

    `error` is relative. Both changes make the law stiffer, or both softer, so that their effects
    add up. Above its limit a law continues as a straight line, which is sufficient to show a
    change.
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
    """Return the plan with models of refined bodies; None if no body can be refined.

    Parameters
    ----------
    plan : Scenario
    solver : str or callable, optional
        The linear solver; see `FEModel.inverse`.
    made : sequence of bool, optional
        For each body, True if its model was made for the impact, and may be replaced; by default
        all.
    every : bool, optional
        True to return a plan even if no body can be refined; its models have more vectors.
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
        more = 0.0  # change of the meshes' compliance at nodes, m/N
        for body, port in known.ports:
            tip = plan.bodies[body].touched_at(port)
            if tip is not None and _is_bare(law, tip):
                one, other = (own[body].extraction_at(port) for own in (bodies, plan.bodies))
                more += one.removed - other.removed if one and other else 0.0
        contacts.append(known._replace(law=_altered(known.law, more)))
    return replace(plan, bodies=bodies, contacts=tuple(contacts), bounded=bounded)


def compared_runs(run: Run, solver: TimeSolver | None, *, every: bool = False) -> list[Run | float]:
    """Return the runs whose differences from a run add up to its error due to the meshes.

    The first is the run with the bodies as the user meshed them, if `run` has finer elements; the
    last is the run of `finer_plan`. Infinity stands for a run that fails.
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
    """Return a list of the plan's run, as long as `run`; [inf] if it fails, [] without a plan."""
    try:
        with held_warnings():
            if (wanted := plan()) is None:
                return []
            return [solve(replace(wanted, duration=run.duration, energies=False), solver)]
    except (AOImpactError, MemoryError):  # such as a contact beyond the range of its law
        return [math.inf]


def _finer(model: BodyModel, make: Callable[[Any], BodyModel]) -> BodyModel:
    """Return the model of the refined body, made once for all directions of travel."""
    of, ports = model.kept.get("turned", (model, ()))
    if "finer" not in of.kept:
        of.kept["finer"] = make(of)
    found: BodyModel = of.kept["finer"].turned(ports)
    return found
