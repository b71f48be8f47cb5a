"""The result of a run: motions of the bodies, contacts and energies over time, and its numbers.

Histories are read-only arrays over `Run.t`. Displacements and velocities, also of centres of mass,
are components along the direction of travel; displacements are zero at t = 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from ..base import (
    FilePath,
    FloatArray,
    Found,
    Frozen,
    InputError,
    integer,
    read_only,
    text,
    with_unit,
)
from ..fem import whole_motion
from ..fields import History, Measured, errors_of, response_of, times_within, write_movie
from ..integrate import Events, Recorder
from ..laws import ContactLaw, Dent, own_law
from ..reduction import FullModel
from ..scene import Scenario
from . import plot as figures
from . import table
from .advice import Advice, advice, follows, warn_of_ledger, warn_of_mesh
from .errors import Chosen, ErrorEstimate, ErrorParts, LeftOut
from .quantities import INSTANTS, QUANTITIES, look_up, number, number_errors, read
from .summary import impact_rows, scene_rows, summary_text
from .table import ROLES, different

# Start and end of each interval, s.
Spans = list[tuple[float, float]]


@dataclass(frozen=True, eq=False)
class BodyEnergy(Frozen):
    """Energy of one body over time [J].

    Attributes
    ----------
    kinetic, elastic : (n,) arrays
        Kinetic energy, and strain energy without the energy of the indentation, which belongs to
        the contact law: the paper's nonlocal energy. The strain energy is slightly negative where
        the law's half-space is more compliant than the body, such as a ball.
    dissipated, work : (n,) arrays
        Energy lost in the body's damping, and work of gravity and applied forces on it, since
        t = 0.
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
        Energy stored in the contact laws: the paper's local deformation energy.
    dissipated : array
        Energy lost in the contact laws, by friction and in the bodies' damping since t = 0.
    work : array
        Work of gravity and applied forces since t = 0.
    friction : array
        Part of `dissipated` that is lost by friction.
    total : array
        kinetic + elastic + contact + dissipated − work: constant in an exact run.
    bodies : tuple of BodyEnergy
        Energies of each body.
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
        """Energies of the first body."""
        return self.bodies[0]

    @property
    def target(self) -> BodyEnergy:
        """Energies of the second body."""
        return self.bodies[1]


