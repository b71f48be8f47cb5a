"""The quantities of interest: what an impact or a scene is summed up by.

`QUANTITIES` is the only table of them. ``quantity=``, `Run.value`, summaries, the errors of a
result, the names that ``keep=`` takes, the columns of a sweep with their units, the fast path of
`simulate_many` and the comparison of models all read it. An impact is a scene of two bodies: of a
number that each contact or each body has, it has the first. CONTRIBUTING.md says what goes with a
new one.
"""

from __future__ import annotations

import contextlib
import math
import numbers
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ..base import FloatArray, Found, InputError, InputTypeError
from ..integrate import Events, touch_alike
from .errors import suggestion

if TYPE_CHECKING:
    from .run import Run


# A run and times, s, to values of shape (rows, times).
History = Callable[["Run", FloatArray], FloatArray]

# The least scale of a relative error, as a share of the largest contact of a scene: one that only
# grazes has no digits of its own.
_LEAST_CONTACT = 0.1

# The same, as a share of the largest initial velocity, or of a restitution of 1: a body that is all
# but stopped has neither.
_LEAST_REBOUND = 0.1

# Times at which momenta are compared while bodies touch.
_ON_THE_WAY = 400

# Times at which the largest friction is looked for between two of a record.
_BETWEEN = 65


def recorded(rows: Callable[[Run], FloatArray]) -> History:
    """Return a history from rows that a run has at its own times, shape (rows, times)."""
    return partial(read, rows)


def read(rows: Callable[[Run], FloatArray], run: Run, times: FloatArray) -> FloatArray:
    """Return rows of a run, (..., n), at times, s; interpolated between fixed steps."""
    if run.t is times:
        return rows(run)
    if run.recorder.dense:
        return rows(replace(run, asked=np.minimum(times, run.duration)))
    interpolated = partial(np.interp, times, run.t)
    return np.apply_along_axis(interpolated, -1, rows(run))


@dataclass(frozen=True, eq=False)
class Speeds:
    """How bodies move before their contacts and after them.

    Arrays of shape (bodies,), or (bodies, impacts) of many impacts at once.

    Attributes
    ----------
    before, after : array
        Velocities of the centres of mass along the direction of travel, m/s: when the first contact
        begins, 0 of what is held at rest, and when the last one has ended; `after` is NaN where it
        is not known.
    fixed : array of bool
        Whether a body is constrained, or a wall.
    pair : (int, int) or None
        The bodies of the contact, if there is only one.
    """

    before: FloatArray
    after: FloatArray
    fixed: Any
    pair: tuple[int, int] | None = (0, 1)

    @property
    def still(self) -> Any:
        """Which bodies are held at rest."""
        return self.fixed & (self.before == 0.0)


