"""What a result holds of each body, and of the energies: read-only histories over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .events import FloatArray

__all__ = ["BodyEnergy", "BodyInfo", "BodyResult", "Energy", "ErrorEstimate", "Frozen"]


class Frozen:
    """Makes the arrays of a dataclass read-only, also after unpickling."""

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        Frozen.__post_init__(self)


@dataclass(frozen=True, eq=False)
class BodyEnergy(Frozen):
    """Energy of one body over time [J].

    Attributes
    ----------
    kinetic, elastic : (n,) arrays
        Kinetic energy, and strain energy of the body itself: the paper's nonlocal energy.
    """

    kinetic: FloatArray
    elastic: FloatArray


@dataclass(frozen=True, eq=False)
class Energy(Frozen):
    """Where the energy is over time [J], (n,) arrays.

    Attributes
    ----------
    kinetic, elastic : arrays
        Of both bodies together; `elastic` is the paper's nonlocal deformation energy.
    contact : array
        Stored in the contact law: the paper's local deformation energy.
    dissipated : array
        Lost in the contact law and in the bodies' damping since t = 0.
    total : array
        kinetic + elastic + contact + dissipated − work of applied loads: constant in an exact run.
    projectile, target : BodyEnergy
        The shares of the bodies.
    """

    kinetic: FloatArray
    elastic: FloatArray
    contact: FloatArray
    dissipated: FloatArray
    total: FloatArray
    projectile: BodyEnergy
    target: BodyEnergy


@dataclass(frozen=True, eq=False)
class BodyInfo(Frozen):
    """What a result has to know of a body beside its histories.

    Attributes
    ----------
    label : str
        "rigid", "AO(1)", "modal(40)", "full(3159)".
    mass : float or None
        Total mass [kg]; None where it is not known.
    held : bool
        Whether supports or a ground spring hold it.
    coordinates, rates : arrays
        Its state at the end of the record, in its own coordinates.
    """

    label: str
    mass: float | None
    held: bool
    coordinates: FloatArray
    rates: FloatArray


@dataclass(frozen=True, eq=False)
class BodyResult(Frozen):
    """One body's motion over time.

    Attributes
    ----------
    label, mass, held
        As in :class:`BodyInfo`.
    displacement, velocity : (n,) arrays
        Of the contact coordinate [m, m/s].
    centre_displacement, centre_velocity : (n,) arrays
        Of the centre of mass [m, m/s].
    energy : BodyEnergy or None
        None if the run was made with ``energies=False``.
    coordinates, rates : arrays
        State at the end of the record, in the body's own coordinates.
    """

    label: str
    mass: float | None
    held: bool
    displacement: FloatArray
    velocity: FloatArray
    centre_displacement: FloatArray
    centre_velocity: FloatArray
    energy: BodyEnergy | None
    coordinates: FloatArray
    rates: FloatArray

    @property
    def fixed(self) -> bool:
        """Whether it cannot fly off: held by supports, or of infinite mass."""
        return self.held or (self.mass is not None and bool(np.isinf(self.mass)))


@dataclass(frozen=True)
class ErrorEstimate:
    """What is known of the error, relative; None where nothing is.

    Attributes
    ----------
    reduction : float or None
        Of the peak force, from representing the bodies by fewer degrees of freedom.
    time : float or None
        Of the peak force, from integrating in time: an estimate, or the tolerance that was kept.
    energy : float or None
        Range of the total energy over the record, relative to the initial one: an independent check
        on the run, since no solver uses it.
    """

    reduction: float | None = None
    time: float | None = None
    energy: float | None = None
