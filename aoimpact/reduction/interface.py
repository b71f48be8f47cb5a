"""Bodies touched in several places: the motions that impacts there excite, as modes with ports.

One functional makes a star. Several make no star, since each has anti-oscillators of its own, but
the same subspace: the Ritz modes of a block Krylov subspace, each with its share in every port.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from ..base import (
    HUGE,
    FloatArray,
    Frozen,
    InputError,
    checked,
    finite_array,
    integer,
    positive,
    text,
    warn,
)
from ..fem import (
    SHIFT_TIMES_DURATION,
    ContactPoint,
    fitted_shifts,
    highest_shift,
    translates,
    whole_motion,
)
from ..linalg import Solver
from .bodymodel import (
    FiniteElementModel,
    ReducedModel,
    ascending,
    checked_ports,
)
from .modalbody import ModalBody, Pull, RigidMotion
from .recovery import GeneralizedCoordinates
from .star import described
from .subspace import Subspace

# Share of the ports' own compliances that the rounding of a reduction may cost: as the core has it.
_ROUNDED = 1e-6


def _compliance(name: str, value: Any, *, ports: int) -> FloatArray:
    """Check that forces on the ports do no negative work."""
    matrix = finite_array(name, value, shape=(ports, ports))
    own = np.sqrt(np.maximum(matrix.diagonal(), 0.0))
    slack = _ROUNDED * np.outer(own, own)
    if (np.abs(matrix - matrix.T) > slack).any() or (
        np.linalg.eigvalsh(matrix)[0] < -_ROUNDED * float(own @ own)
    ):
        raise InputError(
            f"{name} must be symmetric and positive semidefinite, as compliances are: "
            f"forces do no negative work on them; got {matrix.tolist()}"
        )
    return matrix


def _contact_time(name: str, value: Any) -> float:
    """Check that a contact time has a frequency to be computed with."""
    time = positive(name, value, unit="s")
    if time * HUGE < SHIFT_TIMES_DURATION:
        raise InputError(f"{name} must be {SHIFT_TIMES_DURATION / HUGE:g} s at least, got {time:g}")
    return time


@dataclass(frozen=True, eq=False, repr=False)
class InterfaceModel(Frozen, FiniteElementModel, ReducedModel):
    """A body with p places of contact: q̈_j + ω_j² q_j = Σ_p r_pj f_p, u_p = Σ_j r_pj q_j.

    Made by `interface`.

    Attributes
    ----------
    tips : tuple of ContactPoint
        The ports.
    omega : ndarray, shape (n,)
        Frequencies of the modes, rad/s, ascending; rigid motions come first, as zeros.
    participation : ndarray, shape (p, n)
        r_pj = b_pᵀφ_j, 1/√kg.
    modes : ndarray, shape (n_dofs, n)
        φ_j, M-orthonormal.
    residual : ndarray, shape (p, p)
        Compliance between the ports that no mode has, m/N; zero as made.
    solver : str
        The linear solver that the modes were made with.
    contact_time : float or None
        The duration of the contact that they were fitted to, s; None where they fit any.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> places = [bar.contact(point=(x, 0.005, 0.01)) for x in (0.03, 0.07)]
    >>> model = ao.interface(places, n=8, contact_time=1e-4)
    >>> model.participation.shape
    (2, 8)
    """

    tips: tuple[ContactPoint, ...]
    omega: FloatArray
    participation: FloatArray
    modes: FloatArray
    residual: FloatArray
    solver: str = ""
    contact_time: float | None = None

    def __post_init__(self) -> None:
        checked(self, tips=checked_ports, omega=ascending, solver=text)
        n, ports = len(self.omega), len(self.tips)
        checked(
            self,
            participation=partial(finite_array, shape=(ports, n), most=HUGE, order="K"),
            modes=partial(finite_array, shape=(self.body.n_dofs, n), most=HUGE, order="K"),
            residual=partial(_compliance, ports=ports),
        )
        moved = np.stack([tip.b for tip in self.tips]) @ self.modes
        if np.abs(moved - self.participation).max() > _ROUNDED * np.abs(moved).max():
            raise InputError("participation must be what the modes move the contact points by, bᵀφ")
        if not moved.any(axis=1).all():
            raise InputError("modes must move every contact point: one has no participation")
        if self.contact_time is not None:
            checked(self, contact_time=_contact_time)
        super().__post_init__()

    def __repr__(self) -> str:
        return described(self, f"{self.n} modes, {len(self.tips)} contact points")

    @property
    def constrained(self) -> bool:
        """True if it has no rigid motion."""
        return not bool((self.omega == 0.0).any())

    @property
    def contact_points(self) -> tuple[ContactPoint, ...]:
        """The ports."""
        return self.tips

    @cached_property
    def static_mass(self) -> float:
        """The mass that an impact on its lightest port moves at first, kg."""
        return float(1.0 / (self.participation**2).sum(axis=1).max())

    @cached_property
    def modal(self) -> ModalBody:
        """Modes of the body with its ports.

        Raises
        ------
        InputError
            If its centre of mass is not known.

        :meta private:
        """
        mass = self.mass
        if mass is None:
            raise InputError(
                "the mass of a body touched in several places is not known: make it with nodes"
            )
        centre = np.ascontiguousarray(self.centre_weights)
        damping = self.body.damping
        participation = np.ascontiguousarray(self.participation)
        return ModalBody(
            omega=self.omega,
            decay=None if damping is None else np.ascontiguousarray(damping.decay(self.omega)),
            shape=participation,
            push=participation,
            residual=self.residual if self.residual.any() else None,
            weight=mass * centre,
            inertia=np.ones(self.n),
            centre=centre,
            centre_residual=None,
            moving=mass * centre,
            rigid=self._rigid,
        )

    @property
    def _rigid(self) -> RigidMotion | None:
        """Rigid motion of the body, where it is touched along tangents as well."""
        if self.tips[0].tangents is None:
            return None
        functionals, momenta = whole_motion(self.body)
        return RigidMotion(functionals @ self.modes, self.modes.T @ momenta)

    def deflection(self, s: float, port: int = 0) -> FloatArray:
        """Return the body's displacement under a unit force at the frequency i s, shape (n_dofs,).

        :meta private:
        """
        shape: FloatArray = self.modes @ (self.participation[port] / (self.omega**2 + s**2))
        return shape

    def coordinates(self, gravity: Pull = 0.0) -> GeneralizedCoordinates:
        """Return the modes as the coordinates of the body.

        :meta private:
        """
        loads = np.stack([tip.b for tip in self.tips], axis=1)
        direction = self.tips[0].direction
        if isinstance(gravity, np.ndarray) and self.mass is not None:
            weights = [self.body.com_functional(axis) for axis in np.eye(3)]
            loads = np.column_stack([loads, self.mass * (gravity @ weights)])
        elif gravity and direction is not None and self.mass is not None:
            weight = gravity * self.mass * self.body.com_functional(direction)
            loads = np.column_stack([loads, weight])
        stiffness = np.diag(self.omega**2)
        return GeneralizedCoordinates(self.body, self.modes, np.ones(self.n), stiffness, loads)

    @property
    def n(self) -> int:
        """Number of modes, rigid ones included."""
        return len(self.omega)

    @property
    def label(self) -> str:
        """Kind of the model, "interface(40)"."""
        return f"interface({self.n})"

    @property
    def dofs(self) -> int:
        """Number of modes."""
        return self.n

    @property
    def linear_solver(self) -> str:
        """The linear solver that the modes were made with."""
        return self.solver

    @property
    def turnable(self) -> bool:
        """No: the participations of all its modes are in the directions it was made with.

        :meta private:
        """
        return False

    def turned(self, ports: Sequence[int]) -> Self:
        """Return the model as it is.

        :meta private:
        """
        return self

    def stiffened(self, factor: float) -> Self:
        """Return the model with all its springs stiffer by a factor.

        :meta private:
        """
        return replace(self, omega=math.sqrt(factor) * self.omega, residual=self.residual / factor)

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies, Hz, ascending, shape (n,)."""
        return self.omega / (2.0 * np.pi)

    @cached_property
    def translates(self) -> bool:
        """True if the body may translate along the first port's direction."""
        return translates(self.tips[0])

    @cached_property
    def centre_weights(self) -> FloatArray:
        """Weights of the modes in the displacement of the centre of mass, 1/√kg, shape (n,).

        Along the first port's direction. A body that translates at V has q̇ = mass · weights · V.

        Raises
        ------
        InputError
            If the body has no nodes, or its M lacks the constrained dofs.
        """
        if self.tips[0].direction is None:
            raise InputError("the centre of mass is not known: make the body with nodes")
        weights: FloatArray = self.body.com_functional(self.tips[0].direction) @ self.modes
        return weights

    def receptance(self, omega: npt.ArrayLike) -> npt.NDArray[Any]:
        """Return the displacements of the ports over forces there, m/N.

        Σ_j r_pj r_qj/(ω_j² - ω² + 2iσ_jω); real without damping.

        Parameters
        ----------
        omega : array_like
            Angular frequency, rad/s, any shape.

        Returns
        -------
        ndarray, shape (..., p, p)
            `[..., p, q]`: of port p for a force at port q; infinite at a resonance.

        Warns
        -----
        AOImpactWarning
            At frequencies outside the model's `band`.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> places = [bar.contact(point=(x, 0.005, 0.01)) for x in (0.05, 0.09)]
        >>> G = ao.interface(places, n=4).receptance(0.0)
        >>> bool(np.allclose(G, G.T))  # Maxwell and Betti
        True
        """
        frequency = finite_array("omega", omega, unit="rad/s", most=HUGE)
        self._warn_outside_band(frequency)
        stiffness: Any = self.omega**2 - frequency[..., None] ** 2
        if self.damping is not None:
            stiffness = stiffness + 2j * self.damping.decay(self.omega) * frequency[..., None]
        with np.errstate(divide="ignore"):
            gain = 1.0 / stiffness
        r = self.participation
        result: npt.NDArray[Any] = np.einsum("pj,...j,qj->...pq", r, gain, r) + self.residual
        return result

    def expand(self, coordinates: npt.ArrayLike) -> FloatArray:
        """Return the full displacement X = Σ q_j φ_j.

        Parameters
        ----------
        coordinates : array_like, shape (n,) or (n, times)
            q, m √kg.

        Returns
        -------
        ndarray, shape (n_dofs,) or (n_dofs, times)
            On the free dofs, in the order of the rows of K, m.

        Raises
        ------
        InputError
            If the shape is wrong.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> places = [bar.contact(point=(x, 0.005, 0.01)) for x in (0.05, 0.09)]
        >>> model = ao.interface(places, n=4)
        >>> model.expand(np.zeros(model.n)).shape == (bar.n_dofs,)
        True
        """
        values = finite_array("coordinates", coordinates)
        if values.ndim not in (1, 2) or values.shape[0] != self.n:
            raise InputError(
                f"coordinates must have shape ({self.n},) or ({self.n}, times), got {values.shape}"
            )
        full: FloatArray = self.modes @ values
        return full


