"""Comparison of models: one impact by rigid bodies, by more and more oscillators, and in full."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..accuracy import Hierarchy, first_guess, model_hierarchy
from ..base import (
    AOImpactError,
    InputError,
    boolean,
    held_warnings,
    instance,
    integer,
    sequence,
    spelled,
    text,
    warn,
)
from ..impact import Impact, fitted_pair, simulate
from ..integrate import Adaptive, Newmark
from ..laws import ContactLaw
from ..linalg import Solver, checked_solver
from ..reduction import BodyModel, FullModel, body_model, full, modal
from ..results import QUANTITIES, Result
from .comparison import Compared, Comparison

_COMPARED = tuple(
    QUANTITIES[name] for name in ("force", "contact_duration", "impulse", "target_displacement")
)

# Far below the differences between models.
_IN_TIME = 1e-6

# Relative difference of masses above which another target is hardly the same.
_SAME_MASS = 0.1

# Distance across the direction of contacts at the same place, relative to the body's size.
_SAME_PLACE = 0.01

_AO, _MODAL = "AO({})".format, "modal({})".format  # labels

Models = tuple[Any, ...]


@spelled
def compare(
    projectile: Any,
    target: Any,
    velocity: float,
    *,
    law: ContactLaw | None = None,
    friction: float | None = None,
    spin: npt.ArrayLike | None = None,
    duration: float | None = None,
    gap: float = 0.0,
    oscillators: Iterable[int] = (0, 1, 2, 3, 5, 8, 12),
    modes: Iterable[int] = (10, 40),
    full: bool = True,
    other_targets: Mapping[str, Any] | None = None,
    linear_solver: Solver = "auto",
) -> Comparison:
    """Run an impact with models from rigid to full; return the cost and the error of each.

    Both bodies are modelled alike; those given by numbers have no more oscillators than they have.

    Parameters
    ----------
    projectile, target : ContactPoint, FullModel, AOModel or ModalModel
        A reduced model stands for the finite-element body that it was made of.
    velocity, law, duration, gap
        As in `simulate`, also where `law` or `duration` is left out.
    friction, spin : optional
        Refused: impacts with friction are not compared.
    oscillators : iterable of int, optional
        Numbers of scene-fitted anti-oscillators.
    modes : iterable of int, optional
        Numbers of natural modes of classical truncations.
    full : bool, optional
        True to run the finite-element bodies themselves, by Newmark's rule. Errors are relative
        to that; without it, to the model of the most oscillators.
    other_targets : mapping of str to ContactPoint or model, optional
        The same target by other elements, such as shells in place of thin solids, struck at the
        same place; by the label of its row. Each is run under the same law as `simulate` takes it,
        reduced by default, with the projectile as it is given. The time to build it includes the
        choice of its models. Displacements are those of contact points, which on solids contain
        the indentation.
    linear_solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        Linear solver of the reduced models, as `solver` of `antioscillators`.

    Raises
    ------
    InputError
        If there is nothing to compare with.

    Warns
    -----
    AOImpactWarning
        If another target has another mass, or is struck beside the contact point.

    Examples
    --------
    >>> sphere = ao.AOModel(m0=3e-5, k0=0.0, m=[0.033], k=[2.8e8])
    >>> table = ao.compare(sphere, sphere, 1.0, law=ao.Hertz(k=1e10), duration=1e-4,
    ...                    oscillators=(0, 1), modes=(), full=False)
    >>> table.exact, round(table["rigid"].force, 1)
    ('AO(1)', 0.4)

    A plate of 4 mm by solid elements, and by shells:

    >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    >>> box = ao.box_mesh((0.06, 0.06, 0.004), (10, 10, 1), kind="hexahedron20")
    >>> solid = ao.FEModel.from_mesh(box, steel, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    >>> rims = [("xmin", "xyz", "xyz"), ("xmax", "xyz", "xyz")]
    >>> sheet = ao.Shell(0.004, steel)
    >>> shell = ao.FEModel.from_mesh(ao.sheet_mesh((0.06, 0.06), (10, 10)), sheet, fixed=rims)
    >>> table = ao.compare(
    ...     ao.ball(0.005, steel), solid.contact(point=(0.03, 0.03, 0.004)), 1.0, duration=5e-5,
    ...     oscillators=(16,), modes=(), full=False,
    ...     other_targets={"shell": shell.contact(point=(0.03, 0.03, 0))},
    ... )
    >>> table["shell"].impulse < 0.01
    True
    """
    along = not isinstance(velocity, list | tuple | np.ndarray)
    for name, given in (("velocity", velocity), ("friction", friction), ("spin", spin)):
        if given is not None and not (along and name == "velocity"):
            raise InputError(
                f"{name}={given!r}: models are compared along one direction of travel; give the "
                "speed alone, and simulate an oblique impact with quantity= and rtol="
            )
    full = boolean("full", full)
    orders = _ascending("oscillators", oscillators, low=0)
    truncations = _ascending("modes", modes, low=1)
    if not orders and not full:
        raise InputError("full=False without oscillators leaves no model to compare with")
    others = (
        {} if other_targets is None else dict(instance("other_targets", other_targets, Mapping))
    )
    own = ["rigid", *map(_AO, orders), *map(_MODAL, truncations), *(["full"] if full else [])]
    for label, other in others.items():
        body_model(f"other_targets[{text('a label of other_targets', label)!r}]", other)
        if label in own:
            raise InputError(f"other_targets: {label!r} is a row of its own; give another label")
    with held_warnings():  # each run has them again
        impact = Impact(projectile, target, velocity, gap=gap, duration=duration)
        impact.touch(law)
        law, duration = impact.law, impact.duration
        if duration is None:
            duration = simulate(projectile, target, velocity, law=law, gap=gap).duration
    velocity = impact.velocity
    run = partial(simulate, law=law, velocity=velocity, duration=duration, gap=gap)
    bodies = _body("projectile", projectile), _body("target", target)
    for label, other in others.items():
        _warn_of_differences(bodies[1], label, body_model(label, other))
    # Over the same patches: `simulate` would fit those of full models alone.
    bodies = fitted_pair(*bodies, impact.with_bodies(bodies).met)

    def quick(models: Models) -> Result:
        with held_warnings():
            return run(projectile=models[0], target=models[1], solver=Adaptive(rtol=_IN_TIME))

    contact_time, span = first_guess(bodies, quick, QUANTITIES["target_displacement"])
    linear = checked_solver(linear_solver, name="linear_solver")
    hierarchies = tuple(
        model_hierarchy(body, contact_time, max(span, duration), linear) for body in bodies
    )
    tries = _of_oscillators(hierarchies, orders, quick)
    for n in truncations:
        tries.append(_try(_MODAL(n), partial(_with_modes, bodies, n, linear), quick))
    exact = tries[len(orders)]
    if full:
        meshed = any(isinstance(body, FullModel) for body in bodies)
        solver = Newmark() if meshed else Adaptive(rtol=_IN_TIME)
        exact = _try("full", lambda: bodies, lambda pair: run(*pair, solver=solver))
        tries.append(exact)
    for label, other in others.items():
        chosen = partial(run, projectile=projectile, target=other)
        tries.append(_try(label, partial(_chosen_models, chosen), quick))
    if exact.result is None:
        raise InputError(f"{exact.label}: {exact.failure}")
    return Comparison(
        f"{_called(bodies[0])} on {_called(bodies[1])}, {law}, {velocity:g} m/s",
        exact.label,
        exact.result.error.time,
        tuple(each.compared(exact.result) for each in tries),
        ", ".join(dict.fromkeys(name for each in tries for name in each.solvers)),
    )


def _chosen_models(chosen: Callable[[], Result]) -> Models:
    return tuple(chosen().models)


def _warn_of_differences(target: BodyModel, label: str, other: BodyModel) -> None:
    """Warn of another target with another mass, or struck beside the target's contact point."""
    if not (target.contact_points and other.contact_points):
        return
    first, second = target.contact_points[0], other.contact_points[0]
    mass, weight, nodes, said = first.body.mass, second.body.mass, first.body.nodes, []
    if mass and weight and abs(weight - mass) > _SAME_MASS * mass:
        said.append(f"weighs {weight:.4g} kg in place of {mass:.4g} kg")
    along, one, two = first.direction, first.point, second.point
    if nodes is not None and along is not None and one is not None and two is not None:
        away = two - one - ((two - one) @ along) * along  # without the distance by thickness
        apart = float(np.linalg.norm(away))
        if apart > _SAME_PLACE * float(np.ptp(nodes, axis=0).max()):
            said.append(f"is struck {apart:.3g} m beside the target's contact point")
    if said:
        warn(f"other_targets[{label!r}] {' and '.join(said)}: its row compares another impact")


def _ascending(name: str, values: Iterable[int], *, low: int) -> list[int]:
    return sorted({integer(name, n, low=low) for n in sequence(name, values)})


def _of_oscillators(
    hierarchies: tuple[Hierarchy, ...], orders: list[int], run: Callable[[Models], Result]
) -> list[_Try]:
    """Rigid bodies, and models of so many oscillators, each with the time of those before it."""
    tries = [_try("rigid", lambda: tuple(each.model(0) for each in hierarchies), run)]
    spent = 0.0
    for n in orders:
        make = partial(lambda n: tuple(each.model(n + each.first) for each in hierarchies), n)
        tries.append(_try(_AO(n), make, run))
        if not tries[-1].failure:
            spent += tries[-1].build  # the bases are nested: each model adds to the one before
            tries[-1].build = spent
    return tries


def _body(name: str, body: Any) -> BodyModel:
    """The finite-element body that a model was made of; of an AO model by numbers itself."""
    model = body_model(name, body)
    return full(model.contact_points) if model.contact_points else model


def _called(body: BodyModel) -> str:
    if isinstance(body, FullModel):
        return body.name or f"a body of {body.body.n_dofs} dofs"
    return body.name or body.label


@dataclass
class _Try:
    """One pair of models: the time to build and to run it, or why that failed."""

    label: str
    dofs: int = 0
    build: float = math.nan
    run: float = math.nan
    result: Result | None = None
    failure: str = ""
    solvers: tuple[str, ...] = ()

    def compared(self, exact: Result) -> Compared:
        result = self.result
        force, touch, impulse, displacement = (
            math.nan if result is None else of.difference(result, exact) for of in _COMPARED
        )
        errors = force, touch, impulse, displacement
        return Compared(self.label, self.dofs, self.build, self.run, *errors, self.failure)


def _try(label: str, make: Callable[[], Any], run: Callable[[Models], Result]) -> _Try:
    done = _Try(label)
    try:
        start = time.perf_counter()
        models = make()
        done.build = time.perf_counter() - start
        done.dofs = sum(model.dofs for model in models)
        done.solvers = tuple(model.linear_solver for model in models if model.linear_solver)
        start = time.perf_counter()
        done.result = run(models)
        done.run = time.perf_counter() - start
    except AOImpactError as error:
        done.failure = str(error)
    return done


def _with_modes(bodies: Models, n: int, linear: Solver) -> Models:
    first, second = (
        modal(body.tips[0], min(n, body.body.n_dofs), solver=linear)
        if isinstance(body, FullModel)
        else body
        for body in bodies
    )
    return first, second
