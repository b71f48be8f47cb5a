"""The one interface of every model of a body: what a scene, an integrator or a user asks of it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import fields
from functools import cached_property
from typing import Any, Self

import numpy as np

from ..base import HUGE, FloatArray, InputError, InputTypeError, finite_array
from ..fem import (
    ContactCompliance,
    ContactPoint,
    ContactSurface,
    Damping,
    Extraction,
    FEModel,
    ThinExtraction,
    field_error,
    missing_energy,
    thin_stiffness_error,
)
from .band import Band, band_of
from .modalbody import ModalBody, Pull
from .recovery import GeneralizedCoordinates


class BodyModel(ABC):
    """A model of a body, and the places where it is touched: its ports.

    A new kind derives from this class or from those below. `modal` is what the adaptive method
    takes; `scene/bodies.py` says what Newmark's rule steps for it.
    """

    def __getstate__(self) -> dict[str, Any]:
        """Pickle and copy without what is derived from the fields: it is cheap to find again."""
        return {one.name: vars(self)[one.name] for one in fields(self)}  # type: ignore[arg-type]

    @cached_property
    def kept(self) -> dict[Any, Any]:
        """Results of others that are derived from this model alone, which does not change.

        :meta private:
        """
        return {}

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the body in results, tables and plots; empty if it has none."""

    @property
    @abstractmethod
    def label(self) -> str:
        """Kind of the model, such as "rigid" or "AO(3)"."""

    @property
    @abstractmethod
    def contact_points(self) -> tuple[ContactPoint, ...]:
        """Contact points, one for each port; none of a body given by numbers."""

    @property
    @abstractmethod
    def mass(self) -> float | None:
        """Mass of the whole body, kg; None where its matrices do not determine it."""

    @property
    @abstractmethod
    def most_mass(self) -> float:
        """A mass not below the static mass, kg; infinite for a constrained body.

        :meta private:
        """

    @property
    @abstractmethod
    def dofs(self) -> int:
        """Number of degrees of freedom of the model; 0 of a wall."""

    @property
    def damping(self) -> Damping | None:
        """Damping of the natural modes; None where nothing is damped."""
        return None

    @property
    @abstractmethod
    def constrained(self) -> bool:
        """True if supports or a ground spring constrain it."""

    @property
    def centre_known(self) -> bool:
        """True if its centre of mass is known; else the mean over the static mode stands in."""
        return True

    @property
    def known_mass(self) -> float | None:
        """Mass of the whole body, kg; None where its centre of mass is not known.

        :meta private:
        """
        return self.mass if self.centre_known else None

    @property
    def wall(self) -> bool:
        """True if it is of infinite mass.

        :meta private:
        """
        return self.known_mass is not None and math.isinf(self.known_mass)

    @property
    def fixed(self) -> bool:
        """True if it stays in its place: constrained, or a wall.

        :meta private:
        """
        return self.constrained or self.wall

    @property
    @abstractmethod
    def static_mass(self) -> float:
        """The mass that an impact on its lightest port moves statically, kg, eq. (10)."""

    @property
    @abstractmethod
    def modal(self) -> ModalBody:
        """The body in its natural modes; of a full model in all of them.

        :meta private:
        """

    @property
    def ports(self) -> int:
        """Number of its contact functionals.

        :meta private:
        """
        return max(1, len(self.contact_points))

    @property
    def places(self) -> int:
        """Number of places where it may be touched: with tangents each has three ports.

        :meta private:
        """
        points = self.contact_points
        return self.ports // 3 if points and points[0].tangents is not None else self.ports

    @property
    def weightless(self) -> bool:
        """True if gravity has no effect on it, since its supports are not known.

        :meta private:
        """
        return False

    @property
    def massless(self) -> bool:
        """True if a port moves at once with the force on it.

        :meta private:
        """
        return self.modal.residual is not None

    @property
    def omitted(self) -> tuple[float, float]:
        """Share of the centre of mass's velocity, and mass, kg, that the model does not contain.

        :meta private:
        """
        return 0.0, 0.0

    def fast_compliance(self, slowest: float, *, weighed: bool) -> tuple[FloatArray, FloatArray]:
        """Return Σ |r_p| |r_q| / ω² of modes above a frequency, rad/s, or a bound of it.

        Returns
        -------
        by_forces : ndarray, shape (ports, ports)
            m/N.
        by_weight : ndarray, shape (ports,)
            m per m/s² of gravity; zero unless `weighed`.

        :meta private:
        """
        modal = self.modal
        fast = modal.omega > slowest
        shape = np.abs(modal.shape[:, fast]) / modal.omega[fast] ** 2
        by_weight = shape @ np.abs(modal.weight[fast]) if weighed else np.zeros(self.ports)
        return shape @ np.abs(modal.push[:, fast].T), by_weight

    @property
    def contact_time(self) -> float | None:
        """The contact's duration that the model was fitted to, s; None where it fits any."""
        return None

    @property
    def linear_solver(self) -> str:
        """The linear solver that the model was made with; empty where none was needed."""
        return ""

    @property
    def reducible(self) -> bool:
        """True if it stands for contact points whose model is yet to be chosen."""
        return False

    def touched_at(self, port: int = 0) -> ContactPoint | None:
        """Return the contact point of a port; None of a body given by numbers.

        :meta private:
        """
        points = self.contact_points
        return points[port] if points else None

    def extraction_at(self, port: int = 0) -> ContactCompliance | None:
        """Return the compliances at a port; None of a rigid body, and where they are not known.

        :meta private:
        """
        point = self.touched_at(port)
        return None if point is None else point.extraction

    def surface_at(self, port: int = 0) -> ContactSurface | None:
        """Return material and curvatures at a port; None where they are not known.

        :meta private:
        """
        point = self.touched_at(port)
        return None if point is None else point.contact_surface

    @property
    def turnable(self) -> bool:
        """True if the direction of travel at its ports can be turned round once it is made.

        :meta private:
        """
        return True

    @abstractmethod
    def turned(self, ports: Sequence[int]) -> Self:
        """Return the model with the direction of travel turned round at some ports, if it can be.

        :meta private:
        """


