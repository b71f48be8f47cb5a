"""The table of a sweep: parameters and quantities by column, a row a case."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..accuracy import CONTROLLED, Named, keeper
from ..base import (
    AOImpactError,
    Frozen,
    InputError,
    InputTypeError,
    aligned,
    choice,
    given_axes,
    html_table,
    label,
    legend,
    optional_package,
    plain,
    scale_for,
    with_unit,
    write_csv,
)
from ..fem import ContactPoint
from ..results import quantity_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Rows of a printed table: what they hold is seen, and the note below stays on the screen. Lines of
# a plot that a legend names: more would cover it.
_SHOWN, _MOST_LINES = 10, 12

# Units of parameters of `simulate` that are numbers or vectors, for figures.
_PARAMETERS = {"velocity": "m/s", "spin": "rad/s", "gap": "m", "duration": "s"}

# Stands behind a number in a printed table that no tolerance controlled.
_MARK = "*"


@dataclass(frozen=True, eq=False, repr=False)
class SweepTable(Frozen):
    """Results of a sweep.

    Attributes
    ----------
    data : structured array, shape (cases,)
        Read-only; a field for each parameter and each quantity.
    parameters, quantities : tuple of str
        Names of the columns.
    shape : tuple of int
        Numbers of values of the parameters: a column reshaped to it is an array over the grid.
    errors : dict of int to exception
        By row that failed; its quantities are NaN. A number that does not exist is NaN as well: the
        restitution of bodies that have not parted.

    Examples
    --------
    >>> ball = ao.rigid(mass=0.1)
    >>> case = {"projectile": ball, "target": ball, "law": ao.Hertz(k=1e9), "duration": 1e-3}
    >>> table = ao.sweep(case, {"velocity": [0.5, 1.0], "gap": [0.0, 1e-4]}, keep=["peak_force"])
    >>> table.shape, bool(table.data["peak_force"][2] > table.data["peak_force"][0])
    ((2, 2), True)
    """

    data: npt.NDArray[Any]
    parameters: tuple[str, ...]
    quantities: tuple[str, ...]
    shape: tuple[int, ...]
    errors: Mapping[int, Exception]

    def __len__(self) -> int:
        return len(self.data)

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Return a column, shape (cases,)."""
        return self.data[choice("column", name, self.columns)]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all columns, parameters first."""
        return self.parameters + self.quantities

    def to_dataframe(self) -> Any:
        """Return a pandas DataFrame of all columns, and "error" where cases failed.

        Raises
        ------
        MissingPackageError
            If pandas is not installed.

        Examples
        --------
        >>> case = {"projectile": ao.rigid(mass=0.1), "target": ao.rigid(mass=0.1)}
        >>> case |= {"law": ao.Hertz(k=1e9), "duration": 1e-3}
        >>> table = ao.sweep(case, {"velocity": [0.5, 1.0]}, keep=["peak_force"])
        >>> frame = table.to_dataframe()  # with pandas
        """
        otherwise = "take .data, a structured array, or .to_csv(path)"
        pandas = optional_package("pandas", "to_dataframe", otherwise)
        columns = {name: self.data[name] for name in self.columns}
        if self.errors:
            told = [_message(self.errors.get(i)) for i in range(len(self))]
            columns["error"] = np.array(told, dtype=object)
        return pandas.DataFrame(columns)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write all columns, numbers so that they read back bit for bit, and "error" at the end.

        Examples
        --------
        >>> import tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> case = {"projectile": ao.rigid(mass=0.1), "target": ao.rigid(mass=0.1)}
        >>> case |= {"law": ao.Hertz(k=1e9), "duration": 1e-3}
        >>> table = ao.sweep(case, {"velocity": [0.5, 1.0]}, keep=["peak_force"])
        >>> table.to_csv(folder / "sweep.csv")
        """
        told = [[_message(self.errors.get(i))] if self.errors else [] for i in range(len(self))]
        heading = [*map(_heading, self.columns), *(["error"] if self.errors else [])]
        rows = zip(self.data, told, strict=True)
        write_csv(path, heading, ([*map(_text, row.item()), *error] for row, error in rows))

    def plot(
        self, x: str | None = None, y: str | None = None, ax: Axes | None = None, **kwargs: Any
    ) -> Axes:
        """Draw a quantity over a parameter, a line for each combination of the others.

        Parameters
        ----------
        x : str, optional
            A parameter of numbers; by default the first with more than one value.
        y : str, optional
            A quantity; by default the first.
        ax : Axes, optional
        **kwargs
            Go to ``Axes.plot``.

        Returns
        -------
        Axes

        Examples
        --------
        >>> case = {"projectile": ao.rigid(mass=0.1), "target": ao.rigid(mass=0.1)}
        >>> case |= {"law": ao.Hertz(k=1e9), "duration": 1e-3}
        >>> table = ao.sweep(case, {"velocity": [0.5, 1.0]}, keep=["peak_force"])
        >>> ax = table.plot()
        """
        along = self._along(x)
        name = self.quantities[0] if y is None else choice("y", y, self.quantities)
        ax = given_axes(ax)
        largest = np.abs(self[name][np.isfinite(self[name])]).max(initial=0.0)
        scale = scale_for(float(largest), quantity_unit(name))
        lines = self._lines(along, name)
        for named, values, heights in lines:
            style: dict[str, Any] = {"marker": "o", "markersize": 3, "label": named} | kwargs
            ax.plot(values, scale.factor * heights, **style)
        ax.set_xlabel(label(along.replace("_", " "), _PARAMETERS.get(along, "")))
        ax.set_ylabel(label(name.replace("_", " "), scale.unit))
        ax.grid(True, alpha=0.3)
        ax.margins(x=0.02)  # markers at both ends
        if 1 < len(lines) <= _MOST_LINES:
            legend(ax)
        return ax

    def _along(self, x: str | None) -> str:
        numeric = [name for name in self.parameters if self.data[name].dtype.kind in "iuf"]
        if not numeric:
            raise InputError("plot: no parameter of this sweep is a number; draw .data yourself")
        several = [n for n in numeric if self.shape[self.parameters.index(n)] > 1]
        return (several or numeric)[0] if x is None else choice("x", x, numeric)

    def _lines(self, along: str, name: str) -> list[tuple[str, Any, Any]]:
        """Label, x and y of each line, ascending in x."""
        axis = self.parameters.index(along)
        order = np.moveaxis(np.arange(len(self)).reshape(self.shape), axis, -1)
        others = [
            other for i, other in enumerate(self.parameters) if i != axis and self.shape[i] > 1
        ]
        lines = []
        for rows in order.reshape(-1, self.shape[axis]):
            named = ", ".join(_setting(other, self.data[other][rows[0]]) for other in others)
            rows = rows[np.argsort(self.data[along][rows], kind="stable")]
            lines.append((named, self.data[along][rows], self.data[name][rows]))
        return lines

    def _shown(self) -> list[list[str]]:
        """Headings, then the rows that are printed: numbers nobody controlled are marked."""
        names = [name for name in self.columns if not name.endswith(CONTROLLED)]
        rows = []
        for of in self.data[:_SHOWN]:
            row = dict(zip(self.columns, of.item(), strict=True))
            marks = [_MARK if row.get(name + CONTROLLED) == 0.0 else "" for name in names]
            shown = (f"{row[n]:.6g}" if isinstance(row[n], float) else _text(row[n]) for n in names)
            rows.append([cell + mark for cell, mark in zip(shown, marks, strict=True)])
        return [[_heading(name) for name in names], *rows]

    def _note(self) -> str:
        text = f"{len(self)} cases"
        if self.errors:
            first = min(self.errors)
            text += f", {len(self.errors)} failed; row {first}: {_message(self.errors[first])}"
        controlled = [self.data[name] for name in self.columns if name.endswith(CONTROLLED)]
        if any((column == 0.0).any() for column in controlled):
            text += f"; {_MARK} not controlled: models were chosen for another number"
        return text

    def __repr__(self) -> str:
        more = ["..."] if len(self) > _SHOWN else []
        return "\n".join([*aligned(self._shown()), *more, self._note()])

    def _repr_html_(self) -> str:
        headings, *rows = self._shown()
        return html_table(headings, rows, below=[self._note()])


