"""The quantities of interest: numbers and histories that summarise an impact or a scene.

`QUANTITIES` is their only table. ``quantity=``, `Run.value`, summaries, the errors of a result,
the names that ``keep=`` takes, the columns of a sweep with their units, the fast path of
`simulate_many` and the comparison of models all read it. An impact is a scene of two bodies with
one contact; each quantity has only the number of the first contact or body. CONTRIBUTING.md says
what a new quantity needs.
"""

from __future__ import annotations

import contextlib
import math
import numbers
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ..base import FloatArray, Found, InputError, InputTypeError
from ..integrate import Events, touch_alike
from .errors import ErrorEstimate, suggestion

if TYPE_CHECKING:
    from .run import Run


# Function of a run and times, s, that returns the values of histories, shape (rows, times).
History = Callable[["Run", FloatArray], FloatArray]

# Smallest value that an error is divided by: for a contact of a scene, relative to the largest of
# all contacts; for a rebound velocity, relative to the largest initial velocity; for a restitution,
# absolute. A contact that only grazes, or a body that almost stops, has no accurate digits.
_LEAST = 0.1

# Number of instants of a smooth curve, such as the momentum during a contact, or the friction force
# around its largest recorded value.
INSTANTS = 400


def recorded(rows: Callable[[Run], FloatArray]) -> History:
    """Return a `History` made of a function that returns rows at a run's own times."""
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
    """Velocities of bodies before their contacts and after them.

    Arrays have the shape (bodies,), or (bodies, impacts) for many impacts at once.

    Attributes
    ----------
    before, after : array
        Velocities of the centres of mass along the direction of travel, m/s, when the first contact
        begins (0 for supported bodies at rest) and when the last one has ended (NaN if unknown).
    fixed : array of bool
        True for a constrained body or a wall.
    pair : (int, int) or None
        Numbers of the two bodies in contact; None for several contacts.
    """

    before: FloatArray
    after: FloatArray
    fixed: Any
    pair: tuple[int, int] | None = (0, 1)

    @property
    def still(self) -> Any:
        """True for each body that is held at rest by supports."""
        return self.fixed & (self.before == 0.0)


