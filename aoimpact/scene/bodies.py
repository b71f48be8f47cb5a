"""The kinds of body that meet in an impact, each as the core steps it.

From coarse to exact: a rigid mass, an AO model, a modal truncation (run as the AO model that it is
in other coordinates), a body touched in several places, and the finite-element model itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base import FloatArray
from ..fem import Rayleigh
from ..reduction import (
    AOModel,
    FullModel,
    InterfaceModel,
    ModalBody,
    StarModes,
    body_model,
    modal_body,
    star_modes,
)
from .body import SceneBody, State
from .full_body import FullBody
from .stepped import SteppedBody, SteppedModes, SteppedStar

__all__ = ["InterfaceBody", "StarBody", "scene_body"]


@dataclass(frozen=True, eq=False)
class StarBody(SceneBody):
    """An AO model; its topology is a star."""

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
        """A free body struck off its centre also turns, which its AO model does not contain."""
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

    @property
    def weightless(self) -> bool:
        return self.model.weightless

    def _stepped(
        self,
        gravity: FloatArray | None,
        u: FloatArray,
        v: FloatArray,
        ports: FloatArray | None,
    ) -> SteppedBody:
        star = self.model
        if self._modes is not None:
            return _stepped_modes(self._modes, gravity, u, v, ports)
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

    @property
    def constrained(self) -> bool:
        return self.model.constrained

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
        modal, residual_forces = self.modal, None
        if modal.residual is not None and ports is not None:
            residual_forces = _residual_forces(modal.residual, ports, modal.shape, u, v)
        none = np.zeros((self.ports, self.ports))
        return SteppedModes(
            omega=modal.omega,
            decay=np.zeros(modal.n) if modal.decay is None else modal.decay,
            shape=modal.shape,
            residual=none if modal.residual is None else modal.residual,
            residual_forces=residual_forces,
            gravity=gravity,
            centre=modal.centre,
            u=u,
            v=v,
        )


def scene_body(name: str, body: Any, velocity: float) -> SceneBody:
    """Return the scene body for what a caller handed over as projectile or target.

    Raises
    ------
    InputError, InputTypeError
        If `body` is no model of a body.
    """
    model = body_model(name, body)
    if isinstance(model, AOModel):
        return StarBody(model, velocity)
    if isinstance(model, FullModel):
        return FullBody(model, velocity)
    assert isinstance(model, InterfaceModel)
    return InterfaceBody(model, velocity)


def _stepped_modes(
    modes: StarModes,
    gravity: FloatArray | None,
    u: FloatArray,
    v: FloatArray,
    ports: FloatArray | None,
) -> SteppedBody:
    x, rates = modes.project(u), modes.project(v)
    residual_forces = None
    if modes.residual:  # displaced by more than the modes are: something presses on the contact
        at = np.array([u[:1], [modes.participation @ rates]]) if ports is None else ports
        shape = modes.participation[None, :]
        residual_forces = _residual_forces(np.array([[modes.residual]]), at, shape, x, rates)
    return SteppedModes(
        omega=modes.omega,
        decay=modes.decay,
        shape=modes.participation,
        residual=np.array([modes.residual]),
        residual_forces=residual_forces,
        gravity=None if gravity is None else modes.force(gravity),
        centre=modes.participation * modes.centre[0],
        u=x,
        v=rates,
    )


def _residual_forces(
    residual: FloatArray, ports: FloatArray, shape: FloatArray, x: FloatArray, v: FloatArray
) -> FloatArray:
    """The forces that displace ports by more than modes do, N, and their rates, N/s, (2, p)."""
    beyond = ports.T - shape @ np.column_stack([x, v])
    return np.ascontiguousarray(np.linalg.lstsq(residual, beyond)[0].T, dtype=np.float64)
