"""Errors of a run by its meshes and its contact laws, from the errors of compliances.

The errors of a contact point's compliance (`compliance_error`) are corrected in the reduced models,
and one more run gives the change of any quantity. Elements that are too stiff make the whole body
too stiff: all its springs are softened until they add the missing compliance at a frequency of the
contact. In a plate this is bending, of which a spring in series at the contact would give a
twentieth. The half-space's error is local to the contact, and acts as such a spring. The errors of
two bodies, and of several contacts, are corrected in the same run, which is the reference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base import AOImpactError, held_warnings
from ..laws import ContactLaw, Hertz, HertzianLaw, PatchLaw, own_law
from ..reduction import FullModel, ReducedModel
from ..results import LeftOut, Quantity, Run, TimeSolver, number_errors, solve
from ..scene import Contact, FullBody, Plan, SceneBody, scene_body
from .compliance import compliance_error
from .hierarchy import model_hierarchy

__all__ = ["LeftOutFinder"]

# A run is repeated with laws stiffer or softer by no more than this, and the change is scaled: peak
# forces depend on a power of the stiffness below 1, so this is linear to 5 %.
_SMALL = 0.1

# Oscillators of a model that replaces the full body where errors of mesh and contact are estimated.
# Its forces have errors of some percent, and so have the estimates.
_IN_PLACE_OF_ALL = 16

# Slopes are taken over this share of the indentation.
_DIFFERENCE = 1e-3

# The mesh's error is evaluated for a contact time longer by this factor, at s = 6/T. At higher
# frequencies the error just under the contact has a larger share, which matters less to the force.
# Measured on plates and beams of all kinds of elements: springs softened by the true error at 6/T
# correct .6 to 1.15 of the error of the peak force; at 4/T .4 to .9, at 10/T .65 to 1.45. Hence the
# safety factor, with which 95 of 100 errors are within the estimate (docs/calibration.md).
_SLOWER, _SAFETY = 10.0 / 6.0, 1.5


@dataclass(frozen=True, eq=False)
class LeftOutFinder:
    """Estimates the errors of a run by meshes and laws, when they are read.

    Attributes
    ----------
    interest : callable
        Returns a new quantity of interest, so that what it stores while runs are compared is freed.
    solver : Adaptive or Newmark, optional
        Of the run.
    law_errors : sequence of float
        Relative error of each contact's stiffness, by that of the curvatures.
    meshed : bool
        Whether any body was given with a mesh, even if its model is a wall. Errors of models given
        by numbers are not known.
    """

    interest: Callable[[], Quantity]
    solver: TimeSolver | None
    law_errors: Sequence[float] = ()
    meshed: bool = True

    def __call__(self, run: Run) -> LeftOut:
        """Return the errors; None where a body's are not known."""
        plan = run.plan
        if not self.meshed:
            return LeftOut()
        full = [body.model.body for body in plan.bodies if isinstance(body, FullBody)]
        if full:
            if any(body.mesh is None for body in full) or not any(of.contacts for of in run.events):
                return LeftOut()
            return replace(self, solver=None)(_with_models(run))
        found = [_of_contact(run, i) for i in range(len(plan.contacts))]
        if None in found:
            return LeftOut()
        softening: dict[int, float] = {}
        for end in (end for ends in found for end in ends or ()):
            softening[end.body] = max(end.softening, softening.get(end.body, 0.0))
        contact = [math.fsum(end.contact for end in ends or ()) for ends in found]
        quantity = self.interest()
        in_mesh, when = self._changes(quantity, run, _softer(run, softening))
        in_contact, then = self._changes(quantity, run, _in_series(run, contact))
        if any(self.law_errors):
            in_law, _ = self._changes(quantity, run, _stiffer(run, self.law_errors))
            in_contact = {name: error + in_law[name] for name, error in in_contact.items()}
        worst = when if in_mesh[quantity.name] >= in_contact[quantity.name] else then
        if quantity.local is not None:
            in_mesh[quantity.name] += quantity.local(run)
        return LeftOut(in_mesh, in_contact, worst)

    def _changes(
        self, quantity: Quantity, run: Run, altered: _Altered
    ) -> tuple[dict[str, float], float | None]:
        """The change of the quantity and of each number, and the time of a history's largest."""
        names = [*number_errors(run, ()), quantity.name]
        if altered.plan is None:
            return dict.fromkeys(names, 0.0), None
        try:
            with held_warnings():
                other = solve(altered.plan, self.solver)
        except AOImpactError:  # a contact beyond the range of its law
            return dict.fromkeys(names, math.inf), None
        changes = np.abs(quantity.deviation(run, other))
        change = altered.scale * float(changes.max(initial=0.0))
        when = None
        if quantity.is_history and change:
            when = float(other.t[changes.argmax() % len(other.t)])
        numbers = number_errors(run, [other], altered.scale)
        return numbers | {quantity.name: change}, when


