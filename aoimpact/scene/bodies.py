"""The kinds of body that meet in an impact, each as the core steps it.

The ladder: a rigid mass, a star of anti-oscillators, a modal truncation (run as the star that it is
in other coordinates), and the finite-element model itself.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, InputTypeError
from ..fem import (
    ContactPoint,
    ModalDamping,
    Rayleigh,
    centre_of,
    moves_rigidly,
    static_mode,
    translates,
)
from ..reduction import (
    AOModel,
    InterfaceModel,
    ModalBody,
    ModalModel,
    StarModes,
    antioscillators,
    checked_ports,
    modal,
    modal_body,
    star_modes,
    whole_interface,
)
from .stepped import SteppedBody, SteppedFull, SteppedModes, SteppedStar

__all__ = ["FullBody", "InterfaceBody", "SceneBody", "StarBody", "scene_body"]

State = tuple[FloatArray, FloatArray]

# All modes of a body of that many dofs take some ten seconds and a third of a GiB.
_MODAL_MOST = 3000


@dataclass(frozen=True, eq=False)
class SceneBody(ABC):
    """A body about to take part in a scene, moving as a whole.

    Attributes
    ----------
    model : AOModel, InterfaceModel or tuple of ContactPoint
    velocity : float
        m/s.
    """

    model: Any
    velocity: float

    @property
    @abstractmethod
    def label(self) -> str:
        """What the body is, in a word."""

    @property
    @abstractmethod
    def mass(self) -> float | None:
        """kg; None where it is not known."""

    @property
    @abstractmethod
    def centre_known(self) -> bool:
        """Whether its centre of mass is known; else the mean over the static mode stands for it."""

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
        """What a blow at its lightest port has to move in all, kg, eq. (10)."""

    @property
    @abstractmethod
    def modal(self) -> ModalBody:
        """The body in its natural modes; a full model in all of them."""

    @property
    def ports(self) -> int:
        """Number of places where it may be touched."""
        return 1

    @property
    def omitted(self) -> tuple[float, float]:
        """Share of the centre of mass's velocity, and mass, kg, that the model leaves out."""
        return 0.0, 0.0

    @property
    @abstractmethod
    def undeformed(self) -> State:
        """The state, as `stepped` takes it, that moves as a whole."""

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
            Displacements of the ports just after the start, m, and their rates, m/s: of what has no
            mass, the state does not tell them.
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


@dataclass(frozen=True, eq=False)
class StarBody(SceneBody):
    """A star."""

    model: AOModel

    @property
    def label(self) -> str:
        return self.model.label

    @property
    def mass(self) -> float | None:
        return self.model.mass if self.centre_known else None

    @property
    def centre_known(self) -> bool:
        return self.model.centre_known

    @property
    def constrained(self) -> bool:
        return self.model.constrained

    @property
    def static_mass(self) -> float:
        return self.model.static_mass

    @property
    def modal(self) -> ModalBody:
        return modal_body(self.model)

    @property
    def omitted(self) -> tuple[float, float]:
        """A free body hit off its centre also moves in ways that its star does not contain."""
        if self.model.origin is None or not self.model.origin.translates:
            return 0.0, 0.0
        share = float(self.model.centre_weights.sum())
        return 1.0 - share, self.model.mass - self.model.static_mass

    @property
    def undeformed(self) -> State:
        return np.zeros(self.model.n + 1), np.full(self.model.n + 1, self.velocity)

    def weight(self, gravity: float) -> FloatArray | None:
        star = self.model
        if math.isinf(star.m0) or star.weightless:
            return None
        forces: FloatArray = gravity * star.mass * star.centre_weights
        return forces

    def preloaded(self, x: FloatArray, beside: FloatArray) -> State:
        coordinates = self.modal.coordinates(x)
        coordinates[0] += beside[0]
        return coordinates, self.undeformed[1]

    @cached_property
    def _modes(self) -> StarModes | None:
        """Its natural modes, where the core cannot step the star itself."""
        star = self.model
        if star.damping is None or (isinstance(star.damping, Rayleigh) and star.m0 > 0.0):
            return None
        return star_modes(star)

    @property
    def massless(self) -> bool:
        return self.model.m0 == 0.0

    def _stepped(
        self,
        gravity: FloatArray | None,
        u: FloatArray,
        v: FloatArray,
        ports: FloatArray | None,
    ) -> SteppedBody:
        star = self.model
        if self._modes is not None:
            return _modal_core(self._modes, gravity, u, v, ports)
        damping = star.damping if isinstance(star.damping, Rayleigh) else Rayleigh()
        if ports is not None and self.massless:
            u[0], v[0] = ports[:, 0]
        return SteppedStar(
            m0=star.m0,
            k0=star.k0,
            m=star.m,
            k=star.k,
            damping=damping,
            gravity=gravity,
            centre=np.ascontiguousarray(star.centre_weights),
            u=u,
            v=v,
        )

    def coordinates(self, values: FloatArray) -> FloatArray:
        modes = self._modes
        return values if modes is None else modes.coordinates(modes.participation * values)


