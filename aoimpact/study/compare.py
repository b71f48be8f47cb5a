"""Comparison of models: one impact with rigid, reduced and full finite-element models."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping
from dataclasses import astuple, dataclass, fields, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from ..accuracy import first_guess, model_hierarchy
from ..base import (
    AOImpactError,
    FilePath,
    InputError,
    aligned,
    boolean,
    error_axes,
    given_axes,
    held_warnings,
    instance,
    integer,
    real,
    sequence,
    text,
    with_unit,
    write_csv,
)
from ..impact import Foreseen, pair, simulate
from ..integrate import Adaptive, Newmark
from ..laws import ContactLaw, own_law
from ..linalg import Solver, checked_solver
from ..reduction import FullModel, body_model, modal
from ..reduction import full as whole
from ..results import QUANTITIES, ROLES, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Quantities whose errors are in each row of a comparison.
_COMPARED = "force", "contact_duration", "impulse", "target_displacement"

# Time integration with a tolerance far below the differences between models.
_IN_TIME = Adaptive(rtol=1e-6)

# Names of curves in the plot, by the kind of model.
_KINDS = {"AO": "anti-oscillators", "modal": "natural modes"}

Models = tuple[Any, ...]


@dataclass(frozen=True)
class Compared:
    """Cost and errors of one pair of models.

    Attributes
    ----------
    model : str
        "rigid", "AO(3)", "modal(40)", "full", or the label of another target.
    dofs : int
        Degrees of freedom of both bodies.
    build, run : float
        Time to make the models from the finite elements, s, and time to run them, s.
    force, contact_duration, impulse, displacement : float
        Relative errors. For the histories of force and of the target's contact displacement: ratio
        of the largest error to the largest value.
    failure : str
        Message if the models could not be made or run; empty otherwise. After a failure, all
        numbers are 0 or NaN.
    """

    model: str
    dofs: int = 0
    build: float = math.nan
    run: float = math.nan
    force: float = math.nan
    contact_duration: float = math.nan
    impulse: float = math.nan
    displacement: float = math.nan
    failure: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Costs and errors of models of one impact.

    Attributes
    ----------
    scene : str
        Description of the impact.
    exact : str
        Reference model, whose results count as exact.
    exact_error : float or None
        Relative error of time integration of the reference model; None if it is not known.
    rows : tuple of Compared
    linear_solver : str
        Linear solver of the reduced models; empty for dense matrices.

    Examples
    --------
    >>> sphere = ao.AOModel(m0=3e-5, k0=0.0, m=[0.033], k=[2.8e8])
    >>> table = ao.compare(projectile=sphere, target=sphere, law=ao.Hertz(k=1e10), velocity=1.0,
    ...                    duration=1e-4, oscillators=(0, 1), modes=(), full=False)
    >>> [row.model for row in table.rows], round(table["rigid"].force, 1)
    (['rigid', 'AO(0)', 'AO(1)'], 0.4)
    """

    scene: str
    exact: str
    exact_error: float | None
    rows: tuple[Compared, ...]
    linear_solver: str = ""

    def __getitem__(self, model: str) -> Compared:
        """Return the row of a model, such as "AO(3)"."""
        for row in self.rows:
            if row.model == model:
                return row
        raise KeyError(model)

    def plot(self, ax: Axes | None = None, *, error: str = "force", **kwargs: Any) -> Axes:
        """Draw one error against the number of degrees of freedom; keywords go to ``Axes.plot``.

        Parameters
        ----------
        ax : Axes, optional
        error : {"force", "contact_duration", "impulse", "displacement"}, optional

        Returns
        -------
        Axes

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> table = ao.compare(
        ...     projectile=ao.rigid(mass=0.01), target=tip, law=ao.Linear(k=1e5), velocity=1.0,
        ...     duration=1e-3, oscillators=(0, 1, 2), modes=(), full=False,
        ... )
        >>> ax = table.plot()
        """
        ax = given_axes(ax)
        curves: dict[str, list[tuple[int, float]]] = {}
        for row in self.rows:
            if not row.failure and row.model != self.exact:
                name = _KINDS.get(row.model.partition("(")[0], row.model)
                curves.setdefault(name, []).append((row.dofs, getattr(row, error)))
        for name, points in curves.items():
            ax.plot(*zip(*points, strict=True), **{"marker": "o", "label": name} | kwargs)
        up = f"relative error of the {error}".replace("_", " ")
        return error_axes(ax, "degrees of freedom", up)

    def to_csv(self, path: FilePath) -> None:
        """Write the table as CSV: one row per model, times in s, relative errors.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> table = ao.compare(
        ...     projectile=ao.rigid(mass=0.01), target=tip, law=ao.Linear(k=1e5), velocity=1.0,
        ...     duration=1e-3, oscillators=(0, 1, 2), modes=(), full=False,
        ... )
        >>> table.to_csv(folder / "models.csv")
        """
        heading = [field.name for field in fields(Compared)]
        write_csv(path, heading, (astuple(row) for row in self.rows))

    def __repr__(self) -> str:
        rows = aligned([_HEADINGS, *map(_cells, self.rows)], left={0, 8})
        known = "" if self.exact_error is None else f" (in time right to {self.exact_error:.1g})"
        by = f"; reduced by {self.linear_solver}" if self.linear_solver else ""
        return "\n".join([self.scene, f"errors relative to {self.exact}{known}{by}", *rows])


