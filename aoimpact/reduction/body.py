"""A body in its natural modes, the form of every body in the core.

All reduced models are Galerkin models: the motion of the body is X = Σ q_j φ_j. The displacement of
a port is a contact functional of X, u = bᵀX. Anti-oscillator models (star.py) are models of one
port in other coordinates.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import (
    HUGE,
    ArrayPair,
    FloatArray,
    Frozen,
    InputError,
    InputTypeError,
    finite_array,
    integer,
)
from ..contact import (
    Compliance,
    ContactPoint,
    ContactSurface,
    centre_of,
    moves_rigidly,
)
from ..fem import Damping, FEModel, whole_motion
from .band import Band, band_of

if TYPE_CHECKING:
    from .star import AOModel

# Function that takes the fields of the core's struct `aoi_modes` from a mapping, in their order.
_PARTS = itemgetter(*_core.MODES.split())

# Relative difference, due to rounding errors of the mesh, below which a translation and the rigid
# motion that a port excites are taken as equal.
_STRAIGHT = 1e-6

# Velocity along the direction of travel, m/s; or velocity of the centre of mass in three
# directions, m/s, and spin, rad/s, shape (6,).
Velocity = float | FloatArray

# Acceleration of gravity along the direction of travel, or in three directions, shape (3,), m/s².
Pull = float | FloatArray


class BodyModel(ABC):
    """A model of a body with its ports, the contact functionals."""

    kind: str
    n: int
    tips: tuple[ContactPoint, ...]
    contact_time: float | None = None
    linear_solver: str = ""
    reducible: bool = False
    numbers: AOModel | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Pickle and copy only the fields: caches are cheap to recompute."""
        return {one.name: vars(self)[one.name] for one in fields(self)}  # type: ignore[arg-type]

    @cached_property
    def kept(self) -> dict[Any, Any]:
        """Cache for results of other modules that depend on this immutable model alone.

        :meta private:
        """
        return {}

    @property
    def alone(self) -> Self:
        """The same model, but without references to vectors that other models share.

        :meta private:
        """
        return self

    @property
    def body(self) -> FEModel:
        """The finite-element body; a model given by numbers has none."""
        return self.tips[0].body

    @property
    def name(self) -> str:
        """Name of the body in results, tables and plots; empty if it has none."""
        return (self.numbers or self.body).name

    @property
    def damping(self) -> Damping | None:
        """Damping of the natural modes; None where nothing is damped."""
        return (self.numbers or self.body).damping

    @property
    def label(self) -> str:
        """Kind of the model, such as "rigid", "wall", "AO(3)", "interface(40)", "full(3159)"."""
        return self.kind if self.kind in ("rigid", "wall") else f"{self.kind}({self.n})"

    @property
    def dofs(self) -> int:
        """Number of degrees of freedom of the model; 0 for a wall."""
        return {"wall": 0, "AO": self.n + 1, "rigid": self.n + 1}.get(self.kind, self.n)

    @property
    def wall(self) -> bool:
        """True if the mass is infinite.

        :meta private:
        """
        return self.kind == "wall"

    @property
    @abstractmethod
    def constrained(self) -> bool:
        """True if no port can move without a deformation, or if the body is a wall."""

    @property
    @abstractmethod
    def static_mass(self) -> float:
        """Least mass of the static modes of all ports, kg, eq. (10)."""

    @property
    @abstractmethod
    def modal(self) -> Body:
        """The body in the natural modes of the model; a full model has all modes.

        :meta private:
        """

    @property
    @abstractmethod
    def static_mode(self) -> FloatArray:
        """Static mode φ_st at the first port, eqs. (2), (3), shape (n_dofs,).

        :meta private:
        """

    @cached_property
    def centre_of_mass(self) -> tuple[FloatArray, float, bool]:
        """Functional of the centre of mass, (n_dofs,); mass, kg; and True if both are known.

        :meta private:
        """
        return centre_of(self.tips[0], lambda: self.static_mode)

    @property
    def mass(self) -> float | None:
        """Mass of the whole body, kg; if not known, the mass of its static mode."""
        return self.centre_of_mass[1] if self.numbers is None else self.numbers.static_mass

    @property
    def most_mass(self) -> float:
        """Upper bound of the static mass, kg; infinite for a constrained body.

        :meta private:
        """
        if self.body.rigid_modes.shape[1] == 0:
            return math.inf
        mass = self.body.mass
        return float(self.body.M.diagonal().sum()) if mass is None else mass

    @property
    def centre_known(self) -> bool:
        """True if the displacement of the centre of mass is known, as for a body given by numbers.

        If it is not, the mean displacement of the body, weighted with its static mode, stands for
        it.
        """
        return self.numbers is not None or self.centre_of_mass[2]

    @property
    def known_mass(self) -> float | None:
        """Mass of the whole body, kg; None if its centre of mass is not known.

        :meta private:
        """
        return self.mass if self.centre_known else None

    @property
    def ports(self) -> int:
        """Number of contact functionals.

        :meta private:
        """
        return len(self.tips)

    @property
    def places(self) -> int:
        """Number of contact points, each with three ports if it has tangents; 1 for a rigid body.

        :meta private:
        """
        if not self.tips:
            return 1
        return self.ports // 3 if self.tips[0].tangents is not None else self.ports

    @property
    def weightless(self) -> bool:
        """True if gravity has no effect on the body, since its supports are not known.

        :meta private:
        """
        return self.constrained and not self.wall and not (self.tips and self.centre_known)

    def weight(self, gravity: Pull) -> FloatArray:
        """Return the forces on the dofs, N, due to gravity, m/s².

        :meta private:
        """
        if isinstance(gravity, np.ndarray):
            along = [self.body.com_functional(axis) for axis in np.eye(3)]
            return np.asarray((self.mass or 0.0) * (gravity @ along))
        functional, mass, _ = self.centre_of_mass
        return np.asarray((0.0 if self.weightless else gravity * mass) * functional)

    @property
    def massless(self) -> bool:
        """True if a port has no mass and follows the force on it at once.

        :meta private:
        """
        return False

    @abstractmethod
    def fast_compliance(self, slowest: float, *, weighed: bool) -> ArrayPair:
        """Return the compliance of the modes above `slowest`, rad/s, or an upper bound of it.

        The compliance is Σ |r_p| |r_q| / ω², with the participation factors r_p at the ports.

        Returns
        -------
        by_forces : ndarray, shape (ports, ports)
            Displacements of the ports under unit forces on them, m/N.
        by_weight : ndarray, shape (ports,)
            Displacements of the ports per unit gravity, m/(m/s²); zero unless `weighed`.

        :meta private:
        """

    def touched_at(self, port: int = 0) -> ContactPoint | None:
        """Return the contact point of a port; None for a body given by numbers.

        :meta private:
        """
        return self.tips[port] if self.tips else None

    def extraction_at(self, port: int = 0) -> Compliance | None:
        """Return the compliances at a port; None for a rigid body, or if they are not known.

        :meta private:
        """
        return self.tips[port].extraction if self.tips else None

    def surface_at(self, port: int = 0) -> ContactSurface | None:
        """Return material and curvatures of the surface at a port; None if they are not known.

        :meta private:
        """
        return self.tips[port].contact_surface if self.numbers is None else self.numbers.surface

    def turned(self, ports: Sequence[int]) -> Self:
        """Return the model with the direction of travel reversed at some ports.

        :meta private:
        """
        if not ports or not self.tips:
            return self
        key = "turned", tuple(ports)
        if key not in self.kept:
            tips = (tip.reversed if i in ports else tip for i, tip in enumerate(self.tips))
            self.kept[key] = self._with_tips(tuple(tips))
            self.kept[key].kept["turned"] = self, tuple(ports)
        found: Self = self.kept[key]
        return found

    def _with_tips(self, tips: tuple[ContactPoint, ...]) -> Self:
        return replace(self, tips=tips)  # type: ignore[type-var]


