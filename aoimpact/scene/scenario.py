"""A scene as the solvers take it: bodies, the contacts between them, what acts on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from operator import attrgetter

import numpy as np

from ..base import ArrayPair, FloatArray, InputError, record
from ..contact import ContactPoint
from ..fem import Rayleigh
from ..laws import RoundContact, own_law, round_contact
from ..reduction import Body, BodyModel, FullModel, Pull, Velocity
from .contact import Contact, Load
from .preload import Equilibrium, equilibrium
from .rows import RecordLayout
from .stepped import PARTS, SteppedBody, SteppedFull


@record
class Oblique:
    """Motion of a scene in three directions.

    Attributes
    ----------
    axes : ndarray, shape (3, 3)
        Direction of travel and two tangents, as rows.
    velocities : sequence of ndarrays, shape (6,)
        Velocity of each body's centre of mass, m/s, and its spin, rad/s.
    gravity : ndarray, shape (3,)
        m/s².
    """

    axes: FloatArray
    velocities: Sequence[FloatArray]
    gravity: FloatArray


@record
class Scenario:
    """All that a run needs to know.

    Attributes
    ----------
    bodies : sequence of BodyModel
    velocities : sequence of float
        m/s.
    contacts : sequence of Contact
    loads : sequence of Load
    gravity : float
        m/s², along the direction of travel.
    duration : float
        s.
    energies : bool
        Whether to record them.
    preload : bool
        Whether to start at rest under gravity and loads.
    scene : str
        The mark of the scene's handles.
    names : sequence of str
        Names of the bodies in the scene, before their own; empty where they have no other.
    oblique : Oblique or None
        Motion in three directions; `velocities` and `gravity` are along the direction of travel.
    around : sequence of tuples of int
        For each body the ports whose direction of travel is reversed; none of a scene whose bodies
        are known by numbers alone.
    bounded : frozenset of int
        Numbers of the contacts that keep their whole laws; see `Contact.of_models`.
    """

    bodies: Sequence[BodyModel]
    velocities: Sequence[float]
    contacts: Sequence[Contact]
    loads: Sequence[Load]
    gravity: float
    duration: float
    energies: bool
    preload: bool = False
    scene: str = ""
    names: Sequence[str] = ()
    oblique: Oblique | None = None
    around: Sequence[tuple[int, ...]] = ()
    bounded: frozenset[int] = frozenset()

    def of_models(self, models: Sequence[BodyModel], *, energies: bool) -> Scenario:
        """Return the plan of models in place of the bodies, with laws to suit.

        Raises
        ------
        InputError
            If both bodies of a contact are of infinite mass.
        """
        bodies, contacts = tuple(models), self.contacts
        if self.around:
            turned = zip(models, self.around, strict=True)
            bodies = tuple([of.turned(ports) for of, ports in turned])
        if self.around or self.oblique:
            contacts = tuple(
                [of.of_models(bodies, bounded=i in self.bounded) for i, of in enumerate(contacts)]
            )
        for contact in contacts if models is not self.bodies else ():
            if all(math.isinf(bodies[body].static_mass) for body, _ in contact.ports):
                raise InputError(
                    "both bodies of a contact are of infinite mass: there is no motion between them"
                )
        return replace(self, bodies=bodies, contacts=contacts, energies=energies, around=())

    def start(self, body: int) -> Velocity:
        """Return the velocity of a body at t = 0, as `Body.rates` takes it."""
        return self.velocities[body] if self.oblique is None else self.oblique.velocities[body]

    @property
    def pull(self) -> Pull:
        """Gravity, along the direction of travel or in three directions, m/s²; 0 without any."""
        if self.oblique is None or not self.oblique.gravity.any():
            return self.gravity
        return self.oblique.gravity

    @property
    def weighed(self) -> bool:
        """True if gravity acts."""
        return bool(np.any(self.pull))

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies; empty for one without a name."""
        given = self.names or [""] * len(self.bodies)
        return tuple(name or body.name for name, body in zip(given, self.bodies, strict=True))

    @cached_property
    def meshed(self) -> bool:
        """True if a body is touched at known places."""
        return any(map(attrgetter("tips"), self.bodies))

    def touched(self, contact: Contact) -> list[tuple[int, int, ContactPoint]]:
        """Return the bodies that a contact touches at known places: number, port and place."""
        if not self.meshed:
            return []
        known = [(of, at, self.bodies[of].touched_at(at)) for of, at in contact.ports]
        return [(of, at, tip) for of, at, tip in known if tip is not None]

    def round_contact(self, contact: Contact) -> RoundContact | None:
        """Return Hertz's contact of a law like his; None where it is not known."""
        return round_contact(own_law(contact.law), contact.materials(self.bodies))

    @cached_property
    def modal(self) -> tuple[Body, ...]:
        """The bodies in their natural modes."""
        return tuple(map(attrgetter("modal"), self.bodies))

    @cached_property
    def layout(self) -> RecordLayout:
        """Places of the rows of a record."""
        sliding = tuple([contact.friction is not None for contact in self.contacts])
        return RecordLayout(tuple(map(attrgetter("ports"), self.bodies)), sliding)

    @cached_property
    def _loads_of(self) -> dict[int, list[Load]]:
        """The loads on each body that has some."""
        found: dict[int, list[Load]] = {}
        for load in self.loads:
            found.setdefault(load.body, []).append(load)
        return found

    def load_on(self, body: int) -> ArrayPair | None:
        """Return all loads on a body as one: times, shape (m,), and forces on ports, (m, p)."""
        ours = self._loads_of.get(body) if self.loads else None
        if ours is None:
            return None
        times = ours[0].times  # which rise: sorting two million takes a tenth of a second
        if len(ours) > 1:
            times = np.unique(np.concatenate([load.times for load in ours]))
        forces = np.zeros((len(times), self.bodies[body].ports))
        for load in ours:
            forces[:, load.port] += np.interp(times, load.times, load.forces)
        return times, forces

    def port_forces(self, body: int, times: FloatArray, forces: FloatArray) -> FloatArray:
        """Return all forces on a body's ports, N, along their directions, shape (p, times).

        Under gravity one more row of ones after them: the weight acts at any time.

        Parameters
        ----------
        times : ndarray, shape (times,)
            s.
        forces : ndarray, shape (pushes, times)
            The contact forces then, N; see `RecordLayout.pushes`.
        """
        found, row = np.zeros((self.bodies[body].ports, len(times))), 0
        for contact in self.contacts:
            force = forces[row : row + contact.size]
            if contact.first == body:
                found[contact.first_port : contact.first_port + contact.size] -= force
            if contact.second == body:
                found[contact.second_port : contact.second_port + contact.size] += force
            row += contact.size
        for load in self._loads_of.get(body, []):
            found[load.port] += np.interp(times, load.times, load.forces)
        return np.vstack([found, np.ones((1, len(times)))]) if self.weighed else found

    def reduced_mass(self, contact: Contact) -> float:
        """Return 1/(1/m1 + 1/m2) of the static masses of the two bodies of a contact, kg."""
        return 1.0 / math.fsum(1.0 / self.bodies[body].static_mass for body, _ in contact.ports)

    # ------------------------------------------------------------------- the start

    @cached_property
    def rest(self) -> Equilibrium | None:
        """The bodies at rest under gravity and the loads at t = 0; None unless they start so.

        Raises
        ------
        ConvergenceError
            If there is no static equilibrium.
        """
        if not self.preload:
            return None
        nothing = np.zeros((sum(contact.size for contact in self.contacts), 1))
        forces = [
            self.port_forces(i, np.zeros(1), nothing)[: body.ports, 0]
            for i, body in enumerate(self.bodies)
        ]
        return equilibrium(self.modal, self.contacts, gravity=self.gravity, forces=forces)

    def stepped(self, body: int) -> SteppedBody:
        """Return a body as a run with fixed steps takes it."""
        model, load, rest = self.bodies[body], self.load_on(body), self.rest
        start = self.start(body)
        if not isinstance(model, FullModel) or model.in_modes:
            modal = model.modal
            parts = dict(zip(PARTS, modal.for_core(self.pull, load), strict=True))
            x = np.zeros(len(modal.omega)) if rest is None else rest.modes[body]
            return SteppedBody(parts, x, modal.rates(start))
        u, of = np.zeros(model.dofs), model.body
        if rest is not None:
            u = model.modal.displaced(rest.modes[body])
            if model.modal.following is not None:  # massless contacts follow forces at once
                pressed = self.port_forces(body, np.zeros(1), rest.forces[:, None])
                u = u + model.modal.following @ pressed[: model.ports, 0]
        B = np.ascontiguousarray([tip.b for tip in model.tips])
        times, forces = (None, None) if load is None else load
        parts = {"shape": B, "push": B, "load_time": times, "load_force": forces}
        parts["gravity"] = model.weight(self.pull) if self.weighed else None
        parts["centre"] = np.ascontiguousarray(model.centre_of_mass[0])
        damping = of.damping if isinstance(of.damping, Rayleigh) else Rayleigh()
        return SteppedFull(parts, u, model.rates(start), of.K, of.M, damping)

    @cached_property
    def fastest(self) -> float:
        """The largest speed, m/s, at which bodies of the scene may meet first."""
        spread = max(self.velocities) - min(self.velocities)
        return max([spread, *(self.approach(contact)[1] for contact in self.contacts)])

    def approach(self, contact: Contact) -> tuple[float, float]:
        """Return when the bodies of a contact meet, s, and how fast, m/s, as rigid ones do.

        Their distance is closed by v t + a t²/2, so they meet at √(v² + 2 a gap).
        """
        first, second = contact.first, contact.second
        speed = self.velocities[first] - self.velocities[second]
        pull = self._acceleration(first) - self._acceleration(second)
        square = speed * speed + 2.0 * pull * contact.gap
        if square < 0.0 or (meets := math.sqrt(square)) + speed <= 0.0:
            return math.inf, 0.0
        return 2.0 * max(contact.gap, 0.0) / (meets + speed), meets

    def _acceleration(self, body: int) -> float:
        """Acceleration of a body by gravity and constant forces, m/s²; 0 if it is constrained."""
        model = self.bodies[body]
        if math.isinf(mass := model.most_mass):
            return 0.0
        forces = (load.forces[0] for load in self.loads if load.body == body)
        return self.gravity + math.fsum(forces) / mass
