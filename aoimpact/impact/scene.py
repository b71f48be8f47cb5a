"""Scenes of any number of bodies and contacts along one direction of travel."""

from __future__ import annotations

import math
import uuid
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ..accuracy import Quantity, TimeSolver, scene_quantity
from ..base import (
    InputError,
    InputTypeError,
    boolean,
    finite_array,
    real,
    warn,
)
from ..fem import ContactPoint
from ..laws import ContactLaw, effective_law, own_law
from ..linalg import Solver as LinearSolver
from ..reduction import InterfaceModel
from ..results import Handle, Run
from ..scene import Joint, Load, Plan, SceneBody, StarBody, normal_gap, scene_body
from .checks import checked_duration, checked_speed
from .run import RunOptions, run_models

__all__ = ["Scene", "SceneCase"]


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
    gravity : float, optional
        Acceleration of every finite mass along the direction of travel, m/s². A body constrained
        by supports takes its true share where it has nodes; a constrained AO model given by
        numbers takes none.

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

    def __init__(self, *, gravity: float = 0.0) -> None:
        self.gravity = real("gravity", gravity, unit="m/s²")
        self._bodies: list[Any] = []
        self._scene_bodies: list[SceneBody] = []
        self._velocities: list[float] = []
        self._positions: list[float] = []
        self._names: list[str] = []
        self._joints: list[Joint] = []
        self._between: dict[tuple[int, int, int, int], list[int]] = {}  # contacts at the same place
        self._loads: list[Load] = []
        # Copies and pickles keep it: their handles are as good.
        self._mark = _Mark(uuid.uuid4().hex)

    def __repr__(self) -> str:
        labels = ", ".join(body.label for body in self._scene_bodies[:6])
        more = ", …" if len(self._scene_bodies) > 6 else ""
        return (
            f"Scene(gravity={self.gravity:g}): {len(self._scene_bodies)} bodies ({labels}{more}), "
            f"{len(self._joints)} contacts, {len(self._loads)} loads"
        )

    # ------------------------------------------------------------------- building

    def add(
        self, body: Any, *, velocity: float = 0.0, position: float = 0.0, name: str = ""
    ) -> Handle:
        """Add a body, undeformed and moving as a whole.

        Parameters
        ----------
        body : AOModel, ModalModel, InterfaceModel, ContactPoint or list of ContactPoint
            A ContactPoint (``body.contact(...)``) stands for the full finite-element model, a list
            of them on one body for one that is touched in several places, a `rigid` body of
            infinite mass for a wall.
        velocity : float, optional
            m/s.
        position : float, optional
            Of its contact coordinate (of all of them) at t = 0, m.
        name : str, optional
            For messages.

        Returns
        -------
        Handle
            To connect, load and read it by.

        Raises
        ------
        InputError, InputTypeError
            If `body` is no model of a body, or a number is none or beyond the range of squares.
        """
        if not isinstance(name, str):
            raise InputTypeError(f"name must be a str, got {name!r}")
        speed = checked_speed("velocity", velocity)
        self._scene_bodies.append(scene_body("body", body, speed))
        self._bodies.append(tuple(body) if isinstance(body, list) else body)
        self._velocities.append(speed)
        self._positions.append(real("position", position, unit="m"))
        self._names.append(name)
        return Handle(len(self._scene_bodies) - 1, name=name, scene=self._mark.name)

    def connect(self, a: Handle, b: Handle, law: ContactLaw, *, gap: float = 0.0) -> int:
        """Let two bodies touch: δ = (x_a + position_a) - (x_b + position_b) - gap.

        Parameters
        ----------
        a, b : Handle
            Of `add`; ``handle.port(i)`` for another place of a body touched in several.
        law : ContactLaw
        gap : float, optional
            m; may be negative where positions are given.

        Returns
        -------
        int
            Its place in ``run.contacts``.

        Raises
        ------
        InputError
            For a body with itself, two walls, or an unknown handle.
        """
        first, second = self._known("a", a), self._known("b", b)
        if first.body == second.body:
            raise InputError(
                f"a and b are both {self._called(first)}: a body cannot touch itself; connect it "
                "to another"
            )
        if not isinstance(law, ContactLaw):
            raise InputTypeError(f"law must be a contact law such as Hertz(k=...), got {law!r}")
        if all(math.isinf(self._scene_bodies[end.body].static_mass) for end in (first, second)):
            raise InputError(
                f"{self._called(first)} and {self._called(second)} are both of infinite mass: "
                "there is no motion between them"
            )
        apart = real("gap", gap, unit="m")
        apart += self._positions[second.body] - self._positions[first.body]
        ends = _touched(self._bodies, first), _touched(self._bodies, second)
        between = effective_law(law, ends)
        gap = normal_gap(apart)
        joint = Joint(first.body, first.at, second.body, second.at, between, gap, ends)
        beside = self._between.setdefault(joint[:4], [])
        for number in beside:
            other = self._joints[number]
            if (other.law, other.gap) == (joint.law, joint.gap):
                raise InputError(
                    f"contact {number} is the same: {self._called(first)} and "
                    f"{self._called(second)} under the same law and gap; leave this one out, or "
                    "double the law's stiffness"
                )
        beside.append(len(self._joints))
        self._joints.append(joint)
        return len(self._joints) - 1

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
        if math.isinf(self._scene_bodies[end.body].static_mass):
            raise InputError(f"{self._called(end)} is a wall: no force moves it; load another body")
        self._loads.append(Load(end.body, end.at, times.copy(), forces.copy()))

    def _known(self, name: str, handle: Any) -> Handle:
        if not isinstance(handle, Handle):
            raise InputTypeError(f"{name} must be a handle that scene.add returned, got {handle!r}")
        if handle.scene != self._mark.name or handle.body >= len(self._scene_bodies):
            raise InputError(
                f"{name}={handle!r} is of another scene; add the body to this one and take the "
                "handle that scene.add returns"
            )
        ports = self._scene_bodies[handle.body].ports
        if not 0 <= handle.at < ports:
            raise InputError(
                f"{name}: {self._called(handle)} may be touched in {ports} place(s), there is no "
                f"port {handle.at}"
            )
        return handle

    def _called(self, handle: Handle) -> str:
        name = self._names[handle.body]
        return f"body {handle.body}" + (f" ({name})" if name else "")

    # ------------------------------------------------------------------- running

    def simulate(
        self,
        *,
        duration: float,
        solver: TimeSolver | None = None,
        energies: bool = True,
        preload: bool = False,
        quantity: str | Handle | ContactPoint | None = None,
        rtol: float | None = None,
        linear_solver: LinearSolver | None = None,
    ) -> Run:
        """Simulate the scene.

        Parameters
        ----------
        duration : float
            Length of the record, s.
        solver : Adaptive or Newmark, optional
            By default ``Adaptive()``; with a full finite-element model ``Newmark()``.
        energies : bool, optional
            Whether to record energies as well.
        preload : bool, optional
            Whether to start from rest under gravity and the loads at t = 0, bodies pressed on each
            other, found by a static solve; velocities are then added. What no force presses stays
            where it was put, or moves aside as far as it must.
        quantity : str, Handle or ContactPoint, optional
            The quantity of interest: "force" (of every contact over the record), "peak_force" or
            "impulse" (of every contact), a handle, for the displacement of that contact coordinate
            over the record, or a point of a body, for its displacement over the record. Given this
            or `rtol`, finite-element bodies are reduced, and AO models truncated, as far as the
            tolerance allows; `Run.models` are those taken. A body that was added twice is reduced
            once.
        rtol : float, optional
            Its relative error, 1e-2 if left out; that of a history is its largest over the record,
            relative to the largest value, that of a contact relative to no less than a tenth of the
            largest of all contacts. A solver that does not keep it is refused.
        linear_solver : {"auto", "banded", "superlu", "pardiso", "multigrid"} or callable, optional
            What solves for these reduced models, as `solver` of `antioscillators`.

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
        """
        length = checked_duration(duration)
        boolean("energies", energies)
        boolean("preload", preload)
        if not self._scene_bodies:
            raise InputError("the scene is empty: add bodies with scene.add(...)")
        if not preload:
            self._refuse_overlap()
        bodies, which = _different(self._bodies)

        def plan_of(models: Sequence[Any], energies: bool) -> Plan:
            return self._plan([models[i] for i in which], length, energies, preload)

        return run_models(
            plan_of,
            bodies,
            RunOptions(quantity, rtol, solver, energies, linear_solver),
            names=[self._called(Handle(body)) for body in range(len(self._bodies))],
            interest=partial(self._interest, quantity),
            view=_itself,
        )

    def _plan(self, bodies: Sequence[Any], length: float, energies: bool, preload: bool) -> Plan:
        """The plan of the bodies, or of models in their place."""
        scene_bodies, joints = self._scene_bodies, self._joints
        if any(model is not body for model, body in zip(bodies, self._bodies, strict=True)):
            scene_bodies = [
                scene_body("body", body, speed)
                for body, speed in zip(bodies, self._velocities, strict=True)
            ]
            joints = [_between(joint, bodies, scene_bodies) for joint in joints]
        for body in scene_bodies:
            if self.gravity and isinstance(body, StarBody) and body.model.weightless:
                warn(
                    f"gravity has no effect on {body.label}: the supports of an AO model given by "
                    "numbers, or by matrices without nodes, are not known; make it by "
                    "antioscillators(...) of a body with nodes"
                )
        return Plan(
            tuple(scene_bodies),
            tuple(self._velocities),
            tuple(joints),
            tuple(self._loads),
            self.gravity,
            length,
            energies,
            preload,
            self._mark.name,
        )

    def _interest(self, quantity: Any) -> Quantity:
        """The quantity of interest."""
        if isinstance(quantity, Handle):
            self._known("quantity", quantity)
        interest = scene_quantity(quantity, self._bodies)
        if interest.of_contacts and not self._joints:
            raise InputError(
                f"quantity={interest.name!r}: the scene has no contacts; connect bodies, or give "
                "the handle of a body for its displacement"
            )
        return interest

    def _refuse_overlap(self) -> None:
        for number, joint in enumerate(self._joints):
            if joint.gap < 0.0:
                first, second = Handle(joint.first), Handle(joint.second)
                raise InputError(
                    f"contact {number}: {self._called(first)} and {self._called(second)} overlap "
                    f"by {-joint.gap:g} m at the start; change position or gap, or start with "
                    "preload=True from the rest that gravity and loads press them to"
                )


