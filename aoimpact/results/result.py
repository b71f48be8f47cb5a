"""The result of an impact of two bodies: a run's histories, and the numbers that sum them up.

Histories are read-only arrays over `Result.t`. Displacements, velocities and centres of mass are
measured along the direction of travel, from where the bodies were at t = 0.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy.typing as npt

from ..base import FloatArray
from ..integrate import Eventful, Events
from ..laws import PatchLaw
from . import plot
from .errors import ErrorEstimate
from .export import as_dataframe, result_dataset
from .motion import BodyResult, Cost, Energy
from .movie import write_impact_movie
from .plot import During
from .run import Run
from .summary import summary_html, summary_text
from .table import columns, write_csv

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Result"]


@dataclass(frozen=True, eq=False, repr=False)
class Result(Eventful):
    """An impact of a projectile on a target; curves are computed when they are read.

    Attributes
    ----------
    run : Run
        The scene of the two bodies.
    velocity, gap : float
        Initial velocity of the projectile [m/s] and initial gap [m].
    law : ContactLaw
        The contact law.

    Examples
    --------
    >>> ball = ao.ball(0.01, ao.Material(E=210e9, nu=0.3, rho=7800))
    >>> hit = ao.simulate(projectile=ball, target=ball, velocity=1.0)
    >>> round(hit.peak_force, 1), hit.contacts[0][0], round(hit.restitution, 6)
    (1001.5, 0.0, 1.0)
    >>> hit.at([1e-5, 3e-5]).force.round(1)
    array([ 331.8, 1001.5])
    >>> round(float(hit.energy.total[0]), 6)  # J
    0.016336
    """

    run: Run = field(repr=False)
    velocity: float
    gap: float
    law: Any

    # ------------------------------------------------------------------- histories

    @property
    def t(self) -> FloatArray:
        """Times [s], shape (n,)."""
        return self.run.t

    @property
    def duration(self) -> float:
        """Length of the record [s]."""
        return self.run.duration

    @property
    def force(self) -> FloatArray:
        """Contact force, ≥ 0 in compression [N]."""
        return self.run.contacts[0].force

    @property
    def indentation(self) -> FloatArray:
        """Projectile's minus target's contact coordinate minus the initial gap [m]."""
        return self.run.contacts[0].indentation

    @property
    def projectile(self) -> BodyResult:
        """The projectile's motion."""
        return self.run.bodies[0]

    @property
    def target(self) -> BodyResult:
        """The target's motion."""
        return self.run.bodies[1]

    @property
    def energy(self) -> Energy:
        """Energies over time.

        Raises
        ------
        InputError
            If the run did not record them.
        """
        return self.run.energy

    @property
    def error(self) -> ErrorEstimate:
        """Errors of the quantity of interest; ``error["restitution"]`` is that of a number."""
        return self.run.error

    @property
    def cost(self) -> Cost:
        """Seconds spent on models and on the run."""
        return self.run.cost

    @property
    def models(self) -> tuple[Any, ...]:
        """The projectile's and the target's model: those chosen, or as given."""
        return self.run.models

    @property
    def solver(self) -> str:
        """How time was integrated."""
        return self.run.solver

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

        `times` [s], shape (m,), ascend within the record; see `Run.at` for what is refused.

        Examples
        --------
        >>> import numpy as np
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> hit.at([0.0, 1e-4, 2e-4]).force.shape
        (3,)
        """
        return replace(self, run=self.run.at(times))

    # ---------------------------------------------------------------------- events

    @property
    def events(self) -> Events:
        """The events: the solver's own where it locates them, else found between the steps."""
        return self.run.events[0]

    @property
    def contacts(self) -> list[tuple[float, float]]:
        """Start and end [s] of every contact; empty without contact."""
        return list(self.events.contacts)

    @property
    def in_contact_at_end(self) -> bool:
        """Whether the record ends in contact: its numbers are then not yet final."""
        return self.run.in_contact_at_end

    @property
    def contact_radius(self) -> float:
        """Radius of the contact at its largest, √(R δ) [m]; NaN where the law has no surface.

        √(a b) of an elliptic contact of semi-axes a and b.
        """
        contact = self.run.plan.contacts[0]
        found = self.run.plan.round_contact(contact)
        if found is None:
            return math.nan
        depth = float(self.indentation.max(initial=0.0))
        if isinstance(contact.law, PatchLaw):
            depth += contact.law.compliance * self.peak_force
        return found.narrowing * math.sqrt(found.radius * max(depth, 0.0))

    @property
    def hertz_pressure(self) -> float:
        """Largest pressure by Hertz, 3 F/(2 π a b) [Pa]; NaN where the law has no surface."""
        width = self.contact_radius
        return 1.5 * self.peak_force / (math.pi * width**2) if width > 0.0 else math.nan

    @property
    def rebound_velocity(self) -> float:
        """Velocity of the projectile's centre of mass after the last contact [m/s].

        NaN without a rebound, if the bodies have not met or the record ends in contact, and where
        the centre of mass is not known (see `BodyResult`).
        """
        return self.value("rebound_velocity")

    @property
    def restitution(self) -> float:
        """Coefficient of restitution, by the centres of mass after the last contact.

        (v_target − v_projectile) / V for a free target, −v_projectile / V for one that is
        constrained or of infinite mass. NaN without a rebound, and where a centre of mass
        is not known.
        """
        return self.value("restitution")

    def value(self, name: str) -> float:
        """Return a number that sums up the impact, by the name of a quantity of interest.

        NaN where there is no such number, such as the restitution of bodies that have not parted.

        Raises
        ------
        InputError, InputTypeError
            If there is no number of that name.

        Examples
        --------
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> hit.value("contact_count")
        1.0
        """
        return self.run.value(name)

    @property
    def parting(self) -> tuple[float, float]:
        """Velocities of the centres of projectile and target at the end of the last contact [m/s].

        Those of `Run.parting`: NaN where a centre of mass is not known.
        """
        ours, theirs = self.run.parting
        return float(ours), float(theirs)

    # ---------------------------------------------------------------------- output

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write all histories, one row a time, under a header line with names and units.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> hit.to_csv(folder / "impact.csv")
        """
        write_csv(columns(self), path)

    def to_dataframe(self) -> Any:
        """Return all histories as a pandas DataFrame, a row a time.

        The columns are those of `to_csv`, "name [unit]"; the index is "t [s]".

        Raises
        ------
        MissingPackageError
            If pandas is not installed.

        Examples
        --------
        >>> import aoimpact as ao
        >>> ball = ao.rigid(mass=0.0327)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e10), velocity=1.0)
        >>> table = hit.to_dataframe()
        >>> float(table["force [N]"].max()) == hit.peak_force
        True
        """
        return as_dataframe(columns(self))

    def to_xarray(self) -> Any:
        """Return all histories as an xarray Dataset, with units.

        Dimensions are time and body; ``data.sel(body="target").velocity`` is one history,
        ``data.to_netcdf(path)`` a file of all.

        Raises
        ------
        MissingPackageError
            If xarray is not installed.

        Examples
        --------
        >>> import aoimpact as ao
        >>> ball = ao.rigid(mass=0.0327)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e10), velocity=1.0)
        >>> data = hit.to_xarray()
        >>> data.force.attrs["units"], float(data.force.max()) == hit.peak_force
        ('N', True)
        """
        return result_dataset(self)

    def plot(self, *, during: During = "contact") -> Any:
        """Draw force, indentation, displacements and energies in four panels.

        Parameters
        ----------
        during : {"contact", "record"} or (float, float), optional
            What is drawn: the contacts with a little before and after, all of the record, or from
            one time to another, s.

        Returns
        -------
        ndarray of Axes, shape (2, 2)
            ``axes[0, 0].figure`` is the figure, to be saved or changed.

        Examples
        --------
        >>> import aoimpact as ao
        >>> ball = ao.rigid(mass=0.0327)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e10), velocity=1.0)
        >>> axes = hit.plot()
        >>> axes[0, 0].figure.savefig("impact.png")  # doctest: +SKIP
        """
        return plot.plot_panels(self, during)

    def plot_force(
        self, ax: Axes | None = None, *, during: During = "contact", **kwargs: Any
    ) -> Axes:
        """Draw the force over time; keywords go to ``Axes.plot``. Returns the axes.

        `during` is as for `plot`.

        Examples
        --------
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> ax = hit.plot_force(linestyle="--")
        """
        return plot.plot_forces(self.run, ax, during=during, **kwargs)

    def plot_indentation(
        self, ax: Axes | None = None, *, during: During = "contact", **kwargs: Any
    ) -> Axes:
        """Draw the indentation over time; `during` is as for `plot`. Returns the axes.

        Examples
        --------
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> ax = hit.plot_indentation()
        """
        return plot.plot_indentation(self, ax, during=during, **kwargs)

    def plot_energy(
        self,
        ax: Axes | None = None,
        *,
        body: Literal["projectile", "target"] | None = None,
        during: During = "record",
        **kwargs: Any,
    ) -> Axes:
        """Draw the energies over time, of all or of one body (paper, Fig. 5). Returns the axes.

        Examples
        --------
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> ax = hit.plot_energy(body="target")
        """
        return plot.plot_energy(self.run, ax, body=body, during=during, **kwargs)

    def plot_displacement(
        self, ax: Axes | None = None, *, during: During = "record", **kwargs: Any
    ) -> Axes:
        """Draw contact points and centres of mass over time (paper, Fig. 10).

        Examples
        --------
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> ax = hit.plot_displacement()
        """
        return plot.plot_displacement(self, ax, during=during, **kwargs)

    def movie(
        self,
        path: str | os.PathLike[str],
        *,
        times: npt.ArrayLike | None = None,
        frames: int = 60,
        scale: float | None = None,
        fps: float = 15.0,
    ) -> Path:
        """Write a movie of the two bodies as they meet, coloured by von Mises' stress.

        Displacements are enlarged, by a factor that stands in the picture, those of the approach as
        well. The target stands where its mesh is; the projectile is turned and moved to where it
        touches it. Nothing but a rigid ball is drawn of what has no elements. Colours are shared;
        the highest 2 % of the stresses, mostly under the contact, keep the last one.

        Parameters
        ----------
        path : path
            Ending in .gif or .mp4.
        times : array_like, shape (k,), optional
            Ascending, within the record, s; a frame each. By themselves `frames` times from shortly
            before the contact to shortly after it.
        frames : int, optional
        scale : float, optional
            How many times displacements are enlarged; by itself 1, 2 or 5 times a power of ten that
            makes them visible.
        fps : float, optional
            Frames a second.

        Returns
        -------
        Path

        Raises
        ------
        MissingPackageError
            If PyVista or, for .mp4, imageio and imageio-ffmpeg are not installed.
        InputError
            If no body has elements, the path is no place for a movie, or a time is outside the
            record.

        Examples
        --------
        >>> hit.movie("impact.gif", frames=40)  # doctest: +SKIP
        """
        return write_impact_movie(self, path, times=times, frames=frames, scale=scale, fps=fps)

    def plot_interaction(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the force over the approach of the centres of mass (paper, Fig. 7).

        Examples
        --------
        >>> ball = ao.rigid(mass=0.1)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0)
        >>> ax = hit.plot_interaction()
        """
        return plot.plot_interaction(self, ax, **kwargs)

    def __repr__(self) -> str:
        return summary_text(self)

    def _repr_html_(self) -> str:
        return summary_html(self)
