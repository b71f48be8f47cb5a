"""Sweeps: one case for each combination of named parameters, and a table of their results."""

from __future__ import annotations

import itertools
import math
import os
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..accuracy import Named, keeper
from ..base import (
    AOImpactError,
    FilePath,
    Frozen,
    InputError,
    InputTypeError,
    aligned,
    choice,
    optional_package,
    plain,
    require,
    sequence,
    text,
    write_csv,
)
from ..contact import ContactPoint
from ..impact import simulate
from ..results import COLUMNS, quantity_unit
from ..scenefile import SceneFile, read_scene
from .many import check_keywords, run_cases

Column = NDArray[Any]

# Memory per number in the table, bytes: 8 in its column and 8 in the structured array.
_BYTES_PER_NUMBER = 16.0

# Maximum number of rows in a printed table: with few rows, the note below stays on the screen.
_SHOWN = 10

_OTHERWISE = "take .data, a structured array, or .to_csv(path)"


@dataclass(frozen=True, eq=False, repr=False)
class SweepTable(Frozen):
    """Results of a sweep.

    Attributes
    ----------
    data : structured array, shape (cases,)
        Read-only table of the values, with a field for each parameter and each quantity.
    parameters, quantities : tuple of str
        Names of the columns.
    shape : tuple of int
        Number of values of each parameter. A column reshaped to this shape has one axis per
        parameter.
    errors : dict of int to exception
        Exceptions of failed cases by row; quantities in these rows are NaN. Quantities that do not
        exist are NaN as well, such as the restitution of bodies that have not separated.

    Examples
    --------
    >>> ball = ao.rigid(mass=0.1)
    >>> case = {"projectile": ball, "target": ball, "law": ao.Hertz(k=1e9), "duration": 1e-3}
    >>> table = ao.sweep(case, {"velocity": [0.5, 1.0], "gap": [0.0, 1e-4]}, keep=["peak_force"])
    >>> table.shape, bool(table.data["peak_force"][2] > table.data["peak_force"][0])
    ((2, 2), True)
    """

    data: Column
    parameters: tuple[str, ...]
    quantities: tuple[str, ...]
    shape: tuple[int, ...]
    errors: Mapping[int, Exception]

    def __len__(self) -> int:
        return len(self.data)

    def __getitem__(self, name: str) -> Column:
        """Return a column, shape (cases,)."""
        return self.data[choice("column", name, self.columns)]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all columns, parameters first."""
        return self.parameters + self.quantities

    def _filled(self) -> dict[str, Column]:
        """Return all columns by name, with a column "error" of messages if cases failed."""
        columns = {name: self.data[name] for name in self.columns}
        if self.errors:
            columns["error"] = np.full(len(self), "", dtype=object)
            for i, error in self.errors.items():
                columns["error"][i] = _message(error)
        return columns

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame of all columns, with a column "error" if cases failed.

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
        """Return an xarray Dataset of the quantities; its dimensions are the parameters.

        Each quantity has its unit as attribute "units". If cases failed, a variable "error" has the
        messages.

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

    def to_csv(self, path: FilePath) -> None:
        """Write all columns, and "error" if cases failed; numbers are written without rounding.

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
        shown = [
            [_heading(name), *(_text(of, "{:.6g}") for of in self.data[name][:_SHOWN].tolist())]
            for name in self.columns
        ]
        note = f"{len(self)} cases"
        if self.errors:
            first = min(self.errors)
            note += f", {len(self.errors)} failed; row {first}: {_message(self.errors[first])}"
        more = ["..."] if len(self) > _SHOWN else []
        return "\n".join([*aligned(zip(*shown, strict=True)), *more, note])


def sweep(
    base: Any,
    grid: Mapping[str, Iterable[Any]],
    *,
    keep: Any = COLUMNS,
    workers: Any = 1,
    checkpoint: FilePath | None = None,
    key: str | None = None,
    progress: bool = True,
) -> SweepTable:
    """Simulate every combination of parameter values, and return a table of numbers.

    Parameters
    ----------
    base : function, dict, scene file or scene
        One of: a function that takes the parameters as keywords and returns a case of
        `simulate_many`; a dict of `simulate`'s keywords, to which the parameters are added; a scene
        file or its path, with parameters named by their dotted place in the file, such as
        "velocity" (of its impact) or "bodies.beam.contact.point"; a scene, with keywords of its
        ``simulate`` as parameters.
    grid : mapping of str to sequence
        Values of each parameter; the last one varies fastest.
    keep : names or function, optional
        Quantities for the columns, as in `simulate_many`. If models are chosen, there are two
        more columns for a quantity with an estimated error: "restitution_error", and
        "restitution_controlled": 1 if the error is within the tolerance, 0 if it was not
        controlled. A function returns a number, or a dict of numbers with the same names for every
        result.
    workers, checkpoint, key, progress : optional
        As in `simulate_many`. Cases are made in this process, one by one.

    Returns
    -------
    SweepTable
        One row per combination; NaN if a case failed, with its exception in ``.errors``, or if a
        number does not exist.

    Raises
    ------
    InputError, InputTypeError
        If a parameter has no values, or the base has no such parameter.
    MemoryLimitError
        If the table of so many cases would not fit into memory; nothing is simulated then.

    Examples
    --------
    >>> import aoimpact as ao
    >>> base = dict(projectile=ao.rigid(mass=0.03), target=ao.rigid(mass=float("inf")),
    ...             law=ao.Hertz(k=1e10), duration=1e-3)
    >>> table = ao.sweep(base, {"velocity": [0.5, 1.0, 2.0]}, keep="restitution")
    >>> [round(float(e), 6) for e in table["restitution"]]
    [1.0, 1.0, 1.0]
    """
    checked = _checked_grid(grid)
    kept = keeper(keep)
    if kept is None:
        raise InputTypeError(
            "keep=None: a table holds numbers; name some, or take simulate_many for whole results"
        )
    cases: Iterable[Any] = _cases(_maker(base, checked), checked)
    names = kept.names if isinstance(kept, Named) else ()
    sizes = [len(values) for values in checked.values()]
    count, columns = math.prod(sizes), len(checked) + max(len(names), 1)
    require(
        _BYTES_PER_NUMBER * columns * float(count),
        f"a table of {' x '.join(map(str, sizes))} = {count:.4g} cases and {columns} columns",
        "give fewer values, or sweep over parts of the grid, each with its own to_csv",
    )
    values = run_cases(cases, count, workers, kept, checkpoint, key, progress)
    return _table(checked, values, names)


def sweep_file(
    scene: SceneFile, *, workers: Any = None, checkpoint: FilePath | None = None
) -> SweepTable:
    """Run the sweep that a scene file describes.

    Parameters
    ----------
    scene : SceneFile
        Scene file with a [sweep].
    workers, checkpoint : optional
        As in `sweep`; by default as given in the file. A path in the file is relative to the
        file's folder.

    Raises
    ------
    InputError
        If the file has no sweep, or every case of it fails.
    """
    settings = scene.data.get("sweep", {})
    if checkpoint is None and "checkpoint" in settings:
        checkpoint = scene.path.parent / settings["checkpoint"]
    table = sweep(
        scene,
        scene.grid,
        keep=scene.swept,
        workers=settings.get("workers", 1) if workers is None else workers,
        checkpoint=checkpoint,
    )
    if len(table.errors) == len(table):
        raise InputError(f"{scene.path}: every case of the sweep failed: {table.errors[0]}")
    return table


def _checked_grid(grid: Any) -> dict[str, list[Any]]:
    if not isinstance(grid, Mapping):
        raise InputTypeError(
            f'grid must be a dict such as {{"velocity": [0.5, 1.0]}}, got {type(grid).__name__}'
        )
    checked = {
        text("grid: the name of a parameter", name): sequence(f"grid[{name!r}]", values)
        for name, values in grid.items()
    }
    empty = next((f"[{name!r}]" for name, values in checked.items() if not values), "")
    if empty or not checked:
        raise InputError(f"grid{empty} has no values: there is nothing to sweep over")
    return checked


def _cases(make: Any, grid: Mapping[str, Sequence[Any]]) -> Iterator[Any]:
    """Yield each case, made on demand, or the exception if the case cannot be made."""
    for values in itertools.product(*grid.values()):
        try:
            yield make(**dict(zip(grid, values, strict=True)))
        except Exception as error:
            yield error


def _maker(base: Any, grid: Mapping[str, Sequence[Any]]) -> Any:
    """Return the function that makes a case from values of the parameters; refuse unknown names."""
    if isinstance(base, (str, os.PathLike)):
        base = read_scene(base)
    if isinstance(base, SceneFile):
        first = {name: values[0] for name, values in grid.items()}
        base.replaced(first)  # raises an error for an unknown place
        return lambda **parameters: base.replaced(parameters).case()
    if isinstance(base, Mapping):
        check_keywords("base and grid", simulate, [*grid, *base])
        return lambda **parameters: {**base, **parameters}
    if hasattr(base, "simulate"):
        check_keywords("grid", base.simulate, grid)
        return lambda **keywords: (base, keywords)
    if callable(base):
        return base
    raise InputTypeError(
        "base: sweep needs a function, a dict of simulate's keywords, a scene file or a scene, "
        f"got {base!r}"
    )


def _table(
    grid: Mapping[str, Sequence[Any]], values: Iterable[Any], names: Sequence[str]
) -> SweepTable:
    """Return the table of the kept values of all combinations in a grid, in the grid's order.

    `names`: names of the kept numbers, if they are known.

    Raises
    ------
    InputError, InputTypeError
        If cases have numbers of different names, or a number has the name of a parameter.
    """
    axes = np.meshgrid(*map(_column, grid.values()), indexing="ij")
    shape, count = axes[0].shape, axes[0].size
    # Columns are filled with NaN first, since only some cases have estimated errors.
    columns = defaultdict[str, Column](lambda: np.full(count, math.nan))
    errors: dict[int, Exception] = {}
    for i, value in enumerate(values):
        if isinstance(value, Exception):
            errors[i] = value
            continue
        named = value if isinstance(value, Mapping) else {"value": value}
        if columns and not names and named.keys() != columns.keys():
            raise InputError(
                f"keep must give the same names for every case: {', '.join(columns)}, then "
                f"{', '.join(map(str, named))}"
            )
        for name, number in named.items():
            try:
                columns[name][i] = float(number)
            except (TypeError, ValueError):
                raise InputTypeError(
                    f"keep must return a number, or a dict of numbers by name, got {value!r}"
                ) from None
    for name in columns.keys() & grid.keys():
        raise InputError(f"keep: {name!r} is a parameter of the grid; give it another name")
    for name in () if columns else names or ("value",):  # if all cases have failed
        columns[name][:] = math.nan
    filled = {name: axis.ravel() for name, axis in zip(grid, axes, strict=True)} | columns
    data = np.empty(count, dtype=[(name, column.dtype) for name, column in filled.items()])
    for name, column in filled.items():
        data[name] = column
    return SweepTable(data, tuple(grid), tuple(columns), shape, errors)


def _column(values: Sequence[Any]) -> Column:
    """Return an array of numbers or text; an array of objects for any other values."""
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


def _text(value: Any, digits: str = "{}") -> str:
    """Return a number as text in the format `digits`, and an object as its label or place."""
    if isinstance(value, float):
        return digits.format(value)
    if isinstance(value, ContactPoint) and value.point is not None:
        return f"{value.name or 'a body'} at {plain(value.point)} m"
    return str(getattr(value, "label", value))


def _message(error: Exception) -> str:
    return str(error) if isinstance(error, AOImpactError) else f"{type(error).__name__}: {error}"
