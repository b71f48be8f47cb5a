"""What an impact is asked for, and how far apart two runs' answers are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .checks import choice
from .contact import ContactPoint
from .errors import InputError
from .events import FloatArray
from .result import Result

__all__ = ["QUANTITIES", "Answer", "answer"]

QUANTITIES = (
    "force",
    "peak_force",
    "impulse",
    "duration",
    "rebound",
    "projectile_displacement",
    "target_displacement",
)

# A velocity's error is relative to itself, but to no less than this share of the initial one: a
# body that is all but stopped has no digits of its own.
_LEAST_REBOUND = 0.1


@dataclass(frozen=True)
class Answer:
    """A quantity of an impact.

    Attributes
    ----------
    quantity : str or ContactPoint
        "force": the force over the record; "peak_force", "impulse"; "duration": of the first
        contact; "rebound": the projectile's velocity; "projectile_displacement",
        "target_displacement": of the contact coordinate over the record; a point on one of the
        bodies: its displacement over the record.
    on_target : bool
        Whether the point is on the target.
    """

    quantity: str | ContactPoint
    on_target: bool = False

    def difference(self, result: Result, exact: Result) -> float:
        """Return how far a result is from a more exact one, relative.

        Of histories the largest difference over the record, relative to the largest value.
        """
        if isinstance(self.quantity, str) and self.quantity in _NUMBERS:
            one, other = (_NUMBERS[self.quantity](run) for run in (result, exact))
            scale = abs(other)
            if self.quantity == "rebound":
                scale = max(scale, _LEAST_REBOUND * abs(exact.velocity))
            return _relative(abs(one - other), scale)
        times = exact.t
        mine, right = self.history(result, times), self.history(exact, times)
        return _relative(float(np.abs(mine - right).max()), float(np.abs(right).max()))

    def span(self, result: Result) -> float:
        """Return how long, s, the motion must be right for the answer to be so."""
        if isinstance(self.quantity, ContactPoint) or self.quantity.endswith("displacement"):
            return float(result.t[-1])
        return result.contacts[-1][1] if result.contacts else 0.0

    def history(self, run: Result, times: FloatArray) -> FloatArray:
        """Return the force or displacement at `times`, s."""
        if isinstance(self.quantity, ContactPoint):
            body = run.target if self.on_target else run.projectile
            return body.displacement_of(self.quantity.b, times)
        if run.t is times:
            return self._recorded(run)
        try:
            return self._recorded(run.at(times))
        except InputError:  # of a run with fixed steps, known at these only
            return np.interp(times, run.t, self._recorded(run))

    def _recorded(self, run: Result) -> FloatArray:
        if self.quantity == "force":
            return run.force
        body = run.target if self.quantity == "target_displacement" else run.projectile
        return body.displacement


_NUMBERS: dict[str, Callable[[Result], float]] = {
    "peak_force": lambda run: run.peak_force,
    "impulse": lambda run: run.impulse,
    "duration": lambda run: run.contact_duration,
    "rebound": lambda run: run.rebound_velocity,
}


def answer(quantity: Any, projectile: Any, target: Any) -> Answer:
    """Return the answer that a caller's `quantity` means in an impact of two bodies.

    Raises
    ------
    InputError, InputTypeError
        If there is no such quantity, or the point is on neither body.
    """
    if not isinstance(quantity, ContactPoint):
        return Answer(choice("quantity", quantity, QUANTITIES))
    for on_target, body in ((False, projectile), (True, target)):
        if isinstance(body, ContactPoint) and body.body is quantity.body:
            return Answer(quantity, on_target)
    raise InputError(
        f"quantity={quantity!r} is a point on neither projectile nor target: give a point of a "
        "finite-element body that takes part as one"
    )


def _relative(difference: float, scale: float) -> float:
    if difference == 0.0:
        return 0.0
    return difference / scale if scale > 0.0 else float("inf")