@dataclass(frozen=True, eq=False)
class BodyResult(Frozen, Measured):
    """Motion of one body over time.

    Attributes
    ----------
    name : str
        Name given by the user, by default "projectile" or "target", in a scene "body 0".
    label : str
        Kind of the model, such as "rigid", "AO(1)", "modal(40)", "full(3159)".
    mass : float or None
        Total mass [kg]; None where it is not known.
    constrained : bool
        True if supports or a ground spring constrain the body.
    port_displacements, port_velocities : (p, n) arrays
        Displacements and velocities of all contact coordinates [m, m/s].
    """

    name: str
    label: str
    mass: float | None
    constrained: bool
    port_displacements: FloatArray
    port_velocities: FloatArray
    _motion: dict[str, FloatArray] = field(repr=False)
    _run: Run = field(repr=False)
    _number: int = field(repr=False)  # number of the body in the scene

    def __repr__(self) -> str:
        mass = "" if self.mass in (None, math.inf) else f", {self.mass:.4g} kg"
        way = "constrained" if self.constrained else "free"
        return f"BodyResult({self.name}: {self.label}{mass}, {way})"

    @property
    def displacement(self) -> FloatArray:
        """Displacement of the (first) contact coordinate [m], shape (n,).

        Warns, as all histories of a body do, if its error may be large; see `error`.
        """
        return self._told("displacement")

    @property
    def velocity(self) -> FloatArray:
        """Velocity of the (first) contact coordinate [m/s], shape (n,)."""
        return self._told("velocity")

    @property
    def centre_displacement(self) -> FloatArray:
        """Displacement of the centre of mass [m], shape (n,).

        NaN for a body given by K and M without nodes, whose centre of mass is not known, unless
        the body is free and struck through it.
        """
        return self._told("centre_displacement")

    @property
    def energy(self) -> BodyEnergy | None:
        """Energies of the body; None if the run was made with ``energies=False``."""
        return self._run.energy.bodies[self._number] if self._run.plan.energies else None

    @property
    def final_velocity(self) -> FloatArray:
        """Velocity of the centre of mass after the last contact, or at the record's end, m/s, (3,).

        The axes are those of the scene and its meshes; see `simulate`.

        Raises
        ------
        InputError
            If the run has only one direction of travel.
        """
        return self._at_end[:3]

    @property
    def final_spin(self) -> FloatArray:
        """Angular velocity after the last contact, rad/s, shape (3,); NaN for a constrained body.

        The velocity is the spin of a rigid body with the same angular momentum as the deforming
        body.
        """
        return self._at_end[3:]

    @cached_property
    def spin(self) -> FloatArray:
        """Angular velocity over time, rad/s, shape (n, 3), defined as for `final_spin`."""
        return read_only(self._run._whole_motion(self._number, self._run.t)[3:].T)

    @cached_property
    def _at_end(self) -> FloatArray:
        return self._run.motion_at(self._number)

    @property
    def centre_velocity(self) -> FloatArray:
        """Velocity of the centre of mass [m/s], shape (n,); see `centre_displacement`."""
        return self._told("centre_velocity")

    @cached_property
    def error(self) -> Mapping[str, FloatArray]:
        """Errors of the histories due to mesh and model, relative to the largest value of each.

        ``error["velocity"]``, shape (n,), is twice the difference from the run with other elements;
        the errors of ``displacement``, ``centre_displacement`` and ``centre_velocity`` are defined
        alike. Errors of the contact law come in addition. The mapping is empty for a body given by
        numbers.

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
    def _histories(self) -> dict[str, History]:
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
        """Return a history; warn if its error may be large. The estimate may take another run."""
        if name.endswith("velocity") or not follows(self._run, self._number):
            return self._histories[name].told()
        return self._motion[name]

    def displacement_of(self, functional: FloatArray, times: FloatArray) -> FloatArray:
        """Return functionalᵀX, m, at `times`, s, from the model's shapes; for a wall, its motion.

        `probe` is more accurate at the price of a factorisation.

        :meta private:
        """
        response = response_of(self._run, self._number)
        if response is None:
            return _moved(self._number, "displacement", self._run, times)
        return response.displacement_of(functional, times)


def _moved(number: int, name: str, run: Run, times: FloatArray) -> FloatArray:
    """Return the history `name` of body `number` of a run at times, s."""
    return read(lambda of: of.bodies[number]._motion[name], run, times)


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
        """Time of the largest force [s]."""
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
        """Number of times that the bodies touch."""
        return self._own_events.contact_count


@dataclass(frozen=True, eq=False)
class ContactResult(Frozen, Eventful):
    """One contact over time.

    Attributes
    ----------
    name : str
        Name given by the user, by default such as "contact 0".
    force, indentation : (n,) arrays
        Contact force, ≥ 0 in compression [N], and indentation of the contact law [m]; see
        ``hit.indentation``.
    elastic, dissipated : (n,) arrays or None
        Energy stored in the law, and lost in it since t = 0 [J]; None without energies.
    events : Events
        Intervals of contact, peak force and impulse.
    law : ContactLaw
        Law given to `connect`, or found from the surfaces.
    friction_force : (n, 3) array or None
        Friction force on the second body [N]; the force on the first is opposite. None without
        friction.
    stuck : (n,) array or None
        Ratio of the radius of the stick zone to the contact radius: 1 in full stick, 0 in full slip
        or without contact.
    friction_energy : (n,) array or None
        Energy dissipated by friction since t = 0 [J]; None without energies.
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
    def slip_intervals(self) -> Spans:
        """Start and end [s] of every interval of full slip.

        Full slip begins with the contact, or where the last sticking point, usually the centre,
        begins to slip. Full slip ends with the contact, or where the first point ceases to slip:
        there the friction force no longer changes as fast as its bound μF. An adaptive run locates
        both times to the error of the motion; with fixed steps they are interpolated between the
        steps.
        """
        if self.stuck is None:
            return []
        return list(self.intervals if self.events.slips is None else self.events.slips)

    @property
    def stick_intervals(self) -> Spans:
        """Start and end [s] of every interval in which at least one point of the contact sticks.

        Stick and slip intervals together cover the intervals of contact.
        """
        found: Spans = []
        for start, end in self.intervals if self.stuck is not None else ():
            slips = [span for span in self.slip_intervals if start <= span[0] < end]
            ends = [start, *(time for span in slips for time in span), end]
            found += [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b > a]
        return found

    @property
    def _own_events(self) -> Events:
        return self.events

    @property
    def intervals(self) -> Spans:
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
        Time to choose and make the bodies' models, including the runs that the choice needs; 0 if
        models were given.
    run : float
        Time of the run itself.

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


_NOTHING_KNOWN = LeftOut()

