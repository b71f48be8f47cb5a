"""The complete plan of a run: bodies, the contacts between them, loads, initial motion."""

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
        Initial velocity of each body's centre of mass, m/s, and its spin, rad/s.
    gravity : ndarray, shape (3,)
        Acceleration of gravity, m/s².
    """

    axes: FloatArray
    velocities: Sequence[FloatArray]
    gravity: FloatArray


@record
class Scenario:
    """The complete plan of a run.

    Attributes
    ----------
    bodies : sequence of BodyModel
    velocities : sequence of float
        Initial velocity of each body along the direction of travel, m/s.
    contacts : sequence of Contact
    loads : sequence of Load
    gravity : float
        Acceleration of gravity along the direction of travel, m/s².
    duration : float
        Duration of the record, s.
    energies : bool
        True to record energies.
    preload : bool
        True to start from static equilibrium under gravity and loads.
    scene : str
        Unique identifier of the scene, by which its handles are recognised; empty for an impact.
    names : sequence of str
        Names given to the bodies in the scene; an empty one means the body's own name.
    oblique : Oblique or None
        Motion in three directions; `velocities` and `gravity` are its components along the
        direction of travel.
    around : sequence of tuples of int
        Ports of each body whose direction of travel must be reversed; empty if all bodies are given
        by numbers.
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
        """Return the plan with models of the bodies, and the meshes' compliance taken out of laws.

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
        """Return the velocity of a body at t = 0, for `Body.rates`."""
        return self.velocities[body] if self.oblique is None else self.oblique.velocities[body]

    @property
    def pull(self) -> Pull:
        """Acceleration of gravity, m/s²: along the direction of travel, or a vector if given so."""
        if self.oblique is None or not self.oblique.gravity.any():
            return self.gravity
        return self.oblique.gravity

    @property
    def weighed(self) -> bool:
        """True if gravity acts."""
        return bool(np.any(self.pull))

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies; empty for a body without a name."""
        given = self.names or [""] * len(self.bodies)
        return tuple(name or body.name for name, body in zip(given, self.bodies, strict=True))

    @cached_property
    def meshed(self) -> bool:
        """True if a body has contact points of a finite-element model."""
        return any(map(attrgetter("tips"), self.bodies))

    def touched(self, contact: Contact) -> list[tuple[int, int, ContactPoint]]:
        """Return number, port and contact point of each finite-element body of a contact."""
        if not self.meshed:
            return []
        known = [(of, at, self.bodies[of].touched_at(at)) for of, at in contact.ports]
        return [(of, at, tip) for of, at, tip in known if tip is not None]

    def round_contact(self, contact: Contact) -> RoundContact | None:
        """Return the Hertzian contact of a law; None for other laws or unknown surfaces."""
        return round_contact(own_law(contact.law), contact.materials(self.bodies))

    @cached_property
    def modal(self) -> tuple[Body, ...]:
        """The bodies in their natural modes."""
        return tuple(map(attrgetter("modal"), self.bodies))

    @cached_property
    def layout(self) -> RecordLayout:
        """Index of each row of a record."""
        sliding = tuple([contact.friction is not None for contact in self.contacts])
        return RecordLayout(tuple(map(attrgetter("ports"), self.bodies)), sliding)

    @cached_property
    def _loads_of(self) -> dict[int, list[Load]]:
        """The loads on each loaded body, by the body's number."""
        found: dict[int, list[Load]] = {}
        for load in self.loads:
            found.setdefault(load.body, []).append(load)
        return found

    def load_on(self, body: int) -> ArrayPair | None:
        """Return the sum of loads on a body: times, s, (m,), and forces on ports, N, (m, p)."""
        ours = self._loads_of.get(body) if self.loads else None
        if ours is None:
            return None
        times = ours[0].times  # ascending already; sorting two million takes 0.1 s
        if len(ours) > 1:
            times = np.unique(np.concatenate([load.times for load in ours]))
        forces = np.zeros((len(times), self.bodies[body].ports))
        for load in ours:
            forces[:, load.port] += np.interp(times, load.times, load.forces)
        return times, forces

    def port_forces(self, body: int, times: FloatArray, forces: FloatArray) -> FloatArray:
        """Return all forces on a body's ports, N, along their directions, shape (p, times).

        Under gravity there is one more row, of ones: the factor on the constant weight.

        Parameters
        ----------
        times : ndarray, shape (times,)
            Times, s.
        forces : ndarray, shape (pushes, times)
            Contact forces at these times, N; see `RecordLayout.pushes`.
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
        """Static equilibrium under gravity and the loads at t = 0; None without `preload`.

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
        """Return the body that Newmark's rule integrates, in modes or in all dofs."""
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
        """Largest speed at which bodies of the scene may first meet, m/s."""
        met = [self.velocities[body] for of in self.contacts for body, _ in of.ports]
        spread = max(met, default=0.0) - min(met, default=0.0)
        return max([spread, *(self.approach(contact)[1] for contact in self.contacts)])

    def approach(self, contact: Contact) -> tuple[float, float]:
        """Return the time at which the bodies of a contact meet, s, and their speed then, m/s.

        The bodies are taken as rigid: their distance changes by v t + a t²/2, and they meet at the
        speed √(v² + 2 a gap). Bodies that do not meet give (inf, 0).
        """
        first, second = contact.first, contact.second
        speed = self.velocities[first] - self.velocities[second]
        pull = self._acceleration(first) - self._acceleration(second)
        square = speed * speed + 2.0 * pull * contact.gap
        if square < 0.0 or (meets := math.sqrt(square)) + speed <= 0.0:
            return math.inf, 0.0
        return 2.0 * max(contact.gap, 0.0) / (meets + speed), meets

    def _acceleration(self, body: int) -> float:
        """Return the acceleration due to gravity and loads at t = 0, m/s²; 0 if constrained."""
        model = self.bodies[body]
        if math.isinf(mass := model.most_mass):
            return 0.0
        forces = (load.forces[0] for load in self.loads if load.body == body)
        return self.gravity + math.fsum(forces) / mass
