"""Scenes of any number of bodies and contacts along one direction of travel, and their runs."""

from __future__ import annotations

import math
import uuid
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..accuracy import (
    Interest,
    check_linear_solver,
    checked_rtol,
    choose_models,
    compared_runs,
    errors_left_out,
    quantity_of,
)
from ..base import (
    FloatArray,
    InputError,
    InputTypeError,
    LawLimitError,
    bar,
    boolean,
    finite_array,
    held_warnings,
    nonnegative,
    positive,
    real,
    text,
    warn,
)
from ..fem import Layers
from ..laws import ContactLaw, LawFromSurfaces, law_between
from ..linalg import Solver
from ..reduction import Body, BodyModel, FullModel, body_model
from ..results import (
    Handle,
    Quantity,
    RecordLength,
    Run,
    TimeSolver,
    warn_of_bodies,
    warn_of_misfit,
    warn_of_run,
)
from ..scene import Contact, Friction, Load, Oblique, Scenario
from .foreseen import Foreseen, goes_against
from .oblique import axes_of, with_tangents

# Squares and energies of lower speeds, m/s, vanish, and of those above the reciprocal overflow.
LEAST_SPEED = 1e-60


@dataclass(frozen=True)
class Mark:
    """Tells the handles of one scene from those of another."""

    name: str = field(metadata={"identity": True})


