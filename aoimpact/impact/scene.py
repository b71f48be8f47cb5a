"""Scenes of any number of bodies and contacts along one direction of travel, and their runs."""

from __future__ import annotations

import math
import uuid
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
import numpy.typing as npt

from ..accuracy import (
    Sensor,
    checked_linear_solver,
    choose_models,
    errors_left_out,
    finer_run,
    scene_quantity,
)
from ..base import (
    FloatArray,
    InputError,
    InputTypeError,
    LawLimitError,
    bar,
    boolean,
    finite_array,
    real,
    spelled,
    text,
    warn,
)
from ..fem import ContactPoint, Layers
from ..integrate import Newmark
from ..laws import ContactLaw, own_law
from ..linalg import LinearSolver, Solver
from ..reduction import BodyModel, FullModel, body_model
from ..results import (
    Handle,
    Quantity,
    RecordLength,
    Run,
    TimeSolver,
    solve,
    warn_of_bodies,
    warn_of_misfit,
    warn_of_run,
)
from ..scene import (
    Contact,
    Friction,
    Load,
    Oblique,
    Plan,
    Port,
    normal_gap,
    oblique_compliance,
    stiffness_ratio,
)
from .defaults import (
    Meeting,
    checked_duration,
    checked_gravity,
    checked_speed,
    chosen_law,
    contact_width,
    fitted,
    meeting,
    turns,
)
from .oblique import (
    ROLES,
    axes_of,
    checked_friction,
    checked_spin,
    refuse_held,
    refuse_plastic,
    vector_or_number,
    with_functionals,
    with_tangents,
)


@dataclass(frozen=True)
class _Mark:
    """Tells the handles of one scene from those of another."""

    name: str = field(metadata={"identity": True})


