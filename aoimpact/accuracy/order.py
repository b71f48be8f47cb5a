"""The number of anti-oscillators that a scene needs for a tolerance.

A run with models of n oscillators is compared with runs of n/1.5, n/1.5² and n/1.5³ oscillators. If
errors fall as a power of n, each difference in the quantity of interest gives an estimate of the
error. The largest estimate is taken, since one difference alone may be small by chance. The orders
of the bodies are raised until the estimate is within the tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..base import (
    AOImpactError,
    ConvergenceError,
    FloatArray,
    InputError,
    InputTypeError,
    LawLimitError,
)
from ..contact import own_contact_time
from ..linalg import Solver
from ..reduction import Body, BodyModel, FullModel
from ..results import Quantity, RecordLength, Run, TimeSolver
from ..scene import Scenario
from .hierarchy import Hierarchy, Models, alike, model_hierarchy

# _GROWTH: ratio of successive orders. _SHARES: ratios of a model's error to its differences from
# the three smaller models, if errors fall as n^-1.25. Over 44 impacts on beams, plates, sheets,
# blocks, rods and spheres with tolerances of 1e-1 … 1e-3, the true errors of peak force and its
# time, impulse, duration, rebound, displacement and force history are below the largest of the
# three estimates in 98 of 100 cases (99 with n^-1, 94 with n^-1.5). The estimate is 2 … 7 times the
# error in the median.
_GROWTH = 1.5
_SHARES = tuple(1.0 / (_GROWTH ** (1.25 * i) - 1.0) for i in (1, 2, 3))

# Number of oscillators per digit of the tolerance, for the smallest model of the first comparison.
_FIRST = 1.5

# Ratio of the tolerance that an error message proposes to the error that was reached.
EASED = 1.1

# _REFIT: largest ratio between the contact time found and the contact time that the bases were
# fitted to at which no new fit is made. _MOST_FITS: largest number of fits.
_REFIT, _MOST_FITS = 2.0, 4

# Orders of the models, one for each distinct body.
_Orders = tuple[int, ...]

# Ratio of the duration of motion to the contact time above which models also represent slow motion.
_LONG = 4.0


class TimeScales(NamedTuple):
    """Times that models are fitted to, s: contact time, and duration of the motion of interest."""

    contact_time: float
    span: float

    @property
    def slow(self) -> float | None:
        """Duration of the slow motion that models must represent, s; None if there is none."""
        return self.span if self.span > _LONG * self.contact_time else None

    def suit(self, others: TimeScales) -> bool:
        """True if models fitted to these time scales are accurate for `others` as well."""
        ratio = others.contact_time / self.contact_time
        alike = max(ratio, 1.0 / ratio) <= _REFIT
        return alike and (self.slow is not None or others.slow is None)


def first_guess(
    bodies: Sequence[BodyModel], run: Callable[[Models], Run], wanted: Sequence[Quantity]
) -> TimeScales:
    """Return the time scales of a scene, estimated by a run with rigid bodies."""
    meshed = (body for body in bodies if isinstance(body, FullModel))
    own = [own_contact_time(point) for body in meshed for point in body.tips]
    otherwise = TimeScales(min((time for time in own if math.isfinite(time)), default=1.0), 0.0)
    rigid = tuple(_rigid(body, otherwise.contact_time) for body in bodies)
    try:
        return _scales(wanted, run(rigid), otherwise)
    except (InputError, ConvergenceError):  # such as a contact of two walls
        return otherwise


def _rigid(body: BodyModel, contact_time: float) -> Any:
    """Return the model of order 0 of a body."""
    make = partial(model_hierarchy(body, contact_time, None).model, 0)
    if not isinstance(body, FullModel):
        return make()
    return body.body.kept.get(("rigid", contact_time, *(tip.key for tip in body.tips)), make)


def _scales(wanted: Sequence[Quantity], run: Run, otherwise: TimeScales) -> TimeScales:
    """Return the time scales of a run; without contact, take the contact time of `otherwise`."""
    contact_time = wanted[0].contact_time(run) or otherwise.contact_time
    return TimeScales(contact_time, max(of.span(run) for of in wanted))


@dataclass(eq=False)
class Search:
    """Models of rising order, fitted to the time scales of a scene, and their runs.

    The caller alternates `error` and `enlarge` until the error is small enough. Each set of models
    is run once.

    Attributes
    ----------
    plan : Scenario
        Scene of the bodies as given.
    bodies : sequence of Body, FullModel or Hierarchy
    wanted : sequence of Quantity
        Quantities of interest.
    rtol : float
        Relative tolerance of each quantity, which determines the first orders.
    rule : Adaptive or Newmark
    record : RecordLength
        Duration of the runs. The run with the largest models determines the duration, which is kept
        for the runs compared with this run.
    most : int
        Order above which models are not enlarged.
    solver : str or callable
        The linear solver of the bodies; see `FEModel.inverse`.
    orders : tuple of int
        Order of the model of each distinct body; 0 is rigid. Equal bodies with the same contact
        point, such as two equal spheres, share a hierarchy.
    run : Run or None
        Run with models of these orders; None if such small models cannot be run.
    compared : list of (Run, float)
        Runs with smaller models, and the ratio of the error to the difference from each.
    errors : ndarray
        Relative error of each quantity from the models.
    """

    plan: Scenario
    bodies: Sequence[Any]
    wanted: Sequence[Quantity]
    rtol: float
    rule: TimeSolver
    record: RecordLength
    most: int
    solver: Solver
    orders: _Orders = field(init=False)
    run: Run | None = field(init=False, default=None)
    compared: list[tuple[Run, float]] = field(init=False, default_factory=list)
    errors: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self._unlike = list(dict.fromkeys(self.bodies))
        self._first = max(1, round(-_FIRST * math.log10(self.rtol)))
        for _ in _SHARES:
            self._first = math.ceil(_GROWTH * self._first)
        self._fits = 0
        # The first run is without friction, which hardly affects contact times but makes runs take
        # 20 times as long.
        smooth = [of._replace(friction=None) for of in self.plan.contacts]
        guess = partial(self._run_of, replace(self.plan, contacts=smooth))
        self._fit(first_guess(self.bodies, guess, self.wanted))

    def error(self) -> float:
        """Return the largest relative error of the models; infinite if they cannot be run.

        Models are fitted again if the contact time of their run differs much from the contact time
        that they were fitted to.
        """
        while True:
            self.record.settled = False
            self.run = self._at(self.orders)
            if self.run is None:
                return math.inf
            found = _scales(self.wanted, self.run, self._scales)
            if self._fits == _MOST_FITS or self._scales.suit(found):
                break
            self._fit(found)
        self.errors = np.zeros(len(self.wanted))
        self.compared = []
        for orders, share in zip(self._smaller, _SHARES, strict=False):
            other = self._at(orders)
            self.errors = np.maximum(self.errors, share * self._apart(other))
            if other is not None:
                self.compared.append((other, share))
        return float(self.errors.max())

    def enlarge(self, rtol: float) -> bool:
        """Raise the orders of the models; return False if they cannot or must not be raised.

        Only bodies whose share of the error exceeds their share of the tolerance get larger models;
        if there are none, all bodies do.

        Raises
        ------
        LawLimitError
            If contacts are stiffer than their meshes: larger models would not change this.
        """
        if self.run is None and isinstance(self._failure, LawLimitError):
            raise self._failure
        if max(self.orders) > self.most or not self._smaller:
            return False
        orders, poor = self.orders, []
        for i, n in enumerate(self._smaller[0]):
            apart = self._apart(self._at((*orders[:i], n, *orders[i + 1 :])))
            poor.append(_SHARES[0] * apart.max() * len(orders) > rtol)
        grown = zip(self._made, orders, poor, strict=True)
        self.orders = tuple(
            [
                min(math.ceil(_GROWTH * n), one.most) if is_poor or not any(poor) else n
                for one, n, is_poor in grown
            ]
        )
        return True

    def failure(self, error: float) -> AOImpactError:
        """Return the exception that says why no models have a smaller error."""
        if self.run is None and self._failure is not None:
            return self._failure
        eased = EASED * error
        larger = f"take rtol={eased:.2g} or more, " if eased < 1.0 else "take "
        return ConvergenceError(
            f"the quantity still changes by {error:.2g} at {max(self.orders)} anti-oscillators: "
            f"{larger}a shorter duration, a contact over a patch (radius=), whose waves are "
            "longer, or the full finite-element models"
        )

    def models(self) -> Models:
        """Return the models of the bodies; memory that only larger models need is freed."""
        models = [one.finished(n) for one, n in zip(self._made, self.orders, strict=True)]
        for one in self._made:
            one.release()
        return self._of_bodies(models)

    def _fit(self, scales: TimeScales) -> None:
        """Restart with models that are fitted to the time scales `scales`."""
        time, slow = alike(scales.contact_time), scales.slow and alike(scales.slow, up=True)
        self._made: list[Hierarchy] = []
        for body in self._unlike:  # reuse models of a similar impact, if any
            make = partial(model_hierarchy, body, time, slow, self.solver)
            if isinstance(body, FullModel):
                tips = tuple([tip.key for tip in body.tips])
                key = tips, time, slow, self.solver, self._first
                make = partial(body.body.kept.get, key, make)
            self._made.append(make())
        self.orders = tuple([one.first + self._first for one in self._made])
        self._scales, self._fits = scales, self._fits + 1
        self._runs: dict[_Orders, Run | None] = {}
        self._failure: AOImpactError | None = None

    def _at(self, orders: _Orders) -> Run | None:
        """Run with models of these orders; None if models this small cannot be run."""
        pairs = list(zip(self._made, orders, strict=True))
        models = [one.model(n) for one, n in pairs]
        key = tuple([min(n, one.most) for one, n in pairs])  # making a model may lower `most`
        run = self._runs.get(key)
        if key not in self._runs or (run and run.plan.duration != self.record.length):
            try:
                self._runs[key] = self._run_of(self.plan, self._of_bodies(models))
            except AOImpactError as error:
                # Some errors vanish with larger models: few vectors make patches too stiff, and two
                # constrained bodies of order 0 are both walls. Other errors are raised.
                deform = all(order > 0 or one.most == 0 for one, order in pairs)
                of_input = isinstance(error, InputError | InputTypeError)
                if of_input and deform and not isinstance(error, LawLimitError):
                    raise
                self._runs[key], self._failure = None, error
        return self._runs[key]

    def _run_of(self, plan: Scenario, models: Models) -> Run:
        return self.record.run(plan.of_models(models, energies=False), self.rule)

    def _of_bodies(self, models: Sequence[Body]) -> Models:
        """Return the model of each body, given those of the distinct bodies."""
        return tuple([models[self._unlike.index(body)] for body in self.bodies])

    @property
    def _smaller(self) -> list[_Orders]:
        """Orders of the smaller models to compare with; empty if the models have largest order."""
        pairs = list(zip(self._made, self.orders, strict=True))
        if all(n >= one.most for one, n in pairs):
            return []
        shares = [_GROWTH**i for i in range(1, 1 + len(_SHARES))]
        return [
            tuple([n if n >= one.most else int(n / share) for one, n in pairs]) for share in shares
        ]

    def _apart(self, other: Run | None) -> FloatArray:
        """Return each quantity's relative difference from a run; infinite if a run is missing."""
        if self.run is None or other is None:
            return np.full(len(self.wanted), np.inf)
        apart = np.array([of.difference(self.run, other) for of in self.wanted])
        return np.where(np.isfinite(apart), apart, np.inf)
