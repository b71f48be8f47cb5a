"""The full finite-element model of a body, touched in one place or more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

from ..base import Frozen, InputError, InputTypeError, boolean, checked
from ..fem import ContactPoint
from .bodymodel import FiniteElementModel

__all__ = ["FullModel", "checked_ports", "full"]


@dataclass(frozen=True, repr=False)
class FullModel(Frozen, FiniteElementModel):
    """All degrees of freedom of a finite-element body. Made by `full`.

    Two of them are equal if they have the same contact points.

    Attributes
    ----------
    tips : tuple of ContactPoint
        The places where it is touched, on one body.
    reducible : bool
        Whether it stands for contact points whose model is yet to be chosen.

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

    def __post_init__(self) -> None:
        checked(self, tips=checked_ports, reducible=boolean)
        super().__post_init__()

    def __repr__(self) -> str:
        return f"full({self.tips[0] if len(self.tips) == 1 else list(self.tips)})"

    @property
    def contact_points(self) -> tuple[ContactPoint, ...]:
        """The places where it is touched."""
        return self.tips

    @property
    def dofs(self) -> int:
        """Number of the body's free degrees of freedom."""
        return self.body.n_dofs

    @property
    def label(self) -> str:
        """What the model is, in a word."""
        return f"full({self.dofs})"

    def turned(self, ports: Sequence[int]) -> Self:
        """Return the model with the direction of travel turned round at some ports.

        :meta private:
        """
        if not ports:
            return self
        tips = (tip.reversed() if i in ports else tip for i, tip in enumerate(self.tips))
        return replace(self, tips=tuple(tips))


def full(tips: ContactPoint | Sequence[ContactPoint]) -> FullModel:
    """Return the full finite-element model of a body.

    Parameters
    ----------
    tips : ContactPoint or sequence of ContactPoint
        Where it is touched, from `FEModel.contact`: one place, or several of one body.

    Raises
    ------
    InputError, InputTypeError
        If there is none, they are on different bodies, or they are no contact points.

    Examples
    --------
    >>> steel = Material(E=210e9, nu=0.3, rho=7800)
    >>> cube = FEModel.from_mesh(box_mesh((0.01, 0.01, 0.01), (3, 3, 3)), steel)
    >>> full(cube.contact(point=(0.005, 0.005, 0.0))).label
    'full(192)'
    """
    return FullModel((tips,) if isinstance(tips, ContactPoint) else checked_ports("tips", tips))


def checked_ports(name: str, tips: Any) -> tuple[ContactPoint, ...]:
    """Return the places on one body.

    Raises
    ------
    InputError, InputTypeError
        If they are not that.
    """
    if not isinstance(tips, Sequence) or isinstance(tips, str):
        raise InputTypeError(f"{name} must be a list of contact points, got {tips!r}")
    ports = tuple(tips)
    for tip in ports:
        if not isinstance(tip, ContactPoint):
            raise InputTypeError(f"{name} must come from FEModel.contact(...), got {tip!r}")
    if not ports:
        raise InputError(f"{name} is empty: a body needs a place where it is touched")
    if any(tip.body is not ports[0].body for tip in ports):
        raise InputError(
            f"{name} has contact points on different bodies: make one model for each body"
        )
    return ports