class Scene:
    """Bodies, the contacts between them, and what acts on them.

    All displacements are measured along one direction of travel. Bodies are added, connected and
    loaded, then the scene is simulated; and again, with more bodies or other solvers.

    Parameters
    ----------
    gravity : float or array_like, shape (3,), optional
        Acceleration of every finite mass along the direction of travel, or in three directions (see
        `simulate`), m/s², up to 1e12. A body
        constrained by supports takes its true share where it has nodes; a constrained AO model
        given by numbers takes none.

    Examples
    --------
    >>> scene = Scene()
    >>> ball = scene.add(rigid(mass=0.03), velocity=1.0)
    >>> wall = scene.add(rigid(mass=math.inf))
    >>> contact = scene.connect(ball, wall, Hertz(k=1e10))
    >>> run = scene.simulate(duration=1e-3)
    >>> print(f"{run.contacts[contact].peak_force:.1f} N, {run[ball].velocity[-1]:.4f} m/s")
    1394.5 N, -1.0000 m/s
    """

    def __init__(self, *, gravity: float | npt.ArrayLike = 0.0) -> None:
        falls = vector_or_number("gravity", gravity, "m/s²")
        size = gravity if falls is None else float(np.linalg.norm(falls))
        self._begin(checked_gravity(size), uuid.uuid4().hex, falls)

    def _begin(self, gravity: float, mark: str, falls: FloatArray | None = None) -> None:
        self.gravity = gravity
        self._bodies: list[BodyModel] = []
        self._velocities: list[float] = []
        self._positions: list[float] = []
        self._names: list[str] = []
        self._contacts: list[Contact] = []
        self._law_errors: list[float] = []  # of laws that were found from the surfaces
        self._between: dict[tuple[int, int, int, int], list[int]] = {}  # contacts at the same place
        self._loads: list[Load] = []
        # Velocities, gravity and friction of motion in three directions, where given.
        self._vectors: list[FloatArray | None] = []
        self._spins: list[FloatArray | None] = []
        self._falls = falls
        self._frictions: list[float | None] = []
        self._axes: FloatArray | None = None
        # Copies and pickles keep it: their handles are as good. An impact of two bodies has none.
        self._mark = _Mark(mark)

    def __repr__(self) -> str:
        labels = ", ".join(body.label for body in self._bodies[:6])
        more = ", …" if len(self._bodies) > 6 else ""
        return (
            f"Scene(gravity={self.gravity:g}): {len(self._bodies)} bodies ({labels}{more}), "
            f"{len(self._contacts)} contacts, {len(self._loads)} loads"
        )

    # ------------------------------------------------------------------- building

    def add(
        self,
        body: Any,
        *,
        velocity: float | npt.ArrayLike = 0.0,
        spin: npt.ArrayLike | None = None,
        position: float = 0.0,
        name: str = "",
    ) -> Handle:
        """Add a body, undeformed and moving as a whole.

        Parameters
        ----------
        body : ContactPoint or list of ContactPoint, AOModel, Body, FullModel
            A ContactPoint (``body.contact(...)``) is reduced as far as the quantity of interest
            allows, a list of them on one body is one that is touched in several places, ``full``
            of them the full finite-element model, a `rigid` body of infinite mass a wall.
        velocity : float or array_like, shape (3,), optional
            Along the direction of travel, or in three directions (see `simulate`), m/s.
        spin : array_like, shape (3,), optional
            Angular velocity in the same axes, rad/s.
        position : float, optional
            Place of its contact coordinate (of all of them) at t = 0, m.
        name : str, optional
            Name in results, tables and plots; by default that of the body itself.

        Returns
        -------
        Handle
            To connect, load and read it by.

        Raises
        ------
        InputError, InputTypeError
            If `body` is no model of a body, or a number is none or beyond the range of squares.

        Examples
        --------
        >>> scene = ao.Scene()
        >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0, name="ball")
        """
        called, along = text("name", name), vector_or_number("velocity", velocity, "m/s")
        size = velocity if along is None else float(np.linalg.norm(along))
        speed, where = checked_speed(size), real("position", position, unit="m")
        turns = checked_spin(spin)
        self._append(body_model("body", body), speed, where, called, along, turns)
        return Handle(len(self._bodies) - 1, name=called, scene=self._mark.name)

    def _append(
        self,
        model: BodyModel,
        velocity: float,
        position: float = 0.0,
        name: str = "",
        vector: FloatArray | None = None,
        spin: FloatArray | None = None,
    ) -> None:
        self._bodies.append(model)
        self._velocities.append(velocity)
        self._positions.append(position)
        self._names.append(name)
        self._vectors.append(vector)
        self._spins.append(spin)

    def connect(
        self,
        a: Handle,
        b: Handle,
        law: ContactLaw | None = None,
        *,
        gap: float = 0.0,
        friction: float | None = None,
        name: str = "",
    ) -> int:
        """Let two bodies touch: δ = (x_a + position_a) - (x_b + position_b) - gap.

        Parameters
        ----------
        a, b : Handle
            Of `add`; ``handle.port(i)`` for another place of a body touched in several.
        law : ContactLaw, optional
            If left out, Hertz's, from the materials of both bodies and the curvatures of their
            surfaces at the contact.
        gap : float, optional
            m; may be negative where positions are given.
        friction : float, optional
            Coefficient of friction; see `simulate`.
        name : str, optional
            Name of the contact in results, tables and plots.

        Returns
        -------
        int
            Its place in ``run.contacts``.

        Raises
        ------
        InputError
            For a body with itself, two walls, an unknown handle, a direction that was given the
            wrong way round, or a law that is left out and not known.

        Examples
        --------
        >>> scene = ao.Scene()
        >>> ball, floor = scene.add(ao.rigid(mass=0.1)), scene.add(ao.rigid(mass=float("inf")))
        >>> scene.connect(ball, floor, ao.Hertz(k=1e9), gap=1e-3)
        0
        """
        first, second = self._known("a", a), self._known("b", b)
        if first.body == second.body:
            raise InputError(
                f"a and b are both {self._called(first.body)}: a body cannot touch itself; connect "
                "it to another"
            )
        apart = real("gap", gap, unit="m")
        apart += self._positions[second.body] - self._positions[first.body]
        ends = (first.body, first.at), (second.body, second.at)
        return self._join(*ends, law, apart, name, friction=friction)

    def _join(
        self,
        first: tuple[int, int],
        second: tuple[int, int],
        law: ContactLaw | None,
        gap: float,
        name: str = "",
        turned: Sequence[bool] = (False, False),
        friction: float | None = None,
    ) -> int:
        """Add a contact of two (body, port) with that distance, m, at the start.

        turned: of each, whether its direction of travel must be reversed.
        """
        if law is not None and not isinstance(law, ContactLaw):
            raise InputTypeError(f"law must be a contact law such as Hertz(k=...), got {law!r}")
        ends = first, second
        if all(math.isinf(self._bodies[body].static_mass) for body, _ in ends):
            raise InputError(
                f"{' and '.join(self._called(body) for body, _ in ends)} are both of infinite "
                "mass: there is no motion between them"
            )
        law_error, mu = 0.0, checked_friction(friction)
        if law is None:
            models = [
                (self._bodies[body].turned((port,) if turn else ()), port)
                for (body, port), turn in zip(ends, turned, strict=True)
            ]
            found = chosen_law(models, [self._called(body) for body, _ in ends])
            law, law_error = found.law, found.error
        contact = Contact(*first, *second, law, normal_gap(gap), text("name", name))
        if mu:
            refuse_plastic(law)
        self._refuse_again(contact)
        self._between.setdefault(contact[:4], []).append(len(self._contacts))
        self._contacts.append(contact)
        self._law_errors.append(law_error)
        self._frictions.append(mu)
        return len(self._contacts) - 1

    def _refuse_again(self, contact: Contact) -> None:
        """Refuse a second contact between the same two places with the same law and gap."""
        for number in self._between.get(contact[:4], []):
            other = self._contacts[number]
            if (other.law, other.gap) == (contact.law, contact.gap):
                first, second = (self._called(body) for body, _ in contact.ports)
                raise InputError(
                    f"contact {number} is the same: {first} and {second} under the same law and "
                    "gap; leave this one out, or double the law's stiffness"
                )

    def apply(self, body: Handle, *, force: Any) -> None:
        """Apply a force to a body's contact coordinate, along the direction of travel.

        Parameters
        ----------
        body : Handle
        force : float or (times, forces)
            N; constant, or straight between times, s, that ascend, and constant outside them.

        Raises
        ------
        InputError
            For a wall, an unknown handle, or times and forces that do not match.

        Examples
        --------
        >>> scene = ao.Scene()
        >>> ball = scene.add(ao.rigid(mass=0.1))
        >>> scene.apply(ball, force=([0.0, 1e-3], [0.0, 20.0]))  # a ramp, then 20 N
        """
        end = self._known("body", body)
        if isinstance(force, tuple):
            if len(force) != 2:
                raise InputError(f"force must be a number or (times, forces), got {force!r}")
            times = finite_array("times", force[0], ndim=1, unit="s")
            forces = finite_array("forces", force[1], ndim=1, unit="N")
            if len(times) != len(forces) or len(times) == 0 or (np.diff(times) <= 0.0).any():
                raise InputError(
                    f"force=(times, forces) needs as many forces as times, and times that ascend; "
                    f"got {len(times)} times and {len(forces)} forces"
                )
        else:
            times, forces = np.zeros(1), np.array([real("force", force, unit="N")])
        if math.isinf(self._bodies[end.body].static_mass):
            called = self._called(end.body)
            raise InputError(f"{called} is a wall: no force moves it; load another body")
        self._loads.append(Load(end.body, end.at, times.copy(), forces.copy()))

    def _known(self, name: str, handle: Any) -> Handle:
        if not isinstance(handle, Handle):
            raise InputTypeError(f"{name} must be a handle that scene.add returned, got {handle!r}")
        if handle.scene != self._mark.name or handle.body >= len(self._bodies):
            raise InputError(
                f"{name}={handle!r} is of another scene; add the body to this one and take the "
                "handle that scene.add returns"
            )
        ports = self._bodies[handle.body].places
        if not 0 <= handle.at < ports:
            raise InputError(
                f"{name}: {self._called(handle.body)} may be touched in {ports} place(s), there is "
                f"no port {handle.at}"
            )
        return handle

    def _called(self, body: int) -> str:
        name, role = self._names[body] or self._bodies[body].name, self._role(body)
        return f"{role} ({name})" if name else role

    def _role(self, body: int) -> str:
        return f"body {body}"

    # ------------------------------------------------------------------- running

    @spelled
    def simulate(
        self,
        *,
        duration: float | None = None,
        solver: TimeSolver | None = None,
        energies: bool = True,
        preload: bool = False,
        quantity: str | Handle | ContactPoint | Sensor | None = None,
        rtol: float | None = None,
        linear_solver: Solver | None = None,
    ) -> Run:
        """Simulate the scene.

        Parameters
        ----------
        duration : float, optional
            Length of the record, s. If left out, until the last contact is over and as long again.
        solver : Adaptive or Newmark, optional
            By default ``Adaptive()``, with friction ``Adaptive(rtol=1e-4)``; with a full
            finite-element model, or friction of a damped law, ``Newmark()``.
        energies : bool, optional
            Whether to record energies as well.
        preload : bool, optional
            Whether to start from rest under gravity and the loads at t = 0, bodies pressed on each
            other, found by a static solve; velocities are then added. What no force presses stays
            where it was put, or moves aside as far as it must.
        quantity : str, Handle, ContactPoint or sensor, optional
            The quantity of interest: "force" (of every contact over the record), "peak_force",
            "peak_time", "impulse", "contact_duration" (of the first touch) or "contact_count" (of
            every contact), "rebound_velocity" (after the last contact, of every body but those held
            at rest), "restitution" (of a scene of one contact), with friction
            "peak_friction_force", "tangential_restitution" or "final_spin", a handle, for the
            displacement of that contact coordinate over the record, a point of a body, for its
            displacement over the record, or a sensor such as `ReactionAt`, as for `simulate`.
            Contact points are reduced as far as the tolerance allows, and AO models truncated if
            this or `rtol` is given; `Run.models` are those taken. A body
            that was added twice is reduced once. Numbers are read by `Run.value`.
        rtol : float, optional
            Its relative error. If left out, 2e-3, or up to 1e-2 where 2e-3 takes a third more
            oscillators. That of a history is its largest over the record,
            relative to the largest value, that of a contact relative to no less than a tenth of the
            largest of all contacts. A solver that does not keep it is refused.
        linear_solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
            Linear solver for these reduced models, as `solver` of `antioscillators`.

        Raises
        ------
        InputError, InputTypeError
            For an argument that makes no sense, an empty scene, or bodies that overlap at the start
            without `preload`.
        ConvergenceError
            If the tolerance cannot be met, or bodies find no rest.

        Warns
        -----
        AOImpactWarning
            If gravity has no effect on a constrained AO model given by numbers or without nodes, a
            body's centre of mass is not known, or its model was fitted to another contact time.

        Examples
        --------
        >>> scene = ao.Scene()
        >>> ball = scene.add(ao.rigid(mass=0.1), velocity=1.0)
        >>> wall = scene.add(ao.rigid(mass=float("inf")))
        >>> number = scene.connect(ball, wall, ao.Hertz(k=1e9))
        >>> run = scene.simulate(duration=1e-3)
        >>> round(run.contacts[number].peak_force)  # N
        1143
        """
        began = perf_counter()
        length = None if duration is None else checked_duration(duration)
        boolean("energies", energies)
        boolean("preload", preload)
        if not self._bodies:
            raise InputError("the scene is empty: add bodies with scene.add(...)")
        self._orient()
        if preload and self._axes is not None:
            raise InputError(
                "preload: rest with friction is not known; start without preload, and let the "
                "weight or the load grow: apply(body, force=([0, time], [0, force]))"
            )
        if not preload:
            self._refuse_overlap()
        linear = checked_linear_solver(linear_solver, chosen=self._chooses(quantity, rtol))
        return self._run(
            self._record(length),
            quantity=quantity,
            rtol=rtol,
            solver=solver,
            energies=energies,
            preload=preload,
            linear_solver=linear,
            began=began,
        )

    def _run(self, record: RecordLength, **given: Any) -> Run:
        """Run the scene as `_once` does; a contact stiffer than its meshes gets a wider patch.

        Supports, loads and other bodies press contacts further than two bodies alone would. Where
        no patch on a shell helps, the law is bounded.
        """
        tips = [tip for body in self._bodies for tip in body.tips]
        ways = [(False, False)]
        if any(tip.automatic for tip in tips):
            ways.append((True, False))
        if any(isinstance(tip.thin, Layers) for tip in tips):
            ways.append((True, True))
        for wider, bounded in ways[:-1]:
            try:
                return self._once(record, **given, wider=wider, bounded=bounded)
            except LawLimitError:
                continue
        wider, bounded = ways[-1]
        return self._once(record, **given, wider=wider, bounded=bounded)

    def _orient(self) -> None:
        """Find the axes of motion in three directions, and what of it is along the first.

        Raises
        ------
        InputError
            If a contact has no friction, or the contacts differ in their direction of travel.
        """
        given = [of for of in (*self._vectors, *self._spins, self._falls) if of is not None]
        sliding = [mu for mu in self._frictions if mu is not None]
        if not given and not sliding:
            return
        if len(sliding) < len(self._frictions):
            raise InputError(
                "friction: with a spin, or with a velocity or gravity in three directions, every "
                "contact needs it; give a coefficient, or friction=0 for smooth surfaces"
            )
        ends = [
            [(self._called(body), self._bodies[body], port) for body, port in contact.ports]
            for contact in self._contacts
        ]
        axes = self._axes = axes_of(ends)
        for body, vector in enumerate(self._vectors):
            if vector is not None:
                self._velocities[body] = float(axes[0] @ vector)
        if self._falls is not None:
            self.gravity = float(axes[0] @ self._falls)

    def _oblique(self, bodies: Sequence[BodyModel]) -> list[BodyModel]:
        """The bodies with three ports for each place where they are touched."""
        assert self._axes is not None
        for body, model in enumerate(bodies):
            if self._spins[body] is not None:
                refuse_held(self._called(body), model)
        return [
            with_functionals(self._called(body), model, self._axes, self._roles(body))
            for body, model in enumerate(bodies)
        ]

    def _roles(self, body: int) -> list[float]:
        """The roles in which a body is touched."""
        first, second = ({end[of].body for end in self._ends} for of in (0, 1))
        return [role for role, of in zip(ROLES, (first, second), strict=True) if body in of]

    @property
    def _ends(self) -> list[tuple[Port, Port]]:
        return [contact.ports for contact in self._contacts]

    def _port(self, body: int, port: int, role: float) -> int:
        """The first of the three ports of a place."""
        if self._bodies[body].tips:
            return 3 * port
        return 3 * self._roles(body).index(role)

    def _sliding(self, models: Sequence[Any]) -> tuple[list[Contact], list[Load]]:
        """Contacts with friction and loads, by the ports of bodies in three directions."""
        contacts, loads = [], []
        for of, mu in zip(self._contacts, self._frictions, strict=True):
            places = [self._port(*end, role) for end, role in zip(of.ports, ROLES, strict=True)]
            ends = [(models[end.body], at) for end, at in zip(of.ports, places, strict=True)]
            known = [model.touched_at(at) or model.surface_at(at) for model, at in ends]
            ratio = stiffness_ratio([None if one is None else one.material for one in known])
            assert mu is not None
            # A smooth contact has a normal force alone, by any law.
            friction = Friction(mu, ratio, oblique_compliance(of.law, ends)) if mu else None
            first, second = places
            contacts.append(of._replace(first_port=first, second_port=second, friction=friction))
        for load in self._loads:
            roles = self._roles(load.body)
            at = self._port(load.body, load.port, roles[0]) if roles else 0
            loads.append(load._replace(port=at))
        return contacts, loads

    @property
    def _motion(self) -> Oblique | None:
        """Velocities and gravity in three directions; None of motion in one."""
        if self._axes is None:
            return None
        along = self._axes[0]
        vectors = [
            speed * along if vector is None else vector
            for speed, vector in zip(self._velocities, self._vectors, strict=True)
        ]
        spins = [np.zeros(3) if spin is None else spin for spin in self._spins]
        velocities = tuple(map(np.concatenate, zip(vectors, spins, strict=True)))
        falls = self.gravity * along if self._falls is None else self._falls
        return Oblique(self._axes, velocities, falls)

    def _chooses(self, quantity: Any, rtol: float | None) -> bool:
        """True if models are to be chosen: always where a body is given by contact points."""
        controlled = quantity is not None or rtol is not None
        return controlled or any(body.reducible for body in self._bodies)

    def _once(
        self,
        record: RecordLength,
        *,
        quantity: Any,
        rtol: float | None,
        solver: TimeSolver | None,
        energies: bool,
        preload: bool = False,
        linear_solver: Solver,
        began: float,
        wider: bool,
        bounded: bool,
    ) -> Run:
        """Run the bodies as they are, or small models of them that give a quantity to a tolerance.

        Parameters
        ----------
        record : RecordLength
        quantity, rtol, solver, energies, preload, linear_solver
            As of `simulate`.
        began : float
            When the call began, by `perf_counter`, s.
        wider : bool
            True for wider patches than two bodies alone would need.
        bounded : bool
            See `Contact.of_models`.
        """
        record.margin = quantity.memory if isinstance(quantity, Sensor) else 0.0
        bodies, plan_of = self._bodies, partial(self._plan, record, preload)
        meshed = any(body.tips for body in bodies)
        factors: dict[Any, LinearSolver] = {}
        if meshed:
            bodies, around = self._fitted(factors, wider), self._turns()
            for i, body in enumerate(bodies):
                # A model with several contact points needs the direction of travel of each.
                if len(body.tips) > 1 or self._axes is not None:
                    bodies[i], around[i] = body.turned(around[i]), ()
            plan_of = partial(plan_of, around=around, widths=self._widths(), bounded=bounded)
        if self._axes is not None:
            bodies = self._oblique(bodies)
            if solver is None and any(of.law.depends_on_rate for of in self._contacts):
                solver = Newmark()  # `solve` refuses the other one
        interest = partial(self._interest, quantity, bodies)
        if self._chooses(quantity, rtol):
            with bar("models", unit="solution"):
                run = choose_models(
                    plan_of,
                    bodies,
                    interest,
                    rtol,
                    solver,
                    truncated=quantity is not None or rtol is not None,
                    energies=energies,
                    record=record,
                    law_errors=self._law_errors,
                    linear_solver=linear_solver,
                    factors=factors,
                )
            # The cost of the models: all but the run itself.
            run = replace(run, modelled=max(perf_counter() - began - run.recorder.seconds, 0.0))
        else:
            run = record.run(plan_of(bodies, energies), partial(solve, solver=solver))
        names = [self._called(body) for body in range(len(bodies))]
        if meshed:
            if run.chosen is None:
                warn_of_misfit(run, names)
                if run.plan.contacts:
                    find = partial(errors_left_out, interest=interest, solver=solver)
                    run = replace(run, left_out=partial(find, law_errors=self._law_errors))
            run = replace(run, finer=partial(finer_run, solver=solver))
        record.warn_if_cut()
        warn_of_bodies(run, names)
        warn_of_run(run)
        return run

    def _record(self, length: float | None) -> RecordLength:
        if length is not None:
            return RecordLength(length, given=True)
        fastest = self._fastest
        meetings = [self._meeting(contact, fastest) for contact in self._contacts]
        times = [met.contact_time for met in meetings if met]
        if not times:
            for contact in self._contacts:
                self._meeting(contact, fastest, strict=True)
            raise InputError(
                "duration was left out, and cannot be foreseen: no velocity, gravity or constant "
                "force brings bodies that have a contact towards each other; give it"
            )
        ways = [time for contact in self._contacts if (time := self._way(contact)[0]) < math.inf]
        gaps = max(contact.gap for contact in self._contacts)
        return RecordLength(max(times) + max([*ways, gaps / fastest]), given=False)

    @property
    def _fastest(self) -> float:
        """The largest speed, m/s, at which bodies of the scene may meet first."""
        spread = max(self._velocities) - min(self._velocities)
        return max([spread, *(self._way(contact)[1] for contact in self._contacts)])

    def _way(self, contact: Contact) -> tuple[float, float]:
        """When the bodies of a contact meet, s, and how fast, m/s, as rigid bodies by themselves.

        Their distance is closed by v t + a t²/2, so they meet at √(v² + 2 a gap).
        """
        first, second = contact.first, contact.second
        speed = self._velocities[first] - self._velocities[second]
        pull = self._acceleration(first) - self._acceleration(second)
        square = speed**2 + 2.0 * pull * contact.gap
        if square < 0.0 or (meets := math.sqrt(square)) + speed <= 0.0:
            return math.inf, 0.0
        return 2.0 * max(contact.gap, 0.0) / (meets + speed), meets

    def _acceleration(self, body: int) -> float:
        """Acceleration of a body by gravity and constant forces, m/s²; 0 if it is constrained."""
        model = self._bodies[body]
        if math.isinf(mass := model.most_mass):
            return 0.0
        forces = (load.forces[0] for load in self._loads if load.body == body)
        return self.gravity + math.fsum(forces) / mass

    def _meeting(self, contact: Contact, speed: float, *, strict: bool = False) -> Meeting | None:
        bodies = [self._bodies[body] for body, _ in contact.ports]
        return meeting(own_law(contact.law), bodies, speed, strict=strict)

    def _fitted(self, factors: dict[Any, LinearSolver], wider: bool) -> list[BodyModel]:
        """The bodies with patches fitted to their contacts, where their radius was left out."""
        bodies = list(self._bodies)
        if self._axes is not None:
            bodies = [with_tangents(body, self._axes) for body in bodies]
        made: dict[tuple[BodyModel, int], BodyModel] = {}
        if not any(isinstance(body, FullModel) for body in bodies):
            return bodies
        fastest = self._fastest
        for contact in self._contacts:
            met = self._meeting(contact, fastest)
            for body, port in contact.ports:
                key = bodies[body], port
                if key not in made:
                    made[key] = fitted(bodies[body], port, met, factors, wider=wider)
                bodies[body] = made[key]
        return bodies

    def _turns(self) -> list[tuple[int, ...]]:
        """For each body the contact points whose direction of travel must be reversed."""
        roles: dict[tuple[int, int], set[bool]] = {}
        sides: dict[ContactPoint | None, set[bool]] = {}
        for contact in self._contacts:
            for outward, (body, port) in zip((True, False), contact.ports, strict=True):
                roles.setdefault((body, port), set()).add(outward)
                sides.setdefault(self._bodies[body].touched_at(port), set()).add(outward)
        around: list[tuple[int, ...]] = [()] * len(self._bodies)
        for (body, port), ways in roles.items():
            if len(ways) > 1:  # pressed from both sides: its direction suits one of them
                continue
            model, outward = self._bodies[body], True in ways
            like = len(sides[model.touched_at(port)]) > 1  # one place stands for two like bodies
            if turns(self._called(body), model, port, outward=outward, like=like):
                around[body] = (*around[body], port)
        return around

    def _widths(self) -> list[float | None]:
        """Radius of each contact, m, where a body is known by its mesh; see `Contact.of_models`."""
        widths: list[float | None] = []
        for contact in self._contacts:
            bodies = [self._bodies[body] for body, _ in contact.ports]
            meshed = any(body.tips for body in bodies)
            law = own_law(contact.law)
            widths.append(contact_width(law, bodies, self._fastest) if meshed else None)
        return widths

    def _plan(
        self,
        record: RecordLength,
        preload: bool,
        models: Sequence[Any],
        energies: bool,
        *,
        around: Sequence[tuple[int, ...]] = (),
        widths: Sequence[float | None] = (),
        bounded: bool = False,
    ) -> Plan:
        """The plan of the bodies, or of models in their place.

        Parameters
        ----------
        record : RecordLength
        preload, energies : bool
            As of `simulate`.
        models : sequence
            One for each body.
        around, widths : sequences, optional
            For bodies with meshes: `_turns` and `_widths`.
        bounded : bool, optional
            See `Contact.of_models`.
        """
        bodies, contacts, loads = tuple(models), self._contacts, self._loads
        if self._axes is not None:
            contacts, loads = self._sliding(bodies)
        if around:
            bodies = tuple(of.turned(ports) for of, ports in zip(models, around, strict=True))
            contacts = [
                of.of_models(bodies, width, bounded=bounded)
                for of, width in zip(contacts, widths, strict=True)
            ]
        if bodies != tuple(self._bodies):
            for contact in contacts:
                if all(math.isinf(bodies[body].static_mass) for body, _ in contact.ports):
                    raise InputError(
                        "both bodies of a contact are of infinite mass: there is no motion between "
                        "them"
                    )
        for body in bodies:
            if self.gravity and body.weightless:
                warn(
                    f"gravity has no effect on {body.label}: the supports of an AO model given by "
                    "numbers, or by matrices without nodes, are not known; make it by "
                    "antioscillators(...) of a body with nodes"
                )
        return Plan(
            bodies,
            tuple(self._velocities),
            tuple(contacts),
            tuple(loads),
            self.gravity,
            record.length,
            energies,
            preload,
            self._mark.name,
            tuple(self._names),
            self._motion,
        )

    def _interest(self, quantity: Any, bodies: Sequence[Any]) -> Quantity:
        """The quantity of interest; where nothing meets, the motion of a body to be reduced."""
        if isinstance(quantity, Handle):
            self._known("quantity", quantity)
        if quantity is None and not self._contacts:
            moved = [i for i, body in enumerate(bodies) if isinstance(body, FullModel)]
            quantity = Handle(moved[0], scene=self._mark.name) if moved else None
        interest = self._known_here(scene_quantity(quantity, bodies))
        if interest.name == "restitution":
            self._refuse_restitution()
        if interest.each == "contacts" and not self._contacts:
            raise InputError(
                f"quantity={interest.name!r}: the scene has no contacts; connect bodies, or give "
                "the handle of a body for its displacement"
            )
        return interest

    def _known_here(self, interest: Quantity) -> Quantity:
        """Refuse a quantity of friction where there is none."""
        if interest.sliding and self._axes is None:
            raise InputError(
                f"quantity={interest.name!r} is of contacts with friction; give friction="
            )
        return interest

    def _refuse_restitution(self) -> None:
        """Refuse a restitution unless one contact of two approaching bodies defines it."""
        speeds = {self._velocities[body] for contact in self._contacts for body, _ in contact.ports}
        if len(self._contacts) != 1 or len(speeds) != 2:
            count = f"{len(self._contacts)} contacts"
            raise InputError(
                'quantity="restitution" is of one contact between two bodies that come with '
                f"velocities, and the scene has {count if len(self._contacts) != 1 else 'none'}; "
                'give "rebound_velocity", that of every body'
            )

    def _refuse_overlap(self) -> None:
        for number, contact in enumerate(self._contacts):
            if contact.gap < 0.0:
                first, second = self._called(contact.first), self._called(contact.second)
                raise InputError(
                    f"contact {number}: {first} and {second} overlap by {-contact.gap:g} m at the "
                    "start; change position or gap, or start with preload=True from the rest that "
                    "gravity and loads press them to"
                )


@dataclass(frozen=True)
class SceneCase:
    """A scene and the keywords of its run, without the duration."""

    scene: Any
    keywords: dict[str, Any]

    def simulate(self, *, duration: float | None = None) -> Any:
        return self.scene.simulate(duration=duration, **self.keywords)
