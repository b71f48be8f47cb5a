"""Running given models, or models to be chosen, for `simulate` and `Scene.simulate`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

from ..accuracy import (
    FixedModel,
    LeftOutFinder,
    StressAt,
    checked_linear_solver,
    choose_models,
    finer_run,
)
from ..base import bar
from ..fem import ContactPoint
from ..linalg import LinearSolver, Solver
from ..reduction import AOModel, BodyModel
from ..results import (
    Handle,
    Quantity,
    RecordLength,
    Run,
    TimeSolver,
    solve,
    warn_of_bodies,
    warn_of_misfit,
    warn_of_run,
)
from ..scene import Plan

__all__ = ["PlanOf", "RunOptions", "run_models"]

# Returns the plan for a model of each body, and whether to record energies.
PlanOf = Callable[[Sequence[Any], bool], Plan]


class RunOptions(NamedTuple):
    """The options of a run; see `simulate`."""

    quantity: str | Handle | ContactPoint | StressAt | None
    rtol: float | None
    solver: TimeSolver | None
    energies: bool
    linear_solver: Solver | None

    @property
    def controlled(self) -> bool:
        """Whether a quantity or a tolerance was given: then given models are truncated, too."""
        return self.quantity is not None or self.rtol is not None

    def chooses(self, bodies: Sequence[BodyModel]) -> bool:
        """Whether models are to be chosen: always where a body is given by contact points."""
        return self.controlled or any(body.reducible for body in bodies)


def _kept(body: BodyModel, controlled: bool) -> BodyModel | FixedModel:
    """A body for the choice of models: fixed, if its model was given and is not to be truncated."""
    if body.reducible or (controlled and isinstance(body, AOModel)):
        return body
    return FixedModel(body)


def run_models(
    plan_of: PlanOf,
    bodies: Sequence[Any],
    options: RunOptions,
    *,
    record: RecordLength,
    names: Sequence[str],
    interest: Callable[[], Quantity],
    law_errors: Sequence[float] = (),
    began: float,
    factors: dict[Any, LinearSolver] | None = None,
) -> Run:
    """Run bodies as they are, or with small models that give a quantity to a tolerance.

    Parameters
    ----------
    plan_of : callable
    bodies : sequence
        AOModel, InterfaceModel or FullModel.
    options : RunOptions
    record : RecordLength
        How long.
    names : sequence of str
        Of the bodies in the plan, for messages.
    interest : callable
        Returns the quantity of interest, after checking it.
    law_errors : sequence of float, optional
        Of each contact, where the law was found from the surfaces; see `LeftOutFinder`.
    began : float
        When the call began, by `perf_counter`, s.
    factors : dict of body to LinearSolver, optional
        Those that have been set up on the way here; see `proven_orders`.
    """
    meshed = any(body.contact_points for body in bodies)
    chooses = options.chooses(bodies)
    linear_solver = checked_linear_solver(options.linear_solver, chosen=chooses)
    if chooses:
        with bar("models", unit="solution"):
            run = choose_models(
                plan_of,
                [_kept(body, options.controlled) for body in bodies],
                interest,
                options.rtol,
                options.solver,
                energies=options.energies,
                record=record,
                law_errors=law_errors,
                linear_solver=linear_solver,
                factors=factors,
            )
        # What its models cost: all but the run itself.
        modelled = max(perf_counter() - began - run.recorder.seconds, 0.0)
        run = replace(run, modelled=modelled)
    else:
        plan = plan_of(bodies, options.energies)
        run = record.run(plan, partial(solve, solver=options.solver))
        if meshed:
            warn_of_misfit(run, names)
            if plan.contacts:
                finder = LeftOutFinder(interest, options.solver, law_errors)
                run = replace(run, left_out=finder)
    record.warn_if_cut()
    warn_of_bodies(run, names)
    warn_of_run(run)
    return replace(run, finer=partial(finer_run, solver=options.solver)) if meshed else run