# Headings of the columns; the last column, of failures, has none.
_HEADINGS = (*(field.name.replace("_", " ") for field in fields(Compared)[:-1]), "")


def _cells(row: Compared) -> tuple[str, ...]:
    """Return the cells of a row as text; the last cell is the failure message."""
    model, dofs, build, run, *errors, failure = astuple(row)
    if failure:
        return (model, *("-",) * 7, failure)
    times = with_unit(build, "s", 3), with_unit(run, "s", 3)
    return (model, str(dofs), *times, *(f"{error:.1e}" for error in errors), "")


def compare(
    projectile: Any,
    target: Any,
    velocity: float,
    *,
    law: ContactLaw | None = None,
    duration: float | None = None,
    gap: float = 0.0,
    oscillators: Iterable[int] = (0, 1, 2, 3, 5, 8, 12),
    modes: Iterable[int] = (10, 40),
    full: bool = True,
    other_targets: Mapping[str, Any] | None = None,
    linear_solver: Solver = "auto",
) -> Comparison:
    """Run an impact with models from rigid to full; return the cost and the error of each.

    The impact must be along one direction of travel; for an oblique impact, use `simulate` with
    quantity= and rtol=. Both bodies have the same kind of model. An AO model given by numbers has
    at most its own number of oscillators.

    Parameters
    ----------
    projectile, target : ContactPoint, FullModel, AOModel or Body
        A reduced model stands for the finite-element body that it was made from.
    velocity, law, duration, gap
        As in `simulate`, also if `law` or `duration` is left out.
    oscillators : iterable of int, optional
        Numbers of scene-fitted anti-oscillators.
    modes : iterable of int, optional
        Numbers of natural modes of classical truncations.
    full : bool, optional
        True to run the finite-element bodies themselves, by Newmark's rule. This run is then the
        reference for errors; otherwise the model with the most oscillators is.
    other_targets : mapping of str to ContactPoint or model, optional
        Models of the same target with other elements, such as shells in place of thin solids,
        struck at the same place; keys are the labels of their rows. Each is simulated under the
        same law and with the projectile as given, and is reduced by default. Its build time
        includes the choice of models. Displacements are those of the contact points; on solids,
        these include the indentation.
    linear_solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        Linear solver of the reduced models, as `solver` of `antioscillators`.

    Raises
    ------
    InputError
        If there is no model to compare with.

    Examples
    --------
    >>> sphere = ao.AOModel(m0=3e-5, k0=0.0, m=[0.033], k=[2.8e8])
    >>> table = ao.compare(sphere, sphere, 1.0, law=ao.Hertz(k=1e10), duration=1e-4,
    ...                    oscillators=(0, 1), modes=(), full=False)
    >>> table.exact, round(table["rigid"].force, 1)
    ('AO(1)', 0.4)

    A plate of 4 mm by solid elements, and by shells:

    >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    >>> box = ao.box_mesh((0.06, 0.06, 0.004), (6, 6, 1), kind="hexahedron20")
    >>> solid = ao.FEModel.from_mesh(box, steel, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    >>> rims = [("xmin", "xyz", "xyz"), ("xmax", "xyz", "xyz")]
    >>> sheet = ao.Shell(0.004, steel)
    >>> shell = ao.FEModel.from_mesh(ao.sheet_mesh((0.06, 0.06), (8, 8)), sheet, fixed=rims)
    >>> table = ao.compare(
    ...     ao.ball(0.005, steel), solid.contact(point=(0.03, 0.03, 0.004)), 1.0, duration=5e-5,
    ...     oscillators=(16,), modes=(), full=False,
    ...     other_targets={"shell": shell.contact(point=(0.03, 0.03, 0))},
    ... )
    >>> table["shell"].impulse < 0.01
    True
    """
    speed, full = real("velocity", velocity, unit="m/s"), boolean("full", full)
    labels = {"rigid": 0, **_labels("AO", "oscillators", oscillators, low=0)}
    exact = "full" if full else [*labels][-1]
    if exact == "rigid":
        raise InputError("full=False without oscillators leaves no model to compare with")
    truncations = _labels("modal", "modes", modes, low=1)
    given = {} if other_targets is None else other_targets
    others = dict(instance("other_targets", given, Mapping))
    for label, other in others.items():
        body_model(f"other_targets[{text('a label of other_targets', label)!r}]", other)
        if label in {*labels, *truncations, exact}:
            raise InputError(f"other_targets: {label!r} is a row of its own; give another label")
    with held_warnings():  # else each run repeats the warnings
        _, plan = pair(projectile, target, speed, law, gap=gap)
        law = own_law(plan.contacts[0].law)
        if duration is None:
            duration = simulate(projectile, target, speed, law=law, gap=gap).duration
    run = partial(simulate, law=law, velocity=speed, duration=duration, gap=gap)
    # Finite-element bodies replace models made from them; AO models given by numbers stay. Contact
    # patches are fitted here, the same for all models: `simulate` fits only those of full models.
    bodies = tuple(whole(body.tips) if body.tips else body for body in plan.bodies)
    bodies = tuple(Foreseen(replace(plan, bodies=bodies)).fitted(ROLES, {}).bodies)

    def quick(models: Models) -> Result:
        with held_warnings():
            return run(*models, solver=_IN_TIME)

    contact_time, span = first_guess(bodies, quick, [QUANTITIES["target_displacement"]])
    linear = checked_solver(linear_solver, name="linear_solver")
    hierarchies = [
        model_hierarchy(body, contact_time, max(span, duration), linear) for body in bodies
    ]

    def models_of(label: str) -> Models:
        if label in labels:
            n = labels[label]
            return tuple(of.model(0 if label == "rigid" else n + of.first) for of in hierarchies)
        if label in others:
            return run(projectile=projectile, target=others[label]).models
        count = truncations.get(label)
        return tuple(
            modal(body.tips[0], min(count, body.body.n_dofs), solver=linear)
            if count and isinstance(body, FullModel)
            else body
            for body in bodies
        )

    in_full = Newmark() if FullModel in map(type, bodies) else _IN_TIME
    rows: dict[str, Compared] = {}
    results: dict[str, Result] = {}
    spent = 0.0
    for label in dict.fromkeys([*labels, *truncations, exact, *others]):
        start = time.perf_counter()
        try:
            models = models_of(label)
            build = time.perf_counter() - start
            result = run(*models, solver=in_full) if label == "full" else quick(models)
        except AOImpactError as error:
            rows[label] = Compared(label, failure=str(error))
            continue
        ran = time.perf_counter() - start - build
        if label in labels:  # nested bases: each model extends the previous one
            build = spent = spent + build
        results[label] = result
        rows[label] = Compared(label, sum(model.dofs for model in models), build, ran)
    if exact not in results:
        raise InputError(f"{exact}: {rows[exact].failure}")
    for label, result in results.items():
        errors = (QUANTITIES[name].difference(result, results[exact]) for name in _COMPARED)
        rows[label] = Compared(*astuple(rows[label])[:4], *errors)
    called = " on ".join(body.name or body.label for body in bodies)
    solvers = {model.linear_solver: 0 for of in results.values() for model in of.models}
    solvers.pop("", None)
    title, in_time = f"{called}, {law}, {speed:g} m/s", results[exact].error.time
    return Comparison(title, exact, in_time, tuple(rows.values()), ", ".join(solvers))


def _labels(kind: str, name: str, values: Iterable[int], *, low: int) -> dict[str, int]:
    """Return the numbers of oscillators or modes, ascending, by the labels of the models."""
    numbers = sorted({integer(name, n, low=low) for n in sequence(name, values)})
    return {f"{kind}({n})": n for n in numbers}
