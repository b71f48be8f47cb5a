"""How many anti-oscillators a scene needs: the order of each body, from rigid upward.

The reference is a model of all bodies that is enlarged until the quantity of interest no longer
changes. Each body then takes its least order at which the quantity agrees with the reference.
Looking further, for pairs of orders whose errors cancel and past orders that fail, took a third of
the time and made 2 models of 48 impacts smaller, by 2 oscillators at most: it is not done.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple

import numpy as np

from ..base import AOImpactError, ConvergenceError, FloatArray, InputError
from ..linalg import Solver
from ..reduction import BodyModel, FullModel, own_contact_time
from .hierarchy import Hierarchy, Models, model_hierarchy
from .quantities import Quantity, R

__all__ = ["Orders", "first_guess", "least_orders"]

# The reference's order grows by this factor. Two references may agree by chance, three hardly.
_GROWTH = 1.5
_FIRST_ORDER = 6
_MOST_ORDER = 600

# Up to this order each is tried, beyond it bisection: errors do not fall with every single order.
_EACH = 12

# Share of the tolerance that the reference's own error may take; the same where a larger reference
# costs more than a somewhat larger model; and the share beyond which nothing is proven.
_GOOD_REFERENCE, _FAIR_REFERENCE, _POOR_REFERENCE = 0.1, 0.35, 0.5

# A message names a tolerance that can be met with this factor to spare.
_EASED = 1.1

# Bounds on the ratio of successive changes: a smaller one may be chance, a larger one is no
# convergence.
_FASTEST, _SLOWEST = 0.5, 0.85

# Exponents with which changes add up: the largest that is looked for, and that of unrelated ones,
# which is the largest with which a model's error and the reference's add up.
_MOST_EXPONENT, _UNRELATED = 16.0, 2.0

# While one body's orders are tried, the others have the least order tried for the reference whose
# error is this share of the tolerance.
_COMPANION = 0.3

# To make a body rigid the others' models may grow by this share of all oscillators.
_WORTH_OF_RIGID = 1.0 / 3.0

# Bases are fitted anew where the contact time that they were fitted to and the one found differ by
# this factor; and how often.
_REFIT, _MOST_FITS = 2.0, 4

# Where motion matters for longer than this many contact times, the bases hold slow motion as well.
_LONG = 4.0


@dataclass(frozen=True, eq=False)
class Orders:
    """The least orders that meet the tolerance.

    Attributes
    ----------
    orders : tuple of int
        Of the bodies; 0 is rigid.
    models : tuple of AOModel or InterfaceModel
    error : float
        Estimated relative error of the quantity from the models' orders.
    runs : tuple
        With these models, with the reference and, unless that is the whole bodies, with the
        reference before it. Their differences estimate the errors of other numbers.
    """

    orders: tuple[int, ...]
    models: Models
    error: float
    runs: tuple[Any, ...]


def least_orders(
    bodies: Sequence[BodyModel],
    *,
    run: Callable[[Models], R],
    quantity: Quantity,
    rtol: float,
    solver: Solver = "auto",
) -> Orders:
    """Return the least orders of bodies that give a quantity to `rtol` of the whole bodies.

    Parameters
    ----------
    bodies : sequence
        AOModel, InterfaceModel or FullModel.
    run : callable
        Simulates with given models, one for each body.
    quantity : Quantity
    rtol : float
        Relative.
    solver : str or callable, optional
        The linear solver of the bodies; see `FEModel.inverse`.

    Raises
    ------
    ConvergenceError
        If not even the largest models tried agree to within the tolerance.
    """
    contact_time, length = first_guess(bodies, run, quantity)
    for fit in range(1, _MOST_FITS + 1):
        slow = length if length > _LONG * contact_time else None
        # Equal bodies struck at the same place, as two like spheres are, share one basis.
        made = {body: model_hierarchy(body, contact_time, slow, solver) for body in set(bodies)}
        hierarchies = tuple(made[body] for body in bodies)
        search = _Search(hierarchies, run, quantity, rtol)
        first = search.at((_FIRST_ORDER,) * len(bodies))
        found = (None if first is None else quantity.contact_time(first)) or contact_time
        if max(found / contact_time, contact_time / found) > _REFIT and fit < _MOST_FITS:
            contact_time = found
            continue
        length = quantity.span(search.find_reference())
        if slow is not None or length <= _LONG * contact_time:
            break
    return search.least()


class TimeScales(NamedTuple):
    """What models are fitted to, s: the contact's duration, and how long motion must be right."""

    contact_time: float
    span: float


