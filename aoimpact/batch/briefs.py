"""Plain impacts by the hundred: one call of the core makes them, and only their numbers come back.

An impact is plain if both bodies are stars, it is integrated to a tolerance, they touch once at
most and have parted before the record ends. All others are left to `simulate`, which has the same
numbers of plain ones, to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import held_warnings
from ..impact import FASTEST, LONGEST, SLOWEST, plan_impact
from ..integrate import Adaptive
from ..laws import UserLaw
from ..reduction import AOModel, ModalBody, ModalModel, fitted_times, knows
from ..scene import normal_gap

__all__ = ["BRIEF", "brief_numbers"]

# What the core sums a plain impact up by.
BRIEF = frozenset(
    (
        "peak_force",
        "peak_time",
        "contact_duration",
        "impulse",
        "rebound_velocity",
        "restitution",
        "error.time",
    )
)

_KEYWORDS = {"projectile", "target", "law", "velocity", "duration", "solver", "gap", "energies"}

# Columns of the core's answers (enum in python_many.c).
_STATUS, _TOUCHES, _LASTING, _PEAK_FORCE, _PEAK_TIME, _IMPULSE, _START, _END, _OURS, _THEIRS = (
    range(10)
)


@dataclass(frozen=True)
class _Pair:
    """Two bodies and a law as the core takes them, by their places in the stock.

    Attributes
    ----------
    places : tuple of int
        Of projectile, target and law.
    drift : float
        Share of the projectile's velocity that its centre of mass keeps, whatever happens.
    fixed : bool
        Whether the target does not fly off.
    fits : tuple of float
        Between which durations of the contact the models need not be looked at, s.
    models : tuple
        These.
    """

    places: tuple[int, int, int]
    drift: float
    fixed: bool
    fits: tuple[float, float]
    models: tuple[Any, ...]

    def know(self, lasted: float) -> bool:
        """Whether the models know enough for a contact that long, s."""
        least, most = self.fits
        return least <= lasted <= most or all(knows(model, lasted) for model in self.models)


@dataclass
class _Stock:
    """Bodies and laws of some cases, each once."""

    bodies: list[ModalBody] = field(default_factory=list)
    laws: list[Any] = field(default_factory=list)
    pairs: dict[tuple[int, int, int], _Pair | None] = field(default_factory=dict)
    _places: dict[int, int] = field(default_factory=dict)

    def pair(self, case: Mapping[str, Any]) -> _Pair | None:
        """Return a case's bodies and law; None where they are not plain, or wrong."""
        # The cases live as long as the stock: an id stays one thing's.
        key = id(case["projectile"]), id(case["target"]), id(case["law"])
        if key not in self.pairs:
            self.pairs[key] = self._new(case)
        return self.pairs[key]

    def _new(self, case: Mapping[str, Any]) -> _Pair | None:
        stars = (case["projectile"], case["target"])
        if not all(isinstance(star, (AOModel, ModalModel)) for star in stars):
            return None
        if isinstance(case["law"], UserLaw):  # needs Python at every step
            return None
        with held_warnings() as messages:
            try:
                plan = plan_impact(*stars, case["law"], velocity=1.0, duration=1.0)
                bodies = plan.modal
            except Exception:
                return None  # simulate says what is wrong
        if messages or not all(body.centre_known for body in plan.bodies):
            return None
        law, target = plan.joints[0].law, plan.bodies[1]
        self.laws.append(law.for_core())
        omitted = plan.omitted[0]
        models = tuple(body.model for body in plan.bodies)
        return _Pair(
            (self._place(bodies[0]), self._place(bodies[1]), len(self.laws) - 1),
            0.0 if omitted is None else omitted.share,
            target.fixed,
            fitted_times(models),
            models,
        )

    def _place(self, body: ModalBody) -> int:
        if id(body) not in self._places:
            self._places[id(body)] = len(self.bodies)
            self.bodies.append(body)
        return self._places[id(body)]