def interface(
    tips: ContactPoint | Sequence[ContactPoint],
    n: int,
    *,
    contact_time: float | None = None,
    duration: float = math.inf,
    solver: Solver = "auto",
) -> InterfaceModel:
    """Return the model of a body touched in several places.

    Its modes are those of the body projected on the rigid motions and on what impacts at the ports
    excite, port by port in turn: (K + s²M)⁻¹ B, (K + s²M)⁻¹ M (K + s²M)⁻¹ B, …

    Parameters
    ----------
    tips : ContactPoint, or a sequence of them
        Places on one and the same body, from `FEModel.contact`.
    n : int
        Number of modes, the body's rigid motions included and at least one more for each port.
    contact_time : float, optional
        The shortest contact that the modes are fitted to, s; by default the shortest of those that
        the ports have by themselves.
    duration : float, optional
        How long the body's motion is to be right, s. By default for ever: every other vector is
        static, so that the lowest natural modes are right. ``duration=contact_time`` fits all
        vectors to the contact, which spares a factorisation and is best for its force alone.
    solver : str or callable, optional
        See `FEModel.inverse`.

    Raises
    ------
    InputError
        If the tips are not on one body, or `n` is out of range.
    SingularError
        If a port moves part of the body as a mechanism.

    Warns
    -----
    AOImpactWarning
        If the ports excite fewer than `n` modes.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> places = [bar.contact(point=(x, 0.005, 0.01)) for x in (0.03, 0.07)]
    >>> model = ao.interface(places, n=8, contact_time=1e-4)
    >>> len(model.tips), model.participation.shape
    (2, (2, 8))
    """
    space = InterfaceSpace(tips, contact_time=contact_time, duration=duration, solver=solver)
    body = space.tips[0].body
    least = min(space.rigid_count + len(space.tips), body.n_dofs)
    n = integer("n", n, low=least, high=body.n_dofs)
    model = space.of_vectors(n)
    if model.n < n:
        warn(f"n={n}: the ports excite only {model.n} modes")
    return model


