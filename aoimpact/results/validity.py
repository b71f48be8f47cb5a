"""How far an impact is from the limits of linear elasticity: one table of its summary."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..laws import ElasticPlastic, Thornton, own_law
from .advice import SPEED, limits, small_deflection

if TYPE_CHECKING:
    from .run import Result


# Masses of a projectile over that of a plate below which the waves of the impact do not come back
# from the supports before it is over, and above which the plate follows quasi-statically
# (R. Olsson, Composites A 31, 879, 2000).
_WAVES, _QUASI_STATIC = 0.2, 2.0


@dataclass(frozen=True)
class Advice:
    """One way in which an impact may leave the range of the method.

    Attributes
    ----------
    name : {"yield", "deflection", "mass ratio", "speed"}
    value : float
        What it has reached, relative: of the force of first yield, of the thickness or the size of
        the body, of the target's mass, or of the velocity of waves.
    limit : float
        Up to where it needs no thought; infinite where there is no such limit.
    meaning : str
        In words.
    """

    name: str
    value: float
    limit: float
    meaning: str

    @property
    def within(self) -> bool:
        """True if the value is within the limit."""
        return self.value <= self.limit

    def __str__(self) -> str:
        return f"{self.value:.2g} {self.meaning}"


def advice_of(result: Result) -> tuple[Advice, ...]:
    """Return what is known of the validity of an impact, in the order of `Advice.name`."""
    return tuple(_known(result)) if result.contacts else ()


def _known(result: Result) -> Iterator[Advice]:
    plan = result.plan
    contact = plan.contacts[0]
    law, most = own_law(contact.law), limits(plan, contact)
    yields = law.yield_force if isinstance(law, ElasticPlastic | Thornton) else most.pressure
    if math.isfinite(yields):
        of = "of the force of first yield"
        meaning = f"{of}: elastic" if result.peak_force <= yields else f"{of}: beyond"
        if result.peak_force > yields and law.has_memory:
            meaning += ", as the law has it"
        yield Advice("yield", result.peak_force / yields, 1.0, meaning)
    for body, port in contact.ports:
        model, tip = plan.bodies[body], plan.bodies[body].touched_at(port)
        if not model.constrained or tip is None or tip.body.mesh is None:
            continue
        size, what, share = small_deflection(tip)
        moved = float(np.abs(result.bodies[body].port_displacements[port]).max(initial=0.0))
        meaning = f"of the {what} of {result.names[body]}: small up to {share:g}"
        yield Advice("deflection", moved / size, share, meaning)
    first, second = plan.bodies
    if first.known_mass and second.mass and second.constrained and not second.wall:
        ratio = first.known_mass / second.mass
        meaning = "of the target: supports and waves both matter"
        if ratio < _WAVES:
            meaning = "of the target: over before waves return, if it is a plate"
        elif ratio > _QUASI_STATIC:
            meaning = "of the target: quasi-static, by the stiffness of its supports"
        yield Advice("mass ratio", ratio, math.inf, meaning)
    if math.isfinite(most.speed):
        slowest = most.speed / SPEED
        ratio = abs(result.velocity) / slowest
        yield Advice("speed", ratio, SPEED, f"of that of waves: slow up to {SPEED:g}")
