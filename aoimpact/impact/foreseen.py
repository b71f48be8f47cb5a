"""Estimates from rigid bodies: the duration of a scene, and the radii of its contacts.

These estimates determine the patches of contact points whose radius was left out, and the contact
laws.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

from ..accuracy import alike
from ..base import AOImpactError, InputError, plain
from ..contact import SHIFT_TIMES_DURATION, ContactPoint, contact_within
from ..integrate import rigid_contact_time
from ..laws import ContactLaw, own_law, round_contact
from ..linalg import LinearSolver, Solver
from ..reduction import BodyModel, FullModel
from ..results import RecordLength
from ..scene import Contact, Load, Scenario
from .oblique import ROLES, with_functionals


class Foreseen:
    """Estimates of a scene's contacts from rigid bodies, which indent deeper than elastic bodies.

    Parameters
    ----------
    plan : Scenario
        Scene of the bodies as given.
    solver : str or callable, optional
        The linear solver; see `FEModel.inverse`.
    """

    def __init__(self, plan: Scenario, solver: Solver = "auto") -> None:
        self._plan, self._solver = plan, solver
        # Bodies have only weak references to their solvers; this dict keeps the solvers alive until
        # models are made.
        self._solvers: dict[Any, LinearSolver] = {}

    def record(self) -> RecordLength:
        """Return a first guess of the record's duration, s.

        Raises
        ------
        InputError
            If no velocity, gravity or constant force makes the bodies of any contact approach.
        """
        plan = self._plan
        times = [time for time in self._times if time is not None]
        if not times:
            for met in filter(None, map(self._met, plan.contacts)):
                rigid_contact_time(*met)  # raises the law's own error, if there is one
            raise InputError(
                "duration was left out, and cannot be foreseen: no velocity, gravity or constant "
                "force brings bodies that have a contact towards each other; give duration="
            )
        ways = [way for of in plan.contacts if (way := plan.approach(of)[0]) < math.inf]
        gaps = max(contact.gap for contact in plan.contacts)
        return RecordLength(max(times) + max([*ways, gaps / plan.fastest]), given=False)

    def fitted(self, names: Sequence[str], eased: Mapping[Any, str]) -> Scenario:
        """Return the plan with the patches, radii and directions of its contacts determined.

        Parameters
        ----------
        names : sequence of str
            Names of the bodies, for messages.
        eased : mapping of int to str
            Remedy for each contact whose law is stiffer than its meshes, by the contact's number:
            "wider" for a wider patch than an impact of two bodies needs, "whole" for a wider patch
            and no compliance taken out of the law; see `Contact.of_models`.
        """
        plan, bodies = self._plan, list(self._plan.bodies)
        if not plan.meshed:
            return plan if plan.oblique is None else _with_functionals(plan, names)
        contacts = []
        for number, contact in enumerate(plan.contacts):
            if any(bodies[of].tips for of, _ in contact.ports):
                contact = contact._replace(width=self._widths[number])
            contacts.append(contact)
        fits: dict[Any, BodyModel] = {}
        for number, contact in enumerate(contacts):
            for of, port in contact.ports:
                key = bodies[of], port
                if key not in fits:
                    fits[key] = self._fit(*key, number, number in eased)
                bodies[of] = fits[key]
        around = _around(plan, names)
        for i, body in enumerate(bodies):
            # Directions are reversed now if the model needs the final direction of several ports.
            if len(body.tips) > 1 or plan.oblique is not None:
                bodies[i], around[i] = body.turned(around[i]), ()
        bounded = frozenset(number for number, way in eased.items() if way == "whole")
        fitted = replace(
            plan, bodies=tuple(bodies), contacts=tuple(contacts), around=around, bounded=bounded
        )
        return fitted if plan.oblique is None else _with_functionals(fitted, names)

    @cached_property
    def _times(self) -> list[float | None]:
        """Return the duration of each contact, s; None where not known."""
        return [_known(rigid_contact_time, self._met(contact)) for contact in self._plan.contacts]

    @cached_property
    def _widths(self) -> list[float | None]:
        """Return the radius of each contact at its largest force, m; None where not known."""

        def width(law: ContactLaw, mass: float, speed: float) -> float | None:
            found = round_contact(law, materials)
            radius = law.relative_radius if found is None else found.radius
            return None if radius is None else math.sqrt(radius * law.stroke(0.5 * mass * speed**2))

        widths = []
        for contact in self._plan.contacts:
            # Bodies of unknown material are assumed to be rigid.
            materials = [of for of in contact.materials(self._plan.bodies) if of is not None]
            widths.append(_known(width, self._met(contact)))
        return widths

    def _met(self, contact: Contact) -> tuple[ContactLaw, float, float] | None:
        """Return a contact's law, reduced mass, kg, and speed, m/s; None if bodies cannot meet."""
        bodies = (self._plan.bodies[body] for body, _ in contact.ports)
        share, speed = math.fsum(1.0 / body.most_mass for body in bodies), self._plan.fastest
        return (own_law(contact.law), 1.0 / share, speed) if share > 0.0 < speed else None

    def _fit(self, body: BodyModel, port: int, number: int, wider: bool) -> BodyModel:
        """Return the body with a patch, if it has none, and the compliance at the contact."""
        if not isinstance(body, FullModel) or not ((tip := body.tips[port]).automatic or tip.patch):
            return body
        if (lasting := self._times[number]) is None or (width := self._widths[number]) is None:
            return body
        radius, time = alike(width, up=True), alike(lasting)

        def pressed() -> ContactPoint:
            wide = contact_within(tip, radius, wider=wider) if tip.automatic else tip
            s2 = (SHIFT_TIMES_DURATION / time) ** 2
            if (tip.body, s2) not in self._solvers:
                self._solvers[tip.body, s2] = tip.body.inverse(s2, solver=self._solver)
            return wide.at_impact(radius, self._solvers[tip.body, s2])

        fit = tip.body.kept.get(("patch", tip.key, radius, time, wider, self._solver), pressed)
        return replace(body, tips=(*body.tips[:port], fit, *body.tips[port + 1 :]))


