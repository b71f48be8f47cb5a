"""The finite-element model itself as a body of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base import FloatArray, InputError
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
    FullModel,
    InterfaceModel,
    ModalBody,
    ModalModel,
    antioscillators,
    modal,
    modal_body,
    whole_interface,
)
from .body import SceneBody, State
from .stepped import SteppedBody, SteppedFull, SteppedModes

__all__ = ["FullBody"]

# All modes of a body with so many dofs take some ten seconds and a third of a GiB.
_MODAL_MOST = 3000


@dataclass(frozen=True, eq=False)
class FullBody(SceneBody):
    """A finite-element body, touched in one place or more.

    At the start it translates where it may, or is touched in several places, whose modes know no
    other way to move as a whole; else it moves in φ_st.
    """

    model: FullModel

    @property
    def tip(self) -> ContactPoint:
        """The first place."""
        return self.model.tips[0]

    @property
    def label(self) -> str:
        return self.model.label

    @property
    def mass(self) -> float | None:
        return self._centre_of[1] if self.centre_known else None

    @property
    def centre_known(self) -> bool:
        return self._centre_of[2]

    @cached_property
    def constrained(self) -> bool:
        return not any(moves_rigidly(tip) for tip in self.model.tips)

    @cached_property
    def static_mass(self) -> float:
        return min(static_mode(tip).mass for tip in self.model.tips)

    @property
    def ports(self) -> int:
        return len(self.model.tips)

    @cached_property
    def _whole(self) -> AOModel | InterfaceModel:
        """All that is felt at its places of contact."""
        return antioscillators(self.tip) if self.ports == 1 else whole_interface(self.model.tips)

    @property
    def modal(self) -> ModalBody:
        return modal_body(self._whole)

    def fast_compliance(self, slowest: float, *, weighed: bool) -> tuple[FloatArray, FloatArray]:
        """A bound without the modes: Σ r² / ω² above s is at most 2 bᵀ (K + s²M)⁻¹ b.

        And Σ |r_p| |r_q| / ω² at most the root of both ports' sums (Cauchy and Schwarz).
        """
        loads = [tip.b for tip in self.model.tips]
        weight = self.weight(1.0) if weighed else None
        forces = np.column_stack(loads if weight is None else [*loads, weight])
        moved = self.tip.body.inverse(slowest**2).solve(forces)
        root = np.sqrt(2.0 * (forces * moved).sum(axis=0))
        ports = root[: self.ports]
        by_weight = np.zeros(self.ports) if weight is None else ports * root[-1]
        return np.outer(ports, ports), by_weight

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
        along = self.tip.direction
        if along is not None and (self.ports > 1 or translates(self.tip)):
            return self.velocity * self.tip.body.translation(along)
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
            B=np.ascontiguousarray([tip.b for tip in self.model.tips]),
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
            shape=np.ascontiguousarray([tip.b @ phi for tip in self.model.tips]),
            residual=np.zeros((self.ports, self.ports)),
            residual_forces=None,
            gravity=None if gravity is None else phi.T @ gravity,
            centre=phi.T @ self._centre_of[0],
            u=phi.T @ (mass @ u),
            v=phi.T @ (mass @ v),
        )

    def coordinates(self, values: FloatArray) -> FloatArray:
        return values if self._modes is None else self._modes.modes @ values
