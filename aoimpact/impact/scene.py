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

# Smallest speed, m/s: squares and energies of lower speeds underflow; those of speeds above
# 1/LEAST_SPEED overflow.
LEAST_SPEED = 1e-60


@dataclass(frozen=True)
class Mark:
    """Unique identifier of a scene, by which its handles are recognised."""

    name: str = field(metadata={"identity": True})


class Member(NamedTuple):
    """A body of a scene with its initial velocity, position and names.

    If the user gave the velocity as a vector, `velocity` is the length of this `vector`. `called`
    is the name in messages.
    """

    body: BodyModel
    velocity: float
    vector: FloatArray | None
    spin: FloatArray | None
    position: float
    name: str
    called: str


class Scene:
    """Bodies, the contacts between them, and the loads on them.

    All displacements are along one direction of travel. Bodies are added, connected and loaded,
    then the scene is simulated. A scene can be simulated repeatedly, with more bodies or other
    solvers.

    Parameters
    ----------
    gravity : float or array_like, shape (3,), optional
        Acceleration of gravity along the direction of travel, or in three directions (see
        `simulate`), m/s², up to 1e12. Gravity has no effect on a constrained AO model given by
        numbers or without nodes, whose supports are not known.

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
        # gravity: component along the direction of travel or, if given as a vector (`_falls`), its
        # length.
        self.gravity, self._falls = number_or_vector("gravity", gravity, "m/s²")
        self._members: list[Member] = []
        self._contacts: list[Contact] = []
        self._loads: list[Load] = []
        # Copies and pickles of a scene keep its mark, so that handles stay valid. The mark of an
        # impact of two bodies is empty.
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
        """Add a body, which is undeformed at t = 0 and moves as a whole.

        Parameters
        ----------
        body : ContactPoint or list of ContactPoint, AOModel, Body, FullModel
            Body to add. One given by its contact point (``body.contact(...)``), or by a list of
            several, is reduced as far as the quantity of interest allows; ``full`` of these is the
            full finite-element model. A `rigid` body of infinite mass is a wall.
        velocity : float or array_like, shape (3,), optional
            Velocity along the direction of travel, or in three directions (see `simulate`), m/s.
        spin : array_like, shape (3,), optional
            Angular velocity in the same axes, rad/s.
        position : float, optional
            Position at t = 0 along the direction of travel, common to all contact points, m.
        name : str, optional
            Name in results, tables and plots; by default that of the body itself.

        Returns
        -------
        Handle
            Identifies the body in `connect`, `apply` and the result.

        Raises
        ------
        InputError, InputTypeError
            If `body` is no model of a body, or a number is invalid or its square out of range.

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
        """Add a body given as the argument `argument`; return it and its velocity as a `Member`."""
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
        """Add a contact with the indentation δ = (x_a + position_a) - (x_b + position_b) - gap.

        Parameters
        ----------
        a, b : Handle
            Bodies in contact; ``handle.port(i)`` selects one of several contact points of a body.
        law : ContactLaw, optional
            Contact law; by default Hertz's law of the materials of both bodies and the curvatures
            of their surfaces at the contact.
        gap : float, optional
            Gap between the bodies at equal positions, m; may be negative if positions are given.
        friction : float, optional
            Coefficient of friction; see `simulate`.
        name : str, optional
            Name of the contact in results, tables and plots.

        Returns
        -------
        int
            Index of the contact in ``run.contacts``.

        Raises
        ------
        InputError
            For a contact of a body with itself or of two walls, an unknown handle, a reversed
            direction, or if `law` is left out and the surfaces or materials are not known.

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
        """Add a contact between two ports, given as (body, port), with the initial gap `gap`, m."""
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
                f"friction needs a law without memory or tension, got {law!r}; give Hertz(...), a "
                "damped law and solver=Newmark(), or friction=0"
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
            Constant force, N; or ascending times, s, and the forces at these times, N, linear in
            between and constant outside.

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
        """Return the numbers of the body and contact point of a handle, checked to be valid."""
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
            Length of the record, s; by default until the last contact is over and as long again.
        solver : Adaptive or Newmark, optional
            Time integration; by default ``Adaptive()``, with friction ``Adaptive(rtol=1e-4)``, with
            a full finite-element model, or friction and a damped law, ``Newmark()``.
        energies : bool, optional
            True to record energies as well.
        preload : bool, optional
            True to start from the static equilibrium of bodies pressed on each other by gravity and
            the loads at t = 0; velocities are then added. Bodies that no force presses stay at
            their positions, or move aside as far as they must.
        quantity : str, Handle, ContactPoint or sensor, or list of these, optional
            Quantity of interest. Over the record: "force" (of every contact), the displacement of a
            contact coordinate, given by its handle, or of a point of a body, or a sensor such as
            `ReactionAt`, as for `simulate`. For every contact: "peak_force", "peak_time",
            "impulse", "contact_duration" (of the first touch) or "contact_count". For every body
            that is not held at rest: "rebound_velocity" (after the last contact). For a scene of
            one contact: "restitution", as of `simulate`. With friction: "peak_friction_force",
            "tangential_restitution" or "final_spin". Each quantity of a list meets `rtol`. Bodies
            given by contact points are reduced as far as `rtol` allows; AO models are truncated if
            `quantity` or `rtol` is given. `Run.models` has the resulting models, `Run.value`
            returns numbers. A body that was added twice is reduced once.
        rtol : float, optional
            Relative tolerance of `quantity`; by default 2e-3, or up to 1e-2 if the largest models
            tried do not meet 2e-3. The error of a history is its largest over the record, relative
            to the largest value, and for contacts relative to at least a tenth of the largest of
            all contacts. A solver that does not meet `rtol` is refused.
        linear_solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
            Linear solver for the reduced models, as `solver` of `antioscillators`.

        Raises
        ------
        InputError, InputTypeError
            For an invalid argument, an empty scene, or bodies that overlap at the start without
            `preload`.
        ConvergenceError
            If the tolerance cannot be met, or there is no static equilibrium.

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
                    "position or gap, or start with preload=True from their equilibrium under "
                    "gravity and loads"
                )
        return self._run(plan, duration, quantity, rtol, solver, linear_solver, began)

    def _plan(self, *, energies: bool = True, preload: bool = False) -> Scenario:
        """Return the plan of the bodies as given; its contacts have numbers of contact points.

        With friction, these numbers are later replaced by numbers of ports.

        Raises
        ------
        InputError
            If some contacts have friction and others none, or directions of travel differ.
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
        """Motion in three directions; None for a scene along one direction."""
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
        """Run the scene with the bodies as given, or with models chosen for a tolerance.

        A contact whose law is stiffer than its meshes gets a wider patch: supports, loads and other
        bodies increase indentations beyond those in an impact of two bodies. If no patch helps, the
        contact of the bodies as meshed keeps its whole law. The run with refined bodies is then the
        result, and on a shell only a bound of the motion.

        Parameters
        ----------
        plan : Scenario
            Scene of the bodies as given.
        duration, quantity, rtol, solver, linear_solver
            As of `simulate`.
        began : float
            Start of the call by `perf_counter`, s.
        """
        controlled = quantity is not None or rtol is not None
        chosen = controlled or (plan.meshed and any(body.reducible for body in plan.bodies))
        if linear_solver is not None:
            check_linear_solver(linear_solver, chosen=chosen)
        margin = 0.0
        if controlled:  # invalid input is reported before any expensive work
            checked_rtol(rtol)
            margin = max(of.memory for of in self._interest(quantity, plan))
        foreseen = Foreseen(plan, linear_solver or "auto")
        if duration is None:
            record = foreseen.record()
        else:
            record = RecordLength(positive("duration", duration, unit="s"), given=True)
        record.margin = margin
        names = [member.called for member in self._members]
        eased: dict[int | None, str] = {}  # remedies for contacts stiffer than their meshes
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
                # The cost of the models does not include the last run.
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
        """Return the quantities of interest; equal names get a number, such as "stress_2"."""
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
        """Return the quantity of interest; without contacts, by default a displacement."""
        bodies = plan.bodies
        if isinstance(quantity, Handle):
            self._known("quantity", quantity)
        if quantity is None and not plan.contacts:
            moved = [i for i, body in enumerate(bodies) if isinstance(body, FullModel)]
            quantity = Handle(moved[0], scene=self._mark.name) if moved else None
        interest = quantity_of(quantity, bodies, pair=not plan.scene)
        if interest.sliding and plan.oblique is None:
            raise InputError(
                f"quantity={interest.name!r} needs contacts with friction; give friction="
            )
        if interest.name.endswith("restitution"):
            met = [body for of in plan.contacts for body, _ in of.ports]
            speeds = np.array(plan.velocities)
            if interest.sliding and plan.oblique is not None:
                speeds = np.array(plan.oblique.velocities)[:, :3] @ plan.oblique.axes[1:].T
            comes = plan.weighed or plan.loads or np.ptp(speeds[met], axis=0).any()
            if len(plan.contacts) != 1 or not comes:
                way = "past" if interest.sliding else "towards"
                raise InputError(
                    f"quantity={interest.name!r} needs exactly one contact, between two bodies "
                    f"that move {way} each other; the scene has {len(plan.contacts)} contacts, and "
                    f"the velocities of their bodies are {speeds[met].tolist()} m/s. Give "
                    'quantity="rebound_velocity", which every body has'
                )
        if interest.each == "contacts" and not plan.contacts:
            raise InputError(
                f"quantity={interest.name!r}: the scene has no contacts; connect bodies, or give "
                "the handle of a body for its displacement"
            )
        return interest


def number_or_vector(name: str, value: Any, unit: str) -> tuple[float, FloatArray | None]:
    """Return a number and None or, given a vector, its length and the vector."""
    number, vector = value, None
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        vector = finite_array(name, value, shape=(3,), unit=unit)
        number = math.hypot(*vector)
    number = real(name, number, unit=unit)
    if number and not LEAST_SPEED <= abs(number) <= 1.0 / LEAST_SPEED:
        raise InputError(f"{name}={number:g} {unit}: energies would be beyond the range of numbers")
    return number, vector


def chosen_law(ends: Sequence[tuple[BodyModel, int]], names: Sequence[str]) -> LawFromSurfaces:
    """Return Hertz's law of two bodies from their surfaces and materials.

    Parameters
    ----------
    ends : sequence of (model, int)
        Model and number of the contact point, of projectile and target.
    names : sequence of str
        Names of both bodies, for messages.

    Raises
    ------
    InputError
        If a surface is not known, or the two surfaces have no Hertzian contact.
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