@dataclass(frozen=True)
class Quantity:
    """Numbers or histories of a run, computed by one of four functions.

    Attributes
    ----------
    name, unit : str
    of_contact : callable, optional
        Number of a contact, from its `Events`. The function is also called for contacts that never
        touched: `contacts` is then empty, and force, impulse and duration are 0. The fast path of
        `simulate_many` calls this function for many impacts at once, as if the bodies of each
        touched once, with an array of shape (impacts,) in place of each number. A quotient such as
        impulse / contact_duration must therefore define its value for a divisor of 0, for numbers
        and for arrays.
    of_speeds : callable, optional
        Numbers computed from `Speeds`, shape (k,) or (k, impacts). The fast path of `simulate_many`
        supports only this function and `of_contact`.
    of_run : callable, optional
        Numbers computed from a `Run`, shape (k,).
    history : callable, optional
        Histories of a `Run` at times, s, shape (rows, times).
    each : {"contacts", "bodies", ""}
        Owner of the k numbers or histories: each contact, each body, or the run as a whole, which
        has one number, or none if it is not defined for the scene; an unknown number is NaN.
    scenes : bool
        True if scenes have the quantity, False if only impacts of two bodies do.
    column : bool
        True if a sweep keeps the quantity by default.
    count : bool
        True for a count, which has no relative error: it is either right or wrong.
    lasting : bool
        True if the motion after the last contact affects the quantity.
    memory : float
        Time by which the record must be longer than the impact, s.
    least : callable, optional
        Returns the least value that errors are divided by, from the initial velocities, m/s.
    sliding : bool
        True if only runs with friction have the quantity.
    by_momentum : callable, optional
        Returns the changes of the k numbers of a `Run` due to changes of the momentum that each
        contact has transferred, N s, shape (contacts,).
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
        """True if the quantity consists of histories, not of numbers."""
        return self.history is not None

    @property
    def is_plain(self) -> bool:
        """True if the fast path of `simulate_many` supports the quantity."""
        return self.of_contact is not None or self.of_speeds is not None

    def of_plain(self, events: Events, speeds: Speeds) -> FloatArray:
        """Return the number for many impacts, from arrays of shape (impacts,) in place of numbers.

        Requires `is_plain`.
        """
        if self.of_contact is not None:
            number = self.of_contact(events)
        else:
            assert self.of_speeds is not None
            number = self.of_speeds(speeds)[0]
        return np.broadcast_to(np.asarray(number, dtype=np.float64), speeds.before.shape[1:])

    def names(self, run: Run) -> list[str]:
        """Return the names in a run: "peak_force", in a scene "contacts.0.peak_force"."""
        return [self.called(run, i) for i in range(len(self.values(run)))]

    def called(self, run: Run, number: int) -> str:
        """Return the name of the quantity's number at index `number`."""
        owned = run.plan.scene and self.each
        return f"{self.each}.{number}.{self.name}" if owned else self.name

    def difference(self, run: Run, exact: Run) -> float:
        """Return the largest absolute `deviation` of a run from a more accurate one."""
        return float(np.abs(self.deviation(run, exact)).max(initial=0.0))

    def deviation(self, run: Run, exact: Run) -> FloatArray:
        """Return the signed relative differences of a run from a more accurate one, flattened.

        Histories are compared at the times of the more accurate run. Differences are relative to
        the number, or to the largest value of the history, but at least to a tenth of the largest
        such value of all contacts. Friction is compared with the largest normal force instead.
        """
        if self.history is not None:
            mine, right = self.history(run, exact.t), self.history(exact, exact.t)
            size = np.abs(right).max(axis=1)
            if self.name == "force":
                normal = exact.plan.layout.normal
                size = size[normal][np.cumsum(normal) - 1]
        else:
            mine, right = self.compared(run), self.compared(exact)
            if not len(right):  # the run lacks the quantity, such as friction
                return np.zeros(1)
            there = ~(np.isnan(mine) & np.isnan(right))
            if not there.any():  # no number to compare
                return np.array([math.inf])
            mine, right = mine[there], right[there]
            size = np.abs(right)
        scales = np.maximum(size, _LEAST * size.max(initial=0.0))
        return _relative(mine - right, self.at_least(scales, exact.velocities_before)).ravel()

    def span(self, run: Run) -> float:
        """Return the duration of the motion that affects the quantity, s.

        The motion before the first contact counts only under gravity, loads or preload, which
        deform bodies.
        """
        first, last = run.touching or (0.0, 0.0)
        if run.plan.preload or run.plan.weighed or run.plan.loads:
            first = 0.0
        return (run.duration if self.lasting else last) - first

    def largest(self, run: Run) -> float:
        """Return the largest absolute value of a history over the record; NaN for a number."""
        if self.history is None:
            return math.nan
        return float(np.abs(self.history(run, run.t)).max(initial=0.0))

    def contact_time(self, run: Run) -> float | None:
        """Return the duration of the first contact, s; None without contact.

        In a scene the returned time is the shortest duration of a touch in which a contact has its
        peak force, among contacts with at least a tenth of the largest force.
        """
        if not run.plan.scene:
            return run.events[0].contact_duration or None
        hardest = max((of.peak_force for of in run.events), default=0.0)
        spans = [
            of.peak_contact or (0.0, 0.0) for of in run.events if of.peak_force >= _LEAST * hardest
        ]
        return min((end - start for start, end in spans if end > start), default=None)

    def values(self, run: Run) -> FloatArray:
        """Return the numbers of a run, shape (k,); unknown ones are NaN."""
        if self.of_speeds is None:
            return self.compared(run)
        parted = any(events.contacts for events in run.events) and not run.in_contact_at_end
        known = [parted and body.centre_known for body in run.plan.bodies]
        after = np.where(known, run.compared_velocities, np.nan)
        values = self.of_speeds(_speeds(run, after))
        return values if run.plan.scene else values[:1]

    def compared(self, run: Run) -> FloatArray:
        """Return the numbers by which runs are compared; they are cached in the run.

        Unlike `values`, these numbers use the velocities at the record's end if contact has not
        ended, and the mean velocity weighted with the static mode if no centre is known.
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
        """Return the values that errors are divided by, each raised to at least `least(before)`.

        `before` are the initial velocities, m/s.
        """
        return scales if self.least is None else np.maximum(scales, self.least(before))


def look_up(result: Run, name: str, argument: str) -> float:
    """Return a number of a run by the name of a quantity or, failing that, of an attribute.

    Parameters
    ----------
    result : Run
    name : str
        Name as in `Run.value`. Attributes are dotted, with numbers as indices of sequences.
    argument : str
        Argument of the caller that has the name, for messages.

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
            if isinstance(found, ErrorEstimate) and part in found.parts:
                found = found.parts
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
    if found is None:  # the error is not known
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
    """Return relative error estimates of the force and of each number of a run, by name.

    The error of "peak_force" or, in a scene, "contacts.0.peak_force", is the largest difference
    from the other runs, each multiplied by its factor. The error is infinite where one of the runs
    has no such number.

    Parameters
    ----------
    run : Run
    others : sequence of (Run, float)
        Runs to compare with, and the factor by which the difference from each is multiplied.
    known : mapping of str to float, optional
        Errors that are known already.
    on_the_way : bool, optional
        True to give numbers that integrate the force at least the error that the root mean square
        difference of the momentum transferred during contact causes, since two different forces may
        have the same integral by chance. These errors are infinite if one run touches more often
        than the other: the true motion may touch more often than both.
    """

    moved = cache(partial(_momentum_apart, run))

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
                change = quantity.by_momentum(run, moved(other))
                apart = np.maximum(apart, change[: len(apart)])
            scales = quantity.at_least(np.abs(theirs), run.velocities_before)
            absent = math.isnan(quantity.values(other)[at])
            found.append(math.inf if absent else times * float(_relative(apart, scales)[at]))
        return math.inf if math.isnan(values[at]) else max(found)

    return Found(lambda: ["force", *run.numbers], find, known)


