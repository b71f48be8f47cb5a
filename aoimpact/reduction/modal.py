"""The classical modal truncation of a body, touched in one place or several."""

from __future__ import annotations

from collections.abc import Sequence
from typing import overload

import numpy as np

from ..fem import ContactPoint, refuse_massless
from ..linalg import Solver, lowest
from .bodymodel import checked_ports
from .interface import InterfaceModel, of_modes
from .modes import ModalModel, natural_modes

__all__ = ["modal", "whole_interface"]


@overload
def modal(tips: ContactPoint, n: int, *, solver: Solver = "auto") -> ModalModel: ...
@overload
def modal(tips: Sequence[ContactPoint], n: int, *, solver: Solver = "auto") -> InterfaceModel: ...
def modal(
    tips: ContactPoint | Sequence[ContactPoint], n: int, *, solver: Solver = "auto"
) -> ModalModel | InterfaceModel:
    """Return the classical modal truncation of a body: its `n` lowest natural modes.

    Parameters
    ----------
    tips : ContactPoint or sequence of ContactPoint
        Where it is touched, from `FEModel.contact`: one place, or several of one body.
    n : int
        Number of modes, rigid ones included, 1 … n_dofs.
    solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        The linear solver for what is too large for dense matrices; see `FEModel.inverse`.

    Returns
    -------
    ModalModel or InterfaceModel
        The latter for a sequence.

    Raises
    ------
    InputError
        If `n` is out of range, or there are fewer modes, the other motions having no mass; if the
        tips are not on one body, or act on dofs without mass.

    Warns
    -----
    AOImpactWarning
        If `n` takes in some of the rigid motions only.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> end, middle = (bar.contact(point=(x, 0.005, 0.01)) for x in (0.09, 0.05))
    >>> ao.modal(end, n=8).omega2.shape
    (8,)
    >>> ao.modal([end, middle], n=8).participation.shape
    (2, 8)
    """
    ports = (tips,) if isinstance(tips, ContactPoint) else checked_ports("tips", tips)
    refuse_massless(ports)
    omega2, modes = natural_modes(ports[0].body, n, solver=solver)
    if isinstance(tips, ContactPoint):
        return ModalModel(tips, omega2, modes)
    return of_modes(ports, np.sqrt(omega2), modes, "")


def whole_interface(tips: Sequence[ContactPoint]) -> InterfaceModel:
    """Return the model of all natural modes of a body, at the cost of finding these.

    Raises
    ------
    InputError
        If the tips are not on one body.
    """
    ports = checked_ports("tips", tips)
    refuse_massless(ports)
    body = ports[0].body
    omega2, modes = lowest(body.K, body.M, body.n_dofs, known=body.rigid_modes)
    return of_modes(ports, np.sqrt(omega2), modes, "dense eigensolver")
