"""How wrong a history may be by the few shapes of its body's model, against a finer model's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..base import FloatArray, warn, with_unit

# Relative error from which on a history warns.
_BADLY_WRONG = 0.2

# Share of a displacement over the length of the record below which a velocity is rounding.
_AT_REST = 1e-9


@dataclass(frozen=True, eq=False)
class Compared:
    """A measured quantity of a body; its error is found when it is first read."""

    _error: Callable[[], FloatArray | None] = field(default=lambda: None, repr=False, kw_only=True)

    @cached_property
    def error(self) -> FloatArray | None:
        """Error by the body's model, relative to the largest value, (n,); None of a full model.

        It is found by one more run, with a finer model.
        """
        return self._error()


def relative_error(
    history: FloatArray, right: FloatArray, whole: FloatArray, least: float = 0.0
) -> FloatArray:
    """Return |history - right| over the largest of `whole`, that of rest being 0.

    Parameters
    ----------
    history, right, whole : ndarrays, shapes (..., n), (..., n), (..., m)
        At the times that are asked for, by this model and a finer one; over all of the record.
    least : float, optional
        The error is relative to no less; see `rest`.

    Returns
    -------
    ndarray, shape (n,)
        The largest over all other axes.
    """
    largest = np.nanmax(np.abs(whole), initial=least)
    error = np.abs(history - right) / (largest if largest > 0.0 else 1.0)
    worst: FloatArray = error.reshape(-1, error.shape[-1]).max(axis=0)
    return worst


def rest(displacement: FloatArray, duration: float) -> float:
    """Return a velocity, m/s, that is rounding beside a displacement, m, over a time, s."""
    return float(_AT_REST * np.abs(displacement).max(initial=0.0) / duration)


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