# Numbers of points of a curve. _PER_PERIOD: points per shortest period of the models; _MOST: total
# number at most.
_PER_PERIOD, _MOST = 20, 20_000


@dataclass(frozen=True)
class Handle:
    """Identifies a body of a scene, or one of its contact points, in calls and results.

    Attributes
    ----------
    body : int
        Number of the body in the order of `add`.
    at : int
        Number of the contact point, for a body with several; see `port`.
    name : str
        Name of the body, for messages.
    scene : str
        Unique identifier of the scene.

    Examples
    --------
    >>> scene = ao.Scene()
    >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0)
    >>> wall = scene.add(ao.rigid(mass=float("inf")))
    >>> number = scene.connect(ball, wall, ao.Hertz(k=1e9))
    >>> run = scene.simulate(duration=1e-3)
    >>> round(float(run[ball].velocity[-1]), 6)
    -1.0
    """

    body: int
    at: int = 0
    name: str = field(default="", compare=False)
    scene: str = field(default="", compare=False, repr=False, metadata={"identity": True})

    def port(self, at: int) -> Handle:
        """Return the handle of the body's contact point number `at`, in the order of `tips`.

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> scene = ao.Scene()
        >>> struck = scene.add([bar.contact(point=(x, 0.005, 0.01)) for x in (0.05, 0.09)])
        >>> struck.port(1) != struck.port(0)
        True
        """
        return replace(self, at=integer("at", at, low=0))


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """Result of a simulated scene, whose histories are computed when they are read.

    ``run[handle]`` is a body's motion, ``run.contacts[i]`` a contact in the order of `connect`.

    Attributes
    ----------
    time_error : float or None
        Relative error of peak force and impulse due to time integration.
    chosen : Chosen or None
        Quantities, tolerance and errors of models that `simulate` chose; None for given models.
    modelled : float
        Computing time to choose and make the models, s.

    Examples
    --------
    >>> scene = ao.Scene()
    >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0)
    >>> wall = scene.add(ao.rigid(mass=float("inf")))
    >>> number = scene.connect(ball, wall, ao.Hertz(k=1e9), name="wall")
    >>> run = scene.simulate(duration=1e-3)
    >>> run.contacts[number].name, len(run.contacts[number].intervals)
    ('wall', 1)
    >>> round(float(run.at([0.0])[ball].velocity[0]), 6)
    1.0
    """

    plan: Scenario  # bodies, contacts and loads that were integrated
    recorder: Recorder  # the solver's own record, from which curves are read
    time_error: float | None
    chosen: Chosen | None = None
    asked: FloatArray | None = None  # the times of `at`, s; None for the solver's own
    # Errors due to meshes and contact laws, or the function of the run that estimates these errors
    # when one is first read.
    left_out: LeftOut | Callable[[Run], LeftOut] = _NOTHING_KNOWN
    # Run with the bodies as the user meshed them, if this run has finer elements.
    beside: Run | None = None
    # Function that returns runs with other elements; the differences from them give the errors of
    # histories.
    other_runs: Callable[[Run], list[Run | float]] | None = None
    modelled: float = 0.0
    said: tuple[str, ...] = ()  # warnings of the run, which `simulate` issues

    def __getstate__(self) -> dict[str, Any]:
        """Drop caches; evaluate the error estimate first, since its callable is not picklable."""
        state = {item.name: getattr(self, item.name) for item in fields(self)}
        return state | {"left_out": self._left_out}

    @cached_property
    def _left_out(self) -> LeftOut:
        known = self.left_out
        return known(replace(self, asked=None)) if callable(known) else known

    # ------------------------------------------------------------------- what was run

    @property
    def duration(self) -> float:
        """Length of the record, s."""
        return self.recorder.duration

    @property
    def cost(self) -> Cost:
        """Computing time of the models and of the run, s."""
        return Cost(self.modelled, self.recorder.seconds)

    @property
    def models(self) -> tuple[Any, ...]:
        """The bodies' models, chosen or given, in the order of `add`."""
        return tuple(self.plan.bodies)

    @property
    def solver(self) -> str:
        """Description of the time integration."""
        return self.recorder.solver

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies, all different."""
        others = (
            ROLES if not self.plan.scene else [f"body {i}" for i in range(len(self.plan.bodies))]
        )
        return different(self.plan.body_names, others)

    @cached_property
    def contact_names(self) -> tuple[str, ...]:
        """Names of the contacts, all different."""
        given = [contact.name for contact in self.plan.contacts]
        return different(given, [f"contact {i}" for i in range(len(given))])

    # ------------------------------------------------------------------- histories

    @cached_property
    def t(self) -> FloatArray:
        """Times [s], shape (n,)."""
        return read_only(self.recorder.times if self.asked is None else self.asked)

    def even_times(self, start: float, end: float) -> FloatArray:
        """Return evenly spaced times, s, enough for all vibration but at most `_MOST`.

        :meta private:
        """
        fastest = max((float(of.omega.max(initial=0.0)) for of in self.plan.modal), default=0.0)
        wanted = _PER_PERIOD * (end - start) * fastest / (2.0 * math.pi)
        return np.linspace(start, end, int(np.clip(wanted, INSTANTS, _MOST)))

    @cached_property
    def _rows(self) -> FloatArray:
        return read_only(self.recorder.rows(self.t, self.plan.energies))

    @cached_property
    def pushes(self) -> FloatArray:
        """Contact forces, N, each followed by its friction forces along two tangents, if any.

        If there is no friction, the motions, which cost more, are not computed.

        :meta private:
        """
        if "_rows" in self.__dict__:
            return self.plan.layout.pushes(self._rows)
        return read_only(self.recorder.pushes(self.t))

    @cached_property
    def bodies(self) -> tuple[BodyResult, ...]:
        """The motions of the bodies, in the order of `add`."""
        return tuple(self._body(i) for i in range(len(self.plan.bodies)))

    def __getitem__(self, body: Handle | int) -> BodyResult:
        if isinstance(body, Handle) and body.scene != self.plan.scene:
            raise InputError(f"{body!r} is of another scene; take a handle of this run's scene")
        index = body.body if isinstance(body, Handle) else body
        return self.bodies[integer("body", index, low=0, high=len(self.bodies) - 1)]

    def _body(self, index: int) -> BodyResult:
        body, rows = self.plan.bodies[index], self.plan.layout.body(self._rows, index)
        unknown = np.full((2, len(self.t)), np.nan)
        centre = (rows.displacement, rows.velocity) if body.centre_known else unknown
        motion = rows.port_displacements[0], rows.port_velocities[0], *centre
        names = "displacement", "velocity", "centre_displacement", "centre_velocity"
        return BodyResult(
            self.names[index],
            body.label,
            body.known_mass,
            body.constrained,
            rows.port_displacements,
            rows.port_velocities,
            dict(zip(names, map(read_only, motion), strict=True)),
            self,
            index,
        )

    @property
    def _parted(self) -> float:
        """Time at which the last contact or, without contact, the record ends, s.

        In a run with fixed steps, the time is rounded up to the next step.
        """
        touching, end = self.touching, self.duration
        end = end if touching is None else min(touching[1], end)
        if self.recorder.dense:
            return end
        steps = self.recorder.times
        return float(steps[np.searchsorted(steps, end)])

    @property
    def accelerated(self) -> float | None:
        """Start of the first contact, s, if gravity or loads act until then; else None.

        :meta private:
        """
        acts = self.plan.weighed or self.plan.loads
        return self.touching[0] if acts and self.touching is not None else None

    @cached_property
    def velocities_before(self) -> FloatArray:
        """Velocities of the bodies as the first contact begins, m/s; 0 for bodies held at rest.

        :meta private:
        """
        before = np.array(self.plan.velocities, float)
        if self.accelerated is None:
            return before
        held = [of.constrained for of in self.plan.bodies] & (before == 0.0)
        return np.where(held, 0.0, self.mean_velocities(self.accelerated))

    def motion_at(self, body: int, time: float | None = None) -> FloatArray:
        """Return the velocity of a body's centre of mass and its spin, m/s and rad/s, shape (6,).

        By default the time is the end of the last contact or, without contact, of the record.
        Rounding errors are set to 0.

        :meta private:
        """
        both = self._whole_motion(body, np.array([0.0, self._parted if time is None else time]))
        size = np.abs(both).reshape(2, -1).max(axis=1).repeat(3)
        return np.where(np.abs(both[:, 1]) < np.finfo(float).eps * size, 0.0, both[:, 1])

    def _whole_motion(self, body: int, times: FloatArray) -> FloatArray:
        """Return the velocity of a body's centre of mass and its spin at times, s, (6, times)."""
        model = self.plan.bodies[body]
        if self.plan.oblique is None:
            raise InputError(
                "this run has one direction of travel; give velocity as a vector and friction= for "
                "velocities and spins in three directions"
            )
        full = isinstance(model, FullModel)
        rows = whole_motion(model.body)[0] if full else model.modal.whole.velocity
        assert rows is not None
        return self.recorder.motion(body).observed(rows, times)[1]

    @cached_property
    def others(self) -> list[Run]:
        """The runs with which histories are compared; empty if one of them fails.

        :meta private:
        """
        if self.other_runs is None or FullModel in map(type, self.plan.bodies):
            return []  # the mesh error of a full body is not known
        found = self.other_runs(replace(self, asked=None))
        runs = [of for of in found if isinstance(of, Run)]
        return runs if len(runs) == len(found) else []

    @cached_property
    def compared_velocities(self) -> FloatArray:
        """`mean_velocities` when the last contact, or else the record, ends, m/s, shape (bodies,).

        :meta private:
        """
        return self.mean_velocities(self._parted)

    def mean_velocities(self, time: float) -> FloatArray:
        """Return the velocities of the centres of mass at a time, s, shape (bodies,), m/s.

        Where a centre of mass is not known, the body's mean velocity weighted with its static mode
        is returned, so that runs can still be compared.

        :meta private:
        """
        rows = self.recorder.rows(np.array([time]), energies=False)
        return read_only(self.plan.layout.centre_velocities(rows)[:, 0])

    @property
    def contacts(self) -> Any:
        """The contacts, in the order of `connect`; see `ContactResult`."""
        return self.each_contact

    @cached_property
    def each_contact(self) -> tuple[ContactResult, ...]:
        """The contacts of any run, also of a `Result`, whose attribute `contacts` has intervals.

        :meta private:
        """
        return tuple(map(self._contact, range(len(self.events))))

    def _contact(self, number: int) -> ContactResult:
        plan, contact = self.plan, self.plan.contacts[number]
        rows, zero = plan.layout.contact(self._rows, number), np.zeros(len(self.t))
        stored = rows.elastic + 0.5 * math.fsum(contact.removed) * rows.force**2
        pushed, stuck, lost = None, None, None
        if plan.oblique is not None:
            pushed, stuck, lost = np.zeros((len(self.t), 3)), zero, zero  # without friction
            if rows.tangential is not None and rows.stuck is not None:
                pushed = rows.tangential.T @ plan.oblique.axes[1:]
                stuck, lost = np.sqrt(rows.stuck), rows.friction
        return ContactResult(
            self.contact_names[number],
            rows.force,
            contact.own_indentation(rows),
            stored if self.plan.energies else None,
            rows.dissipated if self.plan.energies else None,
            self.events[number],
            own_law(contact.law),
            pushed,
            stuck,
            lost if self.plan.energies else None,
        )

    def deepest(self, number: int) -> float:
        """Return the largest indentation of a contact's law, m, without keeping its history.

        :meta private:
        """
        times = self.recorder.times
        if self.recorder.dense:  # most laws are deepest where the force is largest
            times = np.union1d(times, self.events[number].peak_time)
        rows = self.plan.layout.contact(self.recorder.rows(times, energies=False), number)
        return float(self.plan.contacts[number].own_indentation(rows).max(initial=0.0))

    @cached_property
    def energy(self) -> Energy:
        """Energies over time.

        Raises
        ------
        InputError
            If the run did not record energies.
        """
        if not self.plan.energies:
            raise InputError("energies: this run has none; call simulate(..., energies=True)")
        layout, contacts, nothing = self.plan.layout, self.each_contact, np.zeros(len(self.t))
        recorded = [layout.body(self._rows, number) for number in range(len(layout.ports))]
        strain = [of.elastic.copy() for of in recorded]
        for between, touch in zip(self.plan.contacts, contacts, strict=True):
            # The energy c F²/2 of the meshes' own indentation belongs to the law, not to the strain
            # energy.
            for port, c in zip(between.ports, between.removed, strict=True):
                strain[port.body] -= 0.5 * c * touch.force**2
        bodies = tuple(
            BodyEnergy(of.kinetic, elastic, of.dissipated, of.work)
            for of, elastic in zip(recorded, strain, strict=True)
        )
        kinetic, elastic, lost, work = np.sum([[*vars(of).values()] for of in bodies], axis=0)
        parts: Any = [(of.elastic, of.dissipated, of.friction_energy) for of in contacts]
        contact, by_law, friction = (
            sum((of for of in each if of is not None), nothing)
            for each in zip((nothing,) * 3, *parts, strict=True)
        )
        dissipated = by_law + lost + friction
        total = kinetic + elastic + contact + dissipated - work
        return Energy(kinetic, elastic, contact, dissipated, work, total, bodies, friction)

    def at(self, times: npt.ArrayLike) -> Self:
        """Return the same run at other times, by dense output as accurate as the run itself.

        Parameters
        ----------
        times : array_like, shape (m,)
            Ascending times within the record [s]; an empty array gives empty histories.

        Raises
        ------
        InputError
            If the run was made with fixed steps, between which nothing is known, or the times do
            not ascend within the record.

        Examples
        --------
        >>> scene = ao.Scene()
        >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0)
        >>> wall = scene.add(ao.rigid(mass=float("inf")))
        >>> number = scene.connect(ball, wall, ao.Hertz(k=1e9))
        >>> run = scene.simulate(duration=1e-3)
        >>> run.at([0.0, 1e-4])[ball].displacement.shape
        (2,)
        """
        if not self.recorder.dense:
            raise InputError(
                "times: nothing is known between this run's fixed steps; take its own t, or "
                "simulate(..., solver=Adaptive(...))"
            )
        wanted = np.minimum(times_within(times, self.duration), self.duration)
        return replace(self, asked=wanted)

    # ---------------------------------------------------------------------- events

    @cached_property
    def events(self) -> tuple[Events, ...]:
        """Events of each contact, located by the solver or interpolated between fixed steps."""
        return self.recorder.events

    @property
    def touching(self) -> tuple[float, float] | None:
        """Start of the first contact and end of the last one, s; None without contact.

        :meta private:
        """
        spans = [span for events in self.events for span in events.contacts]
        return (min(spans)[0], max(end for _, end in spans)) if spans else None

    @cached_property
    def numbers(self) -> Mapping[str, float]:
        """Numbers that summarise the run; the keys are the names that `value` takes."""
        numeric = [of for of in QUANTITIES.values() if not of.is_history]

        def find(name: str) -> float:
            _, at, values = number(self, name)
            return float(values[at])

        return Found(lambda: [name for of in numeric for name in of.names(self)], find)

    @cached_property
    def compared(self) -> dict[str, FloatArray]:
        """Cache of `Quantity.compared`, by the quantity's name.

        :meta private:
        """
        return {}

    def value(self, name: str) -> float:
        """Return a number of the run by its name.

        Parameters
        ----------
        name : str
            Name of a number as in `ErrorEstimate`: "restitution", or in a scene
            "contacts.0.peak_force" and "bodies.0.rebound_velocity". The name of a history that the
            models were chosen for, such as "reaction", means its largest value. Any attribute that
            is a number has a name, such as "error.time", or "bodies.0.final_spin.2" for a component
            of a vector.

        Returns
        -------
        float
            NaN where there is no such number, such as the restitution of bodies that have not
            parted.

        Raises
        ------
        InputError, InputTypeError
            If there is no number of that name.

        Examples
        --------
        >>> scene = ao.Scene()
        >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0)
        >>> wall = scene.add(ao.rigid(mass=float("inf")))
        >>> number = scene.connect(ball, wall, ao.Hertz(k=1e9))
        >>> run = scene.simulate(duration=1e-3)
        >>> round(run.value("restitution"), 6), round(run.value("bodies.0.rebound_velocity"), 6)
        (1.0, -1.0)
        """
        return look_up(self, text("name", name), "name")

    @property
    def in_contact_at_end(self) -> bool:
        """True if the record ends in contact, so that its numbers are not final."""
        return any(events.last_until(self.duration) for events in self.events)

    @cached_property
    def error(self) -> ErrorEstimate:
        """Errors of the quantity of interest; ``error["restitution"]`` has a number's errors."""
        energy, models = None, self.plan.bodies
        walls = [i for i, body in enumerate(models) if body.wall]
        # The work of a moving wall is not known; without this work the total energy is not
        # constant.
        if self.plan.energies and not any(self.bodies[i].port_velocities.any() for i in walls):
            of = (replace(self, asked=self.recorder.marks) if self.recorder.dense else self).energy
            stored = float((of.kinetic + of.elastic + of.contact).max())
            energy = float(np.ptp(of.total) / stored) if stored > 0.0 else None
            if self.recorder.dense and energy is not None:
                warn_of_ledger(energy, self.time_error)
        names = number_errors(self, ())
        full = [model for model in models if isinstance(model, FullModel)]
        whole = full and all(of in full for of in models if of.tips)
        quantities, rtol, absent = list[str](), None, None
        # Full models have no model error.
        by_model: Mapping[str, float] = names if whole else {}
        if self.chosen is not None:
            quantities, rtol = list(self.chosen.quantities), self.chosen.rtol
            by_model, absent = self.chosen.numbers, None if self.plan.meshed else 0.0
        out = self._left_out

        def parts(name: str) -> ErrorParts:
            if name not in names and name not in by_model:
                raise KeyError(name)
            if math.isnan(self.numbers.get(name, 0.0)):  # there is no such number
                return ErrorParts(*[math.nan] * 4)
            mesh, contact = out.mesh.get(name, absent), out.contact.get(name, absent)
            return ErrorParts(mesh, contact, by_model.get(name), self.time_error)

        found = Found(lambda: {**names, **by_model}, parts)
        for name in quantities or ["force"]:
            warn_of_mesh(self, name, found[name])
        quantity = quantities[0] if quantities else None
        main = found[quantity or "force"]
        sources = main.mesh, main.contact, main.model, main.time
        return ErrorEstimate(*sources, found, energy, quantity, rtol, out.worst_time)

    # ---------------------------------------------------------------------- output

    to_csv, to_dataframe, to_xarray = table.to_csv, table.to_dataframe, table.to_xarray
    plot_force = figures.plot_force
    plot_displacement = figures.plot_displacement
    plot_energy = figures.plot_energy

    def __repr__(self) -> str:
        return summary_text(f"Run of {with_unit(self.duration, 's')}", scene_rows(self), 12)


