"""The number of anti-oscillators that a scene needs for a tolerance.

The error of models of n oscillators is estimated by the largest of the differences of the quantity
of interest to the models of n + 2, n + 4, n + 6 and n + 8. The orders of all bodies are raised
until this estimate is within the tolerance. Truncating each model then, as far as the same larger
models allow, made calls no faster: .87 to 1.16 times their time, median .98, with seven bodies of
4 000 to 36 000 dofs and tolerances of 1e-1 to 1e-3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from ..base import AOImpactError, ConvergenceError, InputError, InputTypeError, LawLimitError
from ..contact import own_contact_time
from ..linalg import LinearSolver, Solver
from ..reduction import BodyModel, FullModel
from ..results import Quantity, Run
from .hierarchy import Hierarchy, Models, alike, model_hierarchy

# Models of n oscillators are compared with _COMPARED larger ones, the largest of which has _BEYOND
# oscillators more, or half as many again: where errors fall slowly, 8 of 100 change little. One
# difference may be small by chance: .01 of the error occurred for numbers. The largest of four is
# above .75 of the error for histories and, in 99 of 100 cases, above .64 for peaks and .83 for
# other numbers (1 763 errors below .1 on ten bodies: beams, plates, blocks, a bracket, a disc,
# spheres). The medians are 1.2 … 2. But the error of a single number may fall monotonically as 1/n,
# and is then 3 times the difference to 1.5 n: that of the peak force of two spheres that touch at a
# node does. Errors of histories and of numbers are taken as these multiples of the largest
# difference.
_COMPARED, _BEYOND, _SHARE_BEYOND = 4, 8, 0.5
_SAFETY, _SAFETY_OF_NUMBERS = 1.3, 3.0

# First oscillators for each digit of the tolerance, about the median that these bodies need; least
# and largest factor from one order to the next, by the error over the tolerance, with which as a
# rule at most 2 n + 8 vectors are made for a result of order n; and the largest order. Where no
# tolerance was given the search ends earlier, with the error that it has by then: a thin sheet that
# touches again and again would take hundreds of vectors.
_FIRST, _LEAST_GROWTH, _GROWTH = 2.0, 1.15, 1.5
_MOST_ORDER, _MOST_BY_DEFAULT = 600, 80

# The tolerance named in a message is this factor above the error found.
_EASED = 1.1

# Bases are fitted again where the contact time that they were fitted to and the one found differ by
# more than this factor; and the largest number of fits.
_REFIT, _MOST_FITS = 2.0, 4

# Where contacts exceed their patches with this many sets of models, each larger, the error is
# raised: larger models would not help.
_TOO_WIDE = 3

# The loosest tolerance that is taken where none was given; and how many times the vectors made for
# it are made at most to come down to the default tolerance.
LOOSEST, _WORTH = 1e-2, 4.0 / 3.0

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
    larger : tuple
        Runs with larger ones.
    safety : float
        An error is at most so many times the largest difference to these.
    """

    orders: tuple[int, ...]
    models: Models
    error: float
    rtol: float
    run: Run
    larger: tuple[Run, ...]
    safety: float


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
    quantity : Quantity
    run : callable
        Simulates with given models, one for each body.
    places : tuple of int
        The hierarchy of each body: equal bodies with the same contact point, such as two equal
        spheres, share one. Orders are those of the hierarchies.
    hierarchies : tuple of Hierarchy
    orders, larger : tuple of int, tuple of these
        The orders that are tried, and those that their error is estimated by, the largest last; one
        set where it is the whole bodies.
    """

    quantity: Quantity
    run: Callable[[Models], Run]
    places: tuple[int, ...]
    hierarchies: tuple[Hierarchy, ...]
    orders: _Orders
    larger: tuple[_Orders, ...] = ()

    def __post_init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all runs."""
        self._runs: dict[_Orders, Run | None] = {}
        self._apart: dict[tuple[_Orders, _Orders], float] = {}
        self.failures: dict[_Orders, AOImpactError] = {}

    def at(self, orders: _Orders) -> Run | None:
        """Return the run of such orders; None where models that small cannot be run."""
        models = [one.model(n) for one, n in zip(self.hierarchies, orders, strict=True)]
        key = self.at_most(orders)  # known when the models are made
        if key not in self._runs:
            try:
                self._runs[key] = self.run(tuple([models[place] for place in self.places]))
            except AOImpactError as error:
                # With few vectors patches are too stiff, and two rigid bodies may both be walls:
                # such errors may vanish with larger models.
                pairs = zip(self.hierarchies, orders, strict=True)
                deform = all(order > 0 or one.at_most(1) == 0 for one, order in pairs)
                of_input = isinstance(error, InputError | InputTypeError)
                if of_input and deform and not isinstance(error, LawLimitError):
                    raise
                self._runs[key], self.failures[orders] = None, error
        return self._runs[key]

    def apart(self, orders: _Orders, larger: _Orders) -> float:
        """Return the relative difference of the quantity; infinite where there is none."""
        pair = orders, larger
        if pair not in self._apart:
            one, other, apart = self.at(orders), self.at(larger), math.inf
            if one is not None and other is not None:
                apart = self.quantity.difference(one, other)
            self._apart[pair] = apart if math.isfinite(apart) else math.inf
        return self._apart[pair]

    def at_most(self, orders: Iterable[int]) -> _Orders:
        """Return the orders themselves, or the largest that there are, if these are less."""
        return tuple([one.at_most(n) for one, n in zip(self.hierarchies, orders, strict=True)])

    def enlarge(self) -> _Orders:
        """Find `larger` as far as it is known before the models are made; return the largest."""
        *smaller, largest = zip(
            *[
                [one.reference_order(_beyond(n, (i + 1) / _COMPARED)) for i in range(_COMPARED)]
                for one, n in zip(self.hierarchies, self.orders, strict=True)
            ],
            strict=True,
        )
        whole = all(one.is_whole(n) for one, n in zip(self.hierarchies, largest, strict=True))
        self.larger = (largest,) if whole else (*smaller, largest)
        return largest

    @property
    def safety(self) -> float:
        """The multiple of the largest difference that is taken for the error."""
        if len(self.larger) == 1:  # the whole bodies
            return 1.0
        return _SAFETY if self.quantity.is_history else _SAFETY_OF_NUMBERS

    @property
    def error(self) -> float:
        """The estimated error."""
        return self.safety * max([self.apart(self.orders, one) for one in self.larger])

    def beyond(self, rtol: float) -> float:
        """Return the first estimate of the error that is not within a tolerance; 0 if all are."""
        for one in reversed(self.larger):
            if (error := self.safety * self.apart(self.orders, one)) > rtol:
                return error
        return 0.0

    def further(self, error: float, rtol: float) -> _Orders:
        """Return higher orders of the bodies with too large a share of an error, or of all."""
        growth, largest = min(max(_LEAST_GROWTH, error / rtol), _GROWTH), self.larger[-1]
        allowed, poor = rtol / len(self.orders) / self.safety, []
        for which, order in enumerate(self.orders):
            alone = (*largest[:which], order, *largest[which + 1 :])
            poor.append(self.apart(alone, largest) > allowed)
        return self.at_most(
            math.ceil(growth * order) if is_poor or not any(poor) else order
            for order, is_poor in zip(self.orders, poor, strict=True)
        )

    def found(self, rtol: float) -> Orders:
        """Return the models, which meet a tolerance, and their runs."""
        orders = self.at_most(self.orders)
        finished = [of.finished(n) for of, n in zip(self.hierarchies, orders, strict=True)]
        models = tuple(finished[place] for place in self.places)
        done = (self.at(each) for each in (orders, *self.larger))
        run, *larger = (run for run in done if run is not None)  # all, since their errors are small
        for one in self.hierarchies:
            one.release()
        numbers = tuple(orders[place] for place in self.places)
        return Orders(numbers, models, self.error, rtol, run, tuple(larger), self.safety)


