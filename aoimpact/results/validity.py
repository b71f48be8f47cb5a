"""Limits of linear elasticity: up to where a contact needs no warning, and how far an impact is.

Each rule is one function of a contact before it is run, and a row of `_RULES`: what it limits, up
to where, the warning beyond it, and how far a run has gone. `limits` has those that are known, from
which come the warnings of a run, the force and speed up to which many impacts need none, and the
rows of `Advice` in a summary.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base import with_unit
from ..fem import ContactPoint, Material
from ..laws import (
    ContactLaw,
    ElasticPlastic,
    RoundContact,
    Thornton,
    own_law,
    round_contact,
    yield_force,
    yield_pressure,
)
from ..reduction import Body

if TYPE_CHECKING:
    from ..scene import Contact, Plan
    from .run import Result, Run


# Radius of a contact over that of curvature. Sneddon's punch with the shape of a sphere, instead of
# Hertz's paraboloid, has 1 % less force here and 3 % at .5; strains are .2 of it (Tabor).
_WIDTH, _STRAIN = 0.3, 0.2

# Velocity over that of waves in a bar: the strain of two bars that meet, as large as the tolerance.
_SPEED = 0.01

# Deflection over thickness of a body constrained on both sides, where the linear one is 12 % off:
# the load on a clamped plate goes with w + .471 w³/h² (Timoshenko, *Theory of Plates and Shells*,
# section 100). And over the size of any body.
_THICKNESS, _SIZE = 0.5, 0.1

# Supports along an axis that is no more along the contact's direction than this keep a body from
# drawing in.
_ACROSS = 0.5

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


class Limit(NamedTuple):
    """Up to where a contact needs no warning of one kind.

    Attributes
    ----------
    of : {"force", "speed", "energy"}
        Quantity that is limited: the force of the contact, N, the speed at which its bodies meet,
        m/s, or the energy of all bodies, J, with which one may move too far.
    most : float
    said : callable
        The warning, from the run and the value reached; empty if the motion does not confirm it.
    advice : callable, optional
        How far an impact has gone, as far as the summary says it.
    """

    of: str = "force"
    most: float = math.inf
    said: Callable[[Run, float], str] = lambda run, value: ""
    advice: Callable[[Result], Iterable[Advice]] = lambda result: ()


class _Joint(NamedTuple):
    """Properties of a contact that are known before the run."""

    plan: Plan
    contact: Contact
    law: ContactLaw
    materials: list[Material | None]
    surface: RoundContact | None


def touched(plan: Plan, contact: Contact) -> Iterator[tuple[int, int, ContactPoint]]:
    """Yield the bodies that a contact touches at known places: number, port and place."""
    for body, port in contact.ports:
        if (tip := plan.bodies[body].touched_at(port)) is not None:
            yield body, port, tip


def limits(plan: Plan, contact: Contact) -> dict[str, Limit]:
    """Return the limits of a contact by name, as far as its law and bodies are known."""
    law, materials = own_law(contact.law), contact.materials(plan.bodies)
    joint = _Joint(plan, contact, law, materials, round_contact(law, materials))
    found = ((name, rule(joint)) for name, rule in _RULES.items())
    return {name: limit for name, limit in found if limit is not None}


def contact_name(run: Run, contact: Contact) -> str:
    """Return the name of a contact, by itself that of its bodies."""
    return contact.name or f"{run.names[contact.first]} on {run.names[contact.second]}"


def _yield(joint: _Joint) -> Limit | None:
    """The force at which the first of the bodies begins to yield below the surface."""
    surface, law = joint.surface, joint.law

    def advice(result: Result) -> Iterator[Advice]:
        ratio, had = result.peak_force / first, ", as the law has it" if law.has_memory else ""
        way = "elastic" if ratio <= 1.0 else f"beyond{had}"
        yield Advice("yield", ratio, 1.0, f"of the force of first yield: {way}")

    if isinstance(law, ElasticPlastic | Thornton):
        first = law.yield_force
        return Limit(advice=advice) if math.isfinite(first) else None
    known = [(of, of.yield_strength) for of in joint.materials if of is not None]
    if surface is None or law.has_memory or not any(strength for _, strength in known):
        return None
    first, pressure, strength = min(
        (yield_force(surface.modulus, surface.radius, yield_pressure(of)), yield_pressure(of), by)
        for of, by in known
        if by
    )

    def said(run: Run, force: float) -> str:
        return (
            f"{contact_name(run, joint.contact)}: the largest pressure, "
            f"{with_unit(surface.pressure(force), 'Pa', 3)}, exceeds {pressure / strength:.3g} "
            f"times yield_strength={with_unit(strength, 'Pa', 3)}, so that a body yields from "
            f"{with_unit(first, 'N', 3)} on. Use ElasticPlastic(k={surface.k:.6g}, "
            f"yield_force={first:.4g}, hardness={2.8 * strength:.4g}, "
            f"relative_radius={surface.radius:.6g})."
        )

    return Limit("force", first, said, advice)


def _width(joint: _Joint) -> Limit | None:
    """The force of a contact too wide for the curvature of its surfaces."""
    if (surface := joint.surface) is None:
        return None

    def said(run: Run, force: float) -> str:
        width = float(surface.width(force)) / surface.radius
        return (
            f"{contact_name(run, joint.contact)}: at the peak the contact has a radius of "
            f"{width:.2g} times the radius of curvature R={with_unit(surface.radius, 'm', 3)}, "
            f"with strains of about {_STRAIN * width:.1%}: Hertz's law and linear elasticity are "
            "for small ones; take a lower velocity, or a measured law, Tabulated(...), and check "
            "that R is in metres"
        )

    return Limit("force", surface.k * (_WIDTH * _WIDTH * surface.radius) ** 1.5, said)


def _speed(joint: _Joint) -> Limit | None:
    """The speed of bodies that meet too fast."""
    speeds = [of.bar_speed for of in joint.materials if of is not None]
    if not speeds:
        return None
    slowest = min(speeds)

    def said(run: Run, speed: float) -> str:
        return (
            f"{contact_name(run, joint.contact)}: the bodies meet at {speed:.4g} m/s, "
            f"{speed / slowest:.1%} of the speed of waves, {slowest:.4g} m/s: strains are as "
            "large, and linear elasticity is for small ones; take a lower velocity, and check E "
            "and rho"
        )

    def advice(result: Result) -> Iterator[Advice]:
        ratio = abs(result.velocity) / slowest
        yield Advice("speed", ratio, _SPEED, f"of that of waves: slow up to {_SPEED:g}")

    return Limit("speed", _SPEED * slowest, said, advice)


def _deflection(joint: _Joint) -> Limit | None:
    """The energy below which each constrained body of a contact has a small deflection.

    k0 u²/2 is the least energy of a deflection u; 0 where no such limit is known.
    """
    plan, energies = joint.plan, []
    alone = not plan.weighed and not plan.loads
    for body, _, tip in touched(plan, joint.contact):
        model, mesh = plan.bodies[body], tip.body.mesh
        if model.constrained and mesh is not None:
            least = min(_THICKNESS * tip.depth, _SIZE * mesh.size)
            energies.append(
                0.5 * model.star.k0 * least**2
                if alone and isinstance(model, Body) and model.ports == 1
                else 0.0
            )

    def said(run: Run, _: float) -> str:
        for name, value, size, what, share in _deflections(run, joint.contact):
            if value * size > share * size:
                told = f"{name} deflects by {with_unit(value * size, 'm', 3)}, and is"
                return f"{told} {with_unit(size, 'm', 3)} {_TOO_FAR[what]}"
        return ""

    def advice(result: Result) -> Iterator[Advice]:
        for name, value, _, what, share in _deflections(result, joint.contact):
            meaning = f"of the {what} of {name}: small up to {share:g}"
            yield Advice("deflection", value, share, meaning)

    return Limit("energy", min(energies), said, advice) if energies else None


_TOO_FAR = {
    "thickness": "thick: constrained on both sides it stretches, and is stiffer than linear "
    "elasticity has it; take a lower velocity, or do not trust deflection and stress to better "
    "than tens of percent",
    "size": "long: linear elasticity is for small rotations; take a lower velocity, or check units "
    "and supports",
}


def _deflections(run: Run, contact: Contact) -> Iterator[tuple[str, float, float, str, float]]:
    """Each constrained body of a contact that has a mesh, with how far it deflects.

    Its name, the deflection over what it has to be small beside, m, the name of that, and the share
    of it that is small.
    """
    for body, port, tip in touched(run.plan, contact):
        if not run.plan.bodies[body].constrained or tip.body.mesh is None:
            continue
        moved = float(np.abs(run.bodies[body].port_displacements[port]).max(initial=0.0))
        size, what, share = tip.body.mesh.size, "size", _SIZE
        if _THICKNESS * tip.depth < share * size and _stretches(tip):
            size, what, share = tip.depth, "thickness", _THICKNESS
        yield run.names[body], moved / size, size, what, share


def _stretches(tip: ContactPoint) -> bool:
    """True if supports on two sides of the point keep the body from drawing in as it deflects."""
    body = tip.body
    if body.nodes is None or body.free is None or tip.point is None or tip.direction is None:
        return False
    constrained = np.setdiff1d(np.arange(3 * len(body.nodes)), body.free)
    for axis in np.flatnonzero(np.abs(tip.direction) < _ACROSS):
        offset = body.nodes[constrained[constrained % 3 == axis] // 3] - tip.point
        along = offset[:, axis]
        straight = 2.0 * along**2 > (offset**2).sum(axis=1)  # within 45° of the axis
        if (straight & (along < 0.0)).any() and (straight & (along > 0.0)).any():
            return True
    return False


def _thickness(joint: _Joint) -> Limit | None:
    """The force of a contact that is wider than a shell, or a beam's wall, is thick."""
    tips = touched(joint.plan, joint.contact)
    walls = [tip.thin.narrowest for _, _, tip in tips if tip.thin is not None]
    if (surface := joint.surface) is None or not walls:
        return None
    half = 0.5 * min(walls)

    def said(run: Run, force: float) -> str:
        return (
            f"{contact_name(run, joint.contact)}: at the peak the contact has a radius of "
            f"{with_unit(float(surface.width(force)), 'm', 3)}, more than half the thickness of "
            f"the shell or beam, {with_unit(min(walls), 'm', 3)}: its law is that of a "
            "half-space, and so thin a wall is none; take solids, or a measured law, Tabulated(...)"
        )

    return Limit("force", surface.k * (half * half / surface.radius) ** 1.5, said)


def _mass_ratio(joint: _Joint) -> Limit | None:
    """The masses, which no warning limits: they tell plates' ways of response apart."""

    def advice(result: Result) -> Iterator[Advice]:
        first, second = result.plan.bodies
        if not first.known_mass or not second.mass or not second.constrained or second.wall:
            return
        ratio = first.known_mass / second.mass
        meaning = "of the target: supports and waves both matter"
        if ratio < _WAVES:
            meaning = "of the target: over before waves return, if it is a plate"
        elif ratio > _QUASI_STATIC:
            meaning = "of the target: quasi-static, by the stiffness of its supports"
        yield Advice("mass ratio", ratio, math.inf, meaning)

    return Limit(advice=advice)


# In the order of a summary.
_RULES: dict[str, Callable[[_Joint], Limit | None]] = {
    "yield": _yield,
    "width": _width,
    "deflection": _deflection,
    "mass ratio": _mass_ratio,
    "speed": _speed,
    "thickness": _thickness,
}