def _momentum_apart(run: Run, other: Run) -> FloatArray:
    """Return the root mean square difference of each contact's transferred momentum, N s.

    The mean is over the time from the first to the last contact, and infinite for a contact that
    touches more often in one run. The shape is (contacts,).
    """
    first, last = run.touching or (0.0, 0.0)
    times = np.linspace(first, last, INSTANTS)
    force: Any = QUANTITIES["force"].history
    apart = (force(run, times) - force(other, times))[run.plan.layout.normal]
    passed = np.cumsum(apart, axis=1) * (last - first) / INSTANTS
    alike = [touch_alike(*of) for of in zip(run.events, other.events, strict=True)]
    return np.where(alike, np.sqrt((passed**2).mean(axis=1)), math.inf)


def number(run: Run, name: str) -> tuple[Quantity, int, FloatArray]:
    """Return the quantity, the index of its number `name`, and all its numbers; or KeyError."""
    *_, at, last = ("", "", *name.split("."))
    quantity, place = QUANTITIES[last], int(at) if at.isdigit() else 0
    known = not quantity.is_history and name == quantity.called(run, place)
    if not known or place >= len(values := quantity.values(run)):
        raise KeyError(name)
    return quantity, place, values


def _speeds(run: Run, after: FloatArray) -> Speeds:
    """Return the `Speeds` of a run with given velocities after its last contact, m/s."""
    plan = run.plan
    pair = (plan.contacts[0].first, plan.contacts[0].second) if len(plan.contacts) == 1 else None
    fixed = np.array([of.constrained for of in plan.bodies])
    return Speeds(run.velocities_before, after, fixed, pair)


def _relative(difference: FloatArray, scales: FloatArray) -> FloatArray:
    """Return differences divided by the scale of each row; x/0 is infinite, but 0/0 is 0."""
    scales = scales.reshape(-1, *(1,) * (difference.ndim - 1))
    relative = np.where(difference == 0.0, 0.0, np.copysign(np.inf, difference))
    np.divide(difference, scales, out=relative, where=np.broadcast_to(scales > 0.0, relative.shape))
    return relative


def _allowed(run: Run, momenta: FloatArray) -> FloatArray:
    """Return `momenta`, changes of the contacts' impulses, N s, bounded by the vibration energy.

    Two bodies that part with e times their approach velocity keep 1 - e² of their energy as
    vibration. If all of this energy is uncertain, the relative uncertainty of the impulse is
    (1 - e)/(2 e).
    """
    e = QUANTITIES["restitution"].compared(run).max(initial=0.0)
    if run.plan.weighed or run.plan.loads or e == 0.0:
        return momenta
    most = 0.5 * max(1.0 / e - 1.0, 0.0) * run.events[0].impulse
    return np.where(momenta < math.inf, np.minimum(momenta, most), momenta)


def _of_bodies(run: Run, momenta: FloatArray) -> FloatArray:
    """Return each body's change of velocity, m/s, due to changes of momentum at contacts, N s.

    The change is 0 for bodies held at rest.
    """
    found = np.zeros(len(run.plan.bodies))
    for contact, momentum in zip(run.plan.contacts, _allowed(run, momenta), strict=True):
        for body, _ in contact.ports:
            mass = run.plan.bodies[body].static_mass
            found[body] += momentum / mass if math.isfinite(mass) else 0.0
    return np.where(_speeds(run, found).still, 0.0, found)