@dataclass(frozen=True)
class Quantity:
    """Numbers or histories of a run, by one of four functions.

    Attributes
    ----------
    name, unit : str
    of_contact : callable, optional
        Number of a contact, from its `Events`. It is called for contacts that never touched, too:
        `contacts` is then empty, and force, impulse and duration are 0. The fast path of
        `simulate_many` calls it for many impacts at once, as if each touched once, with an array of
        shape (impacts,) in place of each number. So a quotient such as impulse / contact_duration
        says what it is where it divides by 0, for numbers and for arrays.
    of_speeds : callable, optional
        Of `Speeds`: numbers, shape (k,) or (k, impacts). This and `of_contact` are all that the
        fast path of `simulate_many` has; other numbers take an impact off it.
    of_run : callable, optional
        Numbers of a `Run`, shape (k,).
    history : callable, optional
        Histories of a `Run` at times, s: shape (rows, times).
    each : {"contacts", "bodies", ""}
        Owner of the k numbers, or the histories: each contact, each body, or the run as a whole,
        which has then one or, where there is no such number in its scene, none. A single number
        that is not known is NaN.
    scenes : bool
        Whether scenes have it, or impacts of two bodies only.
    column : bool
        Whether a sweep keeps it by default.
    count : bool
        Whether it counts something, so that it is right or wrong.
    lasting : bool
        Whether the motion after the last contact is part of it.
    memory : float
        By how much longer than the impact a record is for it, s.
    least : callable, optional
        Least scale of relative errors, from the velocities at the start, as `Speeds.before`.
    sliding : bool
        True of what only runs with friction have.
    by_momentum : callable, optional
        How much the k numbers of a `Run` change with the momentum that each contact passes on, from
        changes of it, N s, shape (contacts,).
    """

    name: str
    unit: str
    of_contact: Callable[[Events], Any] | None = None
    of_speeds: Callable[[Speeds], FloatArray] | None = None
    of_run: Callable[[Run], FloatArray] | None = None
    history: History | None = None
    each: str = "contacts"
    scenes: bool = True
    column: bool = False
    count: bool = False
    lasting: bool = False
    memory: float = 0.0
    sliding: bool = False
    least: Callable[[FloatArray], Any] | None = None
    by_momentum: Callable[[Run, FloatArray], FloatArray] | None = None

    @property
    def is_history(self) -> bool:
        """True if it is a history, or several, rather than numbers."""
        return self.history is not None

    @property
    def is_plain(self) -> bool:
        """True if the fast path of `simulate_many` has it."""
        return self.of_contact is not None or self.of_speeds is not None

    def of_plain(self, events: Events, speeds: Speeds) -> FloatArray:
        """Return the number of many impacts, from arrays of shape (impacts,) in place of numbers.

        Only if `is_plain`.
        """
        if self.of_contact is not None:
            number = self.of_contact(events)
        else:
            assert self.of_speeds is not None
            number = self.of_speeds(speeds)[0]
        return np.broadcast_to(np.asarray(number, dtype=np.float64), speeds.before.shape[1:])

    def names(self, run: Run) -> list[str]:
        """Return the names that its numbers are kept by.

        Such as "peak_force" of an impact, "contacts.0.peak_force" of a scene.
        """
        return [self.called(run, i) for i in range(len(self.values(run)))]

    def called(self, run: Run, number: int) -> str:
        """Return the name of one of its numbers: of an impact its own name."""
        owned = run.plan.scene and self.each
        return f"{self.each}.{number}.{self.name}" if owned else self.name

    def difference(self, run: Run, exact: Run) -> float:
        """Return how far a run is from a more exact one: the largest `deviation`."""
        return float(np.abs(self.deviation(run, exact)).max(initial=0.0))

    def deviation(self, run: Run, exact: Run) -> FloatArray:
        """Return by how much a run gives more than a more exact one, relative.

        Flat, contact by contact, of histories at the times of the more exact run. Relative to the
        largest value of the history, or to the number; in a scene to no less than a tenth of the
        largest of all contacts.
        """
        if self.history is not None:
            mine, right = self.history(run, exact.t), self.history(exact, exact.t)
            size = np.abs(right).max(axis=1)
        else:
            mine, right = self.compared(run), self.compared(exact)
            if not len(right):  # friction of runs without
                return np.zeros(1)
            there = ~(np.isnan(mine) & np.isnan(right))
            if not there.any():  # nothing that would tell one from the other
                return np.array([math.inf])
            mine, right = mine[there], right[there]
            size = np.abs(right)
        scales = np.maximum(size, _LEAST_CONTACT * size.max(initial=0.0))
        before = np.array(exact.plan.velocities)
        return _relative(mine - right, self.at_least(scales, before)).ravel()

    def span(self, run: Run) -> float:
        """Return the time, s, over which the motion affects this quantity.

        Bodies without gravity, loads or preload do not deform until the first contact.
        """
        first, last = run.touching or (0.0, 0.0)
        if run.plan.preload or run.plan.weighed or run.plan.loads:
            first = 0.0
        return (run.duration if self.lasting else last) - first

    def largest(self, run: Run) -> float:
        """Return the largest value of a history over the record; NaN of a number."""
        if self.history is None:
            return math.nan
        return float(np.abs(self.history(run, run.t)).max(initial=0.0))

    def contact_time(self, run: Run) -> float | None:
        """Return the duration of the first contact, s, or None where none ends in the record.

        In a scene, that of the shortest hard contact, about its largest force.
        """
        if not run.plan.scene:
            return run.events[0].contact_duration or None
        hardest = max((of.peak_force for of in run.events), default=0.0)
        spans = [
            of.peak_contact or (0.0, 0.0)
            for of in run.events
            if of.peak_force >= _LEAST_CONTACT * hardest
        ]
        return min((end - start for start, end in spans if end > start), default=None)

    def values(self, run: Run) -> FloatArray:
        """Return its numbers of a run, shape (k,)."""
        if self.of_speeds is None:
            return self.compared(run)
        parted = any(events.contacts for events in run.events) and not run.in_contact_at_end
        known = [parted and body.centre_known for body in run.plan.bodies]
        after = np.where(known, run.compared_velocities, np.nan)
        values = self.of_speeds(_speeds(run, after))
        return values if run.plan.scene else values[:1]

    def compared(self, run: Run) -> FloatArray:
        """Return the numbers by which runs are compared, each found once.

        As `values`, but with velocities at the record's end where contact has not ended, and the
        mean over the static mode where a centre of mass is not known.
        """
        if self.name not in run.compared:
            if self.of_contact is not None:
                values = np.array([self.of_contact(of) for of in run.events], dtype=np.float64)
            elif self.of_speeds is not None:
                values = self.of_speeds(_speeds(run, run.compared_velocities))
            else:
                assert self.of_run is not None
                values = self.of_run(run)
            run.compared[self.name] = values if run.plan.scene else values[:1]
        return run.compared[self.name]

    def at_least(self, scales: FloatArray, before: FloatArray) -> FloatArray:
        """Return scales of relative errors, none below the `least` of these velocities, m/s."""
        return scales if self.least is None else np.maximum(scales, self.least(before))


