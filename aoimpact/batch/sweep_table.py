"""The table of a sweep: parameters and quantities by column, a row a case."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..accuracy import CONTROLLED
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
from ..contact import ContactPoint
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
        return pandas.DataFrame(self._filled())

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
        data = {
            name: (self.parameters, column.reshape(self.shape), {"units": quantity_unit(name)})
            for name, column in self._filled().items()
            if name not in self.parameters
        }
        return xarray.Dataset(data, coords=coordinates)

    def _filled(self) -> dict[str, npt.NDArray[Any]]:
        """All columns by name, and "error" where cases failed."""
        columns = {name: self.data[name] for name in self.columns}
        if self.errors:
            columns["error"] = np.full(len(self), "", dtype=object)
            for i, error in self.errors.items():
                columns["error"][i] = _message(error)
        return columns

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
        columns = self._filled()
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        write_csv(path, map(_heading, columns), (map(_text, row) for row in rows))

    def __repr__(self) -> str:
        shown, marked = [], False
        for name in self.columns:
            if name.endswith(CONTROLLED):
                continue
            values = self.data[name][:_SHOWN].tolist()
            cells = [f"{of:.6g}" if isinstance(of, float) else _text(of) for of in values]
            if name + CONTROLLED in self.columns:
                loose = self.data[name + CONTROLLED] == 0.0
                cells = [of + _MARK * int(loose[i]) for i, of in enumerate(cells)]
                marked = marked or bool(loose.any())
            shown.append([_heading(name), *cells])
        note = f"{len(self)} cases"
        if self.errors:
            first = min(self.errors)
            note += f", {len(self.errors)} failed; row {first}: {_message(self.errors[first])}"
        if marked:
            note += f"; {_MARK} not controlled: models were chosen for another number"
        more = ["..."] if len(self) > _SHOWN else []
        return "\n".join([*aligned(zip(*shown, strict=True)), *more, note])


def sweep_table(
    grid: Mapping[str, Sequence[Any]], values: Iterable[Any], names: Sequence[str]
) -> SweepTable:
    """Fill a table with what was kept of each combination of a grid, in its order.

    names: of the numbers that are kept, if they are known.

    Raises
    ------
    InputError, InputTypeError
        If what was kept is not the same numbers for every case, or names a parameter.
    """
    axes = np.meshgrid(*map(_column, grid.values()), indexing="ij")
    shape, count = axes[0].shape, axes[0].size
    columns: dict[str, npt.NDArray[Any]] = {}
    errors: dict[int, Exception] = {}
    for i, value in enumerate(values):
        if isinstance(value, Exception):
            errors[i] = value
            continue
        named = value if isinstance(value, Mapping) else {"value": value}
        try:
            numbers = {str(name): float(number) for name, number in named.items()}
        except (TypeError, ValueError):
            raise InputTypeError(
                f"keep must return a number, or a dict of numbers by name, got {value!r}"
            ) from None
        if columns and not names and numbers.keys() != columns.keys():
            raise InputError(
                f"keep must give the same names for every case: {', '.join(columns)}, then "
                f"{', '.join(numbers)}"
            )
        for name, number in numbers.items():
            if name not in columns:  # errors are known of some cases only
                columns[name] = np.full(count, math.nan)
            columns[name][i] = number
    for name in columns.keys() & grid.keys():
        raise InputError(f"keep: {name!r} is a parameter of the grid; give it another name")
    for name in () if columns else names or ("value",):  # all have failed
        columns[name] = np.full(count, math.nan)
    filled = {name: axis.ravel() for name, axis in zip(grid, axes, strict=True)} | columns
    data = np.empty(count, dtype=[(name, column.dtype) for name, column in filled.items()])
    for name, column in filled.items():
        data[name] = column
    return SweepTable(data, tuple(grid), tuple(columns), shape, errors)


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


def _message(error: Exception) -> str:
    return str(error) if isinstance(error, AOImpactError) else f"{type(error).__name__}: {error}"
