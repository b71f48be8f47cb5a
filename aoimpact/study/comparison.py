"""A table of models of one impact: what each costs and how wrong it is; its text, figure, file."""

from __future__ import annotations

import os
from dataclasses import astuple, dataclass, fields
from typing import TYPE_CHECKING, Any

from ..base import (
    aligned,
    error_axes,
    given_axes,
    html_table,
    with_unit,
    write_csv,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Compared:
    """One pair of models.

    Attributes
    ----------
    model : str
        "rigid", "AO(3)", "modal(40)", "full", or the label of another target.
    dofs : int
        Degrees of freedom of both bodies.
    build, run : float
        Time to make the models, from the finite elements on, and to run them, s.
    force, contact_duration, impulse, displacement : float
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
    contact_duration: float
    impulse: float
    displacement: float
    failure: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Models of one impact.

    Attributes
    ----------
    scene : str
        The impact.
    exact : str
        The model that the errors are relative to.
    exact_error : float or None
        Its own relative error of time integration, as far as it is known.
    rows : tuple of Compared
    linear_solver : str
        Linear solver of the reduced models; empty for dense matrices.

    Examples
    --------
    >>> sphere = ao.AOModel(m0=3e-5, k0=0.0, m=[0.033], k=[2.8e8])
    >>> table = ao.compare(projectile=sphere, target=sphere, law=ao.Hertz(k=1e10), velocity=1.0,
    ...                    duration=1e-4, oscillators=(0, 1), modes=(), full=False)
    >>> [row.model for row in table.rows], round(table["rigid"].force, 1)
    (['rigid', 'AO(0)', 'AO(1)'], 0.4)
    """

    scene: str
    exact: str
    exact_error: float | None
    rows: tuple[Compared, ...]
    linear_solver: str = ""

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
        error : {"force", "contact_duration", "impulse", "displacement"}, optional

        Returns
        -------
        Axes

        Examples
        --------
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> table = ao.compare(
        ...     projectile=ao.rigid(mass=0.01), target=tip, law=ao.Linear(k=1e5), velocity=1.0,
        ...     duration=1e-3, oscillators=(0, 1, 2), modes=(), full=False,
        ... )
        >>> ax = table.plot()
        """
        ax = given_axes(ax)
        others = {row.model: row.model for row in self.rows if not row.model.startswith(_MODELS)}
        for kind, name in (_KINDS | others).items():
            rows = [
                row
                for row in self.rows
                if row.model.startswith(kind) and not row.failure and row.model != self.exact
            ]
            if rows:
                style = {"marker": "o", "label": name} | kwargs
                ax.plot([row.dofs for row in rows], [getattr(row, error) for row in rows], **style)
        return error_axes(
            ax, "degrees of freedom", f"relative error of the {error}".replace("_", " ")
        )

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the table: one row a model, times in s, errors relative.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1), kind="hexahedron20")
        >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(70e9, 0.3, 2700), fixed=[("xmin", "xyz")])
        >>> tip = bar.contact(point=(0.09, 0.005, 0.01), radius=0)
        >>> table = ao.compare(
        ...     projectile=ao.rigid(mass=0.01), target=tip, law=ao.Linear(k=1e5), velocity=1.0,
        ...     duration=1e-3, oscillators=(0, 1, 2), modes=(), full=False,
        ... )
        >>> table.to_csv(folder / "models.csv")
        """
        heading = [field.name for field in fields(Compared)]
        write_csv(path, heading, (astuple(row) for row in self.rows))

    def __repr__(self) -> str:
        rows = aligned([_HEADINGS, *map(_cells, self.rows)], left={0, len(_HEADINGS) - 1})
        return "\n".join([self.scene, self._reference(), *rows])

    def _repr_html_(self) -> str:
        caption = self.scene, self._reference()
        return html_table(_HEADINGS, map(_cells, self.rows), caption=caption)

    def _reference(self) -> str:
        known = "" if self.exact_error is None else f" (in time right to {self.exact_error:.1g})"
        by = f"; reduced by {self.linear_solver}" if self.linear_solver else ""
        return f"errors relative to {self.exact}{known}{by}"


_KINDS = {"AO(": "anti-oscillators", "modal(": "natural modes", "rigid": "rigid"}
_MODELS = (*_KINDS, "full")

# Failures need no heading.
_HEADINGS = (*(field.name.replace("_", " ") for field in fields(Compared)[:-1]), "")


def _cells(row: Compared) -> tuple[str, ...]:
    """Format the row; the last cell is the failure message."""
    model, dofs, build, run, *errors, failure = astuple(row)
    if failure:
        return (model, *("-",) * 7, failure)
    times = with_unit(build, "s", 3), with_unit(run, "s", 3)
    return (model, str(dofs), *times, *(f"{error:.1e}" for error in errors), "")