def _itself(run: Run) -> Run:
    return run


def _different(bodies: Sequence[Any]) -> tuple[list[Any], Sequence[int]]:
    """Bodies that were added more than once only once, and which of these each is."""
    different = list({id(body): body for body in bodies}.values())
    places = {id(body): i for i, body in enumerate(different)}
    return different, [places[id(body)] for body in bodies]


def _touched(bodies: Sequence[Any], handle: Handle) -> Any:
    """The contact point or model whose patch, if any, a handle stands for."""
    body = bodies[handle.body]
    tips = body.tips if isinstance(body, InterfaceModel) else body
    return tips[handle.at] if isinstance(tips, tuple) else tips


def _between(joint: Joint, bodies: Sequence[Any], scene_bodies: Sequence[SceneBody]) -> Joint:
    """The contact between the models that stand for its bodies."""
    if all(math.isinf(scene_bodies[body].static_mass) for body in (joint.first, joint.second)):
        raise InputError(
            "both bodies of a contact are of infinite mass: there is no motion between them"
        )
    ends = (
        _touched(bodies, Handle(joint.first, joint.first_port)),
        _touched(bodies, Handle(joint.second, joint.second_port)),
    )
    return joint._replace(law=effective_law(own_law(joint.law), ends), ends=ends)


@dataclass(frozen=True)
class SceneCase:
    """A scene and the keywords of its run, without the duration."""

    scene: Any
    keywords: dict[str, Any]

    def simulate(self, *, duration: float) -> Any:
        return self.scene.simulate(duration=duration, **self.keywords)
