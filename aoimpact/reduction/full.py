"""The full finite-element model of a body with one or more contact points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base import ArrayPair, FloatArray, Frozen, InputError, InputTypeError, boolean, checked
from ..contact import ContactPoint, moves_rigidly, refuse_massless, static_mode
from ..fem import FEModel, ModalDamping
from ..linalg import DENSE_MOST, lowest
from .body import Body, BodyModel, Pull, Velocity, checked_ports, of_modes
from .reduction import antioscillators
from .star import AOModel


@dataclass(frozen=True, repr=False)
class FullModel(Frozen, BodyModel):
    """A finite-element body with all its degrees of freedom. Made by `full`.

    Two full models are equal if they have the same contact points.

    Attributes
    ----------
    tips : tuple of ContactPoint
        Contact points, on one body.
    reducible : bool
        True if the model stands for contact points whose reduced model is yet to be chosen.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> whole = ao.full(bar.contact(dof=0))
    >>> isinstance(whole, ao.FullModel)
    True
    """

    tips: tuple[ContactPoint, ...]
    reducible: bool = False
    kind = "full"

    def __post_init__(self) -> None:
        checked(self, tips=checked_ports, reducible=boolean)
        super().__post_init__()

    def __repr__(self) -> str:
        return f"full({self.tips[0] if len(self.tips) == 1 else list(self.tips)})"

    @property
    def n(self) -> int:  # type: ignore[override]
        """Number of the body's free degrees of freedom."""
        return self.body.n_dofs

    @property
    def static_mode(self) -> FloatArray:
        """Static mode φ_st at the first port, eqs. (2), (3), shape (n_dofs,).

        :meta private:
        """
        return static_mode(self.tips[0]).phi

    @cached_property
    def constrained(self) -> bool:
        """True if no contact point can move without a deformation."""
        return not any(moves_rigidly(tip) for tip in self.tips)

    @cached_property
    def static_mass(self) -> float:
        """Least mass of the static modes of all contact points, kg, eq. (10)."""
        return min(static_mode(tip).mass for tip in self.tips)

    @cached_property
    def modal(self) -> Body:
        """The body in all natural modes that its contact points excite.

        :meta private:
        """
        if self.ports == 1:
            return antioscillators(self.tips[0]).modal
        refuse_massless(self.tips)
        body = self.body
        omega2, modes = lowest(body.K, body.M, body.n_dofs, known=body.rigid_modes)
        solver = "dense eigensolver"
        return of_modes(self.tips, omega2, modes, kind="modal", linear_solver=solver)

    @property
    def in_modes(self) -> bool:
        """True if modal damping requires integration of the body in all its modes.

        :meta private:
        """
        if not isinstance(self.body.damping, ModalDamping):
            return False
        if self.dofs > DENSE_MOST:
            raise InputError(
                f"damping={self.body.damping!r} needs all modes of the full model, which are "
                f"computed up to {DENSE_MOST} of {self.dofs} dofs; give Rayleigh, or reduce it"
            )
        return True

    @property
    def massless(self) -> bool:
        """True if a port has no mass; False if K and M themselves, not modes, are integrated.

        :meta private:
        """
        return self.in_modes and self.modal.massless

    @cached_property
    def moving(self) -> FloatArray:
        """Initial velocities of the dofs for a unit velocity of the body, shape (n_dofs,).

        The body translates if it can, or if it has several contact points: its models then have no
        other motion as a whole. Otherwise the body moves in the static mode.

        :meta private:
        """
        tip = self.tips[0]
        if tip.direction is not None and (self.ports > 1 or tip.translates):
            return self.body.translation(tip.direction)
        return self.static_mode

    def rates(self, velocity: Velocity) -> FloatArray:
        """Return the initial velocities of the dofs, shape (n_dofs,); see `Body.rates`.

        :meta private:
        """
        if not isinstance(velocity, np.ndarray):
            return velocity * self.moving if velocity else np.zeros(self.dofs)
        nodes = self.body.nodes
        place = self.body.on_dofs(nodes)
        centre = [self.body.com_functional(axis) @ place for axis in np.eye(3)]
        moved: FloatArray = velocity[:3] + np.cross(velocity[3:], nodes - centre)
        return self.body.on_dofs(moved)

    def weight(self, gravity: Pull) -> FloatArray:
        """Return the forces on the dofs, N, due to gravity, m/s².

        :meta private:
        """
        if self.body.mass is None or self.tips[0].direction is None:
            raise InputError("gravity needs the body's nodes: make it from a mesh, or with nodes")
        return super().weight(gravity)

    def fast_compliance(self, slowest: float, *, weighed: bool) -> ArrayPair:
        """Return a bound without modes: for ω above s, Σ r² / ω² is at most 2 bᵀ (K + s²M)⁻¹ b.

        Σ |r_p| |r_q| / ω² is at most √(Σ r_p²/ω² Σ r_q²/ω²) (Cauchy-Schwarz).

        :meta private:
        """
        loads = [tip.b for tip in self.tips]
        forces = np.column_stack([*loads, self.weight(1.0)] if weighed else loads)
        moved = self.body.inverse(slowest**2).solve(forces)
        root = np.sqrt(2.0 * (forces * moved).sum(axis=0))
        ports = root[: self.ports]
        return np.outer(ports, ports), ports * root[-1] if weighed else np.zeros(self.ports)


def full(tips: ContactPoint | Sequence[ContactPoint]) -> FullModel:
    """Return the full finite-element model of a body.

    Parameters
    ----------
    tips : ContactPoint or sequence of ContactPoint
        Contact points from `FEModel.contact`: one, or several of one body.

    Raises
    ------
    InputError, InputTypeError
        If `tips` is empty, has other objects, or has points on different bodies.

    Examples
    --------
    >>> steel = Material(E=210e9, nu=0.3, rho=7800)
    >>> cube = FEModel.from_mesh(box_mesh((0.01, 0.01, 0.01), (3, 3, 3)), steel)
    >>> full(cube.contact(point=(0.005, 0.005, 0.0))).label
    'full(192)'
    """
    return FullModel(checked_ports("tips", tips))


def body_model(name: str, body: Any) -> BodyModel:
    """Return the model that a caller's `body` is or stands for.

    A contact point, or a list of them, stands for a full model that may be reduced.

    Raises
    ------
    InputError, InputTypeError
        If `body` is no model of a body, or its contact points are on different bodies.
    """
    if isinstance(body, AOModel):
        return body.modal
    if isinstance(body, BodyModel):
        return body
    if isinstance(body, ContactPoint | list | tuple):
        return FullModel(checked_ports(name, body), reducible=True)
    if isinstance(body, FEModel):
        raise InputTypeError(
            f"{name} is a whole {body!r}: say where it is touched by body.contact(...), such as "
            f"{name}=body.contact(point=(x, y, z))"
        )
    raise InputTypeError(
        f"{name} must be an AOModel (antioscillators, rigid), a Body (modal, interface), "
        "the full model (full(tip)), or a ContactPoint (body.contact(...); a list of them where it "
        f"is touched in several places), got {body!r}"
    )
