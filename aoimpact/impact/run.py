"""What `simulate` and `Scene.simulate` share: a run of given models, or of models to be chosen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from ..accuracy import Quantity, R, TimeSolver, checked_linear_solver, choose_models, solve
from ..fem import ContactPoint
from ..linalg import Solver
from ..results import Handle, Result, Run, warn_of_misfit
from ..scene import Plan
from .checks import warn_of_centres

__all__ = ["PlanOf", "RunOptions", "run_models"]

# Of a model for each body, and whether to record energies.
PlanOf = Callable[[Sequence[Any], bool], Plan]


class RunOptions(NamedTuple):
    """How to run, as a caller says it; see `simulate`."""

    quantity: str | Handle | ContactPoint | None
    rtol: float | None
    solver: TimeSolver | None
    energies: bool
    linear_solver: Solver | None

    @property
    def chooses(self) -> bool:
        """Whether the bodies' models are to be chosen."""
        return self.quantity is not None or self.rtol is not None


def run_models(
    plan_of: PlanOf,
    bodies: Sequence[Any],
    options: RunOptions,
    *,
    names: Sequence[str],
    interest: Callable[[], Quantity],
    view: Callable[[Run], R],
) -> R:
    """Run bodies as they are, or with small models that give a quantity to a tolerance.

    Parameters
    ----------
    plan_of : callable
    bodies : sequence
        ContactPoint, tuple of ContactPoint, AOModel, ModalModel or InterfaceModel.
    options : RunOptions
    names : sequence of str
        Of the bodies in the plan, for messages.
    interest : callable
        Returns the quantity of interest, after checking it.
    view : callable
        What the caller makes of a run: a `Result`, or the `Run` itself.
    """
    linear_solver = checked_linear_solver(options.linear_solver, chosen=options.chooses)
    if options.chooses:
        done = choose_models(
            plan_of,
            bodies,
            interest(),
            options.rtol,
            options.solver,
            view=view,
            energies=options.energies,
            linear_solver=linear_solver,
        )
    else:
        run = solve(plan_of(bodies, options.energies), options.solver)
        warn_of_misfit(run.plan, run, names)
        done = view(run)
    warn_of_centres((done.run if isinstance(done, Result) else done).plan, names)
    return done
