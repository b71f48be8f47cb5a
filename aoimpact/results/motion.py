"""The histories of a run over time, read-only: of each body, each contact and the energies."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from ..base import FloatArray, Frozen, InputError, read_only, with_unit
from ..fem import whole_motion
from ..fields import History, Measured, errors_of
from ..integrate import Events
from ..laws import ContactLaw, Dent
from ..reduction import FullModel
from .advice import follows

if TYPE_CHECKING:
    from .run import Run


@dataclass(frozen=True, eq=False)
class BodyEnergy(Frozen):
    """Energy of one body over time [J].

    Attributes
    ----------
    kinetic, elastic : (n,) arrays
        Kinetic energy, and strain energy of the body itself, without that of the indentation,
        which the contact law has: the paper's nonlocal energy. Slightly negative where the law's
        half-space yields more than the body, as of a ball.
    dissipated, work : (n,) arrays
        Lost in its damping, and work of gravity and applied forces on it, since t = 0.
    """

    kinetic: FloatArray
    elastic: FloatArray
    dissipated: FloatArray
    work: FloatArray


@dataclass(frozen=True, eq=False)
class Energy(Frozen):
    """Energies over time [J], (n,) arrays.

    Attributes
    ----------
    kinetic, elastic : arrays
        Energies of all bodies together; `elastic` is the paper's nonlocal deformation energy.
    contact : array
        Stored in the contact laws: the paper's local deformation energy.
    dissipated : array
        Lost in the contact laws and in the bodies' damping since t = 0.
    work : array
        Work of gravity and applied forces since t = 0.
    friction : array
        The part of `dissipated` that friction has taken.
    total : array
        kinetic + elastic + contact + dissipated − work: constant in an exact run.
    bodies : tuple of BodyEnergy
        The shares of the bodies.
    """

    kinetic: FloatArray
    elastic: FloatArray
    contact: FloatArray
    dissipated: FloatArray
    work: FloatArray
    total: FloatArray
    bodies: tuple[BodyEnergy, ...]
    friction: FloatArray

    @property
    def projectile(self) -> BodyEnergy:
        """The share of the first body."""
        return self.bodies[0]

    @property
    def target(self) -> BodyEnergy:
        """The share of the second body."""
        return self.bodies[1]


@dataclass(frozen=True, eq=False)
class BodyResult(Frozen, Measured):
    """One body's motion over time.

    Attributes
    ----------
    name : str
        As its user called it; "projectile" and "target", or "body 0", without a name.
    label : str
        "rigid", "AO(1)", "modal(40)", "full(3159)".
    mass : float or None
        Total mass [kg]; None where it is not known.
    constrained : bool
        Whether supports or a ground spring constrain it.
    port_displacements, port_velocities : (p, n) arrays
        Displacements and velocities of all contact coordinates [m, m/s].
    energy : BodyEnergy or None
        None if the run was made with ``energies=False``.
    """

    name: str
    label: str
    mass: float | None
    constrained: bool
    energy: BodyEnergy | None
    port_displacements: FloatArray
    port_velocities: FloatArray
    _motion: dict[str, FloatArray] = field(repr=False)
    _run: Run = field(repr=False)
    _number: int = field(repr=False)  # of the body

    def __repr__(self) -> str:
        mass = "" if self.mass in (None, math.inf) else f", {self.mass:.4g} kg"
        way = "constrained" if self.constrained else "free"
        return f"BodyResult({self.name}: {self.label}{mass}, {way})"

    @property
    def displacement(self) -> FloatArray:
        """Displacement of the (first) contact coordinate [m], shape (n,).

        Warns where it may be badly wrong, as the other histories do; see `error`.
        """
        return self._told("displacement")

    @property
    def velocity(self) -> FloatArray:
        """Velocity of the (first) contact coordinate [m/s], shape (n,)."""
        return self._told("velocity")

    @property
    def centre_displacement(self) -> FloatArray:
        """Displacement of the centre of mass [m], shape (n,).

        NaN where that is not known: of a body given by K and M without nodes, unless it is free
        and struck through its centre.
        """
        return self._told("centre_displacement")

    @property
    def final_velocity(self) -> FloatArray:
        """Velocity of the centre of mass after the last contact, or at the record's end, m/s, (3,).

        In the axes of the scene, which are those of its meshes: `simulate` has them.

        Raises
        ------
        InputError
            If no velocity and no friction in three directions was given.
        """
        return self._at_end[:3]

    @property
    def final_spin(self) -> FloatArray:
        """Angular velocity then, rad/s, shape (3,); NaN where supports or springs hold the body.

        It has the angular momentum of the body, which deforms.
        """
        return self._at_end[3:]

    @cached_property
    def spin(self) -> FloatArray:
        """Angular velocity over time, rad/s, shape (n, 3), as `final_spin` has it at the end."""
        return read_only(self._whole_motion(self._run.t)[3:].T)

    @cached_property
    def _at_end(self) -> FloatArray:
        """Velocity of the centre of mass and spin after the last contact, shape (6,)."""
        return self._cleared(self._whole_motion(np.array([self._run._parted]))[:, 0])

    def _cleared(self, motion: FloatArray) -> FloatArray:
        """A velocity and a spin, shape (6,), with 0 for the rounding of the largest of the run."""
        oblique = self._run.plan.oblique
        assert oblique is not None
        found = np.reshape(motion, (2, 3))
        sizes = [np.reshape(of, (2, 3)) for of in oblique.velocities]
        largest = np.abs([found, *sizes]).max(axis=(0, 2), keepdims=True)[0]
        return np.where(np.abs(found) < np.finfo(float).eps * largest, 0.0, found).ravel()

    def _whole_motion(self, times: FloatArray) -> FloatArray:
        """Velocity of a body's centre of mass and its spin at times, s, shape (6, times)."""
        run, model = self._run, self._run.plan.bodies[self._number]
        if run.plan.oblique is None:
            raise InputError(
                "this run has one direction of travel; give velocity as a vector and friction= for "
                "velocities and spins in three directions"
            )
        if isinstance(model, FullModel):
            rows = whole_motion(model.body)[0]
        else:
            assert model.modal.whole.velocity is not None
            rows = model.modal.whole.velocity
        _, rates = run.recorder.motion(self._number).observed(rows, times)
        return np.asarray(rates)

    @property
    def centre_velocity(self) -> FloatArray:
        """Velocity of the centre of mass [m/s], shape (n,); see `centre_displacement`."""
        return self._told("centre_velocity")

    @cached_property
    def error(self) -> Mapping[str, FloatArray]:
        """Errors of the histories by the body's model, relative to the largest value of each.

        ``error["velocity"]``, shape (n,), and so of the other three: twice the difference to one
        more run, with models that contain this one and what it leaves out first. To it add the
        errors of mesh and contact. It is empty of a body given by numbers.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> hit = ao.simulate(ao.rigid(mass=0.01), tip, velocity=0.1, law=ao.Linear(k=1e5))
        >>> hit.target.error["velocity"].shape == hit.t.shape
        True
        """
        return errors_of(self._run, self._histories)

    @cached_property
    def _histories(self) -> dict[str, History[Run]]:
        run, moved = self._run, partial(_moved, self._number, "displacement")
        return {
            name: History(
                f"{name.replace('_', ' ')} of {self.name}",
                run,
                partial(_moved, self._number, name),
                run.t,
                moved if name.endswith("velocity") else None,
            )
            for name in self._motion
        }

    def _told(self, name: str) -> FloatArray:
        """Return a history, and warn if it may be badly wrong; displacements often need no run."""
        if name.endswith("velocity") or not follows(self._run, self._number):
            return self._histories[name].told()
        return self._motion[name]

    def displacement_of(self, functional: FloatArray, times: FloatArray) -> FloatArray:
        """Return functionalᵀX at `times`, s, by the model's own shapes; of a wall, its place.

        `probe` gives places better, at the price of a factorisation.

        :meta private:
        """
        response = self._run._response(self._number)
        if response is None:
            return _moved(self._number, "displacement", self._run, times)
        return response.displacement_of(functional, times)


