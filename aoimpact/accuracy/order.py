"""How many anti-oscillators a scene needs: the order of each body, from rigid upward.

A larger model of all bodies stands for the truth, itself enlarged until it no longer changes; then
the least orders are taken whose answer agrees with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Generic

import numpy as np

from ..base import AOImpactError, ConvergenceError, FloatArray, InputError
from ..fem import ContactPoint
from ..linalg import Solver
from ..reduction import own_contact_time
from .hierarchy import Ladder, Models, ladder
from .quantities import Quantity, R

__all__ = ["Orders", "first_guess", "least_orders"]

# Orders of the models that stand for the truth grow by this factor. Two of them agree by chance,
# three hardly.
_GROWTH = 1.5
_FIRST_ORDER = 6
_MOST_ORDER = 600

# Up to here each order is tried, beyond it by bisection: errors fall with the order in the large
# only, and a step back may hide one that does.
_EACH = 12

# Share of the tolerance that the truth's own error may take; where a larger truth costs more than a
# model somewhat larger than the least; and beyond which nothing is proven.
_GOOD_REFERENCE, _FAIR_REFERENCE, _POOR_REFERENCE = 0.1, 0.35, 0.5

# A tolerance that can be had is named with so much to spare.
_EASED = 1.1

# Ratios of successive changes that are believed: a change that is smaller by chance proves no more
# than the first, and above the second nothing converges yet.
_FASTEST, _SLOWEST = 0.5, 0.85

# Exponents of sums of changes: no larger than the first; from the second on they are unrelated, and
# a model's error and that of the truth add up with it.
_MOST_EXPONENT, _UNRELATED = 16.0, 2.0

# So many orders less are tried at once before a model counts as the least.
_BEHIND = 5

# The others' models in runs that try one body's orders: no larger than errs by this share of the
# tolerance.
_COMPANION = 0.3

# Two bodies' errors add up, with their signs, but for products of them: pairs that are foreseen to
# err by no more than this many tolerances are tried, so many of them, of orders up to here.
_DOUBT, _TRIES, _FORESEEN = 1.3, 24, 48

# A body that may be rigid is worth models of the others that are larger by this share at most.
_WORTH_OF_RIGID = 1.0 / 3.0

# Bases are fitted anew, but not for ever, where this factor lies between the contact time that they
# were fitted to and the one found.
_REFIT, _MOST_FITS = 2.0, 4

# A record that goes on for longer than this many contact times needs slow motion as well.
_LONG = 4.0


@dataclass(frozen=True, eq=False)
class Orders:
    """The least orders that were found to do.

    Attributes
    ----------
    orders : tuple of int
        Of the bodies; 0 is rigid.
    models : tuple of AOModel or InterfaceModel
    error : float
        Estimated relative error of the quantity from the models' orders.
    runs : tuple
        Of these models, of those that stand for the truth and, unless these are the whole bodies,
        of those before them: what other numbers of the first may be wrong by.
    """

    orders: tuple[int, ...]
    models: Models
    error: float
    runs: tuple[Any, ...]


def least_orders(
    bodies: Sequence[Any],
    *,
    run: Callable[[Models], R],
    quantity: Quantity,
    rtol: float,
    solver: Solver = "auto",
) -> Orders:
    """Return the least orders of bodies whose answer is within `rtol` of the whole bodies'.

    Parameters
    ----------
    bodies : sequence
        ContactPoint, tuple of ContactPoint, AOModel, ModalModel or InterfaceModel.
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
        If not even the largest models looked at agree to within the tolerance.
    """
    contact_time, length = first_guess(bodies, run, quantity)
    for fit in range(1, _MOST_FITS + 1):
        slow = length if length > _LONG * contact_time else None
        # Equal bodies struck at the same place, as two like spheres are, share one basis.
        made = {id(body): ladder(body, contact_time, slow, solver) for body in bodies}
        ladders = tuple(made[id(body)] for body in bodies)
        search = _Search(ladders, run, quantity, rtol)
        first = search.at((_FIRST_ORDER,) * len(bodies))
        found = (None if first is None else quantity.contact_time(first)) or contact_time
        if max(found / contact_time, contact_time / found) > _REFIT and fit < _MOST_FITS:
            contact_time = found
            continue
        length = quantity.span(search.reference())
        if slow is not None or length <= _LONG * contact_time:
            break
    return search.least()


def first_guess(
    bodies: Sequence[Any], run: Callable[[Models], R], quantity: Quantity
) -> tuple[float, float]:
    """Guess the contact time, and how long motion must be right, both in s, by rigid bodies."""
    tips = [tip for body in bodies for tip in (body if isinstance(body, tuple) else (body,))]
    own = [own_contact_time(tip) for tip in tips if isinstance(tip, ContactPoint)]
    otherwise = min((time for time in own if math.isfinite(time)), default=1.0)
    try:
        result = run(tuple(ladder(body, otherwise, None).model(0) for body in bodies))
    except (InputError, ConvergenceError):  # e.g. where nothing gives way between two walls
        return otherwise, 0.0
    return quantity.contact_time(result) or otherwise, quantity.span(result)


class _Search(Generic[R]):
    """Runs of the ladders' models, each made once, and compared with the largest."""

    def __init__(
        self,
        ladders: tuple[Ladder, ...],
        run: Callable[[Models], R],
        quantity: Quantity,
        rtol: float,
    ) -> None:
        self.ladders, self.quantity, self.rtol = ladders, quantity, rtol
        self.run: Callable[[Models], R] = run
        self.results: dict[tuple[int, ...], R | None] = {}
        self.deviations: dict[tuple[tuple[int, ...], tuple[int, ...]], FloatArray | None] = {}
        self.failure: AOImpactError | None = None
        self.truth = (0,) * len(ladders)
        self.truth_error = 0.0
        self.before = self.truth  # the orders that stood for it last
        # Errors add up as the sums of their powers with this exponent.
        self.exponent = 1.0
        # What a body's orders are tried with, as exact as need be.
        self.companion = self.truth

    def models(self, orders: tuple[int, ...]) -> Models:
        return tuple(one.model(n) for one, n in zip(self.ladders, orders, strict=True))

    def at(self, orders: tuple[int, ...]) -> R | None:
        """The run of such orders; None where models that small cannot be run."""
        models = self.models(orders)
        key = tuple(one.at_most(n) for one, n in zip(self.ladders, orders, strict=True))
        if key not in self.results:
            try:
                self.results[key] = self.run(models)
            except AOImpactError as error:  # e.g. of patches that too few vectors make too stiff
                self.results[key], self.failure = None, error
        return self.results[key]

    def error(self, orders: tuple[int, ...]) -> float:
        """Estimated error, the truth's own included."""
        apart = _largest(self._deviation(orders))
        return _added(apart, self.truth_error, min(self.exponent, _UNRELATED))

    def _deviation(self, orders: tuple[int, ...]) -> FloatArray | None:
        """From the truth; None where models that small cannot be run, or give nothing like it."""
        key = orders, self.truth
        if key not in self.deviations:
            self.deviations[key] = self._apart(self.at(orders), self.at(self.truth))
        return self.deviations[key]

    def _apart(self, one: R | None, other: R | None) -> FloatArray | None:
        if one is None or other is None:
            return None
        deviation = self.quantity.deviation(one, other)
        return deviation if np.isfinite(deviation).all() else None

    def reference(self) -> R:
        """Enlarge all models until the answer stands."""
        order, changes, error = _FIRST_ORDER, [math.inf], math.inf
        tried, exponents = [(order,) * len(self.ladders)], [1.0]
        results = [self.at(tried[0])]
        while order <= _MOST_ORDER:
            costly = any(one.is_costly(order) for one in self.ladders)
            share = _FAIR_REFERENCE if costly else _GOOD_REFERENCE
            if costly and self.exponent >= _UNRELATED:
                share = _POOR_REFERENCE
            if error <= share * self.rtol:
                break
            order = math.ceil(_GROWTH * order)
            truth = tuple(one.stand_in(order) for one in self.ladders)
            now = self.at(truth)
            changes.append(_largest(self._apart(results[-1], now)))
            whole = all(one.is_whole(n) for one, n in zip(self.ladders, truth, strict=True))
            if self.quantity.is_history and len(results) > 1:
                both = _largest(self._apart(results[-2], now))
                exponents.append(_exponent(changes[-2], changes[-1], both))
                self.exponent = min(exponents[-2:])
            error = 0.0 if whole else _still_to_come(changes, self.exponent)
            self.before, self.truth, self.truth_error = tried[-1], truth, error
            tried.append(truth)
            results.append(now)
            if whole:
                break
        if (best := results[-1]) is None:
            assert self.failure is not None
            raise self.failure
        if error > _POOR_REFERENCE * self.rtol:
            raise ConvergenceError(
                f"at {order} anti-oscillators more still change the answer by {changes[-1]:.2g}: "
                f"{self._cure(error)}a shorter duration, a contact over a patch (radius=), whose "
                "waves are longer, or the full finite-element models"
            )
        good = (orders for orders in tried if self.error(orders) <= _COMPANION * self.rtol)
        self.companion = next(good, self.truth)
        return best

    @staticmethod
    def _cure(error: float) -> str:
        """What tolerance can be had where the largest models err by that much."""
        within = _EASED * error / _POOR_REFERENCE
        return f"take rtol={within:.2g} or more, " if within < 1.0 else "take "

    def least(self) -> Orders:
        """Each body's least order with the others at their largest, for shares of the tolerance."""
        found = self.truth
        for share in (1.0, 0.8, 0.65, 0.5, 0.4, 0.3, 0.2, 0.1):
            allowed = max(share * self.rtol, self.truth_error)
            orders = tuple(self._alone(which, allowed) for which in range(len(self.ladders)))
            if self.error(orders) <= self.rtol:
                found = orders
                break
        found = self._pruned(found)
        for pair in combinations(range(len(found)), 2):
            found = self._balanced(pair, found)
        for which in range(len(found)):
            found = self._without(which, found)
        finished = (one.finished(n) for one, n in zip(self.ladders, found, strict=True))
        known = (found, self.truth) if self.truth_error == 0.0 else (found, self.truth, self.before)
        runs = tuple(run for run in map(self.at, known) if run is not None)
        return Orders(found, tuple(finished), self.error(found), runs)

    def _oscillators(self, which: int, order: int) -> int:
        return max(0, order - self.ladders[which].first)

    def _balanced(self, pair: tuple[int, int], found: tuple[int, ...]) -> tuple[int, ...]:
        """Find fewer oscillators of two bodies whose errors do, those of the others being as found.

        Errors need not fall with the order, and may cancel; what each body adds alone foretells it.
        """
        most = sum(self._oscillators(i, found[i]) for i in pair)
        common = self._deviation(self.companion)
        rest = [self._deviation(_with(self.companion, i, n)) for i, n in enumerate(found)]
        if most == 0 or common is None or any(one is None for one in rest):
            return found
        fixed = common + sum(
            one - common for i, one in enumerate(rest) if i not in pair and one is not None
        )
        shares = []
        for i in pair:
            ladder = self.ladders[i]
            last = min(most - 1 + ladder.first, ladder.at_most(_FORESEEN))
            alone = [self._deviation(_with(self.companion, i, n)) for n in range(last + 1)]
            shares.append([(n, one - common) for n, one in enumerate(alone) if one is not None])
        foreseen = []
        for n, one in shares[0]:
            for m, other in shares[1]:
                size = self._oscillators(pair[0], n) + self._oscillators(pair[1], m)
                if size < most:
                    error = _largest(fixed + one + other)
                    if error <= _DOUBT * self.rtol:
                        foreseen.append((size, error, n, m))
        for _, _, n, m in sorted(foreseen)[:_TRIES]:
            fewer = _with(_with(found, pair[0], n), pair[1], m)
            if self.error(fewer) <= self.rtol:
                return fewer
        return found

    def _without(self, which: int, orders: tuple[int, ...]) -> tuple[int, ...]:
        """Make one body rigid, if a little more of the largest of the others makes up for it."""
        alone = _with(self.truth, which, 0)
        if orders[which] == 0 or self.error(alone) > self.rtol:
            return orders
        rest = _with(orders, which, 0)
        largest = max(range(len(rest)), key=rest.__getitem__)
        more = orders[which] + int(_WORTH_OF_RIGID * sum(orders))
        most = min(rest[largest] + more, self.truth[largest])
        for order in range(rest[largest] + 1, most + 1, max(1, more // _EACH)):
            if self.error(_with(rest, largest, order)) <= self.rtol:
                return _with(rest, largest, order)
        return orders

    def _alone(self, which: int, allowed: float) -> int:
        """The least order of one body at which it alone errs no more than allowed."""

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

    def _pruned(self, orders: tuple[int, ...]) -> tuple[int, ...]:
        """Take orders off, from the largest first, as long as the answer stands."""
        step = max(1, max(orders) // _EACH)
        while True:
            for which in sorted(range(len(orders)), key=lambda i: -orders[i]):
                fewer = _with(orders, which, orders[which] - step)
                if fewer[which] >= 0 and self.error(fewer) <= self.rtol:
                    orders = fewer
                    break
            else:
                if step == 1:
                    return self._seen_behind(orders)
                step //= 2

    def _seen_behind(self, orders: tuple[int, ...]) -> tuple[int, ...]:
        """Take several orders off at once, where one less is worse: errors do not fall steadily."""
        for step in range(2, _BEHIND + 1):
            for which in range(len(orders)):
                fewer = _with(orders, which, orders[which] - step)
                if fewer[which] >= 0 and self.error(fewer) <= self.rtol:
                    return self._pruned(fewer)
        return orders


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
    """With which two successive changes add up to the change of both: 1, or more.

    It is 1 where answers creep up on the truth from one side, and 2 where each change is of another
    kind. Of a history what errs in the end are waves of ever higher frequency, whose phases at one
    order have nothing to do with those at the next: answers lie all round the truth, and no change
    is much larger than those that it is made of.
    """
    if not (math.isfinite(one) and math.isfinite(other)) or both >= one + other:
        return 1.0
    low, high = 1.0, _MOST_EXPONENT
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _added(one, other, middle) > both else (low, middle)
    return low


def _still_to_come(changes: list[float], exponent: float) -> float:
    """What a sequence of such successive changes still has before it: their geometric rest.

    The last change counts for no less than the one before makes likely: one alone may be small by
    chance.
    """
    before, last = changes[-2], max(changes[-1], _FASTEST * changes[-2])
    if not (math.isfinite(before) and math.isfinite(last)):
        return math.inf
    ratio = max(last / before, _FASTEST) if before > 0.0 else _SLOWEST
    ratio = min(ratio, _SLOWEST)
    return last * ratio / math.pow(1.0 - math.pow(ratio, exponent), 1.0 / exponent)