def _with_models(run: Run) -> Run:
    """The run with models in place of the full bodies, of which every run is expensive.

    Errors of mesh and contact change the models' motion as they change the bodies'.
    """
    times = [end - start for events in run.events for start, end in events.contacts]
    shortest = min((time for time in times if time > 0.0), default=run.duration)
    slow = run.duration if run.duration > shortest else None
    made: dict[FullModel, Any] = {}
    bodies: list[SceneBody] = []
    for body in run.plan.bodies:
        if isinstance(model := body.model, FullModel):
            if model not in made:
                made[model] = model_hierarchy(model, shortest, slow).finished(_IN_PLACE_OF_ALL)
            body = scene_body("body", made[model], body.velocity)
        bodies.append(body)
    plan = replace(run.plan, bodies=tuple(bodies), energies=False)
    with held_warnings():
        return solve(plan, None)


@dataclass(frozen=True)
class _End:
    """Errors of the compliance of a body at a contact.

    Attributes
    ----------
    body : int
        Its number in the plan.
    contact : float
        Error near the contact, m/N.
    softening : float
        Relative increase of the springs' compliances that corrects the mesh's error.
    """

    body: int
    contact: float
    softening: float


@dataclass(frozen=True, eq=False)
class _Altered:
    """A plan with changed laws or bodies, and the factor on changes; None: unchanged."""

    plan: Plan | None
    scale: float = 1.0


def _of_contact(run: Run, number: int) -> list[_End] | None:
    """Errors of the compliances at a contact; none for models given by numbers."""
    plan, events, contact = run.plan, run.events[number], run.plan.contacts[number]
    start, end = events.peak_contact or (0.0, 0.0)
    contact_time = end - start
    if contact_time <= 0.0:
        return []
    law = own_law(contact.law)
    found = []
    for body, port in contact.ports:
        model = plan.bodies[body].model
        points = model.contact_points
        if not points:
            continue
        if points[port].patch is None and not isinstance(law, HertzianLaw):
            continue  # such a law does not contain the bodies' indentation
        fast, slow = (
            compliance_error(
                model,
                contact_time=times * contact_time,
                contact_radius=_contact_radius(run, number),
                port=port,
            )
            for times in (1.0, _SLOWER)
        )
        if fast is None or slow is None:
            return None
        found.append(_End(body, abs(fast.contact), _SAFETY * slow.mesh / slow.strain))
    return found


def _softer(run: Run, softening: Mapping[int, float]) -> _Altered:
    """The plan with springs more compliant by these shares."""
    if not any(softening.values()):
        return _Altered(None)
    bodies = list(run.plan.bodies)
    for body, share in softening.items():
        model = bodies[body].model
        assert isinstance(model, ReducedModel)
        bodies[body] = replace(bodies[body], model=model.stiffened(1.0 / (1.0 + share)))
    return _Altered(replace(run.plan, bodies=tuple(bodies), energies=False))


def _depth(run: Run, number: int) -> float:
    """The largest indentation in a contact's own law, m."""
    contact, deepest = run.plan.contacts[number], run.contacts[number].indentation.max()
    if not isinstance(contact.law, PatchLaw):
        return float(deepest)
    return float(deepest + contact.law.compliance * run.events[number].peak_force)


def _contact_radius(run: Run, number: int) -> float | None:
    """Radius of a contact at its largest indentation, m; None where the law gives none."""
    radius = own_law(run.plan.contacts[number].law).relative_radius
    return None if radius is None else math.sqrt(radius * _depth(run, number))


def _in_series(run: Run, compliances: Sequence[float]) -> _Altered:
    """The plan with these compliances, m/N, in series with the laws."""
    largest = max(
        (_slope(run, i) * change for i, change in enumerate(compliances) if change), default=0.0
    )
    if largest == 0.0:
        return _Altered(None)
    scale = max(1.0, largest / _SMALL)
    contacts = [
        contact._replace(law=_with_compliance(contact.law, change / scale))
        for contact, change in zip(run.plan.contacts, compliances, strict=True)
    ]
    return _Altered(_with(run.plan, contacts), scale)


def _slope(run: Run, number: int) -> float:
    """dF/dδ of a contact's own law at its largest indentation, N/m, from below."""
    depth = _depth(run, number)
    low, high = own_law(run.plan.contacts[number].law).force(
        np.array([1.0 - _DIFFERENCE, 1.0 - 1e-12]) * depth
    )
    return float(high - low) / (_DIFFERENCE * depth)


def _with_compliance(law: ContactLaw, change: float) -> ContactLaw:
    """The law with a compliance in series reduced by `change`, or, where it has less, increased."""
    if change == 0.0:
        return law
    if not isinstance(law, PatchLaw):
        return PatchLaw(law, change)
    if law.compliance > change:
        return replace(law, compliance=law.compliance - change)
    return replace(law, compliance=law.compliance + change)


def _stiffer(run: Run, errors: Sequence[float]) -> _Altered:
    """The plan with Hertz's laws stiffer by these shares."""
    scale = max(1.0, max(errors) / _SMALL)
    contacts = []
    for contact, error in zip(run.plan.contacts, errors, strict=True):
        law = own_law(contact.law)
        if error and isinstance(law, Hertz):
            law = replace(law, k=law.k * (1.0 + error / scale))
        if isinstance(contact.law, PatchLaw):
            law = replace(contact.law, law=law)
        contacts.append(contact._replace(law=law))
    return _Altered(_with(run.plan, contacts), scale)


def _with(plan: Plan, contacts: Sequence[Contact]) -> Plan:
    return replace(plan, contacts=tuple(contacts), energies=False)