def look_up(result: Run, name: str, argument: str) -> float:
    """Return a number of a run by its name, as of `Quantity.named`, or else any attribute of it.

    Parameters
    ----------
    result : Run
    name : str
        Attributes are dotted, with numbers for places in lists.
    argument : str
        For messages: what the name was given as.

    Raises
    ------
    InputError, InputTypeError
        If the run has no such number.
    """
    with contextlib.suppress(KeyError):
        return result.numbers[name]
    found = cast("Any", result)
    largest = result.chosen.quantities.get(name, ("", math.nan))[1] if result.chosen else math.nan
    if not math.isnan(largest):
        return largest
    for part in name.split("."):
        try:
            if isinstance(found, Mapping):
                found = found[part]
            else:
                found = found[int(part)] if part.isdigit() else getattr(found, part)
        except (AttributeError, IndexError, KeyError, TypeError):
            known = [*result.numbers, *(one for one in dir(found) if not one.startswith("_"))]
            raise InputError(
                f"{argument}: {name!r}: {type(found).__name__} has no {part!r}"
                f"{suggestion(name, known)}"
            ) from None
    if found is None:  # an error that is not known
        return math.nan
    if not isinstance(found, (numbers.Real, np.bool_)):
        raise InputTypeError(
            f"{argument}: {name!r} is no number but {type(found).__name__}; name one, such as "
            f"'peak_force', or of a vector a component, such as '{name}.0'"
        )
    return float(found)


def number_errors(
    run: Run,
    others: Sequence[tuple[Run, float]],
    known: Mapping[str, float] | None = None,
    *,
    on_the_way: bool = False,
) -> Mapping[str, float]:
    """Return by how much the force, and each number that sums up a run, may be wrong, relative.

    The largest of its changes to other runs, each times its factor, by the names by which numbers
    are kept, such as "peak_force" or, of a scene, "contacts.0.peak_force". Infinite where one of
    the runs has no such number. Errors that are known already are taken as they are.

    Parameters
    ----------
    on_the_way : bool, optional
        True to take, of numbers that sum up the force, no less than what the momentum differs by
        while the bodies touch, the root of its mean square: two forces that differ may have the
        same integral by chance. They have no bound where one run touches more often than the other:
        the true motion may touch more often than both.
    """
    before = np.array(run.plan.velocities)

    def find(name: str) -> float:
        if name == "force":
            differences = (times * QUANTITIES[name].difference(run, of) for of, times in others)
            return max(differences, default=0.0)
        quantity, at, values = number(run, name)
        ours, found = quantity.compared(run), [0.0]
        for other, times in others:
            theirs = quantity.compared(other)
            apart = np.abs(ours - theirs)
            if on_the_way and quantity.by_momentum is not None:
                change = quantity.by_momentum(run, _momentum_apart(run, other))
                apart = np.maximum(apart, change[: len(apart)])
            scales = quantity.at_least(np.abs(theirs), before)
            absent = math.isnan(quantity.values(other)[at])
            found.append(math.inf if absent else times * float(_relative(apart, scales)[at]))
        return math.inf if math.isnan(values[at]) else max(found)

    return Found(lambda: ["force", *run.numbers], find, known)


def _momentum_apart(run: Run, other: Run) -> FloatArray:
    """By how much the momentum that each contact passes on differs while bodies touch, N s.

    The root of its mean square, shape (contacts,); infinite where one run touches more often.
    """
    first, last = run.touching or (0.0, 0.0)
    times = np.linspace(first, last, _ON_THE_WAY)
    force = QUANTITIES["force"].history
    assert force is not None
    apart = (force(run, times) - force(other, times))[run.plan.layout.normal]
    passed = np.cumsum(apart, axis=1) * (last - first) / _ON_THE_WAY
    alike = [touch_alike(*of) for of in zip(run.events, other.events, strict=True)]
    return np.where(alike, np.sqrt((passed**2).mean(axis=1)), math.inf)