class Member(NamedTuple):
    """A body of a scene: its motion, in three directions where given, its place and its names."""

    body: BodyModel
    velocity: float
    vector: FloatArray | None
    spin: FloatArray | None
    position: float
    name: str
    called: str


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

    def __init__(self, *, gravity: float | ArrayLike = 0.0) -> None:
        # Along the direction of travel, and in three directions where it is given so.
        self.gravity, self._falls = number_or_vector("gravity", gravity, "m/s²")
        self._members: list[Member] = []
        self._contacts: list[Contact] = []
        self._loads: list[Load] = []
        # Copies and pickles keep it: their handles are as good. An impact of two bodies has none.
        self._mark = Mark(uuid.uuid4().hex)

    def __repr__(self) -> str:
        labels = ", ".join(member.body.label for member in self._members[:6])
        more = ", …" if len(self._members) > 6 else ""
        return (
            f"Scene(gravity={self.gravity:g}): {len(self._members)} bodies ({labels}{more}), "
            f"{len(self._contacts)} contacts, {len(self._loads)} loads"
        )

    # ------------------------------------------------------------------- building

    def add(
        self,
        body: Any,
        *,
        velocity: float | ArrayLike = 0.0,
        spin: ArrayLike | None = None,
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
        where, called = real("position", position, unit="m"), text("name", name)
        self._take("body", body, velocity, spin, where, called)
        return Handle(len(self._members) - 1, name=called, scene=self._mark.name)

    def _take(
        self,
        argument: str,
        body: Any,
        velocity: Any = 0.0,
        spin: Any = None,
        position: float = 0.0,
        name: str = "",
    ) -> Member:
        """Add a body that was given as an argument, and return it with its motion."""
        model, motion = body_model(argument, body), number_or_vector("velocity", velocity, "m/s")
        turns = None if spin is None else finite_array("spin", spin, shape=(3,), unit="rad/s")
        own, role = name or model.name, f"body {len(self._members)}"
        role = role if self._mark.name else argument
        called = f"{role} ({own})" if own else role
        self._members.append(Member(model, *motion, turns, position, name, called))
        return self._members[-1]

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
        one, other = self._members[a.body], self._members[b.body]
        if a.body == b.body:
            raise InputError(
                f"a and b are both {one.called}: a body cannot touch itself; connect it to another"
            )
        apart = real("gap", gap, unit="m") + (other.position - one.position)
        return self._join(first, second, law, apart, text("name", name), friction=friction)

    def _join(
        self,
        first: tuple[int, int],
        second: tuple[int, int],
        law: ContactLaw | None,
        gap: float,
        name: str = "",
        friction: float | None = None,
    ) -> int:
        """Add a contact of two (body, port) with that distance, m, at the start."""
        if law is not None and not isinstance(law, ContactLaw):
            raise InputTypeError(f"law must be a contact law such as Hertz(k=...), got {law!r}")
        ends = [(self._members[body].body, port) for body, port in (first, second)]
        names = [self._members[body].called for body, _ in (first, second)]
        if all(math.isinf(body.static_mass) for body, _ in ends):
            raise InputError(
                f"{' and '.join(names)} are both of infinite mass: there is no motion between them"
            )
        law_error = 0.0
        if law is None:
            found = chosen_law(ends, names)
            law, law_error = found.law, found.error
        mu = nonnegative("friction", 0.0 if friction is None else friction)
        if mu and (law.has_memory or law.pulls):
            raise InputError(
                f"friction: law={law!r} remembers or pulls; give Hertz(...), a damped law and "
                "solver=Newmark(), or friction=0"
            )
        rubs = None if friction is None else Friction(mu)
        contact = Contact(*first, *second, law, gap, name, friction=rubs, law_error=law_error)
        self._contacts.append(contact)
        return len(self._contacts) - 1

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
        member = self._members[body.body]
        if isinstance(force, tuple) and len(force) == 2:
            times = finite_array("times", force[0], shape=(None,), unit="s")
            forces = finite_array("forces", force[1], shape=times.shape, unit="N")
            if len(times) == 0 or (np.diff(times) <= 0.0).any():
                raise InputError(f"force: its times must ascend, one at least, got {times}")
        else:
            times, forces = np.zeros(1), np.array([real("force", force, unit="N")])
        if math.isinf(member.body.static_mass):
            raise InputError(f"{member.called} is a wall: no force moves it; load another body")
        self._loads.append(Load(*end, times.copy(), forces.copy()))

    def _known(self, name: str, handle: Any) -> tuple[int, int]:
        """Return the body and the port that a handle of this scene stands for."""
        if not isinstance(handle, Handle):
            raise InputTypeError(f"{name} must be a handle that scene.add returned, got {handle!r}")
        if handle.scene != self._mark.name or handle.body >= len(self._members):
            raise InputError(
                f"{name}={handle!r} is of another scene; add the body to this one and take the "
                "handle that scene.add returns"
            )
        member = self._members[handle.body]
        if not 0 <= handle.at < member.body.places:
            raise InputError(
                f"{name}: {member.called} may be touched in {member.body.places} place(s), there "
                f"is no port {handle.at}"
            )
        return handle.body, handle.at

    # ------------------------------------------------------------------- running

    def simulate(
        self,
        *,
        duration: float | None = None,
        solver: TimeSolver | None = None,
        energies: bool = True,
        preload: bool = False,
        quantity: Handle | Interest | Sequence[Handle | Interest] | None = None,
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
        quantity : str, Handle, ContactPoint or sensor, or list of these, optional
            The quantity of interest: "force" (of every contact over the record), "peak_force",
            "peak_time", "impulse", "contact_duration" (of the first touch) or "contact_count" (of
            every contact), "rebound_velocity" (after the last contact, of every body but those held
            at rest), "restitution" (of a scene of one contact), with friction
            "peak_friction_force", "tangential_restitution" or "final_spin", a handle, for the
            displacement of that contact coordinate over the record, a point of a body, for its
            displacement over the record, or a sensor such as `ReactionAt`, as for `simulate`.
            Contact points are reduced as far as the tolerance allows, and AO models truncated if
            this or `rtol` is given; `Run.models` are those taken. A body
            that was added twice is reduced once. Numbers are read by `Run.value`. Each of a list is
            right to `rtol`, see `simulate`.
        rtol : float, optional
            Its relative error. If left out, 2e-3, or up to 1e-2 where the largest models that are
            tried do not give 2e-3. That of a history is its largest over the record, relative to
            the largest value, that of a contact relative to no less than a tenth of the largest
            of all contacts. A solver that does not keep it is refused.
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
        boolean("energies", energies)
        boolean("preload", preload)
        if not self._members:
            raise InputError("the scene is empty: add bodies with scene.add(...)")
        plan = self._plan(energies=energies, preload=preload)
        if preload and plan.oblique is not None:
            raise InputError(
                "preload: rest with friction is not known; start without preload, and let the "
                "weight or the load grow: apply(body, force=([0, time], [0, force]))"
            )
        for number, contact in enumerate(() if preload else self._contacts):
            if contact.gap < 0.0:
                both = " and ".join(self._members[body].called for body, _ in contact.ports)
                raise InputError(
                    f"contact {number}: {both} overlap by {-contact.gap:g} m at the start; change "
                    "position or gap, or start with preload=True from the rest that gravity and "
                    "loads press them to"
                )
        return self._run(plan, duration, quantity, rtol, solver, linear_solver, began)

    def _plan(self, *, energies: bool = True, preload: bool = False) -> Scenario:
        """The scene of the bodies as they were given, whose contacts are of places.

        Raises
        ------
        InputError
            If a contact has no friction though others do, or contacts differ in their direction of
            travel.
        """
        bodies, speeds, *_, names, _ = zip(*self._members, strict=True)
        oblique, gravity = self._oblique(), self.gravity
        if oblique is not None:
            along = oblique.axes[0]
            bodies = tuple(with_tangents(body, oblique.axes) for body in bodies)
            speeds = tuple(float(along @ velocity[:3]) for velocity in oblique.velocities)
            gravity = float(along @ oblique.gravity)
        return Scenario(
            bodies,
            speeds,
            tuple(self._contacts),
            tuple(self._loads),
            gravity,
            0.0,
            energies,
            preload,
            self._mark.name,
            names,
            oblique,
        )

    def _oblique(self) -> Oblique | None:
        """Motion in three directions; None of a scene along one."""
        members, frictions = self._members, [of.friction for of in self._contacts]
        given = [of for member in members for of in (member.vector, member.spin)]
        if all(of is None for of in (self._falls, *frictions, *given)):
            return None
        if None in frictions:
            raise InputError(
                "friction: with a spin, or with a velocity or gravity in three directions, every "
                "contact needs it; give a coefficient, or friction=0 for smooth surfaces"
            )
        axes = axes_of(
            [(members[body].called, members[body].body, port) for body, port in contact.ports]
            for contact in self._contacts
        )
        velocities = []
        for of in members:
            numbers = of.body.numbers if isinstance(of.body, Body) else None
            stiff = numbers is not None and numbers.inertia is None
            if of.spin is not None and (stiff or of.body.constrained):
                why = "has no inertia to turn with" if stiff else "is held"
                raise InputError(
                    f"spin: {of.called} {why}; give the spin of a free body: ao.ball(...), "
                    "ao.rigid(mass, inertia=) or one of finite elements"
                )
            moving = of.velocity * axes[0] if of.vector is None else of.vector
            velocities.append(np.append(moving, np.zeros(3) if of.spin is None else of.spin))
        falls = self.gravity * axes[0] if self._falls is None else self._falls
        return Oblique(axes, velocities, falls)

    def _run(
        self,
        plan: Scenario,
        duration: Any,
        quantity: Any,
        rtol: float | None,
        solver: TimeSolver | None,
        linear_solver: Solver | None,
        began: float,
    ) -> Run:
        """Run the bodies as they are, or small models of them that give a quantity to a tolerance.

        A contact stiffer than its meshes gets a wider patch: supports, loads and other bodies press
        contacts further than two bodies alone would. Where no patch helps, the bodies as meshed
        keep the whole law, and the finer ones give the answer; that on a shell is a bound.

        Parameters
        ----------
        plan : Scenario
            Of the bodies as they were given.
        duration, quantity, rtol, solver, linear_solver
            As of `simulate`.
        began : float
            When the call began, by `perf_counter`, s.
        """
        controlled = quantity is not None or rtol is not None
        chosen = controlled or (plan.meshed and any(body.reducible for body in plan.bodies))
        if linear_solver is not None:
            check_linear_solver(linear_solver, chosen=chosen)
        margin = 0.0
        if controlled:  # bad input is refused before any work is done
            checked_rtol(rtol)
            margin = max(of.memory for of in self._interest(quantity, plan))
        foreseen = Foreseen(plan, linear_solver or "auto")
        if duration is None:
            record = foreseen.record()
        else:
            record = RecordLength(positive("duration", duration, unit="s"), given=True)
        record.margin = margin
        names = [member.called for member in self._members]
        eased: dict[int | None, str] = {}  # contacts that are stiffer than their meshes
        said = list[str]()
        while True:
            fitted = foreseen.fitted(names, eased)
            interest = partial(self._interest, quantity, fitted)
            try:
                if not chosen:
                    made = fitted.of_models(fitted.bodies, energies=plan.energies)
                    run = record.run(made, solver)
                    break
                with held_warnings() as said, bar("models", unit="solution"):
                    run = choose_models(
                        fitted,
                        interest,
                        rtol,
                        solver,
                        truncated=controlled,
                        record=record,
                        linear_solver=linear_solver or "auto",
                    )
                # The cost of the models: all but the run itself.
                spent = perf_counter() - began - run.recorder.seconds
                run = replace(run, modelled=max(spent, 0.0))
                break
            except LawLimitError as error:
                number = error.contact
                ends = [] if number is None else plan.touched(plan.contacts[number])
                ways = ["", *["wider"] * any(tip.automatic for *_, tip in ends)]
                if any(
                    isinstance(tip.thin, Layers) or (chosen and tip.body.finer) for *_, tip in ends
                ):
                    ways.append("whole")
                left = ways[ways.index(eased.get(number, "")) + 1 :]
                if not left:
                    raise
                eased[number] = left[0]
        if plan.meshed:
            if run.chosen is None:
                warn_of_misfit(run, names)
                find = partial(errors_left_out, interest=interest, solver=solver)
                run = replace(run, left_out=find) if run.plan.contacts else run
            run = replace(run, other_runs=partial(compared_runs, solver=solver, every=True))
        for message in (*said, *run.said):
            warn(message)
        if duration is None:
            record.warn_if_cut()
        warn_of_bodies(run, names)
        warn_of_run(run)
        return run

    def _interest(self, quantity: Any, plan: Scenario) -> tuple[Quantity, ...]:
        """The quantities of interest, by distinct names."""
        given = quantity if isinstance(quantity, (list, tuple)) else [quantity]
        if not given:
            raise InputError("quantity is empty: give one quantity at least, or leave it out")
        found = dict.fromkeys(self._quantity(of, plan) for of in given)
        names = [of.name for of in found]
        before = [names[:i].count(name) for i, name in enumerate(names)]
        return tuple(
            replace(of, name=f"{of.name}_{n + 1}") if n else of
            for of, n in zip(found, before, strict=True)
        )

    def _quantity(self, quantity: Any, plan: Scenario) -> Quantity:
        """A quantity of interest; where nothing meets, the motion of a body to be reduced."""
        bodies = plan.bodies
        if isinstance(quantity, Handle):
            self._known("quantity", quantity)
        if quantity is None and not plan.contacts:
            moved = [i for i, body in enumerate(bodies) if isinstance(body, FullModel)]
            quantity = Handle(moved[0], scene=self._mark.name) if moved else None
        interest = quantity_of(quantity, bodies, pair=not plan.scene)
        if interest.sliding and plan.oblique is None:
            raise InputError(
                f"quantity={interest.name!r} is of contacts with friction; give friction="
            )
        if interest.name.endswith("restitution"):
            met = [body for of in plan.contacts for body, _ in of.ports]
            speeds, comes = np.array(plan.velocities), plan.weighed or bool(plan.loads)
            if interest.sliding and plan.oblique is not None:
                along = plan.oblique.axes[1:].T
                speeds, comes = np.array(plan.oblique.velocities)[:, :3] @ along, False
            if len(plan.contacts) != 1 or not (comes or np.ptp(speeds[met], axis=0).any()):
                way = "past" if interest.sliding else "towards"
                raise InputError(
                    f"quantity={interest.name!r} is of one contact between two bodies that move "
                    f"{way} each other, and the scene has {len(plan.contacts)} contacts of bodies "
                    f'with velocities {speeds[met].tolist()} m/s; give "rebound_velocity", that of '
                    "every body"
                )
        if interest.each == "contacts" and not plan.contacts:
            raise InputError(
                f"quantity={interest.name!r}: the scene has no contacts; connect bodies, or give "
                "the handle of a body for its displacement"
            )
        return interest


def number_or_vector(name: str, value: Any, unit: str) -> tuple[float, FloatArray | None]:
    """Return a number along the direction of travel, or the length of a vector, and that vector.

    The vector, in three directions, is None of a number.
    """
    number, vector = value, None
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        vector = finite_array(name, value, shape=(3,), unit=unit)
        number = math.hypot(*vector)
    number = real(name, number, unit=unit)
    if number and not LEAST_SPEED <= abs(number) <= 1.0 / LEAST_SPEED:
        raise InputError(f"{name}={number:g} {unit} is beyond what can be computed with")
    return number, vector


def chosen_law(ends: Sequence[tuple[BodyModel, int]], names: Sequence[str]) -> LawFromSurfaces:
    """Return Hertz's law of two bodies from their surfaces and materials.

    Parameters
    ----------
    ends : sequence of (model, int)
        Projectile and target, and at which of their places they touch.
    names : sequence of str
        Names of both.

    Raises
    ------
    InputError
        If a surface is not known, or they have no Hertz contact.
    """
    surfaces, tips = [], []
    for name, (body, port), outward in zip(names, ends, (True, False), strict=True):
        tip = body.touched_at(port)
        body = body.turned((port,) if goes_against(tip, outward=outward) else ())
        surface = body.surface_at(port)
        if surface is None:
            raise InputError(
                f"law: it was left out, but {name}, {body!r}, does not know its surface and "
                "material; give law=, such as Hertz.between(...), or a body made by "
                "FEModel.from_mesh(...).contact(point=...), or ball(radius, material)"
            )
        surfaces.append(surface)
        tips.append(body.touched_at(port))
    along = [None if tip is None else tip.direction for tip in tips]
    try:
        return law_between(
            surfaces[0], surfaces[1], projectile_direction=along[0], target_direction=along[1]
        )
    except InputError as error:
        raise InputError(f"law: it was left out, but {error}") from None