def sweep_table(grid: Mapping[str, Sequence[Any]], values: Iterable[Any], keep: Any) -> SweepTable:
    """Fill a table with what was kept of each combination of a grid, in its order.

    Raises
    ------
    InputError, InputTypeError
        If what was kept is not the same numbers for every case, or names a parameter.
    """
    shape = tuple(len(entries) for entries in grid.values())
    kept = keeper(keep)
    names = kept.names if isinstance(kept, Named) else None
    columns: dict[str, npt.NDArray[np.float64]] = {}
    errors: dict[int, Exception] = {}
    for i, value in enumerate(values):
        if isinstance(value, Exception):
            errors[i] = value
            continue
        numbers = _numbers(value)
        if not columns or names is not None:  # errors are known of some cases only
            for name in numbers:
                columns.setdefault(name, np.full(math.prod(shape), math.nan))
        elif numbers.keys() != columns.keys():
            raise InputError(
                f"keep must give the same names for every case: {', '.join(columns)}, then "
                f"{', '.join(numbers)}"
            )
        for name, number in numbers.items():
            columns[name][i] = number
    if not columns:  # all have failed
        columns = {name: np.full(math.prod(shape), math.nan) for name in names or ("value",)}
    return SweepTable(_structured(grid, columns), tuple(grid), tuple(columns), shape, errors)


