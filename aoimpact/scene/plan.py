"""A scene as the solvers take it: bodies, the contacts between them, what acts on them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base import FloatArray
from ..fem import Material
from ..laws import RoundContact, own_law, round_contact
from ..reduction import Body, BodyModel, Pull, Velocity
from .bodies import stepped
from .contact import Contact, Load
from .preload import Equilibrium, equilibrium
from .rows import RecordLayout
from .stepped import SteppedBody


def reduced_mass(first: BodyModel, second: BodyModel) -> float:
    """Return 1/(1/m1 + 1/m2) of two bodies' static masses, kg: they meet as it would a wall."""
    return 1.0 / (1.0 / first.static_mass + 1.0 / second.static_mass)


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True, eq=False)
class Plan:
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

    @cached_property
    def slides(self) -> bool:
        """True if a contact has friction."""
        return any(contact.friction is not None for contact in self.contacts)

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies; empty for one without a name."""
        given = self.names or [""] * len(self.bodies)
        return tuple(name or body.name for name, body in zip(given, self.bodies, strict=True))

    def materials(self, contact: Contact) -> list[Material | None]:
        """Return the materials of both bodies where they touch; None of one given by numbers."""
        ends = [(self.bodies[body], port) for body, port in contact.ports]
        known = [model.touched_at(port) or model.surface_at(port) for model, port in ends]
        return [None if of is None else of.material for of in known]

    def round_contact(self, contact: Contact) -> RoundContact | None:
        """Return Hertz's contact of a law like his; None where it is not known."""
        return round_contact(own_law(contact.law), self.materials(contact))

    @cached_property
    def modal(self) -> tuple[Body, ...]:
        """The bodies in their natural modes."""
        return tuple([body.modal for body in self.bodies])

    @cached_property
    def first_modes(self) -> tuple[int, ...]:
        """Number of the first mode of each body among those of all, and the number of all."""
        return tuple(itertools.accumulate((len(body.omega) for body in self.modal), initial=0))

    @cached_property
    def layout(self) -> RecordLayout:
        """Places of the rows of a record."""
        sliding = tuple(contact.friction is not None for contact in self.contacts)
        return RecordLayout(len(self.contacts), tuple(body.ports for body in self.bodies), sliding)

    @cached_property
    def _loads_of(self) -> dict[int, list[Load]]:
        """The loads on each body that has some."""
        found: dict[int, list[Load]] = {}
        for load in self.loads:
            found.setdefault(load.body, []).append(load)
        return found

    def load_on(self, body: int) -> tuple[FloatArray, FloatArray] | None:
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
        """Return the reduced mass of the two bodies of a contact, kg."""
        return reduced_mass(self.bodies[contact.first], self.bodies[contact.second])

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
        forces = [self._loaded(body) for body in range(len(self.bodies))]
        return equilibrium(self.modal, self.contacts, gravity=self.gravity, forces=forces)

    def stepped(self, body: int) -> SteppedBody:
        """Return a body as a run with fixed steps takes it."""
        rest = None if self.rest is None else self.rest.modes[body]
        model, load = self.bodies[body], self.load_on(body)
        return stepped(model, self.start(body), gravity=self.pull, load=load, rest=rest)

    @cached_property
    def forces_at_rest(self) -> FloatArray | None:
        """The contact forces of `rest`, N."""
        return None if self.rest is None else self.rest.forces

    def _loaded(self, body: int) -> FloatArray:
        """The loads on a body's ports at t = 0, N."""
        load = self.load_on(body)
        if load is None:
            return np.zeros(self.bodies[body].ports)
        return np.array([np.interp(0.0, load[0], column) for column in load[1].T])

    @property
    def fastest(self) -> float:
        """The largest speed at which the bodies of a contact may meet, m/s."""
        speeds = [
            abs(self.velocities[of.first] - self.velocities[of.second]) for of in self.contacts
        ]
        fall = abs(self.gravity) * self.duration
        drop = [math.sqrt(2.0 * abs(self.gravity) * abs(of.gap)) for of in self.contacts]
        return max([*speeds, *(min(fall, d) for d in drop if d), 0.0])
