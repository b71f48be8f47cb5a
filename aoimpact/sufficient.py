"""A run with the least models that give the answer asked for, to the tolerance asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

from .adaptive import TIGHTEST, Adaptive
from .checks import positive
from .errors import InputError, held_warnings
from .ladder import Models
from .order import Asked, least_orders
from .run import Chosen
from .solvers import Solver, checked_solver

__all__ = ["checked_linear_solver", "sufficient"]

# What is asked for where nothing is said, and the tightest that models are searched for: to their
# last digits they agree only by being the whole bodies.
_RTOL, _TIGHTEST = 1e-2, 1e-8

# Shares of the tolerance: what time integration takes of peak forces and times (a history that
# rings errs by twenty times as much), and what is used of it at all, since the search's estimates
# are no bounds.
_SHARE_OF_TIME, _MARGIN = 0.005, 0.95

R = TypeVar("R")
R_contra = TypeVar("R_contra", contravariant=True)


class Wanted(Asked[R_contra], Protocol[R_contra]):
    """What is asked for, and what else a run is summed up by."""

    @property
    def named(self) -> str:
        """What it is, in words."""
        ...

    def errors(self, result: R_contra, /, *exact: R_contra) -> dict[str, float]:
        """By how much each number that sums up a run may be wrong, by more and more exact ones."""
        ...


def checked_linear_solver(solver: Solver | None, *, chosen: bool) -> Solver:
    """Return the linear solver for models that are chosen, and refuse one where none are.

    Parameters
    ----------
    solver : str, callable or None
    chosen : bool
        Whether a quantity or a tolerance was given, for which models are made.
    """
    if solver is None:
        return "auto"
    if not chosen:
        raise InputError(
            f"linear_solver={solver!r} is for models that are made for a tolerance: give quantity "
            "or rtol as well, or make them by antioscillators(tip, n, solver=...)"
        )
    return checked_solver(solver, name="linear_solver")


def sufficient(
    run: Callable[[Models, Any, bool], R],
    bodies: Sequence[Any],
    asked: Wanted[R],
    rtol: float | None,
    solver: Any,
    *,
    energies: bool,
    linear_solver: Solver = "auto",
) -> tuple[R, Chosen]:
    """Run with models of the least order; return what they gave, and what is known of them.

    Parameters
    ----------
    run : callable
        Of models, one for each body, a solver, and whether to see energies.
    bodies : sequence
        As of `least_orders`.
    asked : Wanted
        Of the runs.
    rtol : float, optional
        Relative.
    solver : Adaptive or Newmark, optional
    energies : bool
    linear_solver : str or callable, optional
        See `FEModel.inverse`.

    Raises
    ------
    InputError, InputTypeError
        If `rtol` is out of range.
    ConvergenceError
        If no models that were looked at are good enough.
    """
    tolerance = positive("rtol", _RTOL if rtol is None else rtol)
    if not _TIGHTEST <= tolerance < 1.0:
        raise InputError(
            f"rtol must be from {_TIGHTEST:g} to below 1, got {tolerance:g}: models of fewer "
            "degrees of freedom are compared to no more digits"
        )
    in_time = max(_SHARE_OF_TIME * tolerance, TIGHTEST)
    rule = Adaptive(rtol=in_time) if solver is None else solver

    def trial(models: Models) -> R:
        with held_warnings():  # those of the models taken come with the last run
            return run(models, rule, False)

    found = least_orders(
        bodies,
        run=trial,
        asked=asked,
        rtol=_MARGIN * tolerance - in_time,
        solver=linear_solver,
    )
    numbers = asked.errors(*found.runs) | (
        {asked.named: found.error} if not asked.is_history else {}
    )
    chosen = Chosen(found.models, asked.named, tolerance, found.error, numbers)
    return run(found.models, rule, energies), chosen