def _numbers(value: Any) -> dict[str, float]:
    named = value if isinstance(value, Mapping) else {"value": value}
    try:
        return {str(name): float(number) for name, number in named.items()}
    except (TypeError, ValueError):
        raise InputTypeError(
            f"keep must return a number, or a dict of numbers by name, got {value!r}"
        ) from None


def _structured(
    grid: Mapping[str, Sequence[Any]], columns: Mapping[str, npt.NDArray[np.float64]]
) -> npt.NDArray[Any]:
    for name in columns:
        if name in grid:
            raise InputError(f"keep: {name!r} is a parameter of the grid; give it another name")
    axes = {name: _column(entries) for name, entries in grid.items()}
    places = np.indices([len(axis) for axis in axes.values()]).reshape(len(axes), -1)
    filled = {name: axis[i] for (name, axis), i in zip(axes.items(), places, strict=True)}
    filled |= columns
    kinds = [(name, column.dtype) for name, column in filled.items()]
    data = np.empty(places.shape[1], dtype=kinds)
    for name, column in filled.items():
        data[name] = column
    return data


def _column(values: Sequence[Any]) -> npt.NDArray[Any]:
    """Numbers as numbers, text as text, anything else as the objects themselves."""
    single = (bool, int, float, str, np.generic)
    kinds = {np.asarray(one).dtype.kind if isinstance(one, single) else "O" for one in values}
    if kinds <= set("iuf") or kinds in ({"b"}, {"U"}):
        return np.array(values)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column


def _heading(name: str) -> str:
    unit = quantity_unit(name)
    return f"{name} [{unit}]" if unit else name


def _text(value: Any) -> str:
    """All digits of numbers; of bodies and the like what they call themselves."""
    if isinstance(value, (bool, int, float, str)):
        return str(value)
    if isinstance(value, ContactPoint) and value.point is not None:
        return f"{value.name or 'a body'} at {plain(value.point)} m"
    return str(getattr(value, "label", value))


def _setting(name: str, value: Any) -> str:
    """A parameter's value as a legend says it."""
    unit = _PARAMETERS.get(name)
    if unit is None:
        return f"{name} = {_text(value)}"
    if np.ndim(value):
        return f"{name} = {plain(np.asarray(value, dtype=np.float64))} {unit}"
    return f"{name} = {with_unit(float(value), unit)}"


def _message(error: Exception | None) -> str:
    if error is None:
        return ""
    return str(error) if isinstance(error, AOImpactError) else f"{type(error).__name__}: {error}"