def _unbounded(run: Run, momenta: FloatArray) -> FloatArray:
    """Return inf for each body if the momentum change at any contact is infinite, else 0."""
    return np.full(len(run.plan.bodies), math.inf if np.isinf(momenta).any() else 0.0)


def _restitution(of: Speeds) -> FloatArray:
    """Return the ratio of separation to approach velocity of two bodies; empty if undefined.

    Bodies held at rest stay at rest.
    """
    if of.pair is None:
        return np.empty(0)
    first, second = of.pair
    came = of.before[first] - of.before[second]
    if not came.all():
        return np.empty(0)
    after = np.where(of.still, 0.0, of.after)
    return np.array([(after[second] - after[first]) / came])


def _of_events(name: str, unit: str, **options: Any) -> Quantity:
    """Return the quantity for the attribute `name` of `Events`."""
    return Quantity(name, unit, of_contact=attrgetter(name), **options)


def _displacement(name: str, body: int) -> Quantity:
    """Return the quantity for the displacement of a body's contact point in an impact."""
    history = recorded(lambda run: run.bodies[body].port_displacements)
    return Quantity(name, "m", history=history, scenes=False, lasting=True)


def _friction_peaks(run: Run) -> FloatArray:
    """Return the largest friction force of each contact, N; 0 without friction.

    The largest force is searched again, at closely spaced times, around the maximum of the record:
    the force may have a kink there, at the start of slip.
    """
    found, run = list[float](), replace(run, asked=None)  # read at the solver's own times
    for number, contact in enumerate(run.plan.contacts if run.plan.oblique is not None else ()):
        if contact.friction is None:
            found.append(0.0)
            continue
        of = run.each_contact[number]
        assert of.friction_force is not None
        size = np.linalg.norm(of.friction_force, axis=1)
        top = int(size.argmax()) if len(size) else 0
        if run.recorder.dense and 0 < top < len(size) - 1:
            times = np.linspace(run.t[top - 1], run.t[top + 1], INSTANTS)
            near = run.at(times).each_contact[number].friction_force
            assert near is not None
            size = np.append(np.linalg.norm(near, axis=1), size[top])
        found.append(size.max(initial=0.0))
    return np.array(found)


def _tangential_restitution(run: Run) -> FloatArray:
    """Return the ratio of tangential velocities after and before contact.

    The velocities are of one body relative to the other, along the initial tangential direction.
    """
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
    """Return each body's spin after the last contact, rad/s; NaN for constrained bodies."""
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
        # Bodies held at rest have no rebound velocity, unless all are at rest.
        of_speeds=lambda of: np.where(of.still & ~of.still.all(axis=0), np.nan, of.after),
        each="bodies",
        least=lambda before: _LEAST * np.abs(before).max(axis=0),
        column=True,
        by_momentum=_of_bodies,
    ),
    Quantity(
        "restitution",
        "",
        of_speeds=_restitution,
        each="",
        least=lambda _: _LEAST,
        column=True,
        by_momentum=lambda run, momenta: (
            _of_bodies(run, momenta).sum(keepdims=True)
            / np.ptp(run.velocities_before[[of.body for of in run.plan.contacts[0].ports]])
        ),
    ),
    Quantity("peak_friction_force", "N", of_run=_friction_peaks, sliding=True),
    Quantity(
        "tangential_restitution",
        "",
        of_run=_tangential_restitution,
        each="",
        sliding=True,
        least=lambda _: _LEAST,
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

# Names that ``quantity=`` accepts in an impact and in a scene, and columns that a sweep keeps by
# default.
IMPACT_CHOICES = tuple(QUANTITIES)
SCENE_CHOICES = tuple(one.name for one in _ALL if one.scenes)
COLUMNS = tuple(one.name for one in _ALL if one.column)


def quantity_unit(name: str) -> str:
    """Return the unit of a number by its name; "" where none is known.

    The name may be dotted, and may end with a component of a vector: "bodies.0.final_spin.1".
    """
    *_, last = (part for part in name.split(".") if not part.isdigit())
    if last == "final_velocity":  # a vector, and not in `QUANTITIES`
        return "m/s"
    quantity = QUANTITIES.get(last)
    return "" if quantity is None or quantity.is_history else quantity.unit