def number(run: Run, name: str) -> tuple[Quantity, int, FloatArray]:
    """A number's quantity, and its place among the values of this; KeyError if there is none."""
    *_, at, last = ("", "", *name.split("."))
    quantity, place = QUANTITIES[last], int(at) if at.isdigit() else 0
    known = not quantity.is_history and name == quantity.called(run, place)
    if not known or place >= len(values := quantity.values(run)):
        raise KeyError(name)
    return quantity, place, values


def _speeds(run: Run, after: FloatArray) -> Speeds:
    """How the bodies of a run come to their first contact, with these velocities after the last."""
    plan = run.plan
    pair = (plan.contacts[0].first, plan.contacts[0].second) if len(plan.contacts) == 1 else None
    fixed = np.array([of.constrained for of in plan.bodies])
    return Speeds(run.velocities_before, after, fixed, pair)


def _relative(difference: FloatArray, scales: FloatArray) -> FloatArray:
    """Rows over their scales; of a scale of 0 a difference is infinite."""
    scales = scales.reshape(-1, *(1,) * (difference.ndim - 1))
    relative = np.where(difference == 0.0, 0.0, np.copysign(np.inf, difference))
    np.divide(difference, scales, out=relative, where=np.broadcast_to(scales > 0.0, relative.shape))
    return relative


def _allowed(run: Run, momenta: FloatArray) -> FloatArray:
    """Changes of contacts' momenta, N s, no larger than the energy left in the bodies allows.

    Two bodies that part with e times their velocity keep 1 - e² of their energy. If all of that is
    uncertain, the impulse is so by (1 - e)/(2 e) of itself.
    """
    e = QUANTITIES["restitution"].compared(run).max(initial=0.0)
    if run.plan.weighed or run.plan.loads or e == 0.0:
        return momenta
    most = 0.5 * max(1.0 / e - 1.0, 0.0) * run.events[0].impulse
    return np.where(momenta < math.inf, np.minimum(momenta, most), momenta)


def _of_bodies(run: Run, momenta: FloatArray) -> FloatArray:
    """Changes of velocities, m/s, by those of contacts' momenta, N s; 0 of what is held at rest."""
    found = np.zeros(len(run.plan.bodies))
    for contact, momentum in zip(run.plan.contacts, _allowed(run, momenta), strict=True):
        for body, _ in contact.ports:
            mass = run.plan.bodies[body].static_mass
            found[body] += momentum / mass if math.isfinite(mass) else 0.0
    return np.where(_speeds(run, found).still, 0.0, found)


def _unbounded(run: Run, momenta: FloatArray) -> FloatArray:
    """Changes of a number of each body: no less than 0, and infinite with those of momenta."""
    return np.full(len(run.plan.bodies), math.inf if np.isinf(momenta).any() else 0.0)


def _restitution(of: Speeds) -> FloatArray:
    """How fast the two bodies part over how fast they came; what is held at rest stays so."""
    if of.pair is None:
        return np.empty(0)
    first, second = of.pair
    came = of.before[first] - of.before[second]
    if not came.all():
        return np.empty(0)
    after = np.where(of.still, 0.0, of.after)
    return np.array([(after[second] - after[first]) / came])


def _of_events(name: str, unit: str, **options: Any) -> Quantity:
    """A number that `Events` have by the same name."""
    return Quantity(name, unit, of_contact=attrgetter(name), **options)


def _displacement(name: str, body: int) -> Quantity:
    """The displacement of the contact point of a body of an impact."""
    history = recorded(lambda run: run.bodies[body].port_displacements)
    return Quantity(name, "m", history=history, scenes=False, lasting=True)


def _friction_peaks(run: Run) -> FloatArray:
    """The largest force of friction of each contact that has it, N.

    Between the times of the record next to the largest there it is looked for again: where slip
    begins it has a corner.
    """
    found, run = list[float](), replace(run, asked=None)  # of the solver's own times
    for number, contact in enumerate(run.plan.contacts if run.plan.oblique is not None else ()):
        if contact.friction is None:
            found.append(0.0)
            continue
        of = run.each_contact[number]
        assert of.friction_force is not None
        size = np.linalg.norm(of.friction_force, axis=1)
        top = int(size.argmax()) if len(size) else 0
        if run.recorder.dense and 0 < top < len(size) - 1:
            times = np.linspace(run.t[top - 1], run.t[top + 1], _BETWEEN)
            near = run.at(times).each_contact[number].friction_force
            assert near is not None
            size = np.append(np.linalg.norm(near, axis=1), size[top])
        found.append(size.max(initial=0.0))
    return np.array(found)


