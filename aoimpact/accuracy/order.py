"""The number of anti-oscillators that a scene needs for a tolerance.

The run of models of n oscillators is the answer. It is compared with those of n/1.5, n/1.5² and
n/1.5³: if errors fall as a power of n, each difference of the quantity of interest tells them.
The largest estimate counts, since one difference alone may be small by chance. The orders of all
bodies are raised until it is within the tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

from ..base import AOImpactError, ConvergenceError, InputError, InputTypeError, LawLimitError
from ..contact import own_contact_time
from ..linalg import LinearSolver, Solver
from ..reduction import BodyModel, FullModel
from ..results import LeftOut, Quantity, RecordLength, Run
from .hierarchy import Hierarchy, Models, alike, model_hierarchy

# Factor from one order to the next; and the error of a model over its difference to each of the
# smaller ones that it is compared with, if errors fall as n^-1.25. Over 44 impacts on beams,
# plates, sheets, blocks, rods and spheres to 1e-1 … 1e-3 the true errors of peak force and its
# time, impulse, duration, rebound, displacement and the force itself are within the largest of the
# three in 98 of 100 cases (99 with n^-1, 94 with n^-1.5). It is 2 … 7 times the error in the
# median.
_GROWTH = 1.5
_SHARES = tuple(1.0 / (_GROWTH ** (1.25 * i) - 1.0) for i in (1, 2, 3))

# First oscillators for each digit of the tolerance, of the smallest model; the largest order; and
# where no tolerance was given, with which the search ends with the error that it has by then: a
# thin sheet that touches again and again would take hundreds of vectors.
_FIRST = 1.5
_MOST_ORDER, _MOST_BY_DEFAULT = 600, 80

# The tolerance named in a message is this factor above the error found.
_EASED = 1.1

# Bases are fitted again where the contact time that they were fitted to and the one found differ by
# more than this factor; and the largest number of fits.
_REFIT, _MOST_FITS = 2.0, 4

# Where contacts exceed their patches with this many sets of models, each larger, the error is
# raised: larger models would not help.
_TOO_WIDE = 3

# Where no tolerance was given, that of time and models is this share of the mesh's error of the
# quantity, by which the total error grows, up to the loosest tolerance.
_SHARE_OF_MESH, _LOOSEST = 0.2, 1e-2

# The order of each different hierarchy.
_Orders = tuple[int, ...]

# Where motion matters for longer than this many contact times, the bases hold slow motion as well.
_LONG = 4.0


@dataclass(frozen=True, eq=False)
class Orders:
    """Orders that meet the tolerance.

    Attributes
    ----------
    orders : tuple of int
        Order of each body; 0 is rigid.
    models : tuple of Body
    error : float
        Estimated relative error of the quantity from the models' orders.
    rtol : float
        The tolerance that applied: as given, or the looser one.
    run : Run
        With these models.
    smaller : tuple of (Run, float)
        Runs with smaller ones, and the error over the difference to each.
    left_out : LeftOut or None
        Errors of meshes, which are those of any models, where they made the tolerance looser.
    """

    orders: tuple[int, ...]
    models: Models
    error: float
    rtol: float
    run: Run
    smaller: tuple[tuple[Run, float], ...]
    left_out: LeftOut | None = None


class TimeScales(NamedTuple):
    """Times that models are fitted to, s: the contact's, and how long motion matters."""

    contact_time: float
    span: float

    @property
    def slow(self) -> float | None:
        """The duration of slow motion that matters, if any does, s."""
        return self.span if self.span > _LONG * self.contact_time else None

    def suit(self, others: TimeScales) -> bool:
        """True if models fitted to these time scales are accurate for the others as well."""
        ratio = others.contact_time / self.contact_time
        alike = max(ratio, 1.0 / ratio) <= _REFIT
        return alike and (self.slow is not None or others.slow is None)


def first_guess(
    bodies: Sequence[BodyModel], run: Callable[[Models], Run], quantity: Quantity
) -> TimeScales:
    """Estimate the time scales of a scene by rigid bodies."""
    meshed = (body for body in bodies if isinstance(body, FullModel))
    own = [own_contact_time(point) for body in meshed for point in body.tips]
    otherwise = TimeScales(min((time for time in own if math.isfinite(time)), default=1.0), 0.0)
    rigid = tuple(_rigid(body, otherwise.contact_time) for body in bodies)
    try:
        return _scales(quantity, run(rigid), otherwise)
    except (InputError, ConvergenceError):  # e.g. of two walls
        return otherwise


