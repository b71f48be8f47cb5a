"""The choice of models: the smallest that give the quantities of interest to a tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from typing import Any

from ..base import ConvergenceError, InputError, positive, warn
from ..integrate import DRAWN, TIGHTEST, Adaptive, Newmark
from ..linalg import Solver, checked_solver
from ..reduction import Body
from ..results import Chosen, Quantity, RecordLength, Run, number_errors
from ..scene import Scenario
from .hierarchy import fixed_model, only_models
from .leftout import errors_left_out, finer_plan
from .order import EASED, Search

# _RTOL: default relative tolerance. _TIGHTEST: smallest tolerance; reduced models do not agree to
# more digits.
_RTOL, _TIGHTEST = 2e-3, 1e-8

# Largest relative error of a quantity of interest, with the largest models tried, that is accepted
# without a warning if no tolerance was given.
_LOOSEST = 1e-2

# Largest order (`Hierarchy`) of the models if a tolerance is given (True) or not (False). Without a
# given tolerance the search ends with the error reached: a thin sheet that touches repeatedly would
# need hundreds of vectors.
_MOST_ORDER = {True: 600, False: 80}

# Shares of the tolerance for time integration by the adaptive method (_SHARE_OF_TIME), by fixed
# steps (_SHARE_OF_STEPS), and by the adaptive method with friction (_SHARE_WITH_FRICTION); the rest
# is for the models. Over 148 impacts on nine bodies of up to 6171 dofs, with tolerances of 1e-1 …
# 1e-3, the error is at most .72 of the tolerance. A third or three times _SHARE_OF_TIME changes
# only the number of oscillators, by .2 %. A third of _SHARE_OF_STEPS takes 18 % more time on small
# bodies and 2 % more on bodies of 6171 dofs, due to more steps. Three times _SHARE_OF_STEPS takes
# 4 % less time on small bodies and 7 % more on bodies of 6171 dofs, due to 1.8 times as many
# oscillators. _SHARE_WITH_FRICTION is larger since steps with friction cost more: over 40 impacts
# on four bodies with a tolerance of 1e-3 the error was at most 2e-5 of the speed.
_SHARE_OF_TIME, _SHARE_OF_STEPS, _SHARE_WITH_FRICTION = 0.005, 0.2, 0.05


def check_linear_solver(solver: Solver, *, chosen: bool) -> None:
    """Raise InputError if `solver` is no linear solver, or if the call makes no models.

    Parameters
    ----------
    solver : str or callable
    chosen : bool
        True if models are chosen in this call.
    """
    if not chosen:
        raise InputError(
            f"linear_solver={solver!r} is for models that are made for a tolerance: give quantity "
            "or rtol as well, or make them by antioscillators(tip, n, solver=...)"
        )
    checked_solver(solver, name="linear_solver")


def checked_rtol(rtol: float | None) -> float:
    """Return the checked relative tolerance, or the default tolerance if `rtol` is None.

    Raises
    ------
    InputError, InputTypeError
        If `rtol` is out of range.
    """
    tolerance = positive("rtol", _RTOL if rtol is None else rtol)
    if not _TIGHTEST <= tolerance < 1.0:
        raise InputError(
            f"rtol must be from {_TIGHTEST:g} to below 1, got {tolerance:g}: models of fewer "
            "degrees of freedom are compared to no more digits"
        )
    return tolerance


def choose_models(
    plan: Scenario,
    interest: Callable[[], Sequence[Quantity]],
    rtol: float | None,
    solver: Any,
    *,
    truncated: bool,
    record: RecordLength,
    linear_solver: Solver = "auto",
) -> Run:
    """Run a scene with models of the smallest order that meets the tolerance.

    Parameters
    ----------
    plan : Scenario
        Scene of the bodies as given.
    interest : callable
        Returns the quantities of interest.
    rtol : float, optional
        Relative tolerance of each quantity of interest.
    solver : Adaptive or Newmark, optional
    truncated : bool
        True to truncate given AO models as well; other models stay as they are.
    record : RecordLength
        Duration of the record.
    linear_solver : str or callable, optional
        See `FEModel.inverse`.

    Returns
    -------
    Run
        Run of the chosen models; `Run.chosen` has the quantities, and the errors of the models.

    Raises
    ------
    InputError, InputTypeError
        If `rtol` is out of range, the solver does not estimate its error, or the run does not have
        a quantity.
    ConvergenceError
        If the errors of the largest models tried and of the given solver exceed a given `rtol`;
        without `rtol`, if the error of the models is 1 or more.
    """
    tolerance, wanted = checked_rtol(rtol), interest()
    given = rtol is not None
    rule, in_time = time_rule(solver, tolerance, plan, given=given)
    fixed = cache(fixed_model)  # equal bodies share one hierarchy
    bodies = [
        body
        if body.reducible or (truncated and isinstance(body, Body) and body.ports == 1)
        else fixed(body)
        for body in plan.bodies
    ]
    left_out = partial(errors_left_out, interest=interest, solver=rule)
    in_models = tolerance - in_time
    if models := only_models(bodies):
        error = 0.0
        errors = [0.0] * len(wanted)
        compared = []
        run = record.run(plan.of_models(models, energies=plan.energies), rule)
    else:
        how = rule, record, _MOST_ORDER[given], linear_solver
        search = Search(plan, bodies, wanted, in_models, *how)
        while (error := search.error()) > in_models and search.enlarge(in_models):
            pass
        if error > in_models:
            if given or error >= 1.0:
                raise search.failure(error)
            if error <= _LOOSEST:
                tolerance = _LOOSEST + in_time
            else:
                _warn_of_the_best(search, error, tolerance)
        assert search.run is not None
        run = search.run
        errors = search.errors.tolist()
        compared = search.compared
        refined = None
        with suppress(MemoryError):  # the error due to the meshes is then not bounded
            refined = finer_plan(run.plan, linear_solver, made=[b.reducible for b in plan.bodies])
        energies = plan.energies and refined is None
        whole = plan.of_models(search.models(), energies=energies)
        if run.recorder.dense or not energies:  # else energies take a new run
            whole = replace(whole, duration=run.duration)
            run = replace(run, plan=whole, recorder=replace(run.recorder, plan=whole))
        else:
            run = record.run(whole, rule)
        if refined is not None:
            record.settled = False
            answer = record.run(replace(refined, energies=plan.energies), rule)
            run = replace(answer, beside=run)
    in_steps = run.time_error
    if given and in_steps is not None and in_steps + error > tolerance:
        cure = f"take {type(rule).__name__}(rtol={in_time:.1g})"
        if isinstance(rule, Newmark) and rule.dt is not None:
            finer = rule.dt * min(0.5, math.sqrt(in_time / in_steps))
            cure = f"take dt={finer:.1g} or less, or Newmark() without dt"
        else:
            least = in_time if plan.oblique is None else max(in_time, DRAWN)
            if (reached := in_steps if rule.rtol <= in_time else least) + error > tolerance:
                cure = f"give rtol={EASED * (reached + error):.1e} or more"
        raise ConvergenceError(
            f"rtol={tolerance:g} is not kept with solver={rule!r}: the solver's error, about "
            f"{in_steps:.2g} of the peak force or the impulse, plus the models' error, "
            f"{error:.2g}, exceeds it; {cure}"
        )
    if absent := [of.name for of in wanted if not of.is_history and not of.names(run)]:
        raise InputError(
            f"quantity={absent[0]!r}: the run has no such number, since its bodies do not move "
            "towards or past each other before they meet; leave it out"
        )
    known = dict(zip([of.name for of in wanted], errors, strict=True))
    numbers = number_errors(run.beside or run, compared, known)
    quantities = {of.name: (of.unit, of.largest(run)) for of in wanted}
    run = replace(run, chosen=Chosen(quantities, tolerance, numbers))
    return replace(run, left_out=left_out) if plan.meshed else run


def _warn_of_the_best(search: Search, error: float, tolerance: float) -> None:
    """Warn that the largest models do not meet the default tolerance, and why."""
    assert search.run is not None
    count = max((len(events.contacts) for events in search.run.events), default=0)
    why = (
        f"each of its {count} contacts begins from the motion that earlier contacts have left, so "
        "that errors grow from contact to contact; give the duration= of the first contacts"
        if count > 1
        else "the waves of a short contact take more vectors; choose a shorter duration="
    )
    names = " and ".join(of.name for of in search.wanted)
    warn(
        f"{names}: its error from the models is {error:.2g}, above the tolerance of "
        f"{tolerance:.2g}, with up to {max(search.orders)} vectors: {why}, "
        "a quantity= that sums up (peak_force, impulse), or rtol= as large as you allow"
    )


def time_rule(solver: Any, tolerance: float, plan: Scenario, *, given: bool) -> tuple[Any, float]:
    """Return the method of time integration, and its share of the tolerance.

    Parameters
    ----------
    solver : Adaptive, Newmark or None
        Method given by the caller.
    tolerance : float
    plan : Scenario
        Scene of the bodies as given.
    given : bool
        True if the caller gave the tolerance, which the solver must then keep.
    """
    rubs = any(tip.tangents is not None for body in plan.bodies for tip in body.tips)
    share = _SHARE_WITH_FRICTION if rubs else _SHARE_OF_TIME
    if solver is None and plan.oblique and any(of.law.depends_on_rate for of in plan.contacts):
        solver = Newmark()  # `solve` refuses `Adaptive` for damped friction
    if isinstance(solver, Newmark):
        share = _SHARE_OF_STEPS
    in_time = max(share * tolerance, TIGHTEST)
    if solver is None:
        return Adaptive(rtol=in_time), in_time
    if not isinstance(solver, Newmark):
        return solver, in_time
    if solver.dt is None:
        return replace(solver, rtol=min(solver.rtol, in_time)), in_time
    if given and not solver.estimate:
        raise InputError(
            f"solver=Newmark(dt={solver.dt:g}, estimate=False) leaves the error of its steps "
            "unknown, and rtol cannot be kept: leave estimate=False out, or give models and "
            "no rtol"
        )
    return solver, in_time
