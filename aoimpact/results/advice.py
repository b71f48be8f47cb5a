"""Every warning about a run: its models, its contacts, and the limits of linear elasticity.

`RULES` is the table of the limits of linear elasticity. For a contact each rule returns a `Limit`:
the largest force, speed or energy, relative to a scale, and the warning above this limit. From the
limits follow the rows (`Advice`) of a run, which are its warnings and lines of its summary, and the
force and speed up to which none of many impacts needs a warning. Unknown properties of a body are
not checked, so that models given by numbers cost nothing.

A model fitted to a contact of duration T has the receptance of its body at the frequency i s,
s ~ 10/T. Its accuracy for a contact of another duration is judged by the forces that it leaves
unbalanced at the frequency of that contact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base import ROUNDING, plain, warn, with_unit
from ..contact import SHIFT_TIMES_DURATION, ContactPoint
from ..fem import Material, Orthotropic, Rayleigh
from ..laws import (
    ContactLaw,
    ElasticPlastic,
    HertzianLaw,
    RoundContact,
    Thornton,
    own_law,
    round_contact,
    yield_force,
    yield_pressure,
)
from ..reduction import Body, BodyModel, is_valid_for
from .errors import ErrorParts, percent

if TYPE_CHECKING:
    from ..scene import Contact, Scenario
    from .run import Run


# ------------------------------------------------------------------- limits of linear elasticity

# _WIDTH: largest ratio of contact radius to radius of curvature. _STRAIN: strain divided by the
# same ratio (Tabor). The force on Sneddon's spherical punch is 1 % less than on Hertz's paraboloid
# at the ratio _WIDTH, and 3 % less at .5.
_WIDTH, _STRAIN = 0.3, 0.2

# Largest impact velocity relative to the wave speed in a bar, c. The strain of two bars that meet
# at v is of the order of v/c.
_SPEED = 0.01

# _THICKNESS: largest ratio of deflection to thickness of a body constrained on both sides. _SIZE:
# largest ratio of deflection to size of any body. At _THICKNESS the linear deflection has an error
# of 12 %: the load on a clamped plate is proportional to w + .471 w³/h² (Timoshenko, *Theory of
# Plates and Shells*, section 100).
_THICKNESS, _SIZE = 0.5, 0.1

# Largest |cos| of the angle between an axis and the contact's direction at which supports along the
# axis count as in-plane: such supports stop the edges from being drawn in.
_ACROSS = 0.5

# Ratios of projectile to plate mass. Below _WAVES the impact is over before waves return from the
# supports; above _QUASI_STATIC the plate responds quasi-statically (R. Olsson, Composites A 31,
# 879, 2000).
_WAVES, _QUASI_STATIC = 0.2, 2.0


@dataclass(frozen=True)
class Advice:
    """One way in which an impact may leave the range of the method.

    Attributes
    ----------
    name : str
        "yield", "deflection", "mass ratio" or "speed".
    value : float
        Ratio of the peak force to the force at first yield, of the deflection to the body's
        thickness or size, of the projectile's mass to the target's, or of the impact velocity to
        the wave speed.
    limit : float
        Largest value without a warning; infinite where there is no limit.
    meaning : str
        Text after the value in a summary; empty where a summary leaves the row out.
    warning : str
        Text of the warning if the value exceeds the limit.
    """

    name: str
    value: float
    limit: float
    meaning: str
    warning: str = field(default="", repr=False)

    @property
    def within(self) -> bool:
        """True if the value does not exceed the limit."""
        return self.value <= self.limit

    def __str__(self) -> str:
        return f"{self.value:.2g} {self.meaning}"


class Limit(NamedTuple):
    """Limit of a contact's force, speed or energy, above which a warning is due.

    Attributes
    ----------
    of : {"force", "speed", "energy"}
        Limited quantity: the contact's peak force, N, the speed at which its bodies meet, m/s, or
        the kinetic energy of all bodies, J, which bounds the deflection of each.
    scale : float
        Reference value of the quantity, in its unit.
    limit : float
        Largest ratio of the quantity to its scale.
    text : str
        Reason of the limit and cure, for the warning; empty if the limit causes none.
    meanings : (str, str)
        `Advice.meaning` within the limit and beyond it.
    rows : callable, optional
        Returns the `Advice` on a run, for a limit whose `Advice.value` is not the ratio of the
        quantity to `scale`.
    """

    of: str
    scale: float
    limit: float
    text: str = ""
    meanings: tuple[str, str] = ("", "")
    rows: Callable[[Run], Iterable[Advice]] | None = None

    @property
    def most(self) -> float:
        """Largest value of the quantity without a warning."""
        return self.scale * self.limit if self.text else math.inf


class _Joint(NamedTuple):
    """Properties of a contact that are known before the run."""

    plan: Scenario
    contact: Contact
    law: ContactLaw
    materials: list[Material]
    surface: RoundContact | None
    tips: list[tuple[int, int, ContactPoint]]


def limits(plan: Scenario, contact: Contact) -> dict[str, Limit]:
    """Return the limits of a contact by name; limits that need unknown properties are left out."""
    law, materials = own_law(contact.law), contact.materials(plan.bodies)
    known, surface = list(filter(None, materials)), round_contact(law, materials)
    joint = _Joint(plan, contact, law, known, surface, plan.touched(contact))
    found = {name: rule(joint) for name, rule in RULES.items()}
    return {name: limit for name, limit in found.items() if limit is not None}


def advice(run: Run, number: int, *, exceeded: bool = False) -> Iterator[Advice]:
    """Yield the `Advice` on one contact; if `exceeded`, only that on exceeded limits."""
    plan, events, contact = run.plan, run.events[number], run.plan.contacts[number]
    if not events.contacts:
        return
    both = zip(plan.bodies, run.velocities_before.tolist(), strict=True)
    moving = [(math.inf if of.known_mass is None else of.known_mass, v) for of, v in both if v]
    before = run.velocities_before
    if len(plan.contacts) > 1:  # other contacts may have changed velocities before
        before = run.mean_velocities(events.contacts[0][0])
    reached = {
        "force": events.peak_force,
        "speed": abs(float(before[contact.first] - before[contact.second])),
        "energy": sum(0.5 * m * v * v for m, v in moving),
    }
    for name, limit in limits(plan, contact).items():
        value, most = reached[limit.of], limit.most
        if exceeded and value <= most:
            continue
        if limit.rows is not None:
            yield from limit.rows(run)
            continue
        reached_most = (with_unit(of, _UNITS[limit.of], 4) for of in (value, most))
        told = f"a {limit.of} of {' exceeds '.join(reached_most)}: " if most else ""
        text = told + limit.text
        meaning = limit.meanings[value > limit.scale * limit.limit]
        yield Advice(name, value / limit.scale, limit.limit, meaning, text)


def contact_name(run: Run, contact: Contact) -> str:
    """Return the name of a contact, by default made of the names of its bodies."""
    return contact.name or f"{run.names[contact.first]} on {run.names[contact.second]}"


def _yield(joint: _Joint) -> Limit | None:
    """Limit of the force: above it, the weaker body yields below its surface."""
    surface, law, text = joint.surface, joint.law, ""
    strong = [of for of in joint.materials if of.yield_strength]
    if isinstance(law, ElasticPlastic | Thornton):
        first = law.yield_force
    elif surface is None or law.has_memory or not strong:
        return None
    else:
        softest = min(strong, key=yield_pressure)
        pressure, strength = yield_pressure(softest), softest.yield_strength or 0.0
        first = yield_force(surface.modulus, surface.radius, pressure)
        text = (
            f"the largest pressure is {pressure / strength:.3g} times yield_strength="
            f"{with_unit(strength, 'Pa', 3)}, so that a body yields. Use ElasticPlastic("
            f"k={surface.k:.6g}, yield_force={first:.4g}, hardness={2.8 * strength:.4g}, "
            f"relative_radius={surface.radius:.6g})."
        )
    meaning, had = "of the force of first yield:", ", as the law has it" if law.has_memory else ""
    meanings = f"{meaning} elastic", f"{meaning} beyond{had}"
    return Limit("force", first, 1.0, text, meanings) if math.isfinite(first) else None


def _width(joint: _Joint) -> Limit | None:
    """Limit of the force, above which the contact is too wide for the radius of curvature."""
    if (surface := joint.surface) is None:
        return None
    text = (
        f"the contact has a radius of {_WIDTH} times the radius of curvature "
        f"R={with_unit(surface.radius, 'm', 3)}, with strains of about {_STRAIN * _WIDTH:.0%}, and "
        "Hertz's law needs small strains; take a lower velocity or Tabulated(...), and check R"
    )
    return Limit("force", surface.k * (_WIDTH * _WIDTH * surface.radius) ** 1.5, 1.0, text)


def _speed(joint: _Joint) -> Limit | None:
    """Limit of the speed at which the bodies meet, relative to the wave speed."""
    if not joint.materials:
        return None
    slowest = min(of.bar_speed for of in joint.materials)
    text = (
        f"it is {_SPEED:.1%} of the speed of waves, {slowest:.4g} m/s, and strains are as large; "
        "take a lower velocity, and check E and rho"
    )
    meaning = f"of that of waves: slow up to {_SPEED:g}"
    return Limit("speed", slowest, _SPEED, text, (meaning, meaning))


def _deflection(joint: _Joint) -> Limit | None:
    """Limit of the energy, below which the deflection of each constrained body is surely small.

    A deflection u takes at least the energy k0 u²/2. Where no such bound is known the limit is 0,
    so that the deflection itself is always checked.
    """
    plan, energies = joint.plan, []
    alone = not plan.weighed and not plan.loads
    held = [
        (body, port, tip, tip.body.mesh.size)
        for body, port, tip in joint.tips
        if plan.bodies[body].constrained and tip.body.mesh is not None
    ]
    for body, _, tip, size in held:
        model, most, energy = plan.bodies[body], min(_THICKNESS * tip.depth, _SIZE * size), 0.0
        if alone and isinstance(model, Body) and model.ports == 1:
            energy = 0.5 * model.star.k0 * most**2
        energies.append(energy)

    def rows(run: Run) -> Iterator[Advice]:
        for body, port, tip, size in held:
            name = run.names[body]
            moved = float(np.abs(run.bodies[body].port_displacements[port]).max(initial=0.0))
            of, share, what, cure = size, _SIZE, "size", "long: check units and supports"
            if _THICKNESS * tip.depth < share * size and _stretches(tip):
                of, share, what = tip.depth, _THICKNESS, "thickness"
                cure = "thick: constrained on both sides it stretches, and is stiffer than linear"
            meaning = f"of the {what} of {name}: small up to {share:g}"
            warning = (
                f"{name} deflects by {with_unit(moved, 'm', 3)}, and is {with_unit(of, 'm', 3)} "
                f"{cure}; take a lower velocity, or do not trust deflection and stress"
            )
            yield Advice("deflection", moved / of, share, meaning, warning)

    return Limit("energy", 1.0, min(energies), "deflection", rows=rows) if energies else None


def _stretches(tip: ContactPoint) -> bool:
    """True if supports on opposite sides of the point make the body stretch as it deflects."""
    body = tip.body.given
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
    """Limit of the force, above which the contact is wider than the wall of a body is thick."""
    walls = [tip.thin.narrowest for _, _, tip in joint.tips if tip.thin is not None]
    if (surface := joint.surface) is None or not walls:
        return None
    half = 0.5 * min(walls)
    text = (
        "the contact has a radius of more than half the thickness of the shell or beam, "
        f"{with_unit(2.0 * half, 'm', 3)}; take solids, or Tabulated(...)"
    )
    return Limit("force", surface.k * (half * half / surface.radius) ** 1.5, 1.0, text)


def _mass_ratio(joint: _Joint) -> Limit | None:
    """Limit without a warning: its row states the mass ratio, which tells how a plate responds."""
    first, second = (joint.plan.bodies[body] for body, _ in joint.contact.ports)
    if not first.known_mass or not second.mass or not second.constrained or second.wall:
        return None
    ratio, meaning = first.known_mass / second.mass, "supports and waves both matter"
    if ratio < _WAVES:
        meaning = "over before waves return, if it is a plate"
    elif ratio > _QUASI_STATIC:
        meaning = "quasi-static, by the stiffness of its supports"
    row = Advice("mass ratio", ratio, math.inf, f"of the target: {meaning}")
    return Limit("force", 1.0, 0.0, rows=lambda _: [row])


def _shell(joint: _Joint) -> Limit | None:
    """Limit of the force: 0, so always exceeded, on flat solid elements of a thin sheet."""
    shells = [shell for _, _, tip in joint.tips if (shell := _as_a_shell(tip))]
    return Limit("force", 1.0, 0.0, "; ".join(shells)) if shells else None


_UNITS = {"force": "N", "speed": "m/s", "energy": "J"}

# The order of rules is that of the rows of a summary.
RULES: dict[str, Callable[[_Joint], Limit | None]] = {
    "yield": _yield,
    "width": _width,
    "deflection": _deflection,
    "mass ratio": _mass_ratio,
    "speed": _speed,
    "thickness": _thickness,
    "shell": _shell,
}


# ------------------------------------------------------------------- models fitted to a contact

# Largest relative unbalanced force at which contacts after the first are accurate. On five bodies
# that ring between two to four contacts, the relative error of the impulse was .02 to .45 for
# unbalanced forces above 6e-5, and less than .001 for those below 2e-5.
_BALANCED_AGAIN = 3e-5

# Largest relative unbalanced force at which the displacement after a contact is accurate. On twelve
# bodies the relative error of the displacement was .15 to 1.3 for larger unbalanced forces, except
# for a light body that moves as a whole, and less than .1 for unbalanced forces below a tenth of
# this limit.
_BALANCED_AFTER = 1e-3


def warn_of_misfit(run: Run, names: Sequence[str]) -> None:
    """Warn where a model is inaccurate for the durations of its body's contacts.

    Two durations are checked: that of the contact with the peak force, and the time from the body's
    first contact to its last, since its motion in between determines the later forces.

    Parameters
    ----------
    run : Run
    names : sequence of str
        Names of the bodies, for messages.
    """
    plan = run.plan
    said = set()
    for contact, events in zip(plan.contacts, run.events, strict=True):
        for body, port in contact.ports:
            model = plan.bodies[body]
            fitted = model.contact_time
            if fitted is None or body in said or not events.contacts:
                continue
            start, end = events.peak_contact or (0.0, 0.0)
            # Do not warn that a contact is too short if the record cuts it off.
            contact_time = max(end - start, fitted) if end >= run.duration else end - start
            starts, ends = zip(*_touches(run, body), strict=True)
            touched_for = max(ends) - min(starts) if max(starts) > min(ends) else 0.0
            told = f"{names[body]} was fitted to a contact of {with_unit(fitted, 's')}, but "
            if not is_valid_for(model, contact_time, port):
                told += (
                    f"the contact with the peak force lasts {with_unit(contact_time, 's')}: its "
                    f"force is not exact; make the model with contact_time={contact_time:.2g}"
                )
            elif not is_valid_for(model, touched_for, port, _BALANCED_AGAIN):
                told += (
                    f"is touched again and again for {with_unit(touched_for, 's')}: later forces, "
                    "impulse and rebound are not exact; make the model with "
                    f"duration={touched_for:.2g} and some more oscillators"
                )
            else:
                continue
            said.add(body)
            warn(f"{told}, or give the finite-element body itself and rtol")


def follows(run: Run, body: int) -> bool:
    """Return whether a body's displacement is known to be accurate after the contact.

    The criterion is the force that the model leaves unbalanced at the time scale of the record.
    This criterion costs a few products with K and M, whereas an error estimate costs another run.
    """
    model, touches = run.plan.bodies[body], _touches(run, body)
    if model.contact_time is None or not touches or not len(run.t):
        return not touches
    since = float(run.t[-1]) - min(touches)[0]
    ports = {contact.port_of(body) for contact in run.plan.contacts if contact.touches(body)}
    return since <= model.contact_time or all(
        is_valid_for(model, since, port, _BALANCED_AFTER) for port in ports
    )


def _touches(run: Run, body: int) -> list[tuple[float, float]]:
    """Return start and end of every contact of a body, s."""
    return [
        touch
        for contact, of in zip(run.plan.contacts, run.events, strict=True)
        if contact.touches(body)
        for touch in of.contacts
    ]


# ------------------------------------------------------------------- bodies and contact points

# Largest ratio of the damping coefficient β to the contact's duration at which dashpots at a
# massless contact are negligible. For a body of one oscillator, the relative errors at this ratio
# are 2e-4 (peak force) and 9e-4 (rebound velocity).
_LAGS = 1e-4
# Ratio of the mass that a warning proposes for a massless contact to the body's mass. The effect of
# this mass is as small as the effect of dashpots at the ratio _LAGS.
_LIGHT = 1e-6

# Smallest cosine of the angle between a contact's direction and normal at which no warning is
# given. The angle of 10° allows for the facets of coarse meshes.
_OBLIQUE = math.cos(math.radians(10.0))

# Largest distance between two contact points that count as one, relative to the first body's size.
_SHARED = 1e-3


def warn_of_bodies(run: Run, names: Sequence[str]) -> None:
    """Warn of bodies and contact points outside the range of the method.

    The warnings are of damping that would retard a massless contact, of unknown rebound velocities,
    of directions oblique to the surface, and of two bodies on the same side of their contact.

    Parameters
    ----------
    run : Run
    names : sequence of str
        Names of the bodies, for messages.
    """
    plan = run.plan
    for number, (body, name) in enumerate(zip(plan.bodies, names, strict=True)):
        # Dashpots β k would let a massless contact follow its force with the time constant β, but
        # the compliance of such a contact is taken without them (`Rayleigh`).
        lag = body.damping.beta if body.massless and isinstance(body.damping, Rayleigh) else 0.0
        longest = max((b - a for a, b in _touches(run, number)), default=math.inf) if lag else 0.0
        if lag > _LAGS * longest:
            warn(
                f"{name}: beta = {with_unit(lag, 's')} does not act on a contact without mass, "
                f"which lasts {with_unit(longest, 's')}; give m0={_LIGHT * body.static_mass:.1g}"
            )
        if plan.gravity and body.weightless:
            warn(
                f"gravity has no effect on {body.label}: the supports of an AO model without nodes "
                "are not known; make it by antioscillators(...) of a body with nodes"
            )
        if not body.centre_known and (plan.velocities[number] != 0.0 or not body.constrained):
            warn(
                f"{name}: the centre of mass of a body given by K and M alone is not known, so "
                "that rebound_velocity and restitution are NaN: give FEModel(K=, M=, nodes=)"
            )
    touched = [(plan.touched(contact), own_law(contact.law)) for contact in plan.contacts]
    laws = {(number, tip): law for tips, law in touched for number, _, tip in tips}
    for (number, tip), law in laws.items():
        along, normal = tip.direction, tip.normal
        cosine = 1.0 if along is None or normal is None else abs(float(normal @ along))
        if along is not None and cosine < _OBLIQUE:  # no friction: only normal velocity counts
            angle = math.degrees(math.acos(cosine))
            warn(
                f"{names[number]} is touched along {plain(along)}, {angle:.0f}° off the "
                f"normal. If nothing guides it, leave direction out, and give {cosine:.3g} of the "
                "velocity"
            )
        if tip.body.mesh is None and isinstance(law, HertzianLaw):
            warn(
                f"{names[number]}: {type(law).__name__}'s law and K of solids both have "
                "the indentation of a half-space; give the mesh, body.with_mesh(...)"
            )
    for tips, _ in touched:
        if len(tips) == 2 and _face_alike(tips[0][2], tips[1][2]):
            place: Any = tips[0][2].point
            both = " and ".join(names[number] for number, *_ in tips)
            warn(
                f"{both} touch at {plain(place)} m with outward normals on the same "
                "side: choose the point that faces the other body"
            )


def _face_alike(first: ContactPoint, second: ContactPoint) -> bool:
    """True if two meshes in common coordinates lie on the same side of their common contact."""
    nodes, place, along = first.body.given.nodes, first.point, first.direction
    if first.body is second.body or nodes is None or place is None or second.point is None:
        return False
    if along is None or second.direction is None or along @ second.direction >= 0.0:
        return False
    near = _SHARED * float(np.ptp(nodes, axis=0).max())
    return bool(np.linalg.norm(place - second.point) <= near)


def warn_of_exchange(projectile: BodyModel, target: BodyModel) -> None:
    """Warn if a finite-element projectile has supports and the target is free.

    A projectile on springs only is accepted: it may be a tup on its guide.
    """
    tip = projectile.touched_at()
    if tip is None or not projectile.constrained or target.constrained:
        return
    free, nodes = tip.body.given.free, tip.body.given.nodes
    size = 0 if nodes is None else nodes.size
    if free is not None and np.count_nonzero(free < size) < size:
        warn(
            "projectile moves though supports hold it, and nothing holds the target: if it is what "
            "is struck, exchange both bodies; if it flies, leave its supports (fixed=) out"
        )


# ------------------------------------------------------------------- errors

# Largest ratio, without a warning, of the total energy's relative range over the record to the
# error of time integration.
_DRIFT = 100.0

# Largest relative error due to a mesh or a contact law at which no warning is given.
MESH_LIMIT = 0.1


def warn_of_mesh(run: Run, quantity: str, error: ErrorParts) -> None:
    """Warn of a large error of a quantity due to meshes or contact laws, and name the cure."""
    plan = run.plan
    tips = {(body, port): tip for of in plan.contacts for body, port, tip in plan.touched(of)}
    meshed = [
        (run.names[body], tip, mesh.quadratic)
        for (body, _), tip in sorted(tips.items())
        if (mesh := tip.body.mesh) is not None
    ]
    if meshed and error.mesh is not None and error.mesh > MESH_LIMIT:
        linear = [name for name, _, quadratic in meshed if not quadratic]
        names = " and ".join(dict.fromkeys(linear or [name for name, *_ in meshed]))
        cure = "take smaller elements"
        if any(_as_a_shell(tip) for _, tip, _ in meshed):
            cure = "take ao.Shell or ao.Laminate"
        elif linear and not any(tip.thin for _, tip, _ in meshed):
            cure = "elements of first order: add midside nodes with FEModel.from_mesh(..., order=2)"
        worst = " at its worst time" if quantity == "force" else ""
        warn(
            f"{names}: the mesh makes an error {_size(error.mesh)} in the {quantity}{worst}; {cure}"
        )
    if error.contact is not None and error.contact > MESH_LIMIT:
        warn(
            f"the contact makes an error {_size(error.contact)} in the {quantity}: move it "
            "from the edge, give a smaller radius, the law= or more modes"
        )


def _size(error: float) -> str:
    return f"of {percent(error)} %" if math.isfinite(error) else "without bound"


def _as_a_shell(tip: ContactPoint) -> str:
    """Return text that proposes a shell in place of flat solids under a contact, or ""."""
    if not tip.flat:
        return ""
    material = tip.made_of
    shell = f"ao.Shell(thickness={tip.depth:.4g}, material={material!r})"
    if isinstance(material, Orthotropic):
        shell = f"ao.Laminate of its plies, {tip.depth:.4g} m thick in all"
    return f"solid elements are flat: mesh the middle surface of the sheet, and take {shell}"


def warn_of_ledger(energy: float, error: float | None) -> None:
    """Warn if the total energy varies by far more than the error of time integration allows.

    Over 600 random scenes the relative range of the energy was at most 0.3 times this error, with
    massless contacts at most 10 times.
    """
    if error is not None and energy > _DRIFT * max(error, ROUNDING):
        warn(
            f"total energy varies by {energy:.2g} of the largest stored, but the steps' error is "
            f"{error:.2g}: distrust the run, unless a law's energy is not the work of its force"
        )


# ------------------------------------------------------------------- limits and missed contacts

# Largest ratio of the length of a refined element to the length (D/(m s²))^(1/4) of bending waves,
# s = 5 / (rise time of the force), at which the refined mesh gives an error estimate. At this limit
# the elements of shells and beams before refinement, which are twice as long, have 0.9 times half
# the length of a wave whose quarter period is the rise time.
_BENDING = 2.5


def warning_limits(plan: Scenario) -> tuple[float, float]:
    """Return the largest force, N, and velocity, m/s, at which an impact needs no warning."""
    mass, most = plan.bodies[0].known_mass, {"force": math.inf, "speed": math.inf}
    for limit in limits(plan, plan.contacts[0]).values():
        of, value = limit.of, limit.most
        if of == "energy":
            of, value = "speed", math.sqrt(2.0 * value / mass) if mass else 0.0
        most[of] = min(most[of], value)
    return most["force"], most["speed"]


def warn_of_run(run: Run) -> None:
    """Warn where bodies never meet, or a run leaves the range of the method.

    Each kind of warning is issued once, for the contact that exceeds its limit most.

    Parameters
    ----------
    run : Run
    """
    contacts, worst = run.plan.contacts, dict[str, tuple[float, str]]()
    if contacts and run.touching is None and (text := _missed(run)):
        warn(text)
    for number, contact in enumerate(contacts):
        for row in advice(run, number, exceeded=True):
            excess = row.value / row.limit if row.limit else math.inf
            if not row.within and excess >= worst.get(row.name, (0.0,))[0]:
                worst[row.name] = excess, f"{contact_name(run, contact)}: {row.warning}"
    for _, text in worst.values():
        warn(text)
    for body, tip, edge, rise, most in outgrown(run):
        if tip.thin:
            warn(
                f"{run.names[body]}: elements at the contact are {with_unit(edge, 'm', 3)} long, "
                f"and bending waves of a force that rises in {with_unit(rise, 's', 3)} need at "
                f"most {with_unit(most, 'm', 2)}; refine the mesh there"
            )


def outgrown(run: Run) -> Iterator[tuple[int, ContactPoint, float, float, float]]:
    """Yield the contact points whose elements are too long for an error estimate in bending waves.

    Each row is the body's number, its contact point, the length of the elements there, m, the rise
    time of the force, s, and the largest length that resolves the waves, m.
    """
    for contact, events in zip(run.plan.contacts, run.events, strict=True):
        for body, _, tip in run.plan.touched(contact) if events.contacts else ():
            rise = events.peak_time - (events.peak_contact or (events.peak_time,))[0]
            mesh = (tip.body.coarse or tip.body).mesh
            if mesh is None or rise <= 0.0 or events.peak_time >= run.duration:
                continue  # if the record ends at the peak, the rise time is not known
            cut = 2.0 if all(block.element.thin for block in mesh.blocks) else 1.0
            edge, wave = tip.edge_and_wave(0.5 * SHIFT_TIMES_DURATION / rise)
            edge, most = edge * (1.0 if tip.body.mesh is mesh else cut), cut * _BENDING * wave
            if edge > most:
                yield body, tip, edge, rise, most


def _missed(run: Run) -> str:
    """Return the warning that no bodies met, for the contact that came closest; else ""."""
    recorder, layout = run.recorder, run.plan.layout
    t = run.even_times(0.0, run.duration) if recorder.dense else recorder.times
    rows = recorder.rows(t, energies=False)
    gaps = 0.0 - layout.indentations(rows)
    number = int(gaps.min(axis=1).argmin())
    gap, contact = gaps[number], run.plan.contacts[number]
    at = int(gap.argmin())
    moved = float(np.abs(layout.body(rows, contact.first).port_displacements).max())
    if gap.max() <= ROUNDING * moved:  # the bodies stay in touch, without a force
        return ""
    least, when, cure = float(gap[at]), float(t[at]), "take a smaller gap, or a larger velocity"
    if at == 0:
        cure = "they move apart, or stay: change signs of velocities, spins or loads"
    elif at == len(t) - 1:
        speed = float(gap[-2] - gap[-1]) / (when - float(t[-2]))
        needed = with_unit(run.duration + least / speed, "s")
        cure = f"take a duration beyond {needed}, or a smaller gap"
    elif not recorder.dense:
        cure += ", or a smaller dt"
    return (
        f"{contact_name(run, contact)}: no contact in {with_unit(run.duration, 's')}: they come no "
        f"closer than {with_unit(least, 'm', 3)}, at t = {with_unit(when, 's')}; {cure}"
    )