def _rigid(body: BodyModel, contact_time: float) -> Any:
    """A body that deforms as little as any model of it."""
    make = partial(model_hierarchy(body, contact_time, None).model, 0)
    if not isinstance(body, FullModel):
        return make()
    return body.body.kept.get(("rigid", *(tip.key for tip in body.tips)), make)


def _scales(quantity: Quantity, run: Run, otherwise: TimeScales) -> TimeScales:
    """The time scales of a run; the contact time of `otherwise` if no contact ends in it."""
    return TimeScales(quantity.contact_time(run) or otherwise.contact_time, quantity.span(run))


@dataclass(eq=False)
class _Trials:
    """Models fitted to the time scales of a scene, and their runs: every set is run once.

    Attributes
    ----------
    run : callable
        Simulates with given models, one for each body.
    record : RecordLength
        How long: a run that is not as long as the others is made again.
    places : tuple of int
        The hierarchy of each body: equal bodies with the same contact point, such as two equal
        spheres, share one. Orders are those of the hierarchies.
    hierarchies : tuple of Hierarchy
    """

    run: Callable[[Models], Run]
    record: RecordLength
    places: tuple[int, ...]
    hierarchies: tuple[Hierarchy, ...]

    def __post_init__(self) -> None:
        self._runs: dict[_Orders, Run | None] = {}
        self.failure: AOImpactError | None = None

    def at(self, orders: _Orders) -> Run | None:
        """Return the run of such orders; None where models that small cannot be run."""
        models = [one.model(n) for one, n in zip(self.hierarchies, orders, strict=True)]
        key = self.at_most(orders)  # known when the models are made
        run = self._runs.get(key)
        if key not in self._runs or (run and run.plan.duration != self.record.length):
            try:
                self._runs[key] = self.run(tuple([models[place] for place in self.places]))
            except AOImpactError as error:
                # With few vectors patches are too stiff, and two rigid bodies may both be walls:
                # such errors may vanish with larger models.
                pairs = zip(self.hierarchies, orders, strict=True)
                deform = all(order > 0 or one.most == 0 for one, order in pairs)
                of_input = isinstance(error, InputError | InputTypeError)
                if of_input and deform and not isinstance(error, LawLimitError):
                    raise
                self._runs[key], self.failure = None, error
        return self._runs[key]

    def at_most(self, orders: Iterable[int]) -> _Orders:
        """Return the orders themselves, or the largest that there are, if these are less."""
        return tuple([min(n, one.most) for one, n in zip(self.hierarchies, orders, strict=True)])

    def smaller(self, orders: _Orders) -> list[_Orders]:
        """Return those that they are compared with; none of whole bodies, whose models are exact.

        Whole bodies have exact responses at their contacts.
        """
        pairs = list(zip(self.hierarchies, orders, strict=True))
        if all(n >= one.most for one, n in pairs):
            return []
        shares = [_GROWTH**i for i in range(1, 1 + len(_SHARES))]
        return [
            tuple([n if n >= one.most else int(n / share) for one, n in pairs]) for share in shares
        ]

    def found(self, orders: _Orders, error: float, rtol: float) -> Orders:
        """Return the models, which meet a tolerance, and their runs."""
        compared, orders = self.smaller(orders), self.at_most(orders)
        finished = [of.finished(n) for of, n in zip(self.hierarchies, orders, strict=True)]
        models = tuple(finished[place] for place in self.places)
        run, *smaller = filter(None, map(self.at, (orders, *compared)))  # all: errors are small
        for one in self.hierarchies:
            one.release()
        numbers = tuple(orders[place] for place in self.places)
        return Orders(numbers, models, error, rtol, run, tuple(zip(smaller, _SHARES, strict=False)))


def _apart(quantity: Quantity, exact: Run | None, other: Run | None) -> float:
    """The relative difference of a quantity between two runs; infinite where there is none."""
    if exact is None or other is None:
        return math.inf
    apart = quantity.difference(exact, other)
    return apart if math.isfinite(apart) else math.inf


