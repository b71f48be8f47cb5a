"""A scene as the solvers take it: bodies, the contacts between them, what acts on them."""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..base import FloatArray
from ..laws import ContactLaw, PatchLaw, Tabulated
from ..reduction import ModalBody
from .bodies import Player, State
from .preload import Pressed, equilibrium
from .rows import BODY_ROWS, CONTACT_ROWS, PORT_ROWS

__all__ = ["Drift", "Joint", "Load", "Plan", "normal_gap"]


def normal_gap(gap: float) -> float:
    """Return a gap, m; 0 for a subnormal one, which no time of flight can tell from 0."""
    return gap if abs(gap) >= sys.float_info.min else 0.0


class Joint(NamedTuple):
    """A contact of two bodies.

    Attributes
    ----------
    first, first_port, second, second_port : int
        Numbers of the bodies in the plan, and of the places where they are touched; the indentation
        is the first's coordinate minus the second's minus the gap.
    law : ContactLaw
        What acts between the models: without what their patches give way themselves.
    gap : float
        How far they are apart at the start, m.
    ends : tuple of (model, model)
        The models or points that may have patches.
    """

    first: int
    first_port: int
    second: int
    second_port: int
    law: ContactLaw
    gap: float
    ends: tuple[Any, Any] = (None, None)

    @property
    def ends_at(self) -> tuple[int, int, int, int]:
        """Body and port, body and port."""
        return self.first, self.first_port, self.second, self.second_port

    @property
    def patched(self) -> bool:
        """Whether something has been taken out of the law, or it ends."""
        return isinstance(self.law, (PatchLaw, Tabulated))

    def port_of(self, body: int) -> int:
        """Where one of the two is touched."""
        return self.first_port if body == self.first else self.second_port

    def touches(self, body: int) -> bool:
        """Whether a body is one of the two."""
        return body in (self.first, self.second)


@dataclass(frozen=True, eq=False)
class Load:
    """A force on a port, straight between times and constant outside them.

    Attributes
    ----------
    body, port : int
        As in :class:`Joint`.
    times, forces : ndarrays, shape (m,)
        s, ascending; N, along the direction of travel.
    """

    body: int
    port: int
    times: FloatArray
    forces: FloatArray


@dataclass(frozen=True)
class Drift:
    """What a reduced body leaves out: mass that moves on, untouched, with the whole of the body.

    Attributes
    ----------
    share : float
        Of the centre of mass's motion.
    mass : float
        kg.
    velocity, acceleration : float
        m/s, m/s².
    """

    share: float
    mass: float
    velocity: float
    acceleration: float

    def add(self, rows: FloatArray, t: FloatArray) -> None:
        """Add it to the rows of a body."""
        way = t * (self.velocity + 0.5 * self.acceleration * t)
        speed = self.velocity + self.acceleration * t
        rows[0] += self.share * way
        rows[1] += self.share * speed
        rows[2] += 0.5 * self.mass * speed**2
        rows[5] += self.mass * self.acceleration * way


