"""The anti-oscillator model: a star of springs and masses (Fig. 2 of the paper)."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import (
    HUGE,
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
from ..fem import (
    ContactCompliance,
    ContactPoint,
    ContactSurface,
    Damping,
    Material,
    Patch,
    damping_or_none,
)
from .bodymodel import ReducedModel
from .modalbody import ModalBody, Pull, RigidMotion, oscillator_gain
from .origin import Origin
from .recovery import GeneralizedCoordinates

# Masses, kg, and stiffnesses, N/m, beside each other: their squares and ratios are numbers.
_LARGEST, _LEAST = HUGE, 1.0 / HUGE

# Largest m a²/I of a body touched at an arm a: that of a ball on a rod of 200 times its radius. The
# end of the arm has so little mass then that steps follow its vibration alone.
_MOST_TURNING = 1e5

# Masses of a rigid body, kg, whose weight, momentum and energy are numbers.
_HEAVIEST, _LIGHTEST = 1e200, 1e-200

# ω² that differ by no more than their rounding, two units in the last place, are one.
_ONE_FREQUENCY = 4e-16


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class AOModel(Frozen, ReducedModel):
    """Contact mass m0 on a ground spring k0, and oscillators (m, k) attached to the contact mass.

    Parameters
    ----------
    m0 : float
        Contact (residual) mass, kg, eq. (10). Zero is allowed if there are oscillators; infinite,
        without oscillators, is a fixed wall.
    k0 : float, optional
        Ground spring, N/m, eq. (11); 0 for a free body.
    m, k : array_like, shape (n,), optional
        Masses, kg, eq. (9), and stiffnesses, N/m, eq. (12), of the anti-oscillators, all positive.
    origin : Origin, optional
        The body that the numbers came from; set by `antioscillators` and `modal`.
    damping : Rayleigh or ModalDamping, optional
        Damping of the model's natural modes.
    surface : ContactSurface, optional
        Material and curvatures at the contact; by default those of `origin`.
    name : str, optional
        Name in results, tables and plots; by default that of `origin`.
    inertia : array_like, shape (3, 3), optional
        Tensor of inertia about the centre of mass, kg m², of a rigid body that may turn; see
        `rigid`.
    arm : array_like, shape (3,), optional
        From the centre of mass to where it is touched, m; by default the radius of a ball.

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
    >>> float(model.receptance(0.0)) == 1 / model.k0
    True
    """

    m0: float
    k0: float = 0.0
    m: FloatArray = field(default_factory=lambda: np.zeros(0))
    k: FloatArray = field(default_factory=lambda: np.zeros(0))
    origin: Origin | None = field(default=None, repr=False)
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
        checked(self, origin=(Origin, type(None)), surface=(ContactSurface, type(None)), name=text)
        if not self.name and self.origin is not None:
            set_field(self, "name", self.origin.tip.body.name)
        for name, unit in (("m", "kg"), ("k", "N/m")):
            values = finite_array(name, getattr(self, name), ndim=1, unit=unit).copy()
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
        self._check_reach()
        self._check_turning()
        super().__post_init__()

    def _check_reach(self) -> None:
        """Refuse masses and springs whose squares or ratios leave the range of doubles."""
        if not len(self.m) and not self.k0:
            if math.isfinite(self.m0) and not _LIGHTEST <= self.m0 <= _HEAVIEST:
                raise InputError(
                    f"m0, the mass, must be from {_LIGHTEST:g} to {_HEAVIEST:g} kg to be "
                    f"computed with, got {self.m0:g}; math.inf is a wall"
                )
            return
        for name, unit in (("m0", "kg"), ("k0", "N/m"), ("m", "kg"), ("k", "N/m")):
            values = np.atleast_1d(getattr(self, name))
            wrong = (values != 0.0) & ((values < _LEAST) | (values > _LARGEST))
            if wrong.any():
                value = float(values[wrong][0])
                cure = "; a contact without mass is m0 = 0" if name == "m0" and value < 1.0 else ""
                raise InputError(
                    f"{name} must be from {_LEAST:g} to {_LARGEST:g} {unit} to be computed with, "
                    f"got {value:g}{cure}"
                )

    def _check_turning(self) -> None:
        """Refuse an inertia with which the end of the arm has next to no mass along the surface."""
        if self.inertia is None or self.arm is None or math.isinf(self.m0):
            return
        size = float(np.abs(self.arm).max()) or 1.0
        scale = float(np.abs(self.inertia).max())
        moments, axes = np.linalg.eigh(self.inertia / scale)
        across = np.linalg.norm(
            np.cross(self.arm / size, axes.T), axis=1
        )  # of each axis, over size
        moments = np.maximum(moments, np.finfo(float).tiny)
        with np.errstate(over="ignore"):
            roots = across / np.sqrt(moments) * (math.sqrt(self.m0) / math.sqrt(scale) * size)
            share = float(np.square(roots).max())
        if share > _MOST_TURNING:
            raise InputError(
                f"inertia, mass and arm: m a²/I is {share:.3g} about an axis from which the arm "
                f"leads a away, and at most {_MOST_TURNING:g} is computed with; give all of the "
                "body's inertia in kg m², or leave inertia and arm out"
            )

    def __repr__(self) -> str:
        return described(self, f"{self.n} oscillators" if self.n else "no oscillators")

    def turning(self, axes: FloatArray, sides: Sequence[float]) -> TurningBody:
        """Return the rigid body with its motion in three directions.

        Parameters
        ----------
        axes : ndarray, shape (3, 3)
            Direction of travel and two tangents, as rows.
        sides : sequence of float
            For each place of contact 1 where it is on the far side along the direction of travel,
            -1 where it is on the near side.

        :meta private:
        """
        arm = np.zeros(3) if self.arm is None else self.arm
        arms = [
            arm
            if self.arm is not None or self.surface is None or self.inertia is None
            else side * abs(self.surface.radii[0]) * axes[0]
            for side in sides
        ]
        given = {one.name: getattr(self, one.name) for one in fields(AOModel)}
        return TurningBody(**given, axes=np.tile(axes, (len(arms), 1)), arms=np.repeat(arms, 3, 0))

    @property
    def n(self) -> int:
        """Number of anti-oscillators."""
        return len(self.m)

    @property
    def dofs(self) -> int:
        """Number of coordinates λ: the contact's and the oscillators'; 0 of a wall."""
        return 0 if math.isinf(self.m0) else self.n + 1

    @property
    def constrained(self) -> bool:
        """True if the body is constrained: by its ground spring, or as a wall."""
        return self.k0 > 0.0 or math.isinf(self.m0)

    @property
    def weightless(self) -> bool:
        """True if its weight is not known: constrained, and given by numbers or without nodes."""
        known = self.origin is not None and self.origin.centre_known
        return self.constrained and not known and not math.isinf(self.m0)

    @cached_property
    def static_mass(self) -> float:
        """m_st = m0 + Σ m_i, kg, eq. (10)."""
        return self.m0 + math.fsum(self.m)

    @property
    def mass(self) -> float:
        """Mass of the body, kg; where that is not known, or there is no body, its static mass."""
        return self.static_mass if self.origin is None else self.origin.mass

    @property
    def most_mass(self) -> float:
        """The static mass; infinite for a constrained body.

        :meta private:
        """
        return math.inf if self.constrained else self.static_mass

    @property
    def centre_known(self) -> bool:
        """True if mass and centre of mass are known: not of a body of K and M hit off its centre.

        A model given by numbers is its own body.
        """
        return self.origin is None or self.origin.centre_known

    @property
    def patch(self) -> Patch | None:
        """The patch over which the body is touched; None for a node, or without a body."""
        found: Patch | None = None if self.origin is None else self.origin.tip.patch
        return found

    def extraction_at(self, port: int = 0) -> ContactCompliance | None:
        """Return the compliances at the contact; None of a rigid body, and if they are not known.

        :meta private:
        """
        if self.n == 0 and self.k0 == 0.0 and not self.truncates:
            return None
        if self.origin is not None and self.origin.series is not None:
            of_series: ContactCompliance | None = self.origin.series.extraction_at(port)
            return of_series
        return super().extraction_at(port)

    @property
    def truncates(self) -> bool:
        """True for the first natural modes of a body.

        :meta private:
        """
        return self.origin is not None and self.origin.label == "modal"

    @property
    def contact_surface(self) -> ContactSurface | None:
        """Material and curvatures at the contact; None where they are not known."""
        if self.surface is not None or self.origin is None:
            return self.surface
        found: ContactSurface | None = self.origin.tip.contact_surface
        return found

    def surface_at(self, port: int = 0) -> ContactSurface | None:
        """Return `contact_surface`: there is one contact point.

        :meta private:
        """
        return self.contact_surface

    @property
    def mass_fractions(self) -> FloatArray:
        """m_i / m_st, shape (n,)."""
        return self.m / self.static_mass

    @property
    def frequencies(self) -> FloatArray:
        """Frequencies of the anti-oscillators √(k_i/m_i)/2π, Hz, shape (n,), in their order.

        They are antiresonances of the body at its contact coordinate (section 2).
        """
        return np.sqrt(self.k / self.m) / (2.0 * np.pi)

    @property
    def natural_frequencies(self) -> FloatArray:
        """Frequencies of the model's own natural modes, Hz, ascending, shape (n+1,) or less.

        From the secular equation; zero for the rigid motion of a free model. A massless contact
        coordinate (m0 = 0) has no mode of its own, and oscillators of equal frequency share one.
        """
        return np.sqrt(self.to_modal()[0]) / (2.0 * np.pi)

    @property
    def label(self) -> str:
        """Kind of the model: "rigid", "wall", "AO(3)", "modal(40)"."""
        if math.isinf(self.m0):
            return "wall"
        if self.origin is not None and self.origin.label == "modal":
            return f"modal({self.n + 1})"
        if self.n == 0 and self.k0 == 0.0:
            return "rigid"
        return f"AO({self.n})"

    @cached_property
    def centre_weights(self) -> FloatArray:
        """Weights w of the coordinates λ in the centre of mass's displacement, shape (n+1,).

        The contact coordinate first. Of a model given by numbers: the masses over their sum.
        """
        if math.isinf(self.m0):
            weights = np.ones(1)
        elif self.origin is None:
            weights = np.concatenate([[self.m0], self.m]) / self.static_mass
        else:
            weights = self.weights(self.origin.centre)
        weights.flags.writeable = False
        return weights

    def weights(self, functional: FloatArray) -> FloatArray:
        """Return w, shape (n+1,), with functionalᵀX = w λ: a place's share in the coordinates.

        Parameters
        ----------
        functional : ndarray, shape (n_dofs,)

        Raises
        ------
        InputError
            If the model was given by numbers.

        :meta private:
        """
        if self.origin is None:
            raise InputError("weights: this model was given by numbers and has no body")
        dofs = self.origin.tip.body.n_dofs
        along = finite_array("functional", functional, shape=(dofs,))
        of_static, of_oscillators = self.origin.observed_by(along)
        return np.concatenate([[of_static - of_oscillators.sum()], of_oscillators])

    @property
    def contact_points(self) -> tuple[ContactPoint, ...]:
        """The contact point on the body that the model was made from; none if given by numbers."""
        return () if self.origin is None else (self.origin.tip,)

    @property
    def contact_time(self) -> float | None:
        """The contact's duration that the model was fitted to, s; None where it fits any."""
        return None if self.origin is None else self.origin.contact_time

    @property
    def linear_solver(self) -> str:
        """The linear solver that the model was made with; empty where none was needed."""
        return "" if self.origin is None else self.origin.solver

    def deflection(self, s: float, port: int = 0) -> FloatArray:
        """Return the body's displacement under a unit force at the frequency i s, shape (n_dofs,).

        :meta private:
        """
        follow = self.k / (self.k + s**2 * self.m)
        force = self.k0 + s**2 * self.m0 + float(self.k @ (1.0 - follow))
        return self.expand(np.concatenate([[1.0], follow]) / force)

    def receptance(self, omega: npt.ArrayLike) -> Any:
        """Return displacement over force at the contact coordinate.

        Without damping 1/(k0 - ω² m0 - Σ m_i ω² ω_i²/(ω_i² - ω²)): infinite at a resonance, 0 at an
        antiresonance. With damping Σ r_j²/(ω_j² - ω² + 2iσ_jω) over the natural modes, and what
        compliance a massless contact leaves.

        Parameters
        ----------
        omega : array_like
            Angular frequency, rad/s, any shape.

        Returns
        -------
        float or ndarray
            m/N, of the shape of `omega`; complex where there is damping, real without.

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
        frequency = finite_array("omega", omega, unit="rad/s")
        self._warn_outside_band(frequency)
        if self.damping is not None and not math.isinf(self.m0):
            return self._damped_receptance(self.damping, frequency)
        result = np.empty(frequency.shape)
        _core.star_receptance(self.m0, self.k0, self.m, self.k, frequency, result)
        return result if result.ndim else float(result)

    def _damped_receptance(self, damping: Damping, frequency: FloatArray) -> Any:
        omega2, participation = self.to_modal()
        omega = np.sqrt(omega2)
        real, imaginary = np.empty(frequency.shape), np.empty(frequency.shape)
        weight, decay = participation**2, damping.decay(omega)
        _core.modal_receptance(omega, decay, weight, self.residual, frequency, real, imaginary)
        result = real + 1j * imaginary
        return result if result.ndim else complex(result)

    def coordinates(self, gravity: Pull = 0.0) -> GeneralizedCoordinates | None:
        """Return X = (φ_st - Σ Ψ_i) λ₀ + Σ Ψ_i λ_i, eq. (8); None of a model given by numbers.

        :meta private:
        """
        origin = self.origin
        if origin is None:
            return None
        loads = origin.tip.b[:, None]
        if gravity:
            weight = 0.0 if self.weightless else gravity * origin.mass
            loads = np.column_stack([loads, weight * origin.centre])
        stiffness = np.diag(np.concatenate([[self.k0 + self.k.sum()], self.k]))
        stiffness[0, 1:] = stiffness[1:, 0] = -self.k
        basis = np.column_stack([origin.static_mode - origin.shapes.sum(axis=1), origin.shapes])
        mass = np.concatenate([[self.m0], self.m])
        return GeneralizedCoordinates(origin.tip.body, basis, mass, stiffness, loads)

    @property
    def omitted_translation(self) -> FloatArray | None:
        """The motion of a free body struck off its centre beyond its static mode, eq. (3).

        :meta private:
        """
        origin = self.origin
        if origin is None or not origin.translates:
            return None
        whole: FloatArray = origin.tip.body.translation(origin.tip.direction)
        return whole - origin.static_mode

    @cached_property
    def _reversed(self) -> AOModel:
        origin = self.origin
        return self if origin is None else replace(self, origin=origin.reversed())

    @property
    def omitted(self) -> tuple[float, float]:
        """A free body struck off its centre also turns, which its AO model does not contain.

        :meta private:
        """
        if self.origin is None or not self.origin.translates:
            return 0.0, 0.0
        return 1.0 - float(self.centre_weights.sum()), self.mass - self.static_mass

    @property
    def massless(self) -> bool:
        """True if the contact has no mass.

        :meta private:
        """
        return self.m0 == 0.0

    @property
    def residual(self) -> float:
        """Compliance that no mode has, m/N: where the contact has no mass.

        :meta private:
        """
        return 0.0 if self.m0 > 0.0 else 1.0 / (self.k0 + math.fsum(self.k))

    @cached_property
    def modal(self) -> ModalBody:
        """The model in its natural modes; a wall has one that no force moves.

        :meta private:
        """
        if math.isinf(self.m0):
            one, still = np.ones(1), np.zeros(1)
            return ModalBody(
                omega=still,
                decay=None,
                shape=np.ones((1, 1)),
                push=np.zeros((1, 1)),
                residual=None,
                weight=still,
                inertia=still,
                centre=one,
                centre_residual=None,
                moving=one,
                antiresonance=self.k,
            )
        omega2, participation = self.to_modal()
        omega, push, weights = np.sqrt(omega2), participation**2, self.centre_weights
        antiresonance = self.k / self.m
        if self.constrained:
            centre = weights[0] + weights[1:] @ oscillator_gain(antiresonance, omega)
            moving = push * self.k0 / omega**2
            # Its own weight acts on a star's coordinates by their share in the centre of mass. The
            # supports of one given by numbers are not known, so neither is its deflection.
            weight = np.zeros(len(omega)) if self.weightless else self.mass * push * centre
        else:  # elastic modes do not move the centre of mass
            centre = np.where(omega == 0.0, weights.sum(), 0.0)
            # A free star falls as a whole: exactly, or bodies that fall side by side would press
            # on each other by rounding.
            weight = moving = np.where(omega == 0.0, 1.0, 0.0)
        by_force = np.array([weights[0] * self.residual]) if self.constrained else np.zeros(1)
        return ModalBody(
            omega=omega,
            decay=None if self.damping is None else np.ascontiguousarray(self.damping.decay(omega)),
            shape=np.ones((1, len(omega))),
            push=push[None, :],
            residual=np.array([[self.residual]]) if self.massless else None,
            weight=weight,
            inertia=1.0 / push,
            centre=np.ascontiguousarray(centre),
            centre_residual=by_force if self.massless else None,
            moving=moving,
            antiresonance=antiresonance,
        )

    def turned(self, ports: Sequence[int]) -> AOModel:
        """Return the same model with its body's direction of travel the other way round.

        :meta private:
        """
        return self._reversed if ports else self

    def stiffened(self, factor: float) -> AOModel:
        """Return the model with all its springs stiffer by a factor.

        :meta private:
        """
        made: dict[float, AOModel] = self.kept.setdefault("stiffened", {})
        if factor not in made:
            made[factor] = replace(self, k0=factor * self.k0, k=factor * self.k)
        return made[factor]

    @cached_property
    def multiplied_out(self) -> AOModel:
        """The same model, with shapes of its own: see `Origin.vectors`.

        :meta private:
        """
        if self.origin is None or self.origin.vectors is None:
            return self
        return replace(self, origin=self.origin.multiplied_out())

    def truncated(self, n: int) -> AOModel:
        """Return the model of the first `n` oscillators; the others' mass joins m0, eq. (10).

        Examples
        --------
        >>> model = ao.AOModel(m0=0.1, k0=0.0, m=[0.2, 0.1], k=[1e6, 5e6])
        >>> model.truncated(1).m0
        0.2
        """
        kept = integer("n", n, low=0, high=self.n)
        origin = self.origin
        if origin is not None:
            series = self if self.truncates else origin.series
            oscillators = origin.oscillators[:, :kept]
            origin = replace(origin, label="AO", oscillators=oscillators, series=series)
        elif kept == self.n:
            return self
        return AOModel(
            m0=self.m0 + math.fsum(self.m[kept:]),
            k0=self.k0,
            m=self.m[:kept],
            k=self.k[:kept],
            origin=origin,
            damping=self.damping,
            surface=self.surface,
            name=self.name,
        )

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return K, M and b of the n + 1 coordinates λ, the contact first.

        K has k0 + Σ k_i at the contact, k_i on the diagonal and -k_i between them (Fig. 2); M is
        diagonal; b = (1, 0, …, 0).

        Returns
        -------
        K, M : ndarrays, shape (n+1, n+1)
            N/m, kg.
        b : ndarray, shape (n+1,)

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

    def to_json(self, path: str | os.PathLike[str] | None = None) -> str:
        """Return the model as JSON, and write it where a path is given.

        The model is four things: the contact mass m0 (kg) on a ground spring k0 (N/m), and on it,
        each by a spring k_i, the masses m_i. That is all that another program needs: n + 1 point
        masses that move along one line, n + 1 springs, and the contact's law at the first. Numbers
        have all their digits.

        Parameters
        ----------
        path : path, optional

        Returns
        -------
        str
            An object of ``m0``, ``k0``, ``m``, ``k``, and, if any, ``damping`` and ``name``.

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
        """Return the full displacement of given coordinates λ, eq. (8).

        X = λ₀ φ_st + Σ (λ_i - λ₀) Ψ_i.

        Parameters
        ----------
        coordinates : array_like, shape (n+1,) or (n+1, times)
            λ, contact coordinate first, m.

        Returns
        -------
        ndarray, shape (n_dofs,) or (n_dofs, times)
            On the free dofs, in the order of the rows of K.

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
        values = finite_array("coordinates", coordinates, unit="m")
        if values.ndim not in (1, 2) or values.shape[0] != self.n + 1:
            raise InputError(
                f"coordinates must have shape ({self.n + 1},) or ({self.n + 1}, times), "
                f"got {values.shape}"
            )
        full: FloatArray = np.multiply.outer(self.origin.static_mode, values[0])
        full += self.origin.shapes @ (values[1:] - values[0])
        return full

    def to_modal(self) -> tuple[FloatArray, FloatArray]:
        """Return the model's natural modes by the secular equation.

        Returns
        -------
        omega2 : ndarray, shape (modes,)
            ω², (rad/s)², ascending.
        participation : ndarray, shape (modes,)
            r_j = bᵀφ_j of the mass-normalised modes, 1/√kg, so that the receptance is
            Σ r_j²/(ω_j² - ω²).

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


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class TurningBody(AOModel):
    """A rigid body or a wall in three directions: ports at places of it, along given axes.

    Attributes
    ----------
    axes, arms : ndarrays, shape (p, 3)
        Direction of each port, and where it is from the centre of mass, m.
    """

    axes: FloatArray
    arms: FloatArray

    @property
    def ports(self) -> int:
        """Three for each place of contact.

        :meta private:
        """
        return len(self.axes)

    @property
    def places(self) -> int:
        """Number of places of contact: one, for all ports.

        :meta private:
        """
        return 1

    @cached_property
    def modal(self) -> ModalBody:
        """Three translations, and three rotations about the principal axes if it may turn.

        :meta private:
        """
        wall, turns = math.isinf(self.m0), self.inertia is not None
        moments, principal = np.linalg.eigh(np.eye(3) if self.inertia is None else self.inertia)
        shape = np.hstack([self.axes, np.cross(self.arms, self.axes) @ principal])
        inertia = np.concatenate([np.full(3, 0.0 if wall else self.m0), moments])
        velocity = np.zeros((6, 6))
        velocity[:3, :3], velocity[3:, 3:] = np.eye(3), principal
        kept = slice(6 if turns and not wall else 3)
        shape, inertia, velocity = shape[:, kept].copy(), inertia[kept], velocity[:, kept]
        centre = velocity[:3].T @ self.axes[0]
        return ModalBody(
            omega=np.zeros(len(inertia)),
            decay=None,
            shape=shape,
            push=np.zeros_like(shape) if wall else shape / inertia,
            residual=None,
            weight=np.zeros_like(inertia) if wall else centre,
            inertia=inertia,
            centre=centre,
            centre_residual=None,
            moving=centre,
            rigid=RigidMotion(velocity, velocity.T),
        )