def search(
    bodies: Sequence[Any],
    run: Callable[[Models], Run],
    quantity: Quantity,
    rtol: float,
    record: RecordLength,
    *,
    solver: Solver = "auto",
    factors: dict[Any, LinearSolver] | None = None,
    left_out: Callable[[Run], LeftOut] | None = None,
    in_time: float = 0.0,
    best: bool = False,
) -> Orders:
    """Return small orders of bodies that give a quantity to a tolerance of the whole bodies.

    Models are fitted to the time scales of their runs.

    Parameters
    ----------
    bodies : sequence
        Body, FullModel or Hierarchy.
    run : callable
        Simulates with given models, one for each body.
    quantity : Quantity
    rtol : float
        Relative.
    record : RecordLength
        How long runs are. The largest models determine it for those compared with them.
    solver : str or callable, optional
        The linear solver of the bodies; see `FEModel.inverse`.
    factors : dict of body to LinearSolver, optional
        Those that have been set up, and can be taken from here.
    left_out : callable, optional
        Where no tolerance was given: returns the errors of a run by its meshes. Where these are
        larger, a looser tolerance applies; models that meet `_LOOSEST` are enlarged once to meet
        it.
    in_time : float, optional
        The share of time in the tolerance, which is looser by as much.
    best : bool, optional
        True to return the models of the least error, if it is below 1, where no models tried meet
        the tolerance.

    Raises
    ------
    ConvergenceError
        If not even the largest models tried agree to within the tolerance.
    """
    oscillators = max(1, round(-_FIRST * math.log10(rtol)))
    for _ in _SHARES:
        oscillators = math.ceil(_GROWTH * oscillators)
    unlike = list(dict.fromkeys(bodies))
    places = tuple([unlike.index(body) for body in bodies])
    scales, fits = first_guess(bodies, run, quantity), 0
    by_mesh: LeftOut | None = None  # errors, which are those of any models
    while True:
        time, slow = alike(scales.contact_time), scales.slow and alike(scales.slow, up=True)
        made: list[Hierarchy] = []
        for body in unlike:  # with models that were made for an impact like this one, if any were
            make = partial(model_hierarchy, body, time, slow, solver)
            if isinstance(body, FullModel):
                # The factors are taken from those set up, so that their memory can be freed.
                known = factors.pop(body.body, None) if factors and solver == "auto" else None
                key = tuple([tip.key for tip in body.tips]), time, slow, solver, oscillators
                make = partial(body.body.kept.get, key, partial(make, known))
            made.append(make())
        orders, fits = tuple([one.first + oscillators for one in made]), fits + 1
        trials = _Trials(run, record, places, tuple(made))
        loose, too_wide = False, 0
        while True:
            record.settled = False
            exact = trials.at(orders)
            if exact is not None and fits < _MOST_FITS:
                found = _scales(quantity, exact, scales)
                if not scales.suit(found):
                    scales = found
                    break
            error, applies, smaller = 0.0 if exact else math.inf, rtol, trials.smaller(orders)
            compared = map(trials.at, smaller) if exact is not None else ()
            for share, other in zip(_SHARES, compared, strict=False):
                error = max(error, share * _apart(quantity, exact, other))
            if rtol < error <= _LOOSEST and exact is not None and left_out is not None:
                applies = _LOOSEST
                if not loose:
                    by_mesh, loose = left_out(exact), True
                    share = _SHARE_OF_MESH * by_mesh.mesh.get(quantity.name, 0.0)
                    applies = max(rtol, min(share, _LOOSEST) - in_time)
            if error <= applies:
                return replace(trials.found(orders, error, applies), left_out=by_mesh)
            too_wide += exact is None and isinstance(trials.failure, LawLimitError)
            if trials.failure is not None and too_wide >= _TOO_WIDE:
                raise trials.failure
            limit = min(_MOST_ORDER, _MOST_BY_DEFAULT) if best else _MOST_ORDER
            if max(orders) > limit or not smaller:
                if best and error < 1.0:
                    applies = max(applies, _LOOSEST) if error <= _LOOSEST else applies
                    return replace(trials.found(orders, error, applies), left_out=by_mesh)
                failure = trials.failure if exact is None else None
                raise failure or _no_convergence(error, max(orders))
            # Larger models of the bodies with too large a share of the error, or of all.
            alone = [(*orders[:i], n, *orders[i + 1 :]) for i, n in enumerate(smaller[0])]
            apart = [_apart(quantity, exact, other) for other in map(trials.at, alone)]
            poor = [_SHARES[0] * of * len(orders) > applies for of in apart]
            orders = tuple(
                [
                    one.larger(math.ceil(_GROWTH * n)) if is_poor or not any(poor) else n
                    for one, n, is_poor in zip(made, orders, poor, strict=True)
                ]
            )


def _no_convergence(error: float, order: int) -> ConvergenceError:
    larger = f"take rtol={_EASED * error:.2g} or more, " if _EASED * error < 1.0 else "take "
    return ConvergenceError(
        f"the quantity still changes by {error:.2g} at {order} anti-oscillators: "
        f"{larger}a shorter duration, a contact over a patch (radius=), whose waves are longer, or "
        "the full finite-element models"
    )
