"""The classical modal truncation of a body, and the star that it is in other coordinates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Self, overload

import numpy as np

from .. import _core
from ..base import (
    HUGE,
    FloatArray,
    Frozen,
    InputError,
    checked,
    finite_array,
    integer,
    warn,
)
from ..fem import ContactPoint, ContactSurface, FEModel, Patch, refuse_massless
from ..linalg import EQUAL, Solver, checked_solver, lowest, warn_of_rounding
from .bodymodel import FiniteElementModel, ascending, checked_ports
from .interface import InterfaceModel, of_modes
from .modalbody import ModalBody
from .origin import origin_of
from .star import AOModel, described

# Modes and oscillators with less than this share of the whole count as not excited by the contact.
_NOT_EXCITED = 1e-13


@dataclass(frozen=True, eq=False)
class ModalModel(Frozen, FiniteElementModel):
    """The first natural modes of a body: the classical truncated model.

    Attributes
    ----------
    tip : ContactPoint
    omega2 : ndarray, shape (n,)
        ω², (rad/s)², ascending; zero for rigid modes.
    modes : ndarray, shape (n_dofs, n)
        M-orthonormal.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> modes = ao.modal(bar.contact(point=(0.1, 0.005, 0.005)), n=8)
    >>> modes.truncated(7).omega2.shape
    (7,)
    """

    tip: ContactPoint
    omega2: FloatArray
    modes: FloatArray

    def __post_init__(self) -> None:
        checked(self, tip=(ContactPoint,), omega2=ascending)
        shape = (self.tip.body.n_dofs, len(self.omega2))
        checked(self, modes=partial(finite_array, shape=shape, most=HUGE, order="K"))
        super().__post_init__()

    def __repr__(self) -> str:
        return described(self, f"{self.n} modes")

    @property
    def constrained(self) -> bool:
        """True if it has no rigid motion."""
        return not bool((self.omega2 == 0.0).any())

    @property
    def n(self) -> int:
        """Number of modes, rigid ones included."""
        return len(self.omega2)

    @property
    def patch(self) -> Patch | None:
        """The patch over which the body is touched, or None."""
        return self.tip.patch

    @property
    def contact_surface(self) -> ContactSurface | None:
        """Material and curvatures at the contact; None for a body without a mesh."""
        return self.tip.contact_surface

    @property
    def angular_frequencies(self) -> FloatArray:
        """ω, rad/s, ascending, shape (n,)."""
        omega: FloatArray = np.sqrt(self.omega2)
        return omega

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies, Hz, ascending, shape (n,)."""
        return np.sqrt(self.omega2) / (2.0 * np.pi)

    @property
    def participation(self) -> FloatArray:
        """r_j = bᵀφ_j, 1/√kg, shape (n,)."""
        result: FloatArray = self.modes.T @ self.tip.b
        return result

    @property
    def contact_points(self) -> tuple[ContactPoint, ...]:
        """The contact point on its body."""
        return (self.tip,)

    @property
    def static_mass(self) -> float:
        """The mass that an impact moves statically, kg, eq. (10)."""
        return self.star.static_mass

    @property
    def modal(self) -> ModalBody:
        """The modes that the contact excites.

        :meta private:
        """
        return self.star.modal

    @property
    def dofs(self) -> int:
        """Number of modes."""
        return self.n

    @property
    def label(self) -> str:
        """Kind of the model, "modal(40)"."""
        return f"modal({self.n})"

    def turned(self, ports: Sequence[int]) -> Self:
        """Return the same model with the direction of travel the other way round.

        :meta private:
        """
        return replace(self, tip=self.tip.reversed()) if ports else self

    def truncated(self, n: int) -> ModalModel:
        """Return the model of the first `n` modes.

        Examples
        --------
        >>> K, M = np.array([[2e6, -1e6], [-1e6, 1e6]]), np.diag([0.5, 0.5])
        >>> chain = ao.FEModel(K=K, M=M)
        >>> ao.modal(chain.contact(dof=1), n=2).truncated(1).n
        1
        """
        kept = integer("n", n, low=1, high=self.n)
        return ModalModel(self.tip, self.omega2[:kept], self.modes[:, :kept])

    @cached_property
    def star(self) -> AOModel:
        """The same model as anti-oscillators, by the secular equation.

        Modes of one frequency act as one; those that b does not excite are left out. It is
        exact: both have the same receptance Σ r_j²/(ω_j² - ω²).
        """
        return star_of_modes(self.tip, self.omega2, self.modes, "modal")