def first_guess(
    bodies: Sequence[BodyModel], run: Callable[[Models], R], quantity: Quantity
) -> TimeScales:
    """Estimate the time scales of a scene by rigid bodies."""
    meshed = (body for body in bodies if isinstance(body, FullModel))
    own = [own_contact_time(tip) for body in meshed for tip in body.tips]
    otherwise = min((time for time in own if math.isfinite(time)), default=1.0)
    try:
        result = run(tuple(model_hierarchy(body, otherwise, None).model(0) for body in bodies))
    except (InputError, ConvergenceError):  # e.g. of two walls
        return TimeScales(otherwise, 0.0)
    return TimeScales(quantity.contact_time(result) or otherwise, quantity.span(result))


class _Search(Generic[R]):
    """Runs of the hierarchies' models, each made once, and compared with the largest."""

    def __init__(
        self,
        hierarchies: tuple[Hierarchy, ...],
        run: Callable[[Models], R],
        quantity: Quantity,
        rtol: float,
    ) -> None:
        self.hierarchies, self.quantity, self.rtol = hierarchies, quantity, rtol
        self.run: Callable[[Models], R] = run
        self.results: dict[tuple[int, ...], R | None] = {}
        self.deviations: dict[tuple[tuple[int, ...], tuple[int, ...]], FloatArray | None] = {}
        self.failure: AOImpactError | None = None
        self.reference = (0,) * len(hierarchies)
        self.reference_error = 0.0
        self.previous = self.reference  # the reference before that
        # The sum of two errors a and b is (a^p + b^p)^(1/p), with this p.
        self.exponent = 1.0
        # The orders of the other bodies while one body's orders are tried.
        self.companion = self.reference

    def models(self, orders: tuple[int, ...]) -> Models:
        return tuple(one.model(n) for one, n in zip(self.hierarchies, orders, strict=True))

    def at(self, orders: tuple[int, ...]) -> R | None:
        """The run of such orders; None where models that small cannot be run."""
        models = self.models(orders)
        key = tuple(one.at_most(n) for one, n in zip(self.hierarchies, orders, strict=True))
        if key not in self.results:
            try:
                self.results[key] = self.run(models)
            except AOImpactError as error:  # e.g. of patches that too few vectors make too stiff
                self.results[key], self.failure = None, error
        return self.results[key]

    def error(self, orders: tuple[int, ...]) -> float:
        """Estimated error, the reference's own included."""
        apart = _largest(self._deviation(orders))
        return _added(apart, self.reference_error, min(self.exponent, _UNRELATED))

    def _deviation(self, orders: tuple[int, ...]) -> FloatArray | None:
        """From the reference; None where models that small cannot be run, or give no numbers."""
        key = orders, self.reference
        if key not in self.deviations:
            self.deviations[key] = self._apart(self.at(orders), self.at(self.reference))
        return self.deviations[key]

    def _apart(self, one: R | None, other: R | None) -> FloatArray | None:
        if one is None or other is None:
            return None
        deviation = self.quantity.deviation(one, other)
        return deviation if np.isfinite(deviation).all() else None

    def find_reference(self) -> R:
        """Enlarge all models until the quantity no longer changes; return the last run."""
        order, changes, error = _FIRST_ORDER, [math.inf], math.inf
        tried, exponents = [(order,) * len(self.hierarchies)], [1.0]
        results = [self.at(tried[0])]
        while order <= _MOST_ORDER:
            costly = any(one.is_costly(order) for one in self.hierarchies)
            share = _FAIR_REFERENCE if costly else _GOOD_REFERENCE
            if costly and self.exponent >= _UNRELATED:
                share = _POOR_REFERENCE
            if error <= share * self.rtol:
                break
            order = math.ceil(_GROWTH * order)
            orders = tuple(one.reference_order(order) for one in self.hierarchies)
            now = self.at(orders)
            changes.append(_largest(self._apart(results[-1], now)))
            whole = all(one.is_whole(n) for one, n in zip(self.hierarchies, orders, strict=True))
            if self.quantity.is_history and len(results) > 1:
                both = _largest(self._apart(results[-2], now))
                exponents.append(_exponent(changes[-2], changes[-1], both))
                self.exponent = min(exponents[-2:])
            error = 0.0 if whole else _still_to_come(changes, self.exponent)
            self.previous, self.reference, self.reference_error = tried[-1], orders, error
            tried.append(orders)
            results.append(now)
            if whole:
                break
        best = self._proven(results[-1], order, changes[-1], error)
        good = (orders for orders in tried if self.error(orders) <= _COMPANION * self.rtol)
        self.companion = next(good, self.reference)
        return best

    def _proven(self, run: R | None, order: int, change: float, error: float) -> R:
        """The reference's run, if it can be run and its error is small enough."""
        if run is None:
            assert self.failure is not None
            raise self.failure
        if error > _POOR_REFERENCE * self.rtol:
            within = _EASED * error / _POOR_REFERENCE
            larger = f"take rtol={within:.2g} or more, " if within < 1.0 else "take "
            raise ConvergenceError(
                f"the quantity still changes by {change:.2g} at {order} anti-oscillators: "
                f"{larger}a shorter duration, a contact over a patch (radius=), whose waves are "
                "longer, or the full finite-element models"
            )
        return run

    def least(self) -> Orders:
        """Return each body's least order, for falling shares of the tolerance until all agree."""
        found = self.reference
        for share in (1.0, 0.8, 0.65, 0.5, 0.4, 0.3, 0.2, 0.1):
            allowed = max(share * self.rtol, self.reference_error)
            orders = tuple(self._alone(which, allowed) for which in range(len(self.hierarchies)))
            if self.error(orders) <= self.rtol:
                found = orders
                break
        found = self._reduced(found)
        for which in range(len(found)):
            found = self._without(which, found)
        finished = (one.finished(n) for one, n in zip(self.hierarchies, found, strict=True))
        known = (
            (found, self.reference)
            if self.reference_error == 0.0
            else (found, self.reference, self.previous)
        )
        runs = tuple(run for run in map(self.at, known) if run is not None)
        return Orders(found, tuple(finished), self.error(found), runs)

    def _reduced(self, orders: tuple[int, ...]) -> tuple[int, ...]:
        """Reduce orders, the largest first, by steps that halve, as long as the tolerance is met.

        Without it more than a tenth of the models have over two oscillators too many.
        """
        step = max(1, max(orders) // _EACH)
        while step > 0:
            for which in sorted(range(len(orders)), key=lambda i: -orders[i]):
                fewer = _with(orders, which, orders[which] - step)
                if fewer[which] >= 0 and self.error(fewer) <= self.rtol:
                    orders = fewer
                    break
            else:
                step //= 2
        return orders

    def _without(self, which: int, orders: tuple[int, ...]) -> tuple[int, ...]:
        """Make one body rigid, if a somewhat larger model of the largest other one allows it."""
        alone = _with(self.reference, which, 0)
        if orders[which] == 0 or self.error(alone) > self.rtol:
            return orders
        rest = _with(orders, which, 0)
        largest = max(range(len(rest)), key=rest.__getitem__)
        more = orders[which] + int(_WORTH_OF_RIGID * sum(orders))
        most = min(rest[largest] + more, self.reference[largest])
        for order in range(rest[largest] + 1, most + 1, max(1, more // _EACH)):
            if self.error(_with(rest, largest, order)) <= self.rtol:
                return _with(rest, largest, order)
        return orders

    def _alone(self, which: int, allowed: float) -> int:
        """The least order of one body whose own error is allowed."""

        def fits(order: int) -> bool:
            return self.error(_with(self.companion, which, order)) <= allowed

        low = -1
        for order in range(_EACH + 1):
            if fits(order):
                return order
            low = order
        most = self.companion[which]
        high = min(math.ceil(_GROWTH * low), most)
        while high < most and not fits(high):
            low, high = high, min(math.ceil(_GROWTH * high), most)
        while high - low > 1:
            middle = (low + high) // 2
            if fits(middle):
                high = middle
            else:
                low = middle
        return high


def _with(orders: tuple[int, ...], which: int, order: int) -> tuple[int, ...]:
    return (*orders[:which], order, *orders[which + 1 :])


def _largest(deviation: FloatArray | None) -> float:
    return math.inf if deviation is None else float(np.abs(deviation).max(initial=0.0))


def _added(one: float, other: float, exponent: float) -> float:
    """(a^p + b^p)^(1/p)."""
    larger, smaller = max(one, other), min(one, other)
    if smaller == 0.0 or math.isinf(larger):
        return larger
    return larger * math.pow(1.0 + math.pow(smaller / larger, exponent), 1.0 / exponent)


def _exponent(one: float, other: float, both: float) -> float:
    """The exponent p with which two successive changes add up to the change of both: 1, or more.

    p = 1 where the quantity converges from one side, p = 2 where successive changes are unrelated.
    The last errors of a history are waves of ever higher frequency, whose phases at one order are
    unrelated to those at the next; then p is near 2.
    """
    if not (math.isfinite(one) and math.isfinite(other)) or both >= one + other:
        return 1.0
    low, high = 1.0, _MOST_EXPONENT
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _added(one, other, middle) > both else (low, middle)
    return low


def _still_to_come(changes: list[float], exponent: float) -> float:
    """Estimate the distance to the limit from the last two changes: a geometric series.

    The last change counts as at least half of the one before: a single one may be small by chance.
    """
    before, last = changes[-2], max(changes[-1], _FASTEST * changes[-2])
    if not (math.isfinite(before) and math.isfinite(last)):
        return math.inf
    ratio = max(last / before, _FASTEST) if before > 0.0 else _SLOWEST
    ratio = min(ratio, _SLOWEST)
    return last * ratio / math.pow(1.0 - math.pow(ratio, exponent), 1.0 / exponent)
