"""A table of models of one impact: what each costs and how wrong it is; its text, figure, file."""

from __future__ import annotations

import csv
import html
import os
from dataclasses import astuple, dataclass, fields
from typing import TYPE_CHECKING, Any

from .units import quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Compared", "Comparison"]


@dataclass(frozen=True)
class Compared:
    """One pair of models.

    Attributes
    ----------
    model : str
        "rigid", "AO(3)", "modal(40)", "full".
    dofs : int
        Of both bodies.
    build, run : float
        Time to make the models, from the finite elements on, and to run them, s.
    force, duration, impulse, displacement : float
        Relative errors; of force and of the target's contact displacement the largest over the
        record, relative to the largest value.
    failure : str
        Why there are no numbers (then they are NaN); else empty.
    """

    model: str
    dofs: int
    build: float
    run: float
    force: float
    duration: float
    impulse: float
    displacement: float
    failure: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Models of one impact.

    Attributes
    ----------
    scene : str
        What was simulated.
    exact : str
        The model that the errors are relative to.
    exact_error : float or None
        What is known of its own error from time integration, relative.
    rows : tuple of Compared
    """

    scene: str
    exact: str
    exact_error: float | None
    rows: tuple[Compared, ...]

    def __getitem__(self, model: str) -> Compared:
        """Return the row of a model, such as "AO(3)"."""
        for row in self.rows:
            if row.model == model:
                return row
        raise KeyError(model)

    def plot(self, ax: Axes | None = None, *, error: str = "force", **kwargs: Any) -> Axes:
        """Draw an error over the degrees of freedom; keywords go to ``Axes.plot``.

        Parameters
        ----------
        ax : Axes, optional
        error : {"force", "duration", "impulse", "displacement"}, optional

        Returns
        -------
        Axes
        """
        import matplotlib.pyplot as plt

        if ax is None:
            ax = plt.subplots(layout="constrained")[1]
        for kind, name in (
            ("AO", "anti-oscillators"),
            ("modal", "natural modes"),
            ("rigid", "rigid"),
        ):
            rows = [
                row
                for row in self.rows
                if row.model.startswith(kind) and not row.failure and row.model != self.exact
            ]
            if rows:
                style = {"marker": "o", "label": name} | kwargs
                ax.plot([row.dofs for row in rows], [getattr(row, error) for row in rows], **style)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlabel("degrees of freedom")
        ax.set_ylabel(f"relative error of the {error}")
        ax.grid(True, which="major", alpha=0.3)
        ax.legend()
        return ax

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the table: one row a model, times in s, errors relative."""
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow([field.name for field in fields(Compared)])
            writer.writerows(astuple(row) for row in self.rows)

    def __repr__(self) -> str:
        table = [_HEADINGS, *(_cells(row) for row in self.rows)]
        widths = [max(len(line[i]) for line in table) for i in range(len(_HEADINGS))]
        lines = [self.scene, self._reference()]
        for line, failure in zip(table, ["", *(row.failure for row in self.rows)], strict=True):
            first, *rest = (cell.rjust(width) for cell, width in zip(line, widths, strict=True))
            text = "  ".join([first.strip().ljust(widths[0]), *rest])
            lines.append((text + ("  " + failure if failure else "")).rstrip())
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{html.escape(name)}</th>" for name in (*_HEADINGS, ""))
        body = "".join(
            "<tr>"
            + "".join(f"<td>{html.escape(cell)}</td>" for cell in (*_cells(row), row.failure))
            + "</tr>"
            for row in self.rows
        )
        title = f"{html.escape(self.scene)}<br>{html.escape(self._reference())}"
        return (
            f"<table><caption>{title}</caption><thead><tr>{head}</tr></thead>"
            f"<tbody>{body}</tbody></table>"
        )

    def _reference(self) -> str:
        known = "" if self.exact_error is None else f" (in time right to {self.exact_error:.1g})"
        return f"errors relative to {self.exact}{known}"


_KINDS = {"rigid": "rigid", "AO": "anti-oscillators", "modal": "natural modes"}

_HEADINGS = ("model", "dofs", "build", "run", "force", "duration", "impulse", "displacement")


def _cells(row: Compared) -> tuple[str, ...]:
    if row.failure:
        return (row.model, *("-",) * 7)
    errors = (row.force, row.duration, row.impulse, row.displacement)
    return (
        row.model,
        str(row.dofs),
        quantity(row.build, "s", 3),
        quantity(row.run, "s", 3),
        *(f"{error:.1e}" for error in errors),
    )
