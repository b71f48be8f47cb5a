"""The table of a sweep: parameters and quantities by column, a row a case."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

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
    optional_package,
    plain,
    write_csv,
)
from ..fem import ContactPoint
from ..results import quantity_unit

# Rows of a printed table: what they hold is seen, and the note below stays on the screen.
_SHOWN = 10

_OTHERWISE = "take .data, a structured array, or .to_csv(path)"

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

    def to_pandas(self) -> Any:
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
        >>> frame = table.to_pandas()  # with pandas
        """
        pandas = optional_package("pandas", "to_pandas", _OTHERWISE)
        columns = {name: self.data[name] for name in self.columns}
        if self.errors:
            columns["error"] = self._messages()
        return pandas.DataFrame(columns)

    def to_xarray(self) -> Any:
        """Return an xarray Dataset: quantities over the parameters, which are its dimensions.

        Each quantity has its unit as attribute "units"; "error" is there where cases failed.

        Raises
        ------
        MissingPackageError
            If xarray is not installed.

        Examples
        --------
        >>> case = {"projectile": ao.rigid(mass=0.1), "target": ao.rigid(mass=0.1)}
        >>> case |= {"law": ao.Hertz(k=1e9), "duration": 1e-3}
        >>> table = ao.sweep(case, {"velocity": [0.5, 1.0]}, keep=["peak_force"])
        >>> data = table.to_xarray()  # with xarray
        """
        xarray = optional_package("xarray", "to_xarray", _OTHERWISE)
        coordinates = {
            name: (name, np.moveaxis(self.data[name].reshape(self.shape), i, -1).ravel()[:count])
            for i, (name, count) in enumerate(zip(self.parameters, self.shape, strict=True))
        }
        data: dict[str, Any] = {}
        for name in self.quantities:
            values = self.data[name].reshape(self.shape)
            data[name] = self.parameters, values, {"units": quantity_unit(name)}
        if self.errors:
            data["error"] = self.parameters, self._messages().reshape(self.shape)
        return xarray.Dataset(data, coords=coordinates)

    def _messages(self) -> npt.NDArray[Any]:
        """Failure messages by row."""
        return np.array([_message(self.errors.get(i)) for i in range(len(self))], dtype=object)

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
        heading = [*map(_heading, self.columns), *(["error"] if self.errors else [])]
        told = self._messages()[:, None].tolist() if self.errors else [[]] * len(self)
        rows = zip(self.data, told, strict=True)
        write_csv(path, heading, ([*map(_text, row.item()), *error] for row, error in rows))

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


def _message(error: Exception | None) -> str:
    if error is None:
        return ""
    return str(error) if isinstance(error, AOImpactError) else f"{type(error).__name__}: {error}"