def search(
    bodies: Sequence[Any],
    run: Callable[[Models], Run],
    quantity: Quantity,
    rtol: float,
    *,
    solver: Solver = "auto",
    factors: dict[Any, LinearSolver] | None = None,
    anew: Callable[[], None] | None = None,
    looser: Callable[[Run], float] | None = None,
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
    solver : str or callable, optional
        The linear solver of the bodies; see `FEModel.inverse`.
    factors : dict of body to LinearSolver, optional
        Those that have been set up, and can be taken from here.
    anew : callable, optional
        Called before larger models are tried: properties of the scene that they determine, such as
        the length of the record, hold for all models that are compared with them.
    looser : callable, optional
        Where no tolerance was given: returns that which applies to a run, if it is larger than
        `rtol`, since other errors, such as the mesh's, are larger. Models that would need a third
        more vectors than for `LOOSEST` meet that one only.
    best : bool, optional
        True to return the models of the least error, if it is below 1, where no models tried meet
        the tolerance.

    Raises
    ------
    ConvergenceError
        If not even the largest models tried agree to within the tolerance.
    """
    oscillators = max(1, round(-_FIRST * math.log10(rtol)))
    unlike = list(dict.fromkeys(bodies))
    places = tuple([unlike.index(body) for body in bodies])
    scales, fits = first_guess(bodies, run, quantity), 0
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
        first, fits = tuple([one.first + oscillators for one in made]), fits + 1
        trials = _Trials(quantity, run, places, tuple(made), first)
        most, loosest, too_wide = math.inf, None, 0
        while True:
            largest = trials.enlarge()
            if anew is not None:  # the largest models determine the length of the record
                trials.clear()
                anew()
            exact = trials.at(largest)
            trials.enlarge()
            if exact is not None and fits < _MOST_FITS:
                found = _scales(quantity, exact, scales)
                if not scales.suit(found):
                    scales = found
                    break
            error, applies = trials.beyond(rtol), rtol
            if error and exact is not None and looser is not None:
                error, applies = trials.beyond(LOOSEST), LOOSEST
                if not error:
                    if loosest is None:  # errors of meshes are those of any models
                        loosest = max(rtol, looser(exact))
                    error, applies = trials.beyond(loosest), loosest
                    if error:
                        error, applies = trials.beyond(rtol), rtol
                        most = min(most, _WORTH * max(largest))
                        if _beyond(max(trials.further(error, rtol)), 1.0) > most:
                            error, applies = 0.0, LOOSEST
            if not error:
                return trials.found(applies)
            failure = trials.failures.get(largest)
            too_wide += isinstance(failure, LawLimitError)
            if failure is not None and too_wide >= _TOO_WIDE:
                raise failure
            limit = min(_MOST_ORDER, _MOST_BY_DEFAULT) if best else _MOST_ORDER
            if max(trials.orders) > limit or trials.at_most(trials.orders) == largest:
                if best and trials.error < 1.0:
                    return trials.found(applies)
                raise failure or _no_convergence(trials)
            trials.orders = trials.further(error, applies)


def _no_convergence(trials: _Trials) -> ConvergenceError:
    within = _EASED * trials.error
    larger = f"take rtol={within:.2g} or more, " if within < 1.0 else "take "
    return ConvergenceError(
        f"the quantity still changes by {trials.error / trials.safety:.2g} at "
        f"{max(trials.orders)} anti-oscillators: {larger}a shorter duration, a contact over a "
        "patch (radius=), whose waves are longer, or the full finite-element models"
    )


def _beyond(order: int, share: float) -> int:
    """The order at this share of the distance to the largest one for comparison."""
    return order + math.ceil(share * max(_BEYOND, _SHARE_BEYOND * order))