def brief_numbers(cases: Sequence[Any], names: Iterable[str]) -> list[dict[str, float] | None]:
    """Return the named numbers of the plain ones among some cases; None for the others.

    Parameters
    ----------
    cases : sequence
        As of `simulate_many`.
    names : iterable of str
        Of BRIEF.
    """
    stock = _Stock()
    taken: list[int] = []
    pairs: list[_Pair] = []
    numbers: list[tuple[float, float, float, float]] = []
    for i, case in enumerate(cases):
        row = _row(case)
        pair = None if row is None else stock.pair(case)
        if row is not None and pair is not None:
            taken.append(i)
            pairs.append(pair)
            numbers.append(row)
    found: list[dict[str, float] | None] = [None] * len(cases)
    if not taken:
        return found
    given = np.array(numbers)
    answers = np.empty((len(taken), 10))
    _core.briefs(
        tuple(body.for_core() for body in stock.bodies),
        tuple(body.moving for body in stock.bodies),
        tuple(stock.laws),
        np.array([pair.places for pair in pairs], dtype=np.int32),
        given,
        answers,
    )
    wanted = tuple(names)
    columns = _columns(given, answers, pairs)
    plain = _plain(given, answers).tolist()
    touches = (answers[:, _TOUCHES] > 0.0).tolist()
    lasted = columns["contact_duration"].tolist()
    rows = zip(*(columns[name].tolist() for name in wanted), strict=True)
    for i, pair, is_plain, touched, time, row in zip(
        taken, pairs, plain, touches, lasted, rows, strict=True
    ):
        if is_plain and (not touched or pair.know(time)):  # simulate has a word on the others
            found[i] = dict(zip(wanted, row, strict=True))
    return found


def _row(case: Any) -> tuple[float, float, float, float] | None:
    """Velocity, gap, duration and tolerance of a case; None where `simulate` has to look at it."""
    if not isinstance(case, Mapping) or not case.keys() <= _KEYWORDS:
        return None
    solver = case.get("solver") or _DEFAULT
    if not isinstance(solver, Adaptive) or not isinstance(case.get("energies", True), bool):
        return None
    values = case.get("velocity"), case.get("gap", 0.0), case.get("duration")
    if any(type(value) not in _NUMBERS for value in values) or "law" not in case:
        return None
    try:
        velocity, gap, duration = map(float, values)
    except OverflowError:
        return None
    if not (SLOWEST <= velocity <= FASTEST and 0.0 <= gap < math.inf and 0.0 < duration <= LONGEST):
        return None
    return velocity, normal_gap(gap), duration, solver.rtol


# What `simulate` takes for stars.
_DEFAULT = Adaptive()

_NUMBERS = frozenset((float, int, np.float64))


def _plain(
    given: npt.NDArray[np.float64], answers: npt.NDArray[np.float64]
) -> npt.NDArray[np.bool_]:
    """Whether all went well, with one touch at most that is over."""
    parted = (answers[:, _LASTING] == 0.0) & (answers[:, _END] < given[:, 2] * (1.0 - 1e-12))
    plain: npt.NDArray[np.bool_] = (
        (answers[:, _STATUS] == 0.0) & (answers[:, _TOUCHES] <= 1.0) & parted
    )
    return plain


def _columns(
    given: npt.NDArray[np.float64], answers: npt.NDArray[np.float64], pairs: Sequence[_Pair]
) -> dict[str, npt.NDArray[np.float64]]:
    velocity = given[:, 0]
    ours = answers[:, _OURS] + np.array([pair.drift for pair in pairs]) * velocity
    ours[answers[:, _TOUCHES] == 0.0] = math.nan  # no rebound
    theirs = np.where([pair.fixed for pair in pairs], 0.0, answers[:, _THEIRS])
    return {
        "peak_force": answers[:, _PEAK_FORCE],
        "peak_time": answers[:, _PEAK_TIME],
        "contact_duration": answers[:, _END] - answers[:, _START],
        "impulse": answers[:, _IMPULSE],
        "rebound_velocity": ours,
        "restitution": (theirs - ours) / velocity,
        "error.time": given[:, 3],
    }