class AsWhole(NamedTuple):
    """The motion of a body as a whole, in modal coordinates q.

    Attributes
    ----------
    centre : ndarray, shape (n,)
        Displacement of the centre of mass along the direction of travel per unit q.
    moving : ndarray, shape (n,)
        Modal rates q̇ of the body moving undeformed with unit velocity.
    weight : ndarray, shape (n,)
        Modal accelerations q̈ under unit gravity along the direction of travel.
    velocity : ndarray, shape (6, n), or None
        Velocity of the centre of mass and mean spin per unit q̇, in the axes of the mesh; shape
        (3, n), without spin, if supports prevent it. None if ports have a normal direction only.
    momentum : ndarray, shape (n, 6), or None
        Modal rates q̇ of the undeformed body for unit velocities and spins.
    """

    centre: FloatArray
    moving: FloatArray
    weight: FloatArray
    velocity: FloatArray | None = None
    momentum: FloatArray | None = None


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Body(Frozen, BodyModel):
    """A body in its natural modes: q̈_j + 2σ_j q̇_j + ω_j² q_j = g_j + Σ_p push_pj f_p.

    The displacements of the ports are u_p = Σ_j shape_pj q_j + Σ_k R_pk f_k. Made by
    `antioscillators`, `modal`, `interface`, `rigid`, `ball` and `wall`; `expand` gives the
    displacements of the finite-element body.

    Attributes
    ----------
    kind : str
        Kind of the model: "AO", "modal", "interface", "rigid" or "wall".
    n : int
        Number of anti-oscillators of an "AO" model, else of modes.
    omega : ndarray, shape (n,)
        Natural frequencies ω, rad/s, ascending; zeros of rigid motions come first.
    shape, push : ndarrays, shape (p, n)
        Displacements of the ports per unit q, and accelerations q̈ per unit force on the ports;
        both are bᵀφ, 1/√kg, for M-orthonormal modes.
    inertia : ndarray, shape (n,)
        Modal masses in the kinetic energy Σ inertia q̇²/2: 1 for M-orthonormal modes, 0 for a wall.
    tips : tuple of ContactPoint
        Contact functionals of the ports; empty for a body given by numbers.
    residual : ndarray, shape (p, p), or None
        Compliance R of massless contacts beyond the modes, m/N.
    vectors : ndarray, shape (n_dofs, r), or callable that returns it
        Vectors of which the modes are combinations; None for a body given by numbers.
    coordinates : ndarray, shape (r, n)
        Coefficients of the modes on these vectors; None if the vectors are the modes.
    follow : ndarray, shape (r, p), or None
        Coefficients on the vectors of the displacement, m/N, that follows forces on massless ports
        without delay.
    linear_solver : str
        Name of the linear solver that the model was made with; empty if none was needed.
    contact_time : float or None
        Duration of the contact that the model was fitted to, s; None if the model fits any
        duration.
    slow : float or None
        Duration of the slower motion that every second vector was fitted to, s; None if all
        vectors were fitted to the contact.
    numbers : AOModel or None
        Anti-oscillator model of a body given by numbers.
    oscillators : AOModel or None
        Anti-oscillators that the model was made of, in their order.
    as_whole : AsWhole or None
        Motion as a whole of a body given by numbers.
    series : Body or None
        Body in natural modes that an anti-oscillator model was made of, with the same compliances.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> places = [bar.contact(point=(x, 0.005, 0.01)) for x in (0.03, 0.07)]
    >>> ao.interface(places, n=8, contact_time=1e-4).participation.shape
    (2, 8)
    """

    kind: str
    n: int
    omega: FloatArray
    shape: FloatArray
    push: FloatArray
    inertia: FloatArray
    tips: tuple[ContactPoint, ...] = ()
    residual: FloatArray | None = None
    vectors: FloatArray | Callable[[], FloatArray] | None = None
    coordinates: FloatArray | None = None
    follow: FloatArray | None = None
    linear_solver: str = ""
    contact_time: float | None = None
    slow: float | None = None
    numbers: AOModel | None = None
    oscillators: AOModel | None = None
    as_whole: AsWhole | None = None
    series: Body | None = None

    def __getstate__(self) -> dict[str, Any]:
        return super().__getstate__() if not callable(self.vectors) else self.alone.__getstate__()

    @cached_property
    def alone(self) -> Self:
        """The same model with its own array of modes, without references to shared vectors.

        :meta private:
        """
        if not callable(self.vectors):
            return self
        return replace(self, vectors=self.modes, coordinates=None)

    def __repr__(self) -> str:
        parts = [repr(self.name), self.label] if self.name else [self.label]
        if not self.wall:
            parts += ["mass not known" if self.known_mass is None else f"{self.known_mass:.4g} kg"]
            parts.append("constrained" if self.constrained else "free")
        return f"Body({', '.join(parts)})"

    # ------------------------------------------------------------------ the kind

    @cached_property
    def constrained(self) -> bool:
        """True if no port can move without a deformation, or if the body is a wall."""
        return self.wall or not self.shape[:, self.omega == 0.0].any()

    @property
    def most_mass(self) -> float:
        """Upper bound of the static mass, kg; infinite for a constrained body.

        :meta private:
        """
        if self.constrained:
            return math.inf
        return self.static_mass if self.ports == 1 or not self.tips else super().most_mass

    @property
    def static_mass(self) -> float:
        """Least mass of the static modes of all ports, kg, eq. (10)."""
        if self.numbers is not None:
            return self.numbers.static_mass
        return min(float(q @ q) for q in map(self._static, range(self.ports)))

    @property
    def massless(self) -> bool:
        """True if a port has no mass and follows the force on it at once.

        :meta private:
        """
        return self.residual is not None

    @property
    def ports(self) -> int:
        """Number of contact functionals.

        :meta private:
        """
        return len(self.shape)

    @property
    def modal(self) -> Body:
        """The model itself.

        :meta private:
        """
        return self

    # -------------------------------------------------------------- its modes

    @property
    def participation(self) -> FloatArray:
        """Participation factors r_pj = b_pᵀφ_j, 1/√kg, shape (p, n)."""
        return self.shape

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies, Hz, ascending, shape (n,)."""
        return self.omega / (2.0 * np.pi)

    @cached_property
    def decay(self) -> FloatArray | None:
        """Decay rates σ of the modes, 1/s, shape (n,); None without damping.

        :meta private:
        """
        damping = None if self.wall else self.damping
        return None if damping is None else np.ascontiguousarray(damping.decay(self.omega))

    @cached_property
    def modes(self) -> FloatArray:
        """M-orthonormal modes φ_j, shape (n_dofs, n)."""
        found = self.displaced(np.eye(len(self.omega)))
        found.flags.writeable = False
        return found

    def displaced(self, q: FloatArray) -> FloatArray:
        """Return the displacement of `body` for modal coordinates q, (n_dofs,) or (n_dofs, k).

        :meta private:
        """
        q = q if self.coordinates is None else self.coordinates @ q
        return self.spanning @ q

    @property
    def spanning(self) -> FloatArray:
        """The vectors that the modes are combinations of, shape (n_dofs, r).

        :meta private:
        """
        if self.vectors is None:
            raise InputError("expand: this model was given by numbers and has no body to expand to")
        return self.vectors() if callable(self.vectors) else self.vectors

    def seen(self, functionals: FloatArray) -> FloatArray:
        """Return the values of functionals for each mode, functionals @ modes, (n,) or (m, n).

        :meta private:
        """
        on = functionals @ self.spanning
        return np.ascontiguousarray(on if self.coordinates is None else on @ self.coordinates)

    @cached_property
    def following(self) -> FloatArray | None:
        """Displacement that follows forces on the ports at once, m/N, (n_dofs, p), or None.

        :meta private:
        """
        return None if self.follow is None else np.asarray(self.spanning @ self.follow)

    def expand(self, coordinates: npt.ArrayLike) -> FloatArray:
        """Return the full displacement X = Σ q_j φ_j.

        Parameters
        ----------
        coordinates : array_like, shape (n,) or (n, times)
            Modal coordinates q, m √kg.

        Returns
        -------
        ndarray, shape (n_dofs,) or (n_dofs, times)
            Displacements of the free dofs, in the order of the rows of K, m.

        Raises
        ------
        InputError
            If the shape is wrong, or the body was given by numbers.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> places = [bar.contact(point=(x, 0.005, 0.01)) for x in (0.05, 0.09)]
        >>> ao.interface(places, n=4).expand(np.zeros(4)).shape == (bar.n_dofs,)
        True
        """
        found = self.displaced(in_time(coordinates, len(self.omega)))
        return self.body.restricted(found)

    def truncated(self, n: int) -> Body:
        """Return the model of the first `n` natural modes.

        Examples
        --------
        >>> K, M = np.array([[2e6, -1e6], [-1e6, 1e6]]), np.diag([0.5, 0.5])
        >>> chain = ao.FEModel(K=K, M=M)
        >>> ao.modal(chain.contact(dof=1), n=2).truncated(1).n
        1
        """
        if self.kind != "modal":
            raise InputError(
                f"truncated: {self!r} has no natural modes in order; truncate its star"
            )
        kept = slice(integer("n", n, low=1, high=len(self.omega)))
        first: dict[str, Any] = {"omega": self.omega[kept], "inertia": self.inertia[kept]}
        first |= {"shape": self.shape[:, kept].copy(), "push": self.push[:, kept].copy()}
        return replace(self, n=n, vectors=self.modes[:, kept], coordinates=None, **first)

    @cached_property
    def star(self) -> AOModel:
        """The equivalent anti-oscillator model, which has the same receptance.

        Raises
        ------
        InputError
            If the body has more than one port.
        """
        from .star import of_body, star_of

        return star_of(self) if self.oscillators is None else of_body(self.oscillators, self)

    # ------------------------------------------------------- its motion as a whole

    def _static(self, port: int = 0) -> FloatArray:
        """Modal coordinates of the static mode φ_st at a port, eqs. (2), (3).

        φ_st is the rigid motion with u = 1 if a force at the port moves the body as a whole. The
        part of φ_st that follows forces at once (`following`) is not included.
        """
        r, still = self.shape[port], self.omega == 0.0
        if r[still].any():
            return np.where(still, r, 0.0) / float(r[still] @ r[still])
        yielding = r / np.where(still, np.inf, self.omega) ** 2
        own = 0.0 if self.residual is None else float(self.residual[port, port])
        return np.asarray(yielding / (float(r @ yielding) + own))

    @cached_property
    def static_mode(self) -> FloatArray:
        """Static mode φ_st at the first port, eqs. (2), (3), shape (n_dofs,).

        :meta private:
        """
        q = self._static()
        found = self.displaced(q)
        if self.residual is None or self.following is None:
            return found
        rest = (1.0 - float(self.shape[0] @ q)) / float(self.residual[0, 0])
        return found + rest * self.following[:, 0]

    @cached_property
    def whole(self) -> AsWhole:
        """The motion of the body as a whole.

        Raises
        ------
        InputError
            If the body has several ports, and its centre of mass is not known.

        :meta private:
        """
        if self.as_whole is not None:
            return self.as_whole
        functional, mass, known = self.centre_of_mass
        if self.ports > 1 and not known:
            raise InputError(
                "the mass of a body touched in several places is not known: make it with nodes"
            )
        centre, tip = self.seen(functional), self.tips[0]
        if free := tip.translates:  # elastic modes then do not move the centre of mass
            centre = np.where(self.omega == 0.0, centre, 0.0)
        moving = mass * centre if free or self.ports > 1 else self._static()
        weight = np.zeros_like(centre) if self.weightless else mass * centre
        if tip.tangents is None:
            return AsWhole(centre, moving, weight)
        functionals, momenta = whole_motion(self.body)
        return AsWhole(centre, moving, weight, self.seen(functionals), self.seen(momenta.T).T)

    def rates(self, velocity: Velocity) -> FloatArray:
        """Return the modal rates q̇ of the body moving undeformed, shape (n,).

        Parameters
        ----------
        velocity : float or ndarray, shape (6,)
            Velocity along the direction of travel, m/s; or velocity of the centre of mass in three
            directions, m/s, and spin, rad/s.

        :meta private:
        """
        if not isinstance(velocity, np.ndarray):
            return velocity * self.whole.moving
        assert self.whole.momentum is not None
        found: FloatArray = self.whole.momentum @ velocity
        return found

    def loads(self, gravity: Pull = 0.0) -> FloatArray:
        """Return the forces on the dofs per unit of each port force, shape (n_dofs, p).

        The columns are the functionals of the ports. Under gravity, m/s², one more column is the
        weight, N.

        :meta private:
        """
        columns = [tip.b for tip in self.tips]
        return np.stack([*columns, self.weight(gravity)] if np.any(gravity) else columns, axis=1)

    # --------------------------------------------------------------- for the core

    def for_core(self, gravity: Pull = 0.0, load: ArrayPair | None = None) -> tuple[Any, ...]:
        """Return the body as the core's tuple `aoi_modes`.

        Parameters
        ----------
        gravity : float or ndarray, shape (3,), optional
            Acceleration along the direction of travel, or in three directions, m/s².
        load : (times, forces), optional
            Times, s, (m,), and forces on the ports, N, (m, p), linear between the times.

        :meta private:
        """
        if isinstance(gravity, np.ndarray):
            falls = self.rates(np.concatenate([gravity, np.zeros(3)]))
            pulled = falls if falls.any() and self.inertia.any() else None
        else:
            weight = self.whole.weight
            pulled = gravity * weight if gravity and weight.any() else None
        times, forces = (None, None) if load is None else load
        moved = None if self.residual is None else np.zeros(self.ports)
        if self.following is not None and not self.tips[0].translates:
            moved = self.centre_of_mass[0] @ self.following
        acting = {"gravity": pulled, "load_time": times, "load_force": forces, "full": None}
        own = {"centre": self.whole.centre, "decay": self.decay, "centre_residual": moved}
        found: tuple[Any, ...] = _PARTS(vars(self) | own | acting)
        return found

    # ---------------------------------------------------------------- compliances

    def receptance(self, omega: npt.ArrayLike) -> npt.NDArray[Any]:
        """Return the receptances Σ_j r_pj r_qj/(ω_j² - ω² + 2iσ_jω) + R, m/N.

        The receptances are real without damping.

        Parameters
        ----------
        omega : array_like
            Angular frequency, rad/s, any shape.

        Returns
        -------
        ndarray, shape (..., p, p)
            Displacement of port p per unit force at port q, ``[..., p, q]``; infinite at a
            resonance.

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
        self.warn_outside_band(frequency)
        stiffness: Any = (self.omega - frequency[..., None]) * (self.omega + frequency[..., None])
        if self.decay is not None:
            stiffness = stiffness + 2j * self.decay * frequency[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):
            push = self.shape[:, None] * self.push
            parts = np.where(push == 0.0, 0.0, push / stiffness[..., None, None, :])
            found: npt.NDArray[Any] = parts.sum(axis=-1)
        return found if self.residual is None else found + self.residual

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency, Hz, between which the model has its body's receptance.

        In this band the receptance, averaged over neighbouring frequencies, has a relative error
        below 1e-3. Finding the band takes a static solution for each contact point. The band of a
        model given by numbers is unlimited.
        """
        return (0.0, math.inf) if self._band is None else self._band.limits

    @cached_property
    def _band(self) -> Band | None:
        return band_of(self) if self.tips else None

    def warn_outside_band(self, omega: FloatArray) -> None:
        """Warn if frequencies of a receptance, rad/s, are outside the band.

        :meta private:
        """
        if self._band is not None:
            self._band.warn_outside(omega, fitted=self.contact_time is not None)

    def deflection(self, s: float, port: int = 0) -> FloatArray:
        """Return the body's displacement under a unit force at the frequency i s, m/N, (n_dofs,).

        Parameters
        ----------
        s : float
            Frequency, rad/s, positive.
        port : int, optional
            Port of the force.

        :meta private:
        """
        found = self.displaced(self.push[port] / (self.omega**2 + s**2))
        return found if self.following is None else found + self.following[:, port]

    def extraction_at(self, port: int = 0) -> Compliance | None:
        """Return the compliances at a port; for natural modes, of the truncated model.

        None for a rigid body, or if they are not known.

        :meta private:
        """
        if self.kind == "rigid" or not self.tips:
            return None
        if self.series is not None:
            return self.series.extraction_at(port)
        known = self.tips[port].extraction
        if known is None or self.kind != "modal":
            return known
        found: dict[int, Compliance] = self.kept.setdefault("extraction", {})
        if port not in found:
            found[port] = known.of_truncated(self.tips[port], self.deflection(known.s, port))
        return found[port]

    def fast_compliance(self, slowest: float, *, weighed: bool) -> ArrayPair:
        """Return the compliance Σ |r_p| |r_q| / ω² of the modes above `slowest`, rad/s.

        :meta private:
        """
        fast = self.omega > slowest
        shape = np.abs(self.shape[:, fast]) / self.omega[fast] ** 2
        weight = self.whole.weight[fast]
        by_weight = shape @ np.abs(weight) if weighed else np.zeros(self.ports)
        return shape @ np.abs(self.push[:, fast].T), by_weight

    def _with_tips(self, tips: tuple[ContactPoint, ...]) -> Body:
        # If the caller gave the direction of a contact point on a sheet, b stays, and only the
        # touched side changes.
        changed = [one is not was for one, was in zip(tips, self.tips, strict=True)]
        sign = np.array([np.sign(one.b @ was.b) for one, was in zip(tips, self.tips, strict=True)])
        shape, push = sign[:, None] * self.shape, sign[:, None] * self.push
        follow = None if self.follow is None else self.follow * sign
        residual = None if self.residual is None else sign[:, None] * self.residual * sign
        series = (
            None if self.series is None else self.series.turned(np.flatnonzero(changed).tolist())
        )
        return replace(
            self, tips=tips, shape=shape, push=push, follow=follow, residual=residual, series=series
        )


def of_modes(
    tips: tuple[ContactPoint, ...],
    omega2: FloatArray,
    vectors: FloatArray | Callable[[], FloatArray],
    coordinates: FloatArray | None = None,
    **how: Any,
) -> Body:
    """Return the body in M-orthonormal modes.

    Parameters
    ----------
    tips : tuple of ContactPoint
    omega2 : ndarray, shape (n,)
        Squares of the natural frequencies, (rad/s)², ascending; 0 for rigid motions.
    vectors, coordinates
        Attributes of `Body`.
    **how
        Further attributes of `Body`.
    """
    there = vectors() if callable(vectors) else vectors
    r = np.stack([tip.b for tip in tips]) @ there
    r = np.ascontiguousarray(r if coordinates is None else r @ coordinates)
    if len(omega2) and omega2[0] == 0.0:
        held = [not moves_rigidly(tip) for tip in tips]
        r[np.ix_(held, omega2 == 0.0)] = 0.0  # removes rounding errors
    return Body(
        n=len(omega2),
        omega=np.sqrt(omega2),
        shape=r,
        push=r,
        inertia=np.ones(len(omega2)),
        tips=tips,
        vectors=vectors,
        coordinates=coordinates,
        **how,
    )


def in_time(coordinates: npt.ArrayLike, n: int) -> FloatArray:
    """Return the checked coordinates of a model, shape (n,) or (n, times)."""
    values = finite_array("coordinates", coordinates)
    if values.ndim not in (1, 2) or values.shape[0] != n:
        raise InputError(f"coordinates must have shape ({n},) or ({n}, times), got {values.shape}")
    return values


def ways_of(tip: ContactPoint, push: FloatArray, rigid: FloatArray) -> FloatArray:
    """Return an orthonormal basis of the rigid motions due to an impact at a port, (k, 0 … 2).

    Its columns are coordinates on all rigid motions. The first is the motion that the port excites.
    The second completes the span of a translation along the direction of travel, with which an
    eccentric impact begins.

    Parameters
    ----------
    tip : ContactPoint
    push : ndarray, shape (k,)
        Accelerations of the rigid motions per unit force on the port.
    rigid : ndarray, shape (n_dofs, k)
        M-orthonormal rigid motions.
    """
    size = float(np.linalg.norm(push))
    if size == 0.0:
        return np.zeros((len(push), 0))
    first = push / size
    if not tip.translates:
        return first[:, None]
    way = rigid.T @ (tip.body.M @ tip.body.translation(tip.direction))
    rest = way - (first @ way) * first
    rest -= (first @ rest) * first
    if np.linalg.norm(rest) <= _STRAIGHT * np.linalg.norm(way):
        return first[:, None]
    return np.stack([first, rest / np.linalg.norm(rest)], axis=1)


def checked_ports(name: str, tips: Any) -> tuple[ContactPoint, ...]:
    """Return one or several contact points of one body as a tuple.

    Raises
    ------
    InputError, InputTypeError
        If `tips` is empty, has other objects, or has points on different bodies.
    """
    if isinstance(tips, ContactPoint):
        return (tips,)
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
