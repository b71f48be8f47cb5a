"""An impact with the least models that give the answer asked for, to the tolerance asked for."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

from .adaptive import TIGHTEST, Adaptive
from .answer import answer
from .checks import positive
from .contact import ContactPoint
from .errors import InputError, held_warnings
from .order import least_orders
from .result import Result
from .star import AOModel

__all__ = ["sufficient"]

# What is asked for where nothing is said, and the tightest that models are searched for: to their
# last digits they agree only by being the whole bodies.
_RTOL, _TIGHTEST = 1e-2, 1e-8

# Shares of the tolerance: what time integration takes, and what is used of it at all, since the
# search's estimates are no bounds.
_SHARE_OF_TIME, _MARGIN = 0.02, 0.95


class _Run(Protocol):
    """`simulate` with everything given but the bodies, the solver, and whether to see energies."""

    def __call__(self, *, projectile: Any, target: Any, solver: Any, energies: bool) -> Result: ...


def sufficient(
    run: _Run,
    bodies: tuple[Any, Any],
    quantity: str | ContactPoint | None,
    rtol: float | None,
    solver: Any,
    *,
    energies: bool,
) -> Result:
    """Simulate with models of the least order; for the arguments see `simulate`.

    Raises
    ------
    InputError, InputTypeError
        If there is no such quantity, or `rtol` is out of range.
    ConvergenceError
        If no models that were looked at are good enough.
    """
    wanted = answer("force" if quantity is None else quantity, *bodies)
    tolerance = positive("rtol", _RTOL if rtol is None else rtol)
    if not _TIGHTEST <= tolerance < 1.0:
        raise InputError(
            f"rtol must be from {_TIGHTEST:g} to below 1, got {tolerance:g}: models of fewer "
            "degrees of freedom are compared to no more digits"
        )
    in_time = max(_SHARE_OF_TIME * tolerance, TIGHTEST)
    rule = Adaptive(rtol=in_time) if solver is None else solver

    def trial(models: tuple[AOModel, AOModel]) -> Result:
        with held_warnings():  # those of the models taken come with the last run
            return run(projectile=models[0], target=models[1], solver=rule, energies=False)

    found = least_orders(
        bodies,
        run=trial,
        difference=wanted.difference,
        span=wanted.span,
        rtol=_MARGIN * tolerance - in_time,
    )
    result = run(projectile=found.models[0], target=found.models[1], solver=rule, energies=energies)
    whole = replace(result.run, reduction_error=found.error)
    return replace(result, models=found.models, run=whole)