def _moved(number: int, name: str, run: Run, times: FloatArray) -> FloatArray:
    """A motion of a body of a run at times, s."""
    return run.read(lambda of: of.bodies[number]._motion[name], times)


class Eventful:
    """The numbers of one contact's events, as attributes."""

    @property
    def _own_events(self) -> Events:
        raise NotImplementedError

    @property
    def peak_force(self) -> float:
        """Largest force of the record [N]; 0.0 without contact."""
        return self._own_events.peak_force

    @property
    def peak_time(self) -> float:
        """When the largest force acts [s]."""
        return self._own_events.peak_time

    @property
    def impulse(self) -> float:
        """Integral of the force over the record [N s]."""
        return self._own_events.impulse

    @property
    def contact_duration(self) -> float:
        """Duration of the first contact [s]; 0.0 without contact.

        A contact that the record cuts off counts up to the record's end.
        """
        return self._own_events.contact_duration

    @property
    def contact_count(self) -> int:
        """How often the bodies touch."""
        return self._own_events.contact_count


@dataclass(frozen=True, eq=False)
class ContactResult(Frozen, Eventful):
    """One contact over time.

    Attributes
    ----------
    name : str
        As its user called it; "contact 0" without a name.
    force, indentation : (n,) arrays
        Contact force, ≥ 0 in compression [N], and the law's own indentation [m]; see
        ``hit.indentation``.
    elastic, dissipated : (n,) arrays or None
        Energy stored in its law, and lost in it since t = 0 [J]; None without energies.
    events : Events
        Its intervals, peak and impulse.
    law : ContactLaw
        As it was given to `connect`, or found from the surfaces.
    friction_force : (n, 3) array or None
        Force of friction on the second body [N]; the first has the opposite. None without friction.
    stuck : (n,) array or None
        Share of the contact's radius within which it sticks: 1 all, 0 where all slips, or apart.
    friction_energy : (n,) array or None
        Dissipated by friction since t = 0 [J]; None without energies.
    """

    name: str
    force: FloatArray
    indentation: FloatArray
    elastic: FloatArray | None
    dissipated: FloatArray | None
    events: Events
    law: ContactLaw
    friction_force: FloatArray | None = None
    stuck: FloatArray | None = None
    friction_energy: FloatArray | None = None

    @property
    def slip_intervals(self) -> list[tuple[float, float]]:
        """Start and end [s] of every interval in which all of the contact slips.

        One begins with the contact, or where the last point that sticks begins to slip: its centre,
        as a rule. It ends with the contact, or where the first point ceases to slip: there the
        force of friction no longer changes as fast as its bound μF. Both are located to the error
        of the motion, whatever the times of the record; with fixed steps they are interpolated
        between these.
        """
        if self.stuck is None:
            return []
        return list(self.intervals if self.events.slips is None else self.events.slips)

    @property
    def stick_intervals(self) -> list[tuple[float, float]]:
        """Start and end [s] of every interval in which it sticks, at least in one point.

        With `slip_intervals` they make up the intervals of contact.
        """
        found: list[tuple[float, float]] = []
        for start, end in self.intervals if self.stuck is not None else ():
            slips = [span for span in self.slip_intervals if start <= span[0] < end]
            ends = [start, *(time for span in slips for time in span), end]
            found += [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b > a]
        return found

    @property
    def _own_events(self) -> Events:
        return self.events

    @property
    def intervals(self) -> list[tuple[float, float]]:
        """Start and end [s] of every interval in which the force acts."""
        return list(self.events.contacts)

    @property
    def dent(self) -> Dent:
        """Residual dent, ``depth`` and ``diameter`` [m]; see `ContactLaw.dent`."""
        deepest = float(self.indentation.max(initial=0.0))
        return self.law.dent(deepest) if deepest > 0.0 else Dent(0.0, 0.0)


@dataclass(frozen=True)
class Cost:
    """Computing time of a result, s.

    Attributes
    ----------
    model : float
        To choose and to make the bodies' models, with the runs that this takes; 0 where models were
        given.
    run : float
        The run itself.

    Examples
    --------
    >>> import aoimpact as ao
    >>> hit = ao.simulate(projectile=ao.rigid(mass=1.0), target=ao.rigid(mass=2.0),
    ...                   law=ao.Hertz(k=1e9), velocity=1.0)
    >>> hit.cost.model, hit.cost.run < 1.0
    (0.0, True)
    """

    model: float
    run: float

    def __str__(self) -> str:
        made = f"model {with_unit(self.model, 's', 2)}, " if self.model else ""
        return f"{made}run {with_unit(self.run, 's', 2)}"