def _modal_core(
    modes: StarModes,
    gravity: FloatArray | None,
    u: FloatArray,
    v: FloatArray,
    ports: FloatArray | None,
) -> SteppedBody:
    x, rates = modes.project(u), modes.project(v)
    bent = None
    if modes.residual:  # displaced by more than the modes are: something presses on the contact
        at = np.array([u[:1], [modes.participation @ rates]]) if ports is None else ports
        shape = modes.participation[None, :]
        bent = _bending(np.array([[modes.residual]]), at, shape, x, rates)
    return SteppedModes(
        omega=modes.omega,
        decay=modes.decay,
        shape=modes.participation,
        residual=np.array([modes.residual]),
        bent=bent,
        gravity=None if gravity is None else modes.force(gravity),
        centre=modes.participation * modes.centre[0],
        u=x,
        v=rates,
    )


def _bending(
    residual: FloatArray, ports: FloatArray, shape: FloatArray, x: FloatArray, v: FloatArray
) -> FloatArray:
    """The forces that displace ports by more than modes do, N, and their rates, N/s, (2, p)."""
    beyond = ports.T - shape @ np.column_stack([x, v])
    return np.ascontiguousarray(np.linalg.lstsq(residual, beyond)[0].T, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class FullBody(SceneBody):
    """A finite-element body, touched in one place or more.

    At the start it translates where it may, else it moves in φ_st of the first place.
    """

    model: tuple[ContactPoint, ...]

    @property
    def tip(self) -> ContactPoint:
        """The first place."""
        return self.model[0]

    @property
    def label(self) -> str:
        return f"full({self.tip.body.n_dofs})"

    @property
    def mass(self) -> float | None:
        return self._centre_of[1] if self.centre_known else None

    @property
    def centre_known(self) -> bool:
        return self._centre_of[2]

    @cached_property
    def constrained(self) -> bool:
        return not any(moves_rigidly(tip) for tip in self.model)

    @cached_property
    def static_mass(self) -> float:
        return min(static_mode(tip).mass for tip in self.model)

    @property
    def ports(self) -> int:
        return len(self.model)

    @cached_property
    def _whole(self) -> AOModel | InterfaceModel:
        """All that is felt at its places of contact."""
        return antioscillators(self.tip) if self.ports == 1 else whole_interface(self.model)

    @property
    def modal(self) -> ModalBody:
        return modal_body(self._whole)

    def weight(self, gravity: float) -> FloatArray | None:
        if self.tip.body.mass is None or self.tip.direction is None:
            raise InputError("gravity needs the body's nodes: make it from a mesh, or with nodes")
        forces: FloatArray = gravity * self.tip.body.mass * self._centre_of[0]
        return forces

    def preloaded(self, x: FloatArray, beside: FloatArray) -> State:
        return self._whole.expand(self.modal.coordinates(x)), self._start

    @cached_property
    def _centre_of(self) -> tuple[FloatArray, float, bool]:
        """Functional of the centre of mass, mass, kg, and whether they are known."""
        return centre_of(self.tip, lambda: static_mode(self.tip).phi)

    @property
    def undeformed(self) -> State:
        return np.zeros(self.tip.body.n_dofs), self._start

    @cached_property
    def _start(self) -> FloatArray:
        """The velocities of all dofs."""
        if self.velocity == 0.0:
            return np.zeros(self.tip.body.n_dofs)
        if self.tip.direction is not None and translates(self.tip):
            return self.velocity * self.tip.body.translation(self.tip.direction)
        return self.velocity * static_mode(self.tip).phi

    @cached_property
    def _modes(self) -> ModalModel | None:
        """All natural modes, where damping is given by them."""
        body = self.tip.body
        if not isinstance(body.damping, ModalDamping):
            return None
        if body.n_dofs > _MODAL_MOST:
            raise InputError(
                f"damping={body.damping!r} on the full model of {body.n_dofs} dofs needs all of "
                f"its modes, which are computed up to {_MODAL_MOST} dofs; give Rayleigh(alpha=, "
                "beta=), or simulate a reduced model: antioscillators(tip) or modal(tip, n)"
            )
        return modal(self.tip, body.n_dofs)

    @property
    def massless(self) -> bool:
        return False

    def _stepped(
        self,
        gravity: FloatArray | None,
        u: FloatArray,
        v: FloatArray,
        ports: FloatArray | None,
    ) -> SteppedBody:
        body = self.tip.body
        if self._modes is not None:
            return self._in_modes(self._modes, gravity, u, v)
        damping = body.damping if isinstance(body.damping, Rayleigh) else Rayleigh()
        return SteppedFull(
            K=body.K,
            M=body.M,
            B=np.ascontiguousarray([tip.b for tip in self.model]),
            damping=damping,
            gravity=gravity,
            centre=np.ascontiguousarray(self._centre_of[0]),
            u=u,
            v=v,
        )

    def _in_modes(
        self, modes: ModalModel, gravity: FloatArray | None, u: FloatArray, v: FloatArray
    ) -> SteppedBody:
        phi, mass = modes.modes, self.tip.body.M
        omega = modes.angular_frequencies
        damping = self.tip.body.damping
        return SteppedModes(
            omega=omega,
            decay=np.zeros_like(omega) if damping is None else damping.decay(omega),
            shape=np.ascontiguousarray([tip.b @ phi for tip in self.model]),
            residual=np.zeros((self.ports, self.ports)),
            bent=None,
            gravity=None if gravity is None else phi.T @ gravity,
            centre=phi.T @ self._centre_of[0],
            u=phi.T @ (mass @ u),
            v=phi.T @ (mass @ v),
        )

    def coordinates(self, values: FloatArray) -> FloatArray:
        return values if self._modes is None else self._modes.modes @ values


@dataclass(frozen=True, eq=False)
class InterfaceBody(SceneBody):
    """A body touched in several places, in the modes that they excite."""

    model: InterfaceModel

    @property
    def label(self) -> str:
        return self.model.label

    @property
    def mass(self) -> float | None:
        return self.model.mass

    @property
    def centre_known(self) -> bool:
        return True  # else the model is refused

    @cached_property
    def constrained(self) -> bool:
        return not bool((self.model.omega == 0.0).any())

    @cached_property
    def static_mass(self) -> float:
        inverse = (self.model.participation**2).sum(axis=1).max()
        return float(1.0 / inverse)

    @property
    def ports(self) -> int:
        return len(self.model.tips)

    @property
    def modal(self) -> ModalBody:
        return modal_body(self.model)

    @property
    def undeformed(self) -> State:
        return self.preloaded(np.zeros(self.modal.n), np.zeros(self.ports))

    def weight(self, gravity: float) -> FloatArray | None:
        return gravity * self.modal.weight

    def preloaded(self, x: FloatArray, beside: FloatArray) -> State:
        return x, self.velocity * self.modal.moving

    def _stepped(
        self,
        gravity: FloatArray | None,
        u: FloatArray,
        v: FloatArray,
        ports: FloatArray | None,
    ) -> SteppedBody:
        modal, bent = self.modal, None
        if modal.residual is not None and ports is not None:
            bent = _bending(modal.residual, ports, modal.shape, u, v)
        none = np.zeros((self.ports, self.ports))
        return SteppedModes(
            omega=modal.omega,
            decay=np.zeros(modal.n) if modal.decay is None else modal.decay,
            shape=modal.shape,
            residual=none if modal.residual is None else modal.residual,
            bent=bent,
            gravity=gravity,
            centre=modal.centre,
            u=u,
            v=v,
        )


def scene_body(name: str, body: Any, velocity: float) -> SceneBody:
    """Return the scene body for what a caller handed over as projectile or target.

    Raises
    ------
    InputTypeError
        If `body` is no model of a body.
    """
    if isinstance(body, AOModel):
        return StarBody(body, velocity)
    if isinstance(body, ModalModel):
        return StarBody(body.star, velocity)
    if isinstance(body, ContactPoint):
        return FullBody((body,), velocity)
    if isinstance(body, (list, tuple)):
        return FullBody(checked_ports(body, name), velocity)
    if isinstance(body, InterfaceModel):
        return InterfaceBody(body, velocity)
    raise InputTypeError(
        f"{name} must be an AOModel (antioscillators, rigid), a modal model, an interface model, "
        "or a ContactPoint (body.contact(...), the full model; a list of them where it is touched "
        f"in several places), got {body!r}"
    )
