"""A history of a body, and how wrong the few shapes of its model make it, against a finer model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np

from ..base import FloatArray, warn, with_unit

S = TypeVar("S")

# Relative error from which on a history warns.
_BADLY_WRONG = 0.2

# Share of a displacement over the length of the record below which a velocity is rounding.
_AT_REST = 1e-9

# The error is so many times the difference to a finer model, whose own error is taken
# to be half as large: 98 % of them are then within it, see tools/sensor_errors.py.
_DIFFERENCES = 2.0

# Times of the record at which the largest value is looked for.
LOOKS = 200


@dataclass(frozen=True, eq=False)
class History(Generic[S]):
    """A quantity over time, and its error, each found when it is first read.

    Attributes
    ----------
    name : str
        For messages.
    source : S
        The `Response`, or the run, that it is read from.
    finer : callable
        Returns the same with a finer model; None where there is none.
    seen : callable
        Source and times, s, to values of shape (n, ...).
    t : ndarray, shape (n,)
        s.
    duration : float
        Length of the record, s.
    displacement : callable, optional
        The displacement, as `seen`, of which this is the rate.
    """

    name: str
    source: S
    finer: Callable[[], S | None] = field(repr=False)
    seen: Callable[[S, FloatArray], FloatArray] = field(repr=False)
    t: FloatArray
    duration: float
    displacement: Callable[[S, FloatArray], FloatArray] | None = field(default=None, repr=False)

    @cached_property
    def values(self) -> FloatArray:
        """The values, shape (n, ...)."""
        return self.seen(self.source, self.t)

    @cached_property
    def error(self) -> FloatArray | None:
        """Error by the body's model, relative to the largest value, (n,); None of a full model.

        The largest of all components, by one more run with a finer model.
        """
        if (finer := self.finer()) is None:
            return None
        looks = np.union1d(self.t, np.linspace(0.0, self.duration, LOOKS))
        right, least = self.seen(finer, looks), 0.0
        if self.displacement is not None:  # a velocity that is rounding beside it
            most = float(np.abs(self.displacement(finer, looks)).max())
            least = _AT_REST * most / self.duration
        largest = np.nanmax(np.abs(right), initial=least)
        apart = np.abs(self.values - right[np.searchsorted(looks, self.t)])
        found: FloatArray = apart.reshape(len(self.t), -1).max(axis=1)
        return _DIFFERENCES * found / (largest if largest > 0.0 else 1.0)

    @property
    def doubt(self) -> FloatArray:
        """Signed bound of the error of the values, shape (n, ...); 0 for a full model."""
        right = self.seen(self.finer() or self.source, self.t)
        return np.asarray(_DIFFERENCES * (right - self.values))

    def told(self) -> FloatArray:
        """Return the values, and warn if they may be badly wrong."""
        warn_if_wrong(self.name, self.t, self.error)
        return self.values


@dataclass(frozen=True, eq=False)
class Sensed(Generic[S]):
    """The history of one sensor; its error is found when it is first read."""

    _history: History[S] = field(repr=False)

    @property
    def t(self) -> FloatArray:
        """Times, s, shape (n,)."""
        return self._history.t

    @property
    def error(self) -> FloatArray | None:
        """Error by the body's model, relative to the largest value, (n,); None of a full model.

        It is found by one more run, with a finer model.
        """
        return self._history.error


def warn_if_wrong(what: str, times: FloatArray, error: FloatArray | None) -> None:
    """Warn where a history may be badly wrong; `error` is relative, None where not known."""
    if error is None or not (error > _BADLY_WRONG).any():
        return
    first, worst = float(times[int(np.argmax(error > _BADLY_WRONG))]), float(np.nanmax(error))
    warn(
        f"{what} may be off by {worst:.0%} of the largest, from t = {with_unit(first, 's')} on: "
        "the model gives the force, but not the free vibration afterwards; give quantity= a motion "
        f"or stress of the body, or make its model with duration={times[-1]:.2g} and a larger n"
    )
