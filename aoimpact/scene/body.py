"""A body of a scene, whatever its model: what a run needs to know of it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from ..base import FloatArray
from ..reduction import BodyModel, ModalBody
from .stepped import SteppedBody

__all__ = ["SceneBody", "State"]

State = tuple[FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class SceneBody(ABC):
    """A body about to take part in a scene, moving as a whole.

    Attributes
    ----------
    model : AOModel, InterfaceModel or FullModel
    velocity : float
        m/s.
    """

    model: BodyModel
    velocity: float

    @property
    @abstractmethod
    def label(self) -> str:
        """What kind of model it is: "rigid", "AO(1)", "modal(40)", "full(3159)"."""

    @property
    def name(self) -> str:
        """As its maker called it; empty if it has no name."""
        return self.model.name

    @property
    @abstractmethod
    def mass(self) -> float | None:
        """kg; None where it is not known."""

    @property
    @abstractmethod
    def centre_known(self) -> bool:
        """Whether its centre of mass is known; else the mean over the static mode stands in."""

    @property
    @abstractmethod
    def constrained(self) -> bool:
        """Whether supports or a ground spring constrain it."""

    @property
    def wall(self) -> bool:
        """Whether it is of infinite mass."""
        return self.mass is not None and math.isinf(self.mass)

    @property
    def fixed(self) -> bool:
        """Whether it stays in its place: constrained, or a wall."""
        return self.constrained or self.wall

    @property
    @abstractmethod
    def static_mass(self) -> float:
        """The mass that an impact on its lightest port moves statically, kg, eq. (10)."""

    @property
    @abstractmethod
    def modal(self) -> ModalBody:
        """The body in its natural modes; a full model in all of them."""

    def fast_compliance(self, slowest: float, *, weighed: bool) -> tuple[FloatArray, FloatArray]:
        """Return Σ |r_p| |r_q| / ω² of modes above a frequency, rad/s, or a bound of it.

        Returns
        -------
        by_forces : ndarray, shape (ports, ports)
            m/N.
        by_weight : ndarray, shape (ports,)
            m per m/s² of gravity; zero unless `weighed`.
        """
        modal = self.modal
        fast = modal.omega > slowest
        shape = np.abs(modal.shape[:, fast]) / modal.omega[fast] ** 2
        by_weight = shape @ np.abs(modal.weight[fast]) if weighed else np.zeros(self.ports)
        return shape @ np.abs(modal.push[:, fast].T), by_weight

    @property
    def ports(self) -> int:
        """Number of places where it may be touched."""
        return 1

    @property
    def weightless(self) -> bool:
        """Whether gravity has no effect on it, since what constrains it is not known."""
        return False

    @property
    def omitted(self) -> tuple[float, float]:
        """Share of the centre of mass's velocity, and mass, kg, that the model does not contain."""
        return 0.0, 0.0

    @property
    @abstractmethod
    def undeformed(self) -> State:
        """The state, as `stepped` takes it, of the body moving as a whole."""

    @abstractmethod
    def weight(self, gravity: float) -> FloatArray | None:
        """Return the forces of gravity, m/s², on the coordinates that `stepped` takes them for."""

    @abstractmethod
    def preloaded(self, x: FloatArray, beside: FloatArray) -> State:
        """Return the state, as `stepped` takes it, moving from modes `x` with its velocity.

        `beside`, shape (p,), is what the modes leave out of the displacements of massless ports, m.
        """

    def stepped(
        self,
        *,
        gravity: FloatArray | None = None,
        state: State | None = None,
        ports: FloatArray | None = None,
    ) -> SteppedBody:
        """Return the body as a run with fixed steps takes it.

        Parameters
        ----------
        gravity : ndarray, optional
            Constant forces on the model's coordinates, N.
        state : (u, v), optional
            The model's coordinates and rates at the start; moving undeformed if not given.
        ports : ndarray, shape (2, p), optional
            Displacements of the ports just after the start, m, and their rates, m/s: the state does
            not determine them where a port has no mass.
        """
        u, v = self.undeformed if state is None else state
        return self._stepped(gravity, u.copy(), v.copy(), ports)

    @abstractmethod
    def _stepped(
        self,
        gravity: FloatArray | None,
        u: FloatArray,
        v: FloatArray,
        ports: FloatArray | None,
    ) -> SteppedBody:
        """What `stepped` returns; u and v are written to."""

    @property
    def massless(self) -> bool:
        """Whether a port moves at once with the force on it."""
        return self.modal.residual is not None

    def coordinates(self, values: FloatArray) -> FloatArray:
        """Return the model's coordinates (or rates) from those that the core steps."""
        return values
