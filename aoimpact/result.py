"""What an impact gave: histories over time, and the numbers that sum them up.

Histories are read-only arrays over `Result.t`. Displacements, velocities and centres of mass are
measured along the direction of travel, from where the bodies were at t = 0.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from . import plot
from .checks import finite_array
from .errors import InputError
from .events import Events, FloatArray, find_events
from .motion import BodyEnergy, BodyInfo, BodyResult, Energy, ErrorEstimate, Frozen
from .summary import summary_html, summary_text
from .table import write_csv

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "BodyEnergy",
    "BodyInfo",
    "BodyResult",
    "Energy",
    "ErrorEstimate",
    "Result",
    "result_from_record",
]

# The record of the C core (enum aoi_row): force, indentation and contact energy, then six rows a
# body.
_BODY_FIRST_ROW = 3
_BODY_ROWS = 6
_ROW_COUNT = _BODY_FIRST_ROW + 2 * _BODY_ROWS


@dataclass(frozen=True, eq=False, repr=False)
class Result(Frozen):
    """An impact of a projectile on a target.

    Attributes
    ----------
    t : (n,) array
        Times [s].
    force, indentation : (n,) arrays
        Contact force, ≥ 0 in compression [N]; projectile's minus target's contact coordinate
        minus the initial gap [m].
    projectile, target : BodyResult
        The bodies' motions.
    error : ErrorEstimate
        What is known of the error of the peak force.
    velocity, gap : float
        Initial velocity of the projectile [m/s] and initial gap [m].
    law : object
        The contact law.
    solver : str
        How time was integrated.
    """

    t: FloatArray
    force: FloatArray
    indentation: FloatArray
    projectile: BodyResult
    target: BodyResult
    error: ErrorEstimate
    velocity: float
    gap: float
    law: Any
    solver: str
    _energy: Energy | None = field(default=None)
    _events: Events | None = field(default=None)
    _dense: Callable[[FloatArray], Result] | None = field(default=None)

    # ------------------------------------------------------------------- histories

    @property
    def energy(self) -> Energy:
        """Energies over time.

        Raises
        ------
        InputError
            If the run did not record them.
        """
        if self._energy is None:
            raise InputError(
                "this run has no energies: it was made with energies=False; "
                "call simulate(..., energies=True)"
            )
        return self._energy

    @property
    def approach(self) -> FloatArray:
        """Approach of the centres of mass, projectile's minus target's minus the gap [m].

        The force over it is the paper's modified interaction law (Fig. 7): what two rigid masses
        would have to have between them.
        """
        centres = self.projectile.centre_displacement - self.target.centre_displacement
        approach: FloatArray = centres - self.gap
        return approach

    def at(self, times: npt.ArrayLike) -> Result:
        """Return the same impact at other times: dense output, as exact as the run itself.

        Parameters
        ----------
        times : array_like, shape (m,)
            Ascending, within the record [s].

        Raises
        ------
        InputError
            If the run was made with fixed steps, between which nothing is known, or the times do
            not ascend within the record.
        """
        if self._dense is None:
            raise InputError(
                "this run has fixed steps, with nothing known between them; "
                "call simulate(..., solver=Adaptive(...)) for dense output"
            )
        wanted = np.atleast_1d(finite_array("times", times, unit="s"))
        if wanted.ndim != 1 or wanted.size == 0 or (np.diff(wanted) < 0.0).any():
            raise InputError(f"times must be a flat ascending list, got shape {wanted.shape}")
        if wanted[0] < 0.0 or wanted[-1] > self.t[-1]:
            raise InputError(
                f"times must lie within the record, 0 to {self.t[-1]:g} s, got "
                f"{wanted[0]:g} to {wanted[-1]:g} s"
            )
        return self._dense(wanted)

    # ---------------------------------------------------------------------- events

    @cached_property
    def events(self) -> Events:
        """The events: the solver's own where it locates them, else found between the steps."""
        if self._events is not None:
            return self._events
        rate = self.projectile.velocity - self.target.velocity
        return find_events(self.t, self.force, self.indentation, rate)

    @property
    def peak_force(self) -> float:
        """Largest force of the record [N]; 0.0 without contact."""
        return self.events.peak_force

    @property
    def peak_time(self) -> float:
        """When the largest force acts [s]."""
        return self.events.peak_time

    @property
    def contacts(self) -> list[tuple[float, float]]:
        """Start and end [s] of every contact; empty without contact."""
        return list(self.events.contacts)

    @property
    def contact_duration(self) -> float:
        """Duration of the first contact [s]; 0.0 without contact.

        A contact that the record cuts off counts up to the record's end.
        """
        if not self.events.contacts:
            return 0.0
        start, end = self.events.contacts[0]
        return end - start

    @property
    def impulse(self) -> float:
        """Integral of the force over the record [N s]."""
        return self.events.impulse

    @property
    def in_contact_at_end(self) -> bool:
        """Whether the record ends in contact: its numbers are then not yet final."""
        return bool(self.force[-1] > 0.0)

    @property
    def rebound_velocity(self) -> float:
        """Velocity of the projectile's centre of mass after the last contact [m/s].

        At the end of the record, if that is still in contact; the initial one without contact.
        """
        return float(self.projectile.centre_velocity[self._released])

    @property
    def restitution(self) -> float:
        """Coefficient of restitution, by the centres of mass after the last contact.

        (v_target − v_projectile) / V for a free target, −v_projectile / V for one that is held or
        of infinite mass. −1 if the bodies have not met; 0.0 if there was no initial velocity.
        """
        if self.velocity == 0.0:
            return 0.0
        recoil = 0.0 if self.target.fixed else self.target.centre_velocity[self._released]
        return float((recoil - self.projectile.centre_velocity[self._released]) / self.velocity)

    @property
    def _released(self) -> int:
        """Index of the first sample at or after the end of the last contact, or of the last one."""
        last = len(self.t) - 1
        if not self.events.contacts:
            return last
        return min(int(np.searchsorted(self.t, self.events.contacts[-1][1])), last)

    # ---------------------------------------------------------------------- output

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write all histories, one row a time, under a header line with names and units."""
        write_csv(self, path)

    def plot_force(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the force over time; keywords go to ``Axes.plot``. Returns the axes."""
        return plot.plot_force(self, ax, **kwargs)

    def plot_indentation(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the indentation over time. Returns the axes."""
        return plot.plot_indentation(self, ax, **kwargs)

    def plot_energy(
        self,
        ax: Axes | None = None,
        *,
        body: Literal["projectile", "target"] | None = None,
        **kwargs: Any,
    ) -> Axes:
        """Draw the energies over time, of all or of one body (paper, Fig. 5). Returns the axes."""
        return plot.plot_energy(self, ax, body=body, **kwargs)

    def plot_displacement(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw contact points and centres of mass over time (paper, Fig. 10)."""
        return plot.plot_displacement(self, ax, **kwargs)

    def plot_interaction(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the force over the approach of the centres of mass (paper, Fig. 7)."""
        return plot.plot_interaction(self, ax, **kwargs)

    def __repr__(self) -> str:
        return summary_text(self)

    def _repr_html_(self) -> str:
        return summary_html(self)


def result_from_record(
    *,
    t: FloatArray,
    record: FloatArray,
    projectile: BodyInfo,
    target: BodyInfo,
    law: Any,
    velocity: float,
    gap: float,
    solver: str,
    error: ErrorEstimate,
    energies: bool,
    events: Events | None = None,
    dense: Callable[[FloatArray], Result] | None = None,
) -> Result:
    """Build a result from the record that the C core has written.

    Parameters
    ----------
    t : (n,) array
        Times [s].
    record : (15, n) array
        Rows in the order of ``enum aoi_row``; it becomes read-only. The rows of energies are not
        looked at unless `energies`.
    events : Events, optional
        From a solver that locates them; else they are found between the samples.
    dense : callable, optional
        Gives the result at other times.
    """
    if record.shape != (_ROW_COUNT, len(t)):
        raise InputError(f"record must have shape ({_ROW_COUNT}, {len(t)}), got {record.shape}")
    record.flags.writeable = False
    first_target_row = _BODY_FIRST_ROW + _BODY_ROWS
    bodies = (
        _body_result(projectile, record[_BODY_FIRST_ROW:first_target_row], energies),
        _body_result(target, record[first_target_row:], energies),
    )
    return Result(
        t=t,
        force=record[0],
        indentation=record[1],
        projectile=bodies[0],
        target=bodies[1],
        error=error,
        velocity=float(velocity),
        gap=float(gap),
        law=law,
        solver=str(solver),
        _energy=_energy(record[2], *bodies) if energies else None,
        _events=events,
        _dense=dense,
    )


def _body_result(info: BodyInfo, rows: FloatArray, energies: bool) -> BodyResult:
    displacement, velocity, centre_displacement, centre_velocity, kinetic, elastic = rows
    return BodyResult(
        label=info.label,
        mass=info.mass,
        held=info.held,
        displacement=displacement,
        velocity=velocity,
        centre_displacement=centre_displacement,
        centre_velocity=centre_velocity,
        energy=BodyEnergy(kinetic, elastic) if energies else None,
        coordinates=info.coordinates,
        rates=info.rates,
    )


def _energy(contact: FloatArray, projectile: BodyResult, target: BodyResult) -> Energy:
    # Bodies without damping, laws without loss: nothing is dissipated, and no load does work.
    assert projectile.energy is not None
    assert target.energy is not None
    kinetic = projectile.energy.kinetic + target.energy.kinetic
    elastic = projectile.energy.elastic + target.energy.elastic
    dissipated = np.zeros_like(contact)
    total = kinetic + elastic + contact + dissipated
    return Energy(kinetic, elastic, contact, dissipated, total, projectile.energy, target.energy)