def _known(find: Callable[..., float | None], met: Any) -> float | None:
    """Return ``find(*met)``; None if `met` is None, or the result is beyond the law's range."""
    try:
        return None if met is None else find(*met)
    except AOImpactError:
        return None


def goes_against(tip: ContactPoint | None, *, outward: bool) -> bool:
    """Return whether a contact point's direction of travel must be reversed.

    The direction must go out of the body if `outward` is True, else into the body.
    """
    if tip is None or tip.normal is None or tip.direction is None:
        return False
    return (float(tip.direction @ tip.normal) > 0.0) != outward


def _around(plan: Scenario, names: Sequence[str]) -> list[tuple[int, ...]]:
    """Return the ports of each body whose direction of travel must be reversed.

    The direction goes out of the first body of a contact and into the second.

    Raises
    ------
    InputError
        If the caller gave a reversed direction.
    """
    roles: dict[tuple[int, int], set[bool]] = {}
    sides: dict[ContactPoint | None, set[bool]] = {}
    for contact in plan.contacts:
        for outward, (body, port) in zip((True, False), contact.ports, strict=True):
            roles.setdefault((body, port), set()).add(outward)
            sides.setdefault(plan.bodies[body].touched_at(port), set()).add(outward)
    around: list[tuple[int, ...]] = [()] * len(plan.bodies)
    for (body, port), ways in roles.items():
        if len(ways) > 1:  # first body of one contact, second of another
            continue
        tip, outward = plan.bodies[body].touched_at(port), True in ways
        if tip is None or tip.point is None or not goes_against(tip, outward=outward):
            continue
        around[body] = (*around[body], port)
        like = len(sides[tip]) > 1  # two equal bodies share this contact point
        if tip.directed and tip.thin is None and not like:
            way, opposite = ("out of", "into") if outward else ("into", "out of")
            raise InputError(
                f"{names[body]}: direction {plain(tip.direction)} goes {opposite} the body at "
                f"point {plain(tip.point)} m, whose outward normal is {plain(tip.normal)}. It is "
                "the projectile's direction of travel, out of the projectile and into the target, "
                f"and goes {way} this body: leave direction out, turn it round, or swap the two "
                "bodies"
            )
    return around


def _with_functionals(plan: Scenario, names: Sequence[str]) -> Scenario:
    """Return the plan with three ports per contact point: a normal and two tangents."""
    assert plan.oblique is not None
    sides = [{of.first for of in plan.contacts}, {of.second for of in plan.contacts}]
    touched = [
        [role for role, side in zip(ROLES, sides, strict=True) if body in side]
        for body in range(len(plan.bodies))
    ]

    def first(body: int, port: int, role: float) -> int:
        """Return the first of the three ports of a contact point."""
        return 3 * (port if plan.bodies[body].tips else touched[body].index(role))

    contacts = [
        of._replace(
            first_port=first(of.first, of.first_port, ROLES[0]),
            second_port=first(of.second, of.second_port, ROLES[1]),
            # A smooth contact has only a normal force.
            friction=of.friction if of.friction and of.friction.mu else None,
        )
        for of in plan.contacts
    ]
    loads: list[Load] = [
        of._replace(port=first(of.body, of.port, touched[of.body][0]) if touched[of.body] else 0)
        for of in plan.loads
    ]
    bodies = tuple(
        with_functionals(names[i], body, plan.oblique.axes, touched[i])
        for i, body in enumerate(plan.bodies)
    )
    return replace(plan, bodies=bodies, contacts=tuple(contacts), loads=tuple(loads))