@dataclass(frozen=True, eq=False)
class Plan:
    """All that a run needs to know.

    Attributes
    ----------
    players : sequence of Player
    velocities : sequence of float
        m/s.
    joints : sequence of Joint
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
    """

    players: Sequence[Player]
    velocities: Sequence[float]
    joints: Sequence[Joint]
    loads: Sequence[Load]
    gravity: float
    duration: float
    energies: bool
    preload: bool = False
    scene: str = ""

    @cached_property
    def modal(self) -> tuple[ModalBody, ...]:
        """The bodies in their natural modes."""
        return tuple(player.modal for player in self.players)

    @cached_property
    def first_modes(self) -> tuple[int, ...]:
        """Where each body's modes begin among those of all; and how many these are."""
        return tuple(itertools.accumulate((body.n for body in self.modal), initial=0))

    @cached_property
    def first_rows(self) -> tuple[int, ...]:
        """Where each body's rows begin in a record, after the contacts'; and their number."""
        sizes = (BODY_ROWS + PORT_ROWS * player.ports for player in self.players)
        return tuple(itertools.accumulate(sizes, initial=CONTACT_ROWS * len(self.joints)))

    @property
    def ends(self) -> tuple[tuple[int, int, int, int], ...]:
        """Bodies and ports of the contacts."""
        return tuple(joint.ends_at for joint in self.joints)

    @property
    def drifts(self) -> tuple[Drift | None, ...]:
        """What the reduced bodies leave out."""
        found: list[Drift | None] = []
        for player, velocity in zip(self.players, self.velocities, strict=True):
            share, mass = player.unseen
            moves = mass != 0.0 and (velocity != 0.0 or self.gravity != 0.0)
            found.append(Drift(share, mass, velocity, self.gravity) if moves else None)
        return tuple(found)

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
        forces = np.zeros((len(times), self.players[body].ports))
        for load in ours:
            forces[:, load.port] += np.interp(times, load.times, load.forces)
        return times, forces

    def port_forces(self, body: int, times: FloatArray, record: FloatArray) -> FloatArray:
        """Return all forces on a body's ports, N, along their directions, shape (p, times).

        Under gravity one more row of ones after them: the weight acts at any time.

        Parameters
        ----------
        times : ndarray, shape (times,)
            s.
        record : ndarray, shape (rows, times)
            What the run recorded then.
        """
        forces = np.zeros((self.players[body].ports, len(times)))
        for i, joint in enumerate(self.joints):
            if joint.first == body:
                forces[joint.first_port] -= record[CONTACT_ROWS * i]
            if joint.second == body:
                forces[joint.second_port] += record[CONTACT_ROWS * i]
        for load in self._loads_of.get(body, []):
            forces[load.port] += np.interp(times, load.times, load.forces)
        return np.vstack([forces, np.ones((1, len(times)))]) if self.gravity else forces

    def weight_of(self, body: int) -> FloatArray | None:
        """Return the forces of gravity on the coordinates that are stepped; None without."""
        return self.players[body].weight(self.gravity) if self.gravity else None

    def start_of(self, body: int) -> State | None:
        """Return the state that is stepped from, if that is not moving undeformed."""
        if not self.preload:
            return None
        return self.players[body].pressed(self.at_rest[body], self._rest[1][body])

    def ports_at_rest(self, body: int) -> FloatArray | None:
        """Return the ports of a preloaded body at the start, m, and their rates, m/s, (2, p)."""
        if not self.preload:
            return None
        modal = self.modal[body]
        places = modal.shape @ self.at_rest[body] + self._rest[1][body]
        return np.array([places, modal.shape @ (self.velocities[body] * modal.moving)])

    # ------------------------------------------------------------------- the start

    @cached_property
    def at_rest(self) -> tuple[FloatArray, ...]:
        """Modes of the bodies at rest under gravity and the loads at t = 0, if so asked; or zeros.

        Raises
        ------
        ConvergenceError
            If they come to no rest.
        """
        if not self.preload:
            return tuple(np.zeros(body.n) for body in self.modal)
        rest = itertools.pairwise(self.first_modes)
        return tuple(self._rest[0][first:end] for first, end in rest)

    @cached_property
    def _rest(self) -> tuple[FloatArray, list[FloatArray]]:
        """All modes at rest, and what these leave out of the displacements of massless ports."""
        return equilibrium(
            self.modal,
            [
                Pressed(((j.first, j.first_port), (j.second, j.second_port)), j.gap, j.law)
                for j in self.joints
            ],
            gravity=self.gravity,
            forces=[self._loaded(body) for body in range(len(self.modal))],
        )

    def _loaded(self, body: int) -> FloatArray:
        """The loads on a body's ports at t = 0, N."""
        load = self.load_on(body)
        if load is None:
            return np.zeros(self.players[body].ports)
        return np.array([np.interp(0.0, load[0], column) for column in load[1].T])

    @property
    def fastest(self) -> float:
        """The largest speed at which the bodies of a contact may meet, m/s."""
        speeds = [abs(self.velocities[j.first] - self.velocities[j.second]) for j in self.joints]
        fall = abs(self.gravity) * self.duration
        drop = [math.sqrt(2.0 * abs(self.gravity) * abs(j.gap)) for j in self.joints]
        return max([*speeds, *(min(fall, d) for d in drop if d), 0.0])
