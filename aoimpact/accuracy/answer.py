"""What an impact or a scene is asked for, and how far apart two runs' answers are."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from ..base import FloatArray, InputError, choice, warn
from ..fem import ContactPoint
from ..results import Handle, Result, Run

__all__ = ["QUANTITIES", "SCENE_QUANTITIES", "Answer", "SceneAnswer", "answer", "scene_answer"]

SCENE_QUANTITIES = ("force", "peak_force", "impulse")

# Errors of a contact of a scene are relative to itself, but to no less than this share of the
# largest: one that only grazes has no digits of its own.
_LEAST_CONTACT = 0.1

# Errors of a velocity, or a restitution, are relative to itself, but to no less than this share of
# the initial one, or of 1: a body that is all but stopped has no digits of its own.
_LEAST_REBOUND = 0.1


@dataclass(frozen=True)
class Answer:
    """A quantity of an impact.

    Attributes
    ----------
    quantity : str or ContactPoint
        "force": the force over the record; "peak_force", "impulse"; "contact_duration": of the
        first contact; "rebound_velocity": the projectile's; "projectile_displacement",
        "target_displacement": of the contact coordinate over the record; a point on one of the
        bodies: its displacement over the record.
    on_target : bool
        Whether the point is on the target.
    """

    quantity: str | ContactPoint
    on_target: bool = False

    @property
    def is_history(self) -> bool:
        """Whether it is a history rather than a number."""
        return isinstance(self.quantity, ContactPoint) or self.quantity not in _NUMBERS

    def difference(self, result: Result, exact: Result) -> float:
        """Return how far a result is from a more exact one, relative.

        Of histories the largest difference over the record, relative to the largest value.
        """
        return float(np.abs(self.deviation(result, exact)).max())

    def deviation(self, result: Result, exact: Result) -> FloatArray:
        """Return by how much a result is larger than a more exact one, relative.

        Shape (1,); of histories (times,), relative to the largest value.
        """
        if isinstance(self.quantity, str) and self.quantity in _NUMBERS:
            return np.array([_number_apart(self.quantity, result, exact)])
        times = exact.t
        return _beyond(self.history(result, times), self.history(exact, times))

    def span(self, result: Result) -> float:
        """Return how long, s, the motion must be right for the answer to be so."""
        if isinstance(self.quantity, ContactPoint) or self.quantity.endswith("displacement"):
            return float(result.t[-1])
        return result.contacts[-1][1] if result.contacts else 0.0

    def contact_time(self, result: Result) -> float | None:
        """Return the duration of the first contact, s; None where none ends in the record."""
        return result.contact_duration or None

    def errors(self, result: Result, *exact: Result) -> dict[str, float]:
        """Return by how much each number that sums up a result may be wrong, relative.

        The sum of the changes from each run to the next, more exact one; NaN of a number that there
        is not. "contacts" is infinite if they have not as many.
        """
        runs = (result, *exact)
        errors = {
            name: sum(abs(_number_apart(name, *pair)) for pair in pairwise(runs))
            for name in _NUMBERS
        }
        for name in ("rebound_velocity", "restitution"):
            if math.isnan(getattr(result, name)):
                errors[name] = math.nan
        as_many = len({len(run.contacts) for run in runs}) == 1
        return errors | {"contacts": 0.0 if as_many else math.inf}

    @property
    def named(self) -> str:
        """What it is, in words."""
        return "displacement" if isinstance(self.quantity, ContactPoint) else self.quantity

    def history(self, run: Result, times: FloatArray) -> FloatArray:
        """Return the force or displacement at `times`, s."""
        if isinstance(self.quantity, ContactPoint):
            body = run.target if self.on_target else run.projectile
            return body.displacement_of(self.quantity.b, times)
        return _at(run, times, self._recorded)

    def _recorded(self, run: Result) -> FloatArray:
        if self.quantity == "force":
            force: FloatArray = run.run.forces[0]
            return force
        body = run.target if self.quantity == "target_displacement" else run.projectile
        motion: FloatArray = body.port_displacements[0]
        return motion


_NUMBERS: dict[str, Callable[[Result], float]] = {
    "peak_force": lambda run: run.peak_force,
    "peak_time": lambda run: run.peak_time,
    "contact_duration": lambda run: run.contact_duration,
    "impulse": lambda run: run.impulse,
    # Of runs that end in contact as well: to compare them by.
    "rebound_velocity": lambda run: run.parting[0],
    "restitution": lambda run: run.parting_speed / run.velocity,
}

# What is asked for by another name: with a warning where that means something else elsewhere.
_SHORT, _RENAMED = {"rebound": "rebound_velocity"}, {"duration": "contact_duration"}

QUANTITIES = (
    "force",
    "peak_force",
    "impulse",
    "contact_duration",
    "rebound_velocity",
    "projectile_displacement",
    "target_displacement",
)


def _number_apart(name: str, result: Result, exact: Result) -> float:
    """By how much a number of a result is above that of a more exact one, relative."""
    one, other = (_NUMBERS[name](run) for run in (result, exact))
    scale = abs(other)
    if name == "rebound_velocity":
        scale = max(scale, _LEAST_REBOUND * abs(exact.velocity))
    elif name == "restitution":
        scale = max(scale, _LEAST_REBOUND)
    return float(_relative(np.array(one - other), scale))


def answer(quantity: Any, projectile: Any, target: Any) -> Answer:
    """Return the answer that a caller's `quantity` means in an impact of two bodies.

    Raises
    ------
    InputError, InputTypeError
        If there is no such quantity, or the point is on neither body, or on both.
    """
    if not isinstance(quantity, ContactPoint):
        return Answer(choice("quantity", _by_name(quantity), QUANTITIES))
    on = [
        isinstance(body, ContactPoint) and body.body is quantity.body
        for body in (projectile, target)
    ]
    if not any(on):
        raise InputError(
            f"quantity={quantity!r} is a point on neither projectile nor target: give a point of a "
            "finite-element body that takes part as one"
        )
    if all(on):
        raise InputError(
            f"quantity={quantity!r} is a point of both projectile and target, which are one "
            "FEModel: give one of them a model of its own, copy.copy(model), and take the point "
            "from that; the contact's own are 'projectile_displacement' and 'target_displacement'"
        )
    return Answer(quantity, on_target=on[1])


def _by_name(quantity: Any) -> Any:
    """The name of today."""
    if isinstance(quantity, str) and quantity in _RENAMED:
        warn(
            f"quantity={quantity!r} is called {_RENAMED[quantity]!r} now: duration is the record's"
        )
    return (_SHORT | _RENAMED).get(quantity, quantity) if isinstance(quantity, str) else quantity


@dataclass(frozen=True)
class SceneAnswer:
    """A quantity of a scene.

    Attributes
    ----------
    quantity : str, Handle or ContactPoint
        "force": the forces of all contacts over the record; "peak_force", "impulse": of each
        contact; a handle: the displacement of that contact coordinate over the record; a point of a
        finite-element body: its displacement over the record.
    body : int, optional
        That the point is on.
    """

    quantity: str | Handle | ContactPoint
    body: int = 0

    @property
    def is_history(self) -> bool:
        """Whether it is a history, or several, rather than numbers."""
        return not isinstance(self.quantity, str) or self.quantity == "force"

    def difference(self, run: Run, exact: Run) -> float:
        """Return how far a run is from a more exact one, relative.

        Of histories the largest difference over the record, relative to the largest value; of
        contacts the worst, none of them relative to less than a tenth of the largest of all.
        """
        return float(np.abs(self.deviation(run, exact)).max(initial=0.0))

    def deviation(self, run: Run, exact: Run) -> FloatArray:
        """Return by how much a run gives more than a more exact one, relative as in `difference`.

        Flat: contact by contact; of histories at the times of the more exact run.
        """
        times = exact.t
        if isinstance(self.quantity, ContactPoint):
            point = self.quantity.b
            seen = (of.bodies[self.body].displacement_of(point, times) for of in (run, exact))
            return _beyond(*seen)
        if isinstance(self.quantity, Handle):
            return _beyond(_at(run, times, self._displacement), self._displacement(exact))
        if self.quantity == "force":
            ours, theirs = _at(run, times, _forces), _forces(exact)
            size = theirs.max(axis=1)
        else:
            name = self.quantity
            ours, theirs = (
                np.array([getattr(of, name) for of in one.events]) for one in (run, exact)
            )
            size = np.abs(theirs)
        scales = np.maximum(size, _LEAST_CONTACT * size.max(initial=0.0))
        return np.concatenate(
            [
                _relative(np.atleast_1d(apart), float(scale))
                for apart, scale in zip(ours - theirs, scales, strict=True)
            ]
            or [np.zeros(0)]
        )

    def errors(self, run: Run, *exact: Run) -> dict[str, float]:
        """Return by how much each number that sums up a run may be wrong, relative to itself.

        The sum of the changes from each run to the next, more exact one; by the names by which they
        are kept, such as "contacts.0.peak_force". "contacts.0.intervals" is infinite if these are
        not as many.
        """
        runs = (run, *exact)
        errors = {}
        for i, found in enumerate(zip(*(of.events for of in runs), strict=True)):
            for name in ("peak_force", "peak_time", "impulse"):
                values = [float(getattr(of, name)) for of in found]
                errors[f"contacts.{i}.{name}"] = sum(
                    abs(float(_relative(np.array(one - other), abs(other))))
                    for one, other in pairwise(values)
                )
            as_many = len({len(of.contacts) for of in found}) == 1
            errors[f"contacts.{i}.intervals"] = 0.0 if as_many else math.inf
        return errors

    @property
    def named(self) -> str:
        """What it is, in words."""
        return self.quantity if isinstance(self.quantity, str) else "displacement"

    def span(self, run: Run) -> float:
        """Return how long, s, the motion must be right for the answer to be so."""
        if not isinstance(self.quantity, str):
            return run.duration
        return max((of.contacts[-1][1] for of in run.events if of.contacts), default=0.0)

    def contact_time(self, run: Run) -> float | None:
        """Return how long the shortest of the hard blows lasts, s; None without one."""
        hardest = max((of.peak_force for of in run.events), default=0.0)
        blows = [
            next(end - start for start, end in of.contacts if of.peak_time <= end)
            for of in run.events
            if of.contacts and of.peak_force >= _LEAST_CONTACT * hardest
        ]
        return min((blow for blow in blows if blow > 0.0), default=None)

    def _displacement(self, run: Run) -> FloatArray:
        assert isinstance(self.quantity, Handle)
        displacement: FloatArray = run[self.quantity].port_displacements[self.quantity.at]
        return displacement


def scene_answer(quantity: Any, bodies: Sequence[Any]) -> SceneAnswer:
    """Return the answer that a caller's `quantity` means in a scene; handles are checked before.

    Raises
    ------
    InputError, InputTypeError
        If there is no such quantity, or the point is on none of the bodies, or on several.
    """
    if isinstance(quantity, Handle):
        return SceneAnswer(quantity)
    if not isinstance(quantity, ContactPoint):
        return SceneAnswer(choice("quantity", quantity, SCENE_QUANTITIES))
    tips = [body[0] if isinstance(body, tuple) else body for body in bodies]
    on = [
        number
        for number, tip in enumerate(tips)
        if isinstance(tip, ContactPoint) and tip.body is quantity.body
    ]
    if not on:
        raise InputError(
            f"quantity={quantity!r} is a point on none of the scene's bodies: give a point of a "
            "finite-element body that takes part as one"
        )
    if len(on) > 1:
        raise InputError(
            f"quantity={quantity!r} is a point of {len(on)} of the scene's bodies, which are one "
            "FEModel: give that one a model of its own, copy.copy(model), and take the point from "
            "it; a contact's own displacement is asked for by its handle"
        )
    return SceneAnswer(quantity, on[0])


T = TypeVar("T", Result, Run)


def _at(run: T, times: FloatArray, recorded: Callable[[T], FloatArray]) -> FloatArray:
    """What is recorded of a run, at `times`."""
    if run.t is times:
        return recorded(run)
    try:
        return recorded(run.at(times))
    except InputError:  # of a run with fixed steps, known at these only
        rows = np.atleast_2d(recorded(run))
        between = np.array([np.interp(times, run.t, row) for row in rows])
        return between if recorded(run).ndim > 1 else between[0]


def _forces(run: Run) -> FloatArray:
    """Shape (contacts, times)."""
    return run.forces


def _beyond(mine: FloatArray, right: FloatArray) -> FloatArray:
    """By how much a history is above another, relative to the largest value of that."""
    return _relative(mine - right, float(np.abs(right).max()))


def _relative(difference: FloatArray, scale: float) -> FloatArray:
    if scale > 0.0:
        return difference / scale
    none = difference == 0.0
    return np.where(none, 0.0, np.copysign(np.inf, difference))