def star_of_modes(
    tip: ContactPoint,
    omega2: FloatArray,
    modes: FloatArray,
    label: str,
    *,
    coordinates: FloatArray | None = None,
    vectors: Callable[[], FloatArray] | None = None,
    solver: str = "",
    contact_time: float | None = None,
) -> AOModel:
    """Return the star of M-orthonormal modes: its antiresonances by the secular equation.

    Parameters
    ----------
    tip : ContactPoint
    omega2 : ndarray, shape (n,)
        ω², (rad/s)², ascending; zero for rigid modes.
    modes : ndarray, shape (n_dofs, n), or with coordinates (n_dofs, r)
        The modes, or M-orthonormal vectors of which they are combinations.
    label : str
        Kind of model that the modes were made for: "modal" or "AO".
    coordinates : ndarray, shape (r, n), optional
        Coordinates of the modes on such vectors.
    vectors : callable, optional
        Returns these vectors, with coordinates: the star's shapes are left to be multiplied out.
    solver : str, optional
        The linear solver they were made with.
    contact_time : float, optional
        That they were fitted to, s.
    """
    participation = tip.b @ modes
    size2 = np.einsum("ij,ij->j", modes, modes)
    if coordinates is not None:  # sizes as if the vectors were at right angles: of what is rounding
        participation, size2 = participation @ coordinates, size2 @ coordinates**2
    weight = participation**2
    rounding = 1e-12 * np.linalg.norm(tip.b) * np.sqrt(size2)
    excited = (weight > _NOT_EXCITED * weight.sum()) & (weight > rounding**2)
    if not excited.any():
        raise InputError(f"none of the {len(omega2)} modes moves the contact: take a larger n")
    omega2, weight = omega2[excited], weight[excited]
    shapes = (modes if coordinates is None else coordinates)[:, excited] * participation[excited]
    starts = np.flatnonzero(np.diff(omega2, prepend=-np.inf) > EQUAL * omega2)
    weight = np.add.reduceat(weight, starts)
    shapes = np.add.reduceat(shapes, starts, axis=1)
    m0, k0, m, k, static, shapes = _of_distinct(omega2[starts], weight, shapes)
    origin = origin_of(tip, static, shapes, label, solver, contact_time, vectors)
    return AOModel(m0=m0, k0=k0, m=m, k=k, origin=origin, damping=tip.body.damping)


def _of_distinct(
    omega2: FloatArray, weight: FloatArray, r_phi: FloatArray
) -> tuple[float, float, FloatArray, FloatArray, FloatArray, FloatArray]:
    """m0, k0, m, k, φ_st, Ψ of distinct modes; column j of `r_phi` is r_j φ_j."""
    m, k = np.empty(len(omega2) - 1), np.empty(len(omega2) - 1)
    m0, k0 = _core.star_from_modal(omega2, weight, m, k)
    kept = m > _NOT_EXCITED * (m0 + m.sum())
    m, k = m[kept], k[kept]
    # In modal coordinates φ_st is r_j k0/ω_j² or the rigid mode, Ψ_i is -r_j k_i/(ω_j² - μ_i).
    static = r_phi @ (k0 / omega2) if k0 > 0.0 else r_phi[:, 0] / weight[0]
    shapes = r_phi @ -(k / np.subtract.outer(omega2, k / m))
    return m0, k0, m, k, static, shapes


def natural_modes(
    body: FEModel, n: int, *, solver: Solver = "auto"
) -> tuple[FloatArray, FloatArray]:
    """Return ω², shape (n,), and the M-orthonormal modes, shape (n_dofs, n), of the lowest `n`.

    Raises
    ------
    InputError
        If there are not so many, the other motions having no mass.
    """
    wanted = integer("n", n, low=1, high=body.n_dofs)
    invert = partial(body.inverse, solver=checked_solver(solver))
    rigid = body.rigid_modes.shape[1]
    if wanted < rigid:
        warn(
            f"n={n} takes in some of {rigid} rigid motions, and the force depends on which; take "
            f"n={rigid} or more"
        )
    omega2, modes = lowest(body.K, body.M, wanted, known=body.rigid_modes, invert=invert)
    warn_of_rounding(body.K, modes[:, rigid:], f"{len(omega2) - rigid} elastic modes")
    if len(omega2) < wanted:
        raise InputError(
            f"n must be at most {len(omega2)}, got {n}: the other motions have no mass"
        )
    return omega2, modes


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
    ports = checked_ports("tips", tips)
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
