"""The anti-oscillator model: a star of springs and masses (Fig. 2 of the paper)."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import (
    HUGE,
    PRINTED,
    ROUNDING,
    ArrayPair,
    BoolArray,
    FilePath,
    FloatArray,
    Frozen,
    InputError,
    checked,
    finite_array,
    inertia_tensor,
    instance,
    integer,
    nonnegative,
    positive,
    text,
    written_file,
)
from ..contact import ContactPoint, ContactSurface
from ..fem import Damping, Material, damping_or_none
from .body import AsWhole, Body, in_time, ways_of

# Largest m a²/I of a body with a contact at the arm a: the value of a ball on a rod of 200 times
# the ball's radius. Above this limit, the effective mass at the contact is so small that its
# vibration alone limits the time steps.
_MOST_TURNING = 1e5

# Share of the total participation (or mass) below which a mode (or an oscillator) is not excited.
_NOT_EXCITED = 1e-13


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class AOModel(Frozen):
    """Contact mass m0 on a ground spring k0, and oscillators (m, k) attached to the contact mass.

    Parameters
    ----------
    m0 : float
        Contact (residual) mass, kg, eq. (10). Zero is allowed if there are oscillators; infinite,
        without oscillators, is a fixed wall.
    k0 : float, optional
        Stiffness of the ground spring, N/m, eq. (11); 0 for a free body.
    m, k : array_like, shape (n,), optional
        Masses, kg, eq. (9), and stiffnesses, N/m, eq. (12), of the anti-oscillators, all positive.
    damping : Rayleigh or ModalDamping, optional
        Damping of the model's natural modes.
    surface : ContactSurface, optional
        Material and curvatures at the contact of a body given by numbers.
    name : str, optional
        Name in results, tables and plots.
    inertia : array_like, shape (3, 3), optional
        Tensor of inertia about the centre of mass, kg m², of a rigid body that may turn; see
        `rigid`.
    arm : array_like, shape (3,), optional
        Vector from the centre of mass to the contact, m; by default the radius of a ball.

    Attributes
    ----------
    origin : Body or None
        Model of the finite-element body from which `antioscillators` made the numbers; None for a
        model given by numbers, or a copy with other numbers.

    Raises
    ------
    InputError
        If a value is out of range or not finite, or `m` and `k` differ in length.

    Examples
    --------
    >>> model = ao.AOModel(m0=0.1, k0=1e5, m=[0.2], k=[1e6])
    >>> round(model.static_mass, 3)
    0.3
    >>> model.frequencies.round(1)  # Hz
    array([355.9])
    >>> round(float(model.receptance(0.0) * model.k0), 9)
    1.0
    """

    m0: float
    k0: float = 0.0
    m: FloatArray = field(default_factory=lambda: np.zeros(0))
    k: FloatArray = field(default_factory=lambda: np.zeros(0))
    origin: Body | None = field(default=None, init=False, repr=False)
    damping: Damping | None = None
    surface: ContactSurface | None = field(default=None, repr=False)
    name: str = ""
    inertia: FloatArray | None = field(default=None, repr=False)
    arm: FloatArray | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        set_field = object.__setattr__
        set_field(self, "m0", nonnegative("m0", self.m0, unit="kg", infinite=True))
        set_field(self, "k0", nonnegative("k0", self.k0, unit="N/m"))
        set_field(self, "damping", damping_or_none(self.damping))
        checked(self, surface=(ContactSurface, type(None)), name=text)
        for name, unit in (("m", "kg"), ("k", "N/m")):
            values = finite_array(name, getattr(self, name), shape=(None,), unit=unit).copy()
            if (values <= 0.0).any():
                worst = int(np.argmin(values))
                raise InputError(f"{name} must be positive: {name}[{worst}] is {values[worst]:g}")
            set_field(self, name, values)
        if len(self.m) != len(self.k):
            raise InputError(
                f"m and k must have the same length, got {len(self.m)} masses "
                f"and {len(self.k)} stiffnesses"
            )
        if len(self.m) == 0 and self.m0 == 0.0:
            raise InputError("m0 must be positive where there are no oscillators, got 0 kg")
        if math.isinf(self.m0) and (len(self.m) or self.k0):
            raise InputError("m0 is infinite: a fixed wall has neither oscillators nor k0")
        if self.inertia is not None:
            checked(self, inertia=_tensor_of_inertia)
        if self.arm is not None:
            checked(self, arm=partial(finite_array, shape=(3,), unit="m"))
        for name, unit in (("m0", "kg"), ("k0", "N/m"), ("m", "kg"), ("k", "N/m")):
            what = "mass" if unit == "kg" else "stiffness"
            values = np.atleast_1d(getattr(self, name))
            wrong = (values < 1.0 / HUGE) | (values > HUGE)
            wrong &= (values != 0.0) & np.isfinite(values)
            if wrong.any():
                raise InputError(
                    f"{name} must be a {what} from {1.0 / HUGE:g} to {HUGE:g} {unit}, "
                    f"got {values[wrong][0]:g}"
                )
        if self.inertia is not None and self.arm is not None and math.isfinite(self.m0):
            moments, axes = np.linalg.eigh(self.inertia)
            with np.errstate(all="ignore"):
                away = np.linalg.norm(np.cross(self.arm, axes.T), axis=1)
                share = float(np.max(self.m0 * (away / np.sqrt(moments)) ** 2))
            if not share <= _MOST_TURNING:
                raise InputError(
                    f"inertia, mass and arm: m a²/I is {share:.3g} for the contact's distance a "
                    f"from an axis of inertia I, and must be at most {_MOST_TURNING:g}; give all "
                    "of the body's inertia in kg m², or leave inertia and arm out"
                )
        super().__post_init__()

    def __repr__(self) -> str:
        parts = [repr(self.name)] if self.name else []
        if math.isinf(self.m0):
            return f"AOModel({', '.join([*parts, 'wall'])})"
        parts += [f"{self.n or 'no'} oscillators", f"{self.mass:.4g} kg"]
        return f"AOModel({', '.join([*parts, 'constrained' if self.constrained else 'free'])})"

    @property
    def n(self) -> int:
        """Number of anti-oscillators."""
        return len(self.m)

    @property
    def constrained(self) -> bool:
        """True if the body is constrained: by its ground spring, or as a wall."""
        return self.k0 > 0.0 or math.isinf(self.m0)

    @cached_property
    def static_mass(self) -> float:
        """Static mass m_st = m0 + Σ m_i, kg, eq. (10)."""
        return self.m0 + math.fsum(self.m)

    @property
    def mass(self) -> float:
        """Mass of the body, kg; the static mass if unknown, or for a model given by numbers."""
        found = None if self.origin is None else self.origin.mass
        return self.static_mass if found is None else found

    @property
    def tips(self) -> tuple[ContactPoint, ...]:
        """Contact point of the body that the model was made from; empty if given by numbers."""
        return self.modal.tips

    @cached_property
    def modal(self) -> Body:
        """The same model in its natural modes, as used in scenes."""
        return _body_of(self) if self.origin is None else self.origin

    @property
    def mass_fractions(self) -> FloatArray:
        """Masses of the oscillators relative to the static mass, m_i / m_st, shape (n,)."""
        return self.m / self.static_mass

    @property
    def frequencies(self) -> FloatArray:
        """Frequencies of the anti-oscillators √(k_i/m_i)/2π, Hz, shape (n,), in their order.

        These frequencies are the antiresonances of the body at its contact coordinate (paper,
        section 2).
        """
        return np.sqrt(self.k / self.m) / (2.0 * np.pi)

    @property
    def natural_frequencies(self) -> FloatArray:
        """Frequencies of the model's natural modes, Hz, ascending, shape (n+1,) or less.

        The frequencies are roots of the secular equation, zero for the rigid motion of a free
        model. Their number is smaller by one if the contact coordinate is massless (m0 = 0).
        Oscillators of equal frequency count as one.
        """
        return np.sqrt(self.to_modal()[0]) / (2.0 * np.pi)

    @property
    def label(self) -> str:
        """Kind of the model: "rigid", "wall", "AO(3)"."""
        if math.isinf(self.m0):
            return "wall"
        return "rigid" if self.n == 0 and self.k0 == 0.0 else f"AO({self.n})"

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency, Hz, between which the model has its body's receptance.

        See `Body.band`.
        """
        return self.modal.band

    def receptance(self, omega: npt.ArrayLike) -> Any:
        """Return the receptance at the contact coordinate, the ratio of displacement to force.

        The receptance is Σ r_j²/(ω_j² - ω² + 2iσ_jω) over the natural modes, plus the compliance of
        a massless contact. Without damping it is infinite at a resonance and, but for rounding
        errors, 0 at an antiresonance.

        Parameters
        ----------
        omega : array_like
            Angular frequency, rad/s, any shape.

        Returns
        -------
        float or ndarray
            Receptance, m/N, with the shape of `omega`; complex with damping, real without.

        Warns
        -----
        AOImpactWarning
            At frequencies outside the model's `band`.

        Examples
        --------
        >>> model = ao.AOModel(m0=0.1, k0=1e5)
        >>> round(float(model.receptance(0.0)), 9)  # m/N
        1e-05
        """
        return self.modal.receptance(omega)[..., 0, 0][()]

    @property
    def residual(self) -> float:
        """Compliance of a massless contact beyond the modes, m/N; 0 for a contact with mass.

        :meta private:
        """
        return 0.0 if self.m0 > 0.0 else 1.0 / (self.k0 + math.fsum(self.k))

    def _moved(self, omega2: FloatArray) -> FloatArray:
        """Return the coordinates λ, 1 at the contact, of modes with given ω², (n + 1, modes).

        The coordinate of oscillator i in mode j is ω_i²/(ω_i² - ω_j²).
        """
        own = self.k / self.m
        distance = np.subtract.outer(own, omega2)
        gain = own[:, None] / np.where(distance == 0.0, np.inf, distance)
        return np.vstack([np.ones((1, len(omega2))), gain])

    def truncated(self, n: int) -> AOModel:
        """Return the model of the first `n` oscillators; the others' mass joins m0, eq. (10).

        Examples
        --------
        >>> model = ao.AOModel(m0=0.1, k0=0.0, m=[0.2, 0.1], k=[1e6, 5e6])
        >>> model.truncated(1).m0
        0.2
        """
        kept = integer("n", n, low=0, high=self.n)
        if kept == self.n and self.origin is None:
            return self
        m0 = self.m0 + math.fsum(self.m[kept:])
        numbers = replace(self, m0=m0, m=self.m[:kept], k=self.k[:kept])
        if self.origin is None:
            return numbers
        of, n = self.origin, self.n + 1
        moved = self._displaced(np.column_stack([np.ones(n), np.eye(n)[:, 1 : kept + 1]]))
        return with_shapes(
            numbers,
            of.tips[0],
            moved[:, 0],
            moved[:, 1:],
            linear_solver=of.linear_solver,
            contact_time=of.contact_time,
            slow=of.slow,
            series=of if of.kind == "modal" else of.series,
        )

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return K, M and b for the n + 1 coordinates λ, the contact first.

        K has k0 + Σ k_i on the diagonal at the contact, k_i at oscillator i, and -k_i between the
        two (Fig. 2); M is diagonal; b = (1, 0, …, 0).

        Returns
        -------
        K, M : ndarrays, shape (n+1, n+1)
            Stiffness and mass matrix, N/m, kg.
        b : ndarray, shape (n+1,)
            Contact functional.

        Raises
        ------
        InputError
            For a wall of infinite mass.

        Examples
        --------
        >>> K, M, b = AOModel(m0=0.1, k0=1e6, m=[0.5], k=[2e6]).matrices()
        >>> K.tolist()
        [[3000000.0, -2000000.0], [-2000000.0, 2000000.0]]
        """
        if math.isinf(self.m0):
            raise InputError("a wall of infinite mass has no matrices")
        K = np.diag(np.concatenate([[self.k0 + math.fsum(self.k)], self.k]))
        K[0, 1:] = K[1:, 0] = -self.k
        return K, np.diag(np.concatenate([[self.m0], self.m])), np.eye(self.n + 1)[0]

    def to_json(self, path: FilePath | None = None) -> str:
        """Return the model as JSON, and write it to a file if a path is given.

        The model consists of the contact mass m0 (kg) on a ground spring k0 (N/m), and of the
        masses m_i, each attached to the contact mass by a spring k_i. Another program only needs
        n + 1 point masses that move along one line, n + 1 springs, and the contact law at m0.
        Numbers are written with all digits.

        Parameters
        ----------
        path : path, optional
            File to write.

        Returns
        -------
        str
            JSON object of ``m0``, ``k0``, ``m``, ``k``, and, if any, ``damping`` and ``name``.

        Examples
        --------
        >>> AOModel(m0=0.1, k0=1e6, m=[0.5], k=[2e6]).to_json()
        '{"m0": 0.1, "k0": 1000000.0, "m": [0.5], "k": [2000000.0]}'
        """
        content: dict[str, Any] = {"m0": self.m0, "k0": self.k0}
        content |= {"m": self.m.tolist(), "k": self.k.tolist()}
        if self.damping is not None:
            content["damping"] = asdict(self.damping)
        if self.name:
            content["name"] = self.name
        if math.isinf(self.m0):
            raise InputError("a wall of infinite mass is not written as JSON")
        written = json.dumps(content)
        if path is not None:
            with written_file(path) as file:
                file.write_text(written + "\n", encoding="utf-8")
        return written

    def expand(self, coordinates: npt.ArrayLike) -> FloatArray:
        """Return the full displacement X = λ₀ φ_st + Σ (λ_i - λ₀) Ψ_i, eq. (8).

        Parameters
        ----------
        coordinates : array_like, shape (n+1,) or (n+1, times)
            Coordinates λ, contact coordinate first, m.

        Returns
        -------
        ndarray, shape (n_dofs,) or (n_dofs, times)
            Displacements of the free dofs, in the order of the rows of K, m.

        Raises
        ------
        InputError
            If the model was given by numbers, or the shape is wrong.

        Examples
        --------
        >>> K, M = np.array([[2e6, -1e6], [-1e6, 1e6]]), np.diag([0.5, 0.5])
        >>> chain = ao.FEModel(K=K, M=M)
        >>> model = ao.antioscillators(chain.contact(dof=1), n=1)
        >>> model.expand([1e-3, 1e-3]).round(6)  # the static mode: only the ground spring deforms
        array([0.0005, 0.001 ])
        """
        if self.origin is None:
            raise InputError("expand: this model was given by numbers and has no body to expand to")
        return self.origin.body.restricted(self._displaced(in_time(coordinates, self.n + 1)))

    def _displaced(self, values: FloatArray) -> FloatArray:
        """Return the displacement of the body for coordinates λ, (n_dofs,) or (n_dofs, times)."""
        assert self.origin is not None
        # Modal coordinates are q = φᵀMλ for M-orthonormal modes φ. In the coordinates λ, M is
        # diagonal (`masses`), and φ is `_moved` times the modes' displacement at the port.
        of, masses = self.origin, np.concatenate([[self.m0], self.m])
        q = of.shape[0] * (self._moved(of.omega**2).T @ (values.T * masses).T).T
        full: FloatArray = of.displaced(q.T)
        if of.residual is not None and of.following is not None:
            rest = values[0] - of.shape[0] @ q.T
            full = full + np.multiply.outer(of.following[:, 0] / of.residual[0, 0], rest)
        return full

    def to_modal(self) -> ArrayPair:
        """Return the model's natural modes by the secular equation.

        Returns
        -------
        omega2 : ndarray, shape (modes,)
            Squares of the natural frequencies, (rad/s)², ascending.
        participation : ndarray, shape (modes,)
            Participation factors r_j = bᵀφ_j of the mass-normalised modes, 1/√kg, so that the
            receptance is Σ r_j²/(ω_j² - ω²).

        Raises
        ------
        InputError
            For a wall, which has no modes.

        Examples
        --------
        >>> model = ao.AOModel(m0=0.1, k0=1e5)
        >>> omega2, participation = model.to_modal()
        >>> round(float(omega2[0]), 6), round(float(participation[0] ** 2), 6)  # k0/m0, 1/m0
        (1000000.0, 10.0)
        """
        if math.isinf(self.m0):
            raise InputError("a wall of infinite mass has no natural modes")
        m, k = _merge_equal_frequencies(self.m, self.k)
        omega2, participation, work = np.empty(len(m) + 1), np.empty(len(m) + 1), np.empty(len(m))
        count = _core.star_to_modal(self.m0, self.k0, m, k, omega2, participation, work)
        return omega2[:count], participation[:count]


def _body_of(numbers: AOModel) -> Body:
    """Return the body of given numbers in natural modes, each scaled to 1 at the contact.

    With this scale the masses can differ by any factor. A wall has one mode that no force moves.
    """
    made: dict[str, Any] = {"kind": numbers.label.split("(")[0], "n": numbers.n, "numbers": numbers}
    wall = math.isinf(numbers.m0)
    omega2, participation = (np.zeros(1),) * 2 if wall else numbers.to_modal()
    push = participation**2
    if numbers.k0:
        masses = np.concatenate([[numbers.m0], numbers.m])
        centre = (masses / numbers.static_mass) @ numbers._moved(omega2)
        # The weight is 0: the supports, and so the deflection under it, are not known.
        as_whole = AsWhole(centre, push * numbers.k0 / omega2, np.zeros(len(omega2)))
    else:
        # Exact values are set: rounding errors would press bodies that fall side by side on each
        # other.
        rigid = np.where(omega2 == 0.0, 1.0, 0.0)
        as_whole = AsWhole(rigid, rigid, np.zeros(1) if wall else rigid)
    return Body(
        omega=np.sqrt(omega2),
        shape=np.ones((1, len(omega2))),
        push=push[None],
        inertia=np.zeros(1) if wall else 1.0 / push,
        residual=np.array([[numbers.residual]]) if numbers.m0 == 0.0 else None,
        as_whole=as_whole,
        **made,
    )


def turning(numbers: AOModel, axes: FloatArray, sides: Sequence[float]) -> Body:
    """Return a rigid body or a wall in three directions, with three ports per contact point.

    Its modes are three translations and, if it may turn, rotations about its principal axes.

    Parameters
    ----------
    numbers : AOModel
        Model without oscillators.
    axes : ndarray, shape (3, 3)
        Direction of travel and two tangents, as rows.
    sides : sequence of float
        Side of each contact point: 1 on the far side along the direction of travel, -1 on the near
        side.
    """
    arm, surface = numbers.arm, numbers.surface
    arms = np.zeros((len(sides), 3)) if arm is None else np.tile(arm, (len(sides), 1))
    if arm is None and surface is not None and numbers.inertia is not None:
        arms = np.outer(sides, abs(surface.radii[0]) * axes[0])
    axes, arms = np.tile(axes, (len(sides), 1)), np.repeat(arms, 3, 0)
    wall, turns = math.isinf(numbers.m0), numbers.inertia is not None
    moments, principal = np.linalg.eigh(np.eye(3) if numbers.inertia is None else numbers.inertia)
    shape = np.hstack([axes, np.cross(arms, axes) @ principal])
    inertia = np.concatenate([np.full(3, 0.0 if wall else numbers.m0), moments])
    velocity = np.zeros((6, 6))
    velocity[:3, :3], velocity[3:, 3:] = np.eye(3), principal
    kept = slice(6 if turns and not wall else 3)
    shape, inertia, velocity = shape[:, kept].copy(), inertia[kept], velocity[:, kept]
    centre = velocity[:3].T @ axes[0]
    weight = np.zeros_like(inertia) if wall else centre
    return Body(
        kind="wall" if wall else "rigid",
        n=0,
        omega=np.zeros(len(inertia)),
        shape=shape,
        push=np.zeros_like(shape) if wall else shape / inertia,
        inertia=inertia,
        as_whole=AsWhole(centre, centre, weight, velocity, velocity.T),
        numbers=numbers,
    )


def star_of(body: Body) -> AOModel:
    """Return the anti-oscillator model with the receptance Σ r_j²/(ω_j² - ω²) of a body's modes.

    The secular equation gives its antiresonances. Modes of equal frequency are joined, and modes
    that the contact does not excite are left out.
    """
    if body.numbers is not None:
        return body.numbers
    if body.ports > 1:
        raise InputError(f"star: {body!r} has several contact points, and an AO model has one")
    moved = excited(body)
    omega2, weight = body.omega[moved] ** 2, body.shape[0, moved] ** 2
    starts = np.flatnonzero(np.diff(omega2, prepend=-np.inf) > PRINTED * omega2)
    omega2, weight = omega2[starts], np.add.reduceat(weight, starts)
    m, k = np.empty(len(omega2) - 1), np.empty(len(omega2) - 1)
    m0, k0 = _core.star_from_modal(omega2, weight, m, k)
    kept = m > _NOT_EXCITED * (m0 + m.sum())
    return of_body(AOModel(m0=m0, k0=k0, m=m[kept], k=k[kept]), body)


def of_body(numbers: AOModel, body: Body) -> AOModel:
    """Return an anti-oscillator model with the damping and name of a body, its `origin`."""
    found = replace(numbers, damping=body.damping, name=body.name)
    object.__setattr__(found, "origin", body)
    return found


def excited(body: Body) -> BoolArray:
    """Return True for each mode that an impact on a body's first port excites.

    Raises
    ------
    InputError
        If the port excites no mode.
    """
    there, on = body.spanning, body.coordinates
    # The rounding error of bᵀφ depends on the sizes of the vectors' contributions to φ, even if the
    # contributions cancel.
    size2 = np.einsum("ij,ij->j", there, there)
    size2 = size2 if on is None else size2 @ on**2
    weight = body.shape[0] ** 2
    rounding2 = (ROUNDING * np.linalg.norm(body.tips[0].b)) ** 2 * size2
    found = (weight > _NOT_EXCITED * weight.sum()) & (weight > rounding2)
    if not found.any():
        raise InputError(f"none of the {len(weight)} modes moves the contact: take a larger n")
    return np.asarray(found)


def with_shapes(
    numbers: AOModel, tip: ContactPoint, static: FloatArray, shapes: FloatArray, **how: Any
) -> AOModel:
    """Return the anti-oscillator model of a body, with natural modes made from its shapes.

    Parameters
    ----------
    numbers : AOModel
        Masses and stiffnesses of the model.
    tip : ContactPoint
    static : ndarray, shape (n_dofs,)
        Static mode φ_st, eqs. (2), (3).
    shapes : ndarray, shape (n_dofs, n)
        Shapes Ψ_i = c_i φ_i of the anti-oscillators, eq. (8).
    **how
        Further attributes of `Body`.
    """
    omega2, r = numbers.to_modal()
    still = tip.body.rigid_modes
    within = still.T @ (tip.body.M @ static) * (numbers.k0 == 0.0)
    others = ways_of(tip, within, still)[:, 1:]
    coordinates = numbers._moved(omega2)
    coordinates[1:] -= 1.0
    count, n = len(r), numbers.n
    placed = np.zeros((n + 1 + still.shape[1], others.shape[1] + count))
    placed[n + 1 : n + 1 + len(others), : others.shape[1]] = others
    placed[: n + 1, others.shape[1] :] = coordinates * r
    shape = np.concatenate([np.zeros(others.shape[1]), r])[None]
    follow = None
    if numbers.m0 == 0.0:  # only the contact follows a force at once
        follow = numbers.residual * np.concatenate([[1.0], -np.ones(n), np.zeros(len(still.T))])
    body = Body(
        kind="AO" if n or numbers.k0 else "rigid",
        n=n,
        omega=np.concatenate([np.zeros(others.shape[1]), np.sqrt(omega2)]),
        shape=shape,
        push=shape,
        inertia=np.ones(shape.shape[1]),
        tips=(tip,),
        residual=None if follow is None else np.array([[numbers.residual]]),
        vectors=np.column_stack([static, shapes, still]),
        coordinates=placed,
        follow=None if follow is None else follow[:, None],
        oscillators=numbers,
        **how,
    )
    return body.star


def _tensor_of_inertia(name: str, value: Any) -> FloatArray:
    """Return the inertia tensor, kg m², given as a tensor, three moments or one for all axes."""
    given = finite_array(name, value, unit="kg m²")
    tensor = inertia_tensor(name, given if given.ndim else np.full(3, given), most=HUGE)
    if np.linalg.eigvalsh(tensor)[0] <= 0.0:
        raise InputError(f"{name} must be positive about every axis, got {given.tolist()} kg m²")
    return np.ascontiguousarray(tensor)


def _merge_equal_frequencies(m: FloatArray, k: FloatArray) -> ArrayPair:
    """Sort oscillators by frequency, and join those of equal frequency by adding their m and k."""
    order = np.argsort(k / m, kind="stable")
    m, k = m[order], k[order]
    omega2 = k / m
    starts = np.flatnonzero(np.diff(omega2, prepend=-np.inf) > ROUNDING * omega2)
    if len(starts) == len(m):
        return np.ascontiguousarray(m), np.ascontiguousarray(k)
    return np.add.reduceat(m, starts), np.add.reduceat(k, starts)


def rigid(
    mass: float,
    *,
    inertia: npt.ArrayLike | None = None,
    arm: npt.ArrayLike | None = None,
    name: str = "",
) -> AOModel:
    """Return a rigid mass: an anti-oscillator model without oscillators.

    Parameters
    ----------
    mass : float
        Mass, kg, positive; ``math.inf`` is a fixed wall.
    inertia : float or array_like, shape (3,) or (3, 3), optional
        Tensor of inertia about the centre of mass, or moments about the axes, kg m². By default the
        body is guided and does not turn.
    arm : array_like, shape (3,), optional
        Vector from the centre of mass to the contact, m; by default zero. With an arm, an oblique
        impact turns the body; impacts along one direction of travel ignore the arm.
    name : str, optional
        Name in results, tables and plots.

    Examples
    --------
    >>> rigid(0.03)
    AOModel(no oscillators, 0.03 kg, free)
    >>> rod = rigid(0.03, inertia=(2e-6, 2e-6, 1e-7), arm=(0, 0, -0.02))
    """
    checked_mass = positive("mass", mass, unit="kg", infinite=True)
    if arm is not None and inertia is None:
        raise InputError("arm: a body without inertia= does not turn; give its tensor of inertia")
    made: dict[str, Any] = {"inertia": inertia, "arm": arm}
    return AOModel(m0=checked_mass, name=name, **made)


def ball(
    radius: float, material: Material, *, mass: float | None = None, name: str = ""
) -> AOModel:
    """Return a rigid ball with its surface, from which a contact law can be derived.

    Parameters
    ----------
    radius : float
        Radius r, m. The mass is 4/3 π r³ ρ, the moment of inertia 2/5 of the mass times r².
    material : Material
    mass : float, optional
        Mass, kg, of a guided body with a round nose instead of the ball, such as the tup of a drop
        tower with its carriage. With friction it moves sideways, but it does not turn.
    name : str, optional
        Name in results, tables and plots.

    Examples
    --------
    >>> ball(0.01, Material(E=210e9, nu=0.3, rho=7800))
    AOModel(no oscillators, 0.03267 kg, free)
    >>> ball(0.008, Material(E=210e9, nu=0.3, rho=7800), mass=5.0)  # of a drop tower
    AOModel(no oscillators, 5 kg, free)
    """
    r = positive("radius", radius, unit="m")
    checked_material = instance("material", material, Material)
    own = None if mass is None else positive("mass", mass, unit="kg")
    try:
        whole, curvature = 4.0 / 3.0 * math.pi * r**3 * checked_material.rho, 1.0 / r
        round_one = ContactSurface(checked_material, (curvature, curvature))
        inertia = np.diag(np.full(3, 0.4 * whole * r * r))
        solid = AOModel(m0=whole, surface=round_one, name=name, inertia=inertia)
    except (InputError, OverflowError) as error:
        raise InputError(f"radius={r:g} m is no radius of a ball (is it in metres?)") from error
    return solid if own is None else AOModel(m0=own, surface=round_one, name=name)


def wall(material: Material, *, name: str = "") -> AOModel:
    """Return a fixed half-space; its outward normal is z.

    Parameters
    ----------
    material : Material
    name : str, optional
        Name in results, tables and plots.

    Examples
    --------
    >>> glass, steel = Material(E=70e9, nu=0.25, rho=2500), Material(E=210e9, nu=0.3, rho=7800)
    >>> hit = ao.simulate(ao.ball(0.01, steel), ao.wall(glass), (0, 0.5, -1.0), friction=0.2)
    >>> hit.projectile.final_velocity.round(3)
    array([0.   , 0.299, 1.   ])
    """
    flat = ContactSurface(instance("material", material, Material), (0.0, 0.0))
    return AOModel(m0=math.inf, surface=flat, name=name)