@dataclass(frozen=True, eq=False, repr=False)
class Result(Eventful, Run):
    """An impact of a projectile on a target: a `Run` of two bodies, with its contact's numbers.

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

    @property
    def velocity(self) -> float:
        """Initial velocity of the projectile [m/s]."""
        return self.plan.velocities[0]

    @property
    def gap(self) -> float:
        """Initial gap [m]."""
        return self.plan.contacts[0].gap

    @property
    def law(self) -> Any:
        """The contact law, given or found from the surfaces."""
        return own_law(self.plan.contacts[0].law)

    @property
    def force(self) -> FloatArray:
        """Contact force, ≥ 0 in compression [N], shape (n,)."""
        return self.each_contact[0].force

    @property
    def indentation(self) -> FloatArray:
        """Indentation of the contact law [m], shape (n,): (F/k)^(2/3) for Hertz's on any mesh.

        The indentation is the projectile's minus the target's contact coordinate minus the initial
        gap, plus c F, where c is the local compliance of the meshes, which replaces the
        half-spaces' compliance. The indentation is negative while the bodies are apart.
        """
        return self.each_contact[0].indentation

    @property
    def friction_force(self) -> FloatArray:
        """Friction force on the target [N], shape (n, 3), opposite to that on the projectile.

        The axes are those of the target's mesh, as for the argument `velocity` of `simulate`.

        Raises
        ------
        InputError
            If the impact has no friction.
        """
        return self._with_friction("friction_force")

    @property
    def stuck(self) -> FloatArray:
        """Ratio of the radius of the stick zone to the contact radius, shape (n,)."""
        return self._with_friction("stuck")

    @property
    def slip_intervals(self) -> Spans:
        """Start and end [s] of every interval of full slip; see `ContactResult`."""
        return self.each_contact[0].slip_intervals

    @property
    def stick_intervals(self) -> Spans:
        """Start and end [s] of every interval in which at least one point of the contact sticks."""
        return self.each_contact[0].stick_intervals

    def _with_friction(self, name: str) -> FloatArray:
        found: FloatArray | None = getattr(self.each_contact[0], name)
        if found is None:
            raise InputError(f"{name}: this impact has no friction; give simulate(..., friction=)")
        return found

    def _number(self, quantity: str) -> float:
        values = QUANTITIES[quantity].values(self)
        return float(values[0]) if len(values) else math.nan

    @property
    def tangential_restitution(self) -> float:
        """Ratio of the tangential velocities after the last contact and before the first one.

        The velocity is that of the projectile's centre of mass relative to the target's, along its
        initial direction; the ratio is negative if it reverses. NaN where `restitution` is NaN, and
        without an initial tangential velocity.
        """
        return self._number("tangential_restitution")

    @property
    def projectile(self) -> BodyResult:
        """The projectile's motion."""
        return self.bodies[0]

    @property
    def target(self) -> BodyResult:
        """The target's motion."""
        return self.bodies[1]

    @property
    def approach(self) -> FloatArray:
        """Approach of the centres of mass, projectile's minus target's minus the gap [m].

        The force as a function of the approach is the paper's modified interaction law (Fig. 7):
        with that law, two rigid masses would have the same force over time.
        """
        first, second = (body.centre_displacement for body in self.bodies)
        return first - second - self.gap

    @property
    def _own_events(self) -> Events:
        return self.events[0]

    @property
    def contacts(self) -> Spans:
        """Start and end [s] of every contact; empty without contact."""
        return list(self.events[0].contacts)

    @property
    def contact_radius(self) -> float:
        """Largest radius of the contact, √(R δ) [m]; NaN for a law without a known surface.

        For an elliptic contact of semi-axes a and b the radius is √(a b).
        """
        found = self.plan.round_contact(self.plan.contacts[0])
        if found is None:
            return math.nan
        if (diameter := self.dent.diameter) > 0.0:
            return 0.5 * diameter
        return found.narrowing * math.sqrt(found.radius * self.deepest(0))

    @property
    def dent(self) -> Dent:
        """Residual dent, ``depth`` and ``diameter`` [m]; see `ContactLaw.dent`."""
        return self.each_contact[0].dent

    @property
    def advice(self) -> tuple[Advice, ...]:
        """Results of the checks of linear elasticity that the summary lists; see `Advice`.

        The checks are of yield, deflection, mass ratio and speed, as far as they are known.

        Examples
        --------
        >>> ball = ao.ball(0.01, ao.Material(E=210e9, nu=0.3, rho=7800, yield_strength=1e9))
        >>> hit = ao.simulate(projectile=ball, target=ball, velocity=0.01)
        >>> [(of.name, of.within) for of in hit.advice]
        [('yield', True), ('speed', True)]
        """
        return tuple(row for row in advice(self, 0) if row.meaning)

    @property
    def hertz_pressure(self) -> float:
        """Largest Hertzian pressure, 3 F/(2 π a b) [Pa]; NaN for a law without a known surface."""
        width = self.contact_radius
        return 1.5 * self.peak_force / (math.pi * width**2) if width > 0.0 else math.nan

    @property
    def rebound_velocity(self) -> float:
        """Velocity of the projectile's centre of mass after the last contact [m/s].

        NaN if the bodies have not met, the record ends in contact, or the centre of mass is not
        known (see `BodyResult`).
        """
        return self._number("rebound_velocity")

    @property
    def restitution(self) -> float:
        """Coefficient of restitution, from velocities of centres of mass after the last contact.

        The coefficient is (v_target − v_projectile) / V for a free target, −v_projectile / V for
        one that is constrained or of infinite mass. NaN without a rebound, and where a centre of
        mass is not known.
        """
        return self._number("restitution")

    plot = figures.plot
    plot_indentation = figures.plot_indentation
    plot_interaction = figures.plot_interaction

    def movie(
        self,
        path: FilePath,
        *,
        times: npt.ArrayLike | None = None,
        frames: int = 60,
        scale: float | None = None,
        fps: float = 15.0,
    ) -> Path:
        """Write a movie of the impact, coloured by von Mises stress.

        Displacements, including rigid-body motion, are enlarged by a factor shown in the picture.
        The target is drawn in the coordinates of its mesh; the projectile is turned and moved to
        touch it. A body without elements is drawn if it is a ball. The highest 2 % of the stresses,
        mostly under the contact, share the last colour.

        Parameters
        ----------
        path : path
            File to write, ending in .gif or .mp4.
        times : array_like, shape (k,), optional
            Ascending times of the frames within the record, s; by default `frames` times from
            shortly before the contact to shortly after it.
        frames : int, optional
            Number of frames, if `times` is not given.
        scale : float, optional
            Enlargement of displacements; by default 1, 2 or 5 times a power of ten that makes them
            visible.
        fps : float, optional
            Frames per second.

        Returns
        -------
        Path

        Raises
        ------
        MissingPackageError
            If PyVista or, for .mp4, imageio and imageio-ffmpeg are not installed.
        InputError
            If no body has elements, a movie cannot be written to `path`, or a time is outside the
            record.

        Examples
        --------
        >>> hit.movie("impact.gif", frames=40)  # doctest: +SKIP
        """
        count = integer("frames", frames, low=2, high=10_000)
        wanted = np.linspace(*figures.span_of(self, "contact"), count)
        if times is not None:
            wanted = times_within(times, self.duration)
        return write_movie(path, fps, lambda: figures.shown_bodies(self, wanted), wanted, scale)

    def __repr__(self) -> str:
        return summary_text("Impact", impact_rows(self), 18)
