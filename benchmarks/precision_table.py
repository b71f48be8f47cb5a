"""Table of error against time, as text, figure and file."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING, Any

from scipy_solvers import Outcome

from aoimpact.base import (
    aligned,
    checked,
    choice,
    error_axes,
    given_axes,
    instances,
    positive,
    text,
    with_unit,
    write_csv,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Measurement:
    """Time and errors of one run.

    Attributes
    ----------
    method, setting : str
        E.g. "Newmark" and "dt=1e-08 s".
    seconds : float
        Shortest wall time of several calls, s.
    peak_force, contact_duration, rebound_velocity : float
        Relative errors of these results; the velocity's is relative to the initial velocity.
    failure : str
        Reason if the run failed and the numbers are NaN; else empty.
    """

    method: str
    setting: str
    seconds: float
    peak_force: float
    contact_duration: float
    rebound_velocity: float
    failure: str = ""

    @property
    def error(self) -> float:
        """Largest of the errors of peak force, contact duration and rebound velocity."""
        return max(self.peak_force, self.contact_duration, self.rebound_velocity)


@dataclass(frozen=True)
class Reference:
    """Reference that errors are relative to, and its uncertainty.

    Attributes
    ----------
    outcome : Outcome
        Peak force, N, duration of the first contact, s, and rebound velocity, m/s.
    source : str
        Method that gave the reference.
    uncertainty : float or None
        Largest relative uncertainty of the three: the change from a run with ten times the
        tolerance, or the difference from an independent method if that is larger.
    independent : float or None
        Difference from the independent method, if one was run.
    """

    outcome: Outcome
    source: str
    uncertainty: float | None = None
    independent: float | None = None

    def __str__(self) -> str:
        value = self.outcome
        text = (
            f"{self.source}: peak {value.peak_force:.12g} N, "
            f"contact {with_unit(value.contact_duration, 's', 11)}, "
            f"rebound {value.rebound_velocity:.11g} m/s"
        )
        if self.uncertainty is not None:
            text += f"; uncertain by {self.uncertainty:.1g}"
        if self.independent is not None:
            text += f" ({self.independent:.1g} from SciPy's DOP853)"
        return text


@dataclass(frozen=True, eq=False, repr=False)
class WorkPrecision:
    """A table of error against time.

    Attributes
    ----------
    scene : str
        Description of the impact.
    reference : Reference
    rows : tuple of Measurement
        Runs by method, in the order of the settings.
    """

    scene: str
    reference: Reference
    rows: tuple[Measurement, ...]

    def __post_init__(self) -> None:
        checked(self, scene=text, reference=(Reference,))
        checked(self, rows=partial(instances, kind=Measurement))

    @property
    def methods(self) -> tuple[str, ...]:
        """Names of the methods, in the order of the table."""
        return tuple(dict.fromkeys(row.method for row in self.rows))

    def fastest(self, method: str, error: float) -> Measurement | None:
        """Return the fastest run of a method with no error above `error`, or None."""
        choice("method", method, self.methods)
        limit = positive("error", error)
        good = [row for row in self.rows if row.method == method and row.error <= limit]
        return min(good, key=lambda row: row.seconds, default=None)

    def plot(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the largest error against time, both logarithmic; keywords go to ``Axes.plot``.

        The reference's own uncertainty is shaded. Returns the axes.
        """
        ax = given_axes(ax)
        known = self.reference.uncertainty
        least = math.inf if known is None else known
        for method in self.methods:
            rows = [row for row in self.rows if row.method == method and not row.failure]
            errors = [max(row.error, 1e-16) for row in rows]
            least = min(least, *errors) if errors else least
            style = {"marker": "o", "label": method} | kwargs
            ax.plot([1e3 * row.seconds for row in rows], errors, **style)
        ax.set_title(self.scene, fontsize="medium", wrap=True)
        if known:
            name = f"reference known to {known:.0e}"
            ax.axhspan(0.1 * least, known, color="0.9", zorder=0, label=name)
        errors_of = "largest relative error of\npeak, duration and rebound"
        return error_axes(ax, "time of the call (ms)", errors_of)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the table: one row per run, times in s, errors relative."""
        names = [field.name for field in fields(Measurement)]
        heading = [*names[:3], *(f"error of {name}" for name in names[3:6]), *names[6:]]
        write_csv(path, heading, ([getattr(row, name) for name in names] for row in self.rows))

    def __repr__(self) -> str:
        lines = aligned([_HEADINGS, *(_cells(row) for row in self.rows)], left={0, 1})
        failures = ["", *(row.failure for row in self.rows)]
        rows = [f"{line}  {why}".rstrip() for line, why in zip(lines, failures, strict=True)]
        return "\n".join([self.scene, str(self.reference), *rows, *self._comparisons()])

    def _comparisons(self) -> list[str]:
        """Return a line per error limit: the fastest run of each method, and ratios of times."""
        lines = []
        for error in (1e-3, 1e-6, 1e-9):
            best = [run for name in self.methods if (run := self.fastest(name, error))]
            best.sort(key=lambda run: run.seconds)
            entries = [
                f"{run.method} {with_unit(run.seconds, 's', 3)}"
                + (f" ({run.seconds / best[0].seconds:.2g} times)" if run is not best[0] else "")
                for run in best
            ]
            if entries:
                lines.append(f"fastest with errors up to {error:.0e}: {', '.join(entries)}")
        return lines


_HEADINGS = ("method", "setting", "time", "peak force", "contact duration", "rebound", "worst")


def _cells(row: Measurement) -> tuple[str, ...]:
    if row.failure:
        return (row.method, row.setting, *("-",) * 5)
    errors = (row.peak_force, row.contact_duration, row.rebound_velocity, row.error)
    return (
        row.method,
        row.setting,
        with_unit(row.seconds, "s", 3),
        *(f"{error:.1e}" for error in errors),
    )