class ReducedModel(BodyModel):
    """A model of fewer degrees of freedom than its body has, or one given by numbers."""

    @property
    @abstractmethod
    def n(self) -> int:
        """Number of anti-oscillators, or of modes."""

    @abstractmethod
    def deflection(self, s: float, port: int = 0) -> FloatArray:
        """Return the body's displacement under a unit force at the frequency i s, shape (n_dofs,).

        Parameters
        ----------
        s : float
            rad/s, positive.
        port : int, optional
            Where the force acts.

        :meta private:
        """

    @property
    def truncates(self) -> bool:
        """True if the body yields more to a force than the model: no vector was made for it.

        :meta private:
        """
        return self.contact_time is None

    def extraction_at(self, port: int = 0) -> ContactCompliance | None:
        """Return the compliances at a port, of a truncated model its own; None if not known.

        :meta private:
        """
        known = super().extraction_at(port)
        if known is None or not self.truncates:
            return known
        found: dict[int, ContactCompliance] = self.kept.setdefault("extraction", {})
        if port not in found:
            tip, deflection = self.contact_points[port], self.deflection(known.s, port)
            found[port] = known.of_truncated(tip, deflection)
        return found[port]

    @abstractmethod
    def coordinates(self, gravity: Pull = 0.0) -> GeneralizedCoordinates | None:
        """Return what the body does by the model's coordinates; None of one given by numbers.

        Parameters
        ----------
        gravity : float or ndarray, shape (3,), optional
            m/s², along the direction of travel or in three directions.

        :meta private:
        """

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency, Hz, between which it has the receptance of its body.

        There the receptance, averaged over neighbouring frequencies, is right to 1e-3. It takes a
        static solution for each contact point. A model given by numbers is right everywhere.
        """
        return (0.0, math.inf) if self._band is None else self._band.limits

    @cached_property
    def _band(self) -> Band | None:
        coordinates = self.coordinates()
        return None if coordinates is None else band_of(coordinates, self.contact_points)

    def _warn_outside_band(self, omega: FloatArray) -> None:
        """Warn where a receptance is asked for at frequencies, rad/s, that it does not know."""
        if self._band is not None:
            self._band.warn_outside(omega, fitted=self.contact_time is not None)

    @property
    def omitted_translation(self) -> FloatArray | None:
        """The part of the body's unit translation that its coordinates lack, shape (n_dofs,).

        Along the direction of travel; None where they lack nothing.

        :meta private:
        """
        return None

    def stiffness_error(self, s: float, port: int = 0, axis: int = 0) -> float:
        """Return how much too stiff the mesh is for motion at the frequency i s, relative.

        The energy that the field beyond the half-space lacks, over its strain energy. Frequencies
        within a factor of √2 share one estimate.

        Parameters
        ----------
        s : float
            rad/s, positive.
        port : int, optional
            Where the force acts.
        axis : int, optional
            1 or 2 for a force along the first or second tangent there, if these are known.

        :meta private:
        """
        octave = round(math.log2(s))
        key = octave, port + axis
        found: dict[tuple[int, int], float] = self.kept.setdefault("stiffness", {})
        if key not in found:
            point, known = self.contact_points[port], self.extraction_at(port)
            if known is None:
                return 0.0
            assert point.direction is not None
            deflection = self.deflection(2.0**octave, port + axis)
            if isinstance(known, ThinExtraction):
                found[key] = thin_stiffness_error(point.body, deflection, known.near, 2.0**octave)
                return found[key]
            assert isinstance(known, Extraction)
            field, sign = known.mesh_field, known.splitting.frame[2] @ point.direction
            if axis:
                if known.sheared is None:
                    return 0.0
                field, sign = known.sheared[axis - 1], 1.0
            moved = math.copysign(1.0, sign) * deflection
            beyond = point.body.at_nodes(moved, len(field)) - field
            false, own = field_error(point.body, beyond, ~known.splitting.smooth, 2.0**octave)
            whole = float(own.sum())
            found[key] = missing_energy(false, own) / whole if whole else 0.0
        return found[key]

    @abstractmethod
    def stiffened(self, factor: float) -> Self:
        """Return the model with all its springs stiffer by a factor.

        :meta private:
        """


class FiniteElementModel(BodyModel):
    """A model that knows its finite-element body: its name and mass are the body's."""

    @property
    def body(self) -> FEModel:
        """The body touched."""
        return self.contact_points[0].body

    @property
    def name(self) -> str:
        """Name of the body."""
        return self.body.name

    @property
    def mass(self) -> float | None:
        """Mass of the whole body, kg; None where its matrices do not determine it."""
        return self.body.mass

    @property
    def damping(self) -> Damping | None:
        """Damping of the body."""
        return self.body.damping

    @property
    def most_mass(self) -> float:
        """Infinite without a rigid motion; a mass that is not known is at most M's trace.

        :meta private:
        """
        if self.body.rigid_modes.shape[1] == 0:
            return math.inf
        return float(self.body.M.diagonal().sum()) if self.mass is None else self.mass


def checked_ports(name: str, tips: Any) -> tuple[ContactPoint, ...]:
    """Return the places on one body, one or several.

    Raises
    ------
    InputError, InputTypeError
        If they are not that.
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


def ascending(name: str, value: Any) -> FloatArray:
    """Return `value`, of one mode at least, as frequencies or their squares that do not fall."""
    values = finite_array(name, value, ndim=1, most=HUGE)
    if not len(values) or values[0] < 0.0 or (np.diff(values) < 0.0).any():
        raise InputError(f"{name} must be one number at least, none negative, in ascending order")
    return values