def _tensor_of_inertia(name: str, value: Any) -> FloatArray:
    """Return a tensor of inertia, kg m²: of one number for all axes, three moments, or itself."""
    given = finite_array(name, value, unit="kg m²")
    tensor = inertia_tensor(name, given if given.ndim else np.full(3, given), most=HUGE)
    if np.linalg.eigvalsh(tensor)[0] <= 0.0:
        raise InputError(f"{name} must be positive about every axis, got {given.tolist()} kg m²")
    return np.ascontiguousarray(tensor)


def _merge_equal_frequencies(m: FloatArray, k: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sort by frequency; oscillators of one frequency move as one: their masses add up."""
    order = np.argsort(k / m, kind="stable")
    m, k = m[order], k[order]
    omega2 = k / m
    starts = np.flatnonzero(np.diff(omega2, prepend=-np.inf) > _ONE_FREQUENCY * omega2)
    if len(starts) == len(m):
        return np.ascontiguousarray(m), np.ascontiguousarray(k)
    return np.add.reduceat(m, starts), np.add.reduceat(k, starts)


def described(model: Any, size: str) -> str:
    """Return what a model is in one line: name, size, mass, whether supports constrain it."""
    mass = model.mass
    parts = [repr(model.name)] if model.name else []
    if mass is not None and math.isinf(mass):
        parts.append("wall")
    else:
        parts += [size, "mass not known" if mass is None else f"{mass:.4g} kg"]
        parts.append("constrained" if model.constrained else "free")
    return f"{type(model).__name__}({', '.join(parts)})"


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
        kg, positive; ``math.inf`` is a fixed wall.
    inertia : float or array_like, shape (3,) or (3, 3), optional
        Tensor of inertia about the centre of mass, kg m², or its moments about the axes. Without
        it the body does not turn, as one that is guided.
    arm : array_like, shape (3,), optional
        From the centre of mass to where the body is touched, m; zero if left out. It makes an
        oblique impact turn the body; an impact along the direction of travel alone leaves it out.
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
        r, m. The mass is 4/3 π r³ ρ, the moment of inertia 2/5 of that times r².
    material : Material
    mass : float, optional
        kg, of a body with a round nose in place of the ball, such as the tup of a drop tower with
        its carriage. With friction it moves sideways as this mass, but it does not turn, as one
        that is guided.
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