def _tangential_restitution(run: Run) -> FloatArray:
    """How fast two bodies move past each other after contact, along the way they did before it."""
    plan = run.plan
    if plan.oblique is None or len(plan.contacts) != 1:
        return np.empty(0)
    pair, along = [port.body for port in plan.contacts[0].ports], plan.oblique.axes[1:]
    moved = np.array(plan.oblique.velocities)[pair, :3]
    if run.accelerated is not None:
        moved = np.array([run.motion_at(body, run.accelerated)[:3] for body in pair])
    way = (moved[0] - moved[1]) @ along.T @ along
    if not way.any():
        return np.empty(0)
    if not run.events[0].contacts or run.in_contact_at_end:
        return np.array([np.nan])
    fixed = np.array([plan.bodies[body].constrained for body in pair])
    after = np.array([run.motion_at(body)[:3] for body in pair])
    return -_restitution(Speeds(moved @ way, after @ way, fixed))


def _final_spins(run: Run) -> FloatArray:
    """Spin of each body after the last contact, rad/s."""
    if run.plan.oblique is None:
        return np.empty(0)
    bodies = enumerate(run.plan.bodies)
    spins = [np.nan if of.constrained else np.linalg.norm(run.motion_at(i)[3:]) for i, of in bodies]
    return np.array(spins)


_ALL = (
    Quantity("force", "N", history=recorded(attrgetter("pushes"))),
    _of_events("peak_force", "N", column=True),
    _of_events("peak_time", "s", column=True),
    _of_events(
        "contact_duration",
        "s",
        column=True,
        by_momentum=lambda run, momenta: np.array(
            [
                momentum / of.impulse * of.contact_duration if of.impulse else 0.0
                for momentum, of in zip(momenta, run.events, strict=True)
            ]
        ),
    ),
    _of_events("contact_count", "", count=True),
    _of_events("impulse", "N s", column=True, by_momentum=_allowed),
    Quantity(
        "rebound_velocity",
        "m/s",
        # NaN for bodies held at rest, unless all are.
        of_speeds=lambda of: np.where(of.still & ~of.still.all(axis=0), np.nan, of.after),
        each="bodies",
        least=lambda before: _LEAST_REBOUND * np.abs(before).max(axis=0),
        column=True,
        by_momentum=_of_bodies,
    ),
    Quantity(
        "restitution",
        "",
        of_speeds=_restitution,
        each="",
        least=lambda _: _LEAST_REBOUND,
        column=True,
        by_momentum=lambda run, momenta: (
            _of_bodies(run, momenta).sum(keepdims=True) / np.ptp(run.velocities_before)
        ),
    ),
    Quantity("peak_friction_force", "N", of_run=_friction_peaks, sliding=True),
    Quantity(
        "tangential_restitution",
        "",
        of_run=_tangential_restitution,
        each="",
        sliding=True,
        least=lambda _: _LEAST_REBOUND,
        by_momentum=_unbounded,
    ),
    Quantity(
        "final_spin",
        "rad/s",
        of_run=_final_spins,
        each="bodies",
        sliding=True,
        by_momentum=_unbounded,
    ),
    _displacement("projectile_displacement", 0),
    _displacement("target_displacement", 1),
)

QUANTITIES = {quantity.name: quantity for quantity in _ALL}

# Names for ``quantity=`` in an impact and in a scene, and columns that a sweep keeps by default.
IMPACT_CHOICES = tuple(QUANTITIES)
SCENE_CHOICES = tuple(one.name for one in _ALL if one.scenes)
COLUMNS = tuple(one.name for one in _ALL if one.column)


def quantity_unit(name: str) -> str:
    """Return the unit of a number by its name; "" where none is known.

    The name may be dotted, and may end with a component of a vector: "bodies.0.final_spin.1".
    """
    *_, last = (part for part in name.split(".") if not part.isdigit())
    if last == "final_velocity":  # a vector, and its length no quantity
        return "m/s"
    quantity = QUANTITIES.get(last)
    return "" if quantity is None or quantity.is_history else quantity.unit
