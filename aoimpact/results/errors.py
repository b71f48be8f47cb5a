"""The relative errors of a run's numbers and histories, split by their sources."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from ..base import PRINTED, InputError, nearest, text


@dataclass(frozen=True, eq=False)
class Chosen:
    """The quantities of interest that a run's models were chosen for, and the models' errors.

    Attributes
    ----------
    quantities : mapping of str to (str, float)
        Unit and, for a history, its largest value over the record; NaN for a number.
    rtol : float
        Relative tolerance of each quantity of interest.
    numbers : mapping of str to float
        Estimated relative errors due to the models, of the quantities of interest and of each
        number of the run.
    """

    quantities: Mapping[str, tuple[str, float]]
    rtol: float
    numbers: Mapping[str, float]


@dataclass(frozen=True)
class LeftOut:
    """Relative errors of a run from its meshes and its contact laws; empty where not known.

    Attributes
    ----------
    mesh : mapping of str to float
        Error from finite elements that are too stiff, by the name of the number or history.
    contact : mapping of str to float
        Error from contacts whose width changes and, for a law found from the surfaces, from
        inexact curvatures.
    worst_time : float or None
        Time at which the history of interest has the largest error from mesh and contact, s.
    """

    mesh: Mapping[str, float] = field(default_factory=dict, hash=False)
    contact: Mapping[str, float] = field(default_factory=dict, hash=False)
    worst_time: float | None = None


@dataclass(frozen=True)
class ErrorParts:
    """Relative error of one number or history, split by sources; None for an unknown part.

    Errors of a history are relative to its largest value. Errors of a rebound velocity are relative
    to at least a tenth of the initial velocity, errors of a restitution to at least 0.1.

    Attributes
    ----------
    mesh : float or None
        Error from finite elements that are too stiff, at the contacts and in the whole bodies.
    contact : float or None
        Error from a contact whose width changes, from inexact curvatures, and from the section of a
        beam, which deforms less between contact and axis than the law's half-space.
    model : float or None
        Error from representing the bodies by fewer degrees of freedom.
    time : float or None
        Error of the integration in time.

    Examples
    --------
    >>> error = ErrorParts(mesh=0.004, contact=0.005, model=0.03, time=1e-5)
    >>> round(error.total, 5)
    0.03901
    >>> print(error)
    3.9 % (mesh 0.4, contact 0.5, model 3, time 0.001)
    """

    mesh: float | None = None
    contact: float | None = None
    model: float | None = None
    time: float | None = None

    @property
    def _sources(self) -> dict[str, float | None]:
        return {"mesh": self.mesh, "contact": self.contact, "model": self.model, "time": self.time}

    @property
    def total(self) -> float:
        """Sum of the parts; NaN if a part is not known. The sum of the known parts is `least`.

        The sum is also NaN for a number that does not exist, such as the restitution of bodies that
        have not parted.
        """
        return math.nan if self.unknown else self.least

    @property
    def least(self) -> float:
        """Sum of the parts that are known."""
        return sum(part or 0.0 for part in self._sources.values())

    @property
    def unknown(self) -> tuple[str, ...]:
        """Names of the parts that are not known."""
        return tuple(name for name, part in self._sources.items() if part is None)

    def listed(self) -> str:
        """Return text with the parts in percent, and the names of unknown parts.

        :meta private:
        """
        *others, last = self.unknown or ("",)
        missing = f"{', '.join(others)}{' and ' if others else ''}{last} not known"
        parts = [f"{of} {percent(by)}" for of, by in self._sources.items() if by is not None]
        return ", ".join([missing, *parts] if last else parts)

    def bound(self) -> str:
        """Return the error as text, in percent; "at least" the known parts if a part is not known.

        :meta private:
        """
        least = percent(self.least)
        at_least = "at least " if self.unknown and least[0].isdigit() else ""
        return f"{at_least}{least}{' %' if least[0].isdigit() else ''}"

    def __str__(self) -> str:
        return f"{self.bound()} ({self.listed()})"


@dataclass(frozen=True, repr=False)
class ErrorEstimate(ErrorParts):
    """Relative errors of a run, such as ``error["restitution"].total``, by the number's name.

    ``error.mesh``, ``.contact``, ``.model``, ``.time`` and ``.total`` are the errors of the first
    quantity of interest, or of the force if none was given. The tolerance bounds only the `model`
    errors of the quantities of interest; all other errors are only estimated. Iteration yields the
    names.

    Attributes
    ----------
    parts : mapping of str to ErrorParts
        Errors by the name of the number: "restitution" or, in a scene, "contacts.0.impulse".
    energy : float or None
        Range of the total energy over the record, relative to the largest sum of kinetic, elastic
        and contact energy. No solver uses this range, so it is an independent check of the run.
    quantity : str or None
        First quantity of interest; None if none was given.
    rtol : float or None
        Relative tolerance of the quantities of interest.
    worst_time : float or None
        Time at which the history of interest has the largest error from mesh and contact, s.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
    >>> alu = ao.Material(70e9, 0.3, 2700)
    >>> bar = ao.FEModel.from_mesh(mesh, alu, fixed=[("xmin", "xyz")])
    >>> tip = bar.contact(point=(0.05, 0.005, 0.01))
    >>> hit = ao.simulate(ao.ball(0.005, alu), tip, velocity=0.1)
    >>> hit.error.total == hit.error["force"].total > hit.error["force"].model > 0.0
    True
    >>> "restitution" in hit.error
    True
    """

    parts: Mapping[str, ErrorParts] = field(default_factory=dict, hash=False)
    energy: float | None = None
    quantity: str | None = None
    rtol: float | None = None
    worst_time: float | None = None

    def __getitem__(self, name: str) -> ErrorParts:
        if (found := self.parts.get(text("name", name))) is None:
            raise InputError(f"error: the run has no number {name!r}{suggestion(name, self.parts)}")
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self.parts)

    def __repr__(self) -> str:
        energy = "None" if self.energy is None else f"{self.energy:.3g}"
        return (
            f"ErrorEstimate({self.quantity or 'force'}: {self.bound()} ({self.listed()}), "
            f"energy={energy}); error[name] of each other number"
        )

    __str__ = __repr__


def percent(share: float | None) -> str:
    """Return a relative error in percent with two digits, without the percent sign."""
    if share is None:
        return "not known"
    if math.isnan(share):
        return "none"
    if math.isinf(share):
        return "not bounded"
    digits = f"{100.0 * share:.2g}" if share >= PRINTED else "0"
    return f"{float(digits):.0f}" if 1.0 <= share < 1e3 else digits  # as 120, not 1.2e+02


def suggestion(name: str, names: Iterable[str]) -> str:
    """Return text that suggests a name of the same quantity, or else the nearest name."""
    quantity = name.rpartition(".")[2]
    same = [one for one in names if one.rpartition(".")[2] == quantity]
    return f": take {same[0]!r}" if same else nearest(name, names)