class InterfaceSpace:
    """The space from which models of a body touched in several places are made; it grows.

    For the arguments see `interface`.

    Attributes
    ----------
    tips : tuple of ContactPoint
    rigid_count : int
        Number of the body's rigid motions.
    contact_time : float
        Contact time that it is fitted to, s.
    """

    def __init__(
        self,
        tips: ContactPoint | Sequence[ContactPoint],
        *,
        contact_time: float | None = None,
        duration: float | None = None,
        sharpened: bool = False,
        solver: Solver = "auto",
    ) -> None:
        self.tips = checked_ports("tips", tips)
        shifts = fitted_shifts(self.tips, contact_time, duration)
        self.contact_time = SHIFT_TIMES_DURATION / shifts[0]
        highest = min(map(highest_shift, self.tips)) if sharpened else 0.0
        self._space = Subspace(self.tips, shifts, highest=highest, solver=solver)
        self.rigid_count = self._space.rigid_count

    def of_vectors(self, n: int) -> InterfaceModel:
        """Return the model of `n` vectors, rigid motions included, or of as many as there are."""
        omega2, modes = self._space.ritz(n)
        name = self._space.solver_name
        return of_modes(self.tips, np.sqrt(omega2), modes, name, self.contact_time)

    def release(self) -> None:
        """Give back the memory of the factors."""
        self._space.release()

    @property
    def exhausted(self) -> bool:
        """True if all that the ports excite is in the space."""
        return self._space.exhausted


def of_modes(
    tips: tuple[ContactPoint, ...],
    omega: FloatArray,
    modes: FloatArray,
    solver: str,
    contact_time: float | None = None,
) -> InterfaceModel:
    functionals = np.stack([tip.b for tip in tips])
    nothing = np.zeros((len(tips), len(tips)))
    participation = functionals @ modes
    return InterfaceModel(tips, omega, participation, modes, nothing, solver, contact_time)
