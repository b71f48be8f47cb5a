"""Whether a run is what was meant: no impact at all, and what linear elasticity is not for.

Bodies that yield, contacts as wide as the bodies are curved, plates that stretch, and speeds that
are not small beside that of waves have no small error: each has one warning a run, with its cure.
What is not known of a body is not checked, so that models given by numbers cost nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base import FloatArray, warn, with_unit
from ..fem import ContactPoint, Material
from ..laws import (
    ContactLaw,
    RoundContact,
    Thornton,
    own_law,
    round_contact,
    yield_force,
    yield_pressure,
)
from ..reduction import AOModel

if TYPE_CHECKING:
    from ..scene import Contact, Plan
    from .run import Run

__all__ = ["limits", "warn_of_run", "warning_limits"]

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

# Of displacements.
_ROUNDING = 1e-12

# Times at which bodies that never touch are looked at: so many in each of the shortest periods, at
# least and at most; between them, where a parabola is least.
_EACH_PERIOD, _SAMPLES, _MOST_SAMPLES = 8, 121, 20_000


class Limits(NamedTuple):
    """Up to where a contact needs no warning.

    Attributes
    ----------
    pressure, width : float
        Forces, N: of yield, and of a contact too wide.
    speed : float
        m/s, at which the bodies meet.
    deflection : float
        Energy, J, of all bodies: from there on a body may deflect too far.
    """

    pressure: float
    width: float
    speed: float
    deflection: float


_UNLIMITED = Limits(math.inf, math.inf, math.inf, math.inf)


def limits(plan: Plan, contact: Contact) -> Limits:
    """Return what a contact may come to, as far as its law and bodies are known."""
    own, materials = own_law(contact.law), plan.materials(contact)
    if not any(materials):
        return _UNLIMITED if own.relative_radius is None else _limits_of_numbers(own)
    pressure = width = math.inf
    if (surface := round_contact(own, materials)) is not None:
        width = surface.k * (_WIDTH * _WIDTH * surface.radius) ** 1.5
        if not isinstance(own, Thornton):
            pressure = _yield(surface, materials)[0]
    slowest = min((of.bar_speed for of in materials if of is not None), default=math.inf)
    deflection = min(_deflecting(plan, contact), default=math.inf)
    return Limits(pressure, width, _SPEED * slowest, deflection)


@lru_cache
def _limits_of_numbers(law: ContactLaw) -> Limits:
    """Those of bodies given by numbers, of which nothing is known but the law."""
    surface = round_contact(law, ())
    if surface is None:
        return _UNLIMITED
    return _UNLIMITED._replace(width=surface.k * (_WIDTH * _WIDTH * surface.radius) ** 1.5)


def warning_limits(plan: Plan) -> tuple[float, float]:
    """Return up to which force, N, and velocity, m/s, an impact needs no warning."""
    most, mass = limits(plan, plan.contacts[0]), plan.bodies[0].mass
    speed = most.speed
    if most.deflection < math.inf:
        speed = min(speed, math.sqrt(2.0 * most.deflection / mass) if mass else 0.0)
    return min(most.pressure, most.width), speed


def warn_of_run(run: Run) -> None:
    """Warn where a run is not what was meant, or not what the method is for.

    Of several contacts only the worst is named.

    Parameters
    ----------
    run : Run
    """
    plan, pressed = run.plan, False
    worst: dict[str, tuple[float, int]] = {}
    for number, (contact, events) in enumerate(zip(plan.contacts, run.events, strict=True)):
        if not events.contacts:
            continue
        pressed = True
        if (most := limits(plan, contact)) is _UNLIMITED:
            continue
        force = events.peak_force
        speed = abs(plan.velocities[contact.first] - plan.velocities[contact.second])
        energy = _energy(plan) if most.deflection < math.inf else 0.0
        reached = force, force, speed, energy
        for kind, value, limit in zip(Limits._fields, reached, most, strict=True):
            if value > limit:
                excess = value / limit if limit else math.inf
                worst[kind] = max(worst.get(kind, (0.0, 0)), (excess, number))
    if plan.contacts and not pressed:
        _warn(_missed(run))
    for kind, (_, number) in worst.items():
        _warn(_TEXTS[kind](run, number))


def _warn(text: str) -> None:
    if text:
        warn(text)


# ------------------------------------------------------------------- what is known


def _yield(
    surface: RoundContact, materials: Sequence[Material | None]
) -> tuple[float, Material | None]:
    """The force, N, at which the first of the bodies begins to yield below the surface, and its
    material; infinite where no yield strength is known.
    """
    forces = [
        (yield_force(surface.modulus, surface.radius, yield_pressure(of)), of)
        for of in materials
        if of is not None and of.yield_strength
    ]
    return min(forces, key=lambda pair: pair[0], default=(math.inf, None))


# ------------------------------------------------------------------- deflection


def _deflecting(plan: Plan, contact: Contact) -> Iterator[float]:
    """The energy, J, below which each constrained body of a contact has a small deflection.

    k0 u²/2 is the least energy of a deflection u; 0 where no such limit is known.
    """
    for body, port in contact.ports:
        scene_body = plan.bodies[body]
        model = scene_body.model
        tip = model.touched_at(port)
        if tip is None or not scene_body.constrained or _allowed(tip) == math.inf:
            continue
        alone = not plan.gravity and not plan.loads
        if alone and isinstance(model, AOModel):
            yield 0.5 * model.k0 * _allowed(tip) ** 2
        else:
            yield 0.0


def _energy(plan: Plan) -> float:
    """Of all bodies at the start, J; infinite where a mass is, or is not known."""
    moving = [(body.mass, v) for body, v in zip(plan.bodies, plan.velocities, strict=True) if v]
    return math.fsum(0.5 * (math.inf if mass is None else mass) * v * v for mass, v in moving)


def _allowed(tip: ContactPoint) -> float:
    """The least deflection that may be too large, m; infinite for a body without a mesh."""
    mesh = tip.body.mesh
    return math.inf if mesh is None else min(_THICKNESS * tip.depth, _SIZE * mesh.size)


def _stretches(tip: ContactPoint) -> bool:
    """Whether supports on two sides of the point keep the body from drawing in as it deflects."""
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


# ------------------------------------------------------------------- warnings


def _said_of_pressure(run: Run, number: int) -> str:
    contact, force = run.plan.contacts[number], run.events[number].peak_force
    materials, surface = run.plan.materials(contact), run.plan.round_contact(contact)
    assert surface is not None
    limit, material = _yield(surface, materials)
    assert material is not None
    assert material.yield_strength is not None
    pressure = with_unit(surface.pressure(force), "Pa", 3)
    ratio = yield_pressure(material) / material.yield_strength
    return (
        f"{_contact(run, number)}: the largest pressure, {pressure}, exceeds {ratio:.3g} times "
        f"yield_strength={with_unit(material.yield_strength, 'Pa', 3)}, so that a body yields from "
        f"{with_unit(limit, 'N', 3)} on. Use Thornton(k={surface.k:.6g}, yield_force={limit:.4g}, "
        f"relative_radius={surface.radius:.6g})."
    )


def _said_of_width(run: Run, number: int) -> str:
    contact, force = run.plan.contacts[number], run.events[number].peak_force
    surface = run.plan.round_contact(contact)
    assert surface is not None
    radius = surface.radius
    width = float(surface.width(force)) / radius
    return (
        f"{_contact(run, number)}: at the peak the contact has a radius of {width:.2g} "
        f"times the radius of curvature R={with_unit(radius, 'm', 3)}, with strains of about "
        f"{_STRAIN * width:.1%}: Hertz's law and linear elasticity are for small ones; take a "
        "lower velocity, or a measured law, Tabulated(...), and check that R is in metres"
    )


def _said_of_deflection(run: Run, number: int) -> str:
    """The warning, if the motion itself confirms it."""
    contact = run.plan.contacts[number]
    for body, port in contact.ports:
        tip = run.plan.bodies[body].model.touched_at(port)
        if tip is None or not run.plan.bodies[body].constrained or _allowed(tip) == math.inf:
            continue
        assert tip.body.mesh is not None
        size = tip.body.mesh.size
        most = float(np.abs(run.bodies[body].port_displacements[port]).max(initial=0.0))
        if most > _THICKNESS * tip.depth and _stretches(tip):
            return (
                f"{run.names[body]} deflects by {with_unit(most, 'm', 3)}, and is "
                f"{with_unit(tip.depth, 'm', 3)} thick: constrained on both sides it stretches, "
                "and is stiffer than linear elasticity has it; take a lower velocity, or do not "
                "trust deflection and stress to better than tens of percent"
            )
        if most > _SIZE * size:
            return (
                f"{run.names[body]} deflects by {with_unit(most, 'm', 3)}, and is "
                f"{with_unit(size, 'm', 3)} long: linear elasticity is for small rotations; take a "
                "lower velocity, or check units and supports"
            )
    return ""


def _said_of_speed(run: Run, number: int) -> str:
    plan, contact = run.plan, run.plan.contacts[number]
    speed = abs(plan.velocities[contact.first] - plan.velocities[contact.second])
    materials = plan.materials(contact)
    slowest = min(material.bar_speed for material in materials if material is not None)
    return (
        f"{_contact(run, number)}: the bodies meet at {speed:.4g} m/s, "
        f"{speed / slowest:.1%} of the speed of waves, {slowest:.4g} m/s: strains are as large, "
        "and linear elasticity is for small ones; take a lower velocity, and check E and rho"
    )


_TEXTS: dict[str, Callable[[Run, int], str]] = {
    "pressure": _said_of_pressure,
    "width": _said_of_width,
    "deflection": _said_of_deflection,
    "speed": _said_of_speed,
}


def _contact(run: Run, number: int) -> str:
    """What to call a contact."""
    contact = run.plan.contacts[number]
    if contact.name:
        return contact.name
    return f"{run.names[contact.first]} on {run.names[contact.second]}"


def _missed(run: Run) -> str:
    """What the bodies did that never pressed on each other: of those that came closest."""
    recorder, layout = run.recorder, run.plan.layout
    t = _times_between(run) if recorder.dense else recorder.times
    rows = recorder.rows(t, energies=False)
    gaps = 0.0 - layout.indentations(rows)
    number = int(gaps.min(axis=1).argmin())
    gap, first = gaps[number], run.plan.contacts[number].first
    at = int(gap.argmin())
    moved = float(np.abs(layout.body(rows, first).port_displacements).max())
    if gap.max() <= _ROUNDING * moved:  # side by side
        return ""

    def gap_at(sample: int) -> str:
        return with_unit(float(gap[sample]), "m", 3)

    text = f"{_contact(run, number)}: no contact in {with_unit(run.duration, 's')}"
    if gap.max() == gap[at]:
        return f"{text}: they stay {gap_at(0)} apart, and nothing moves them; give one a velocity"
    if at == 0:
        speeds = [run.plan.velocities[body] for body, _ in run.plan.contacts[number].ports]
        cure = (
            "they do not approach at first, and a load or gravity parts them: change its sign"
            if speeds[0] == speeds[1]
            else "the first body of a contact is behind the second along the direction of travel, "
            "and faster: exchange them, or change the signs of velocities"
        )
        return f"{text}: they move apart, from {gap_at(0)} to {gap_at(-1)}; {cure}"
    if at < len(t) - 1:
        least, when = _least(t[at - 1 : at + 2], gap[at - 1 : at + 2])
        if least <= 0.0 and not recorder.dense:
            return f"{text} at any step, but perhaps between two: take a smaller dt"
        return (
            f"{text}: they come no closer than {with_unit(max(least, 0.0), 'm', 3)}, at t = "
            f"{with_unit(when, 's')}; take a smaller gap, or a larger velocity"
        )
    speed = float(gap[-2] - gap[-1]) / float(t[-1] - t[-2])
    needed = run.duration + float(gap[-1]) / speed
    return (
        f"{text}: at its end they are still {gap_at(-1)} apart and approach at {speed:.3g} m/s; "
        f"take a duration beyond {with_unit(needed, 's')}, or a smaller gap"
    )


def _times_between(run: Run) -> FloatArray:
    """Times, s, that show the vibration of all bodies, as far as a memory of some MB allows."""
    fastest = max((float(of.omega.max(initial=0.0)) for of in run.plan.modal), default=0.0)
    wanted = math.ceil(_EACH_PERIOD * fastest * run.duration / (2.0 * math.pi))
    return np.linspace(0.0, run.duration, min(max(wanted, _SAMPLES), _MOST_SAMPLES))


def _least(t: FloatArray, gap: FloatArray) -> tuple[float, float]:
    """The least gap, m, and when, s, of the parabola through three, the middle one the least."""
    before, after = (float(gap[i] - gap[1]) for i in (0, 2))
    shift = 0.5 * (before - after) / (before + after) if before + after > 0.0 else 0.0
    least = float(gap[1]) - 0.25 * (before - after) * shift
    return least, float(t[1] + shift * (t[2] - t[1]))
