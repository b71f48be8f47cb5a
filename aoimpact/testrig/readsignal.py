"""Signals from the text files of data loggers."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Sequence

import numpy as np

from ..base import InputError, InputTypeError, choice, decoded, file_path, nearest, text
from .signal import STANDARD_GRAVITY, Signal

# SI units of signals, with how else they are written; and what has no prefix.
_BASES = {"N": "N", "s": "s", "m/s²": "m/s²", "m/s2": "m/s²", "m/s^2": "m/s²", "m": "m", "V": "V"}
_BASES |= {"m/s": "m/s"}
_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6}
_OTHERS = {"g": (STANDARD_GRAVITY, "m/s²"), "lbf": (4.4482216152605, "N")}

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def read_signal(
    path: str | os.PathLike[str],
    *,
    time: int | str = 0,
    values: int | str = 1,
    time_unit: str = "s",
    unit: str = "N",
    decimal: str = ".",
    name: str = "force",
) -> Signal:
    """Read a signal from a text file of columns, as data loggers write it.

    Columns are separated by the first of semicolons, tabs, commas (unless they are decimal marks)
    and spaces that the last line has; cells may be quoted. Lines before the first one with numbers
    in both columns are headings; other columns may hold anything.

    Parameters
    ----------
    path : path
    time, values : int or str, optional
        Columns, by number from 0 or by the heading (without the unit will do).
    time_unit : str, optional
        Unit of the times in the file: "s", "ms", "µs" (or "us").
    unit : str, optional
        Unit of the values in the file: "N", "kN", "lbf", "m/s", "m/s²", "g", "mm", ….
    decimal : {".", ","}, optional
        Decimal mark of the numbers, which have no separators of thousands.
    name : str, optional
        Name on axes and in messages.

    Returns
    -------
    Signal
        In SI units.

    Raises
    ------
    InputError
        If the file cannot be read; if a line after the first row has no number in one of the
        columns, or more or fewer cells than that row; or if times do not rise. The message has the
        line.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> text = "time [ms];force [kN]\\n0,0;0,0\\n0,1;1,5\\n0,2;0,3\\n"
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "drop.csv"
    ...     _ = file.write_text(text)
    ...     signal = read_signal(file, time_unit="ms", unit="kN", decimal=",")
    >>> signal
    Signal(force, 3 samples at 10 kHz, largest 1500 N)
    """
    of_time, seconds = _unit("time_unit", time_unit)
    if seconds != "s":
        raise InputError(f"time_unit must be a unit of time such as 'ms', got {time_unit!r}")
    factor, base = _unit("unit", unit)
    mark = choice("decimal", decimal, (".", ","))
    file = file_path("path", path)
    try:
        content = decoded(file.read_bytes())
    except OSError as error:
        raise InputError(f"cannot read {str(file)!r}: {error.strerror or error}") from None
    if content is None:
        raise InputError(f"{file} is binary; export it as text")
    lines = [line.strip(" ") for line in content.split("\n")]
    last = next((line for line in reversed(lines) if line), "")
    bare = re.sub('"[^"]*"', "", last)
    present = (sep for sep in ";\t," if sep in bare and (sep != mark or bare != last))
    separator = next(present, " ")
    split = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    try:
        table = [(split.line_num, [cell.strip() for cell in row]) for row in split if any(row)]
    except csv.Error as error:
        raise InputError(f"{file}, line {split.line_num}: {error}") from None
    rows = [row for _, row in table]
    columns = [_column("time", time, rows), _column("values", values, rows)]

    found: list[tuple[int, float, float]] = []
    point = str.maketrans({mark: ".", ".": mark})
    first: list[str] = []
    heading: list[str] = []
    for at, cells in table:
        wanted = [cells[i].translate(point) if i < len(cells) else "" for i in columns]
        bad = [cell for cell in wanted if not _NUMBER.fullmatch(cell)]
        if bad and not found:
            heading = cells
            continue
        first = first or cells
        if bad or len(cells) != len(first):
            told = f"{bad[0]!r} is no number" if bad else f"{len(cells)} cells, not {len(first)}"
            raise InputError(f"{file}, line {at}: {told}; is decimal={mark!r} right?")
        found.append((at, float(wanted[0]), float(wanted[1])))
    if 1 < len(heading) < sum(map(bool, first)):
        raise InputError(
            f"{file}, line {found[0][0]}: {len(first)} cells under {len(heading)} headings. Write "
            "numbers without separators of thousands; is decimal right?"
        )
    if len(found) < 2:
        raise InputError(
            f"{file}: no two lines have numbers in time={time!r} and values={values!r}; are these "
            f"columns, and is decimal={mark!r} right?"
        )
    at_line, times, numbers = np.array(found).T
    still = np.flatnonzero(np.diff(times) <= 0.0)
    if len(still):
        raise InputError(
            f"{file}, line {at_line[still[0] + 1]:.0f}: the time does not rise; is it the right "
            "column, with digits enough?"
        )
    return Signal(of_time * times, factor * numbers, unit=base, name=text("name", name))


def _unit(name: str, unit: str) -> tuple[float, str]:
    """Factor to SI, and the SI unit."""
    given = text(name, unit)
    prefixed = {
        prefix + written: (factor, base)
        for written, base in _BASES.items()
        for prefix, factor in _PREFIXES.items()
    }
    known = _OTHERS | prefixed
    if given not in known:
        choice(name, given, ["s", "ms", "µs", "N", "kN", "lbf", "m/s", "m/s²", "g", "mm", "V"])
    return known[given]


def _column(name: str, given: int | str, rows: Sequence[list[str]]) -> int:
    """Return the number of a column."""
    if isinstance(given, bool) or not isinstance(given, (int, np.integer, str)):
        raise InputTypeError(f"{name} must be a column's number or heading, got {given!r}")
    if not isinstance(given, str):
        if given < 0:
            raise InputError(f"{name} must be a column from 0 on, got {given}")
        return int(given)
    for row in rows:
        for options in (row, [re.sub(r"\s*[\[(].*$", "", cell) for cell in row]):
            if options.count(given) > 1:
                raise InputError(f"{name}: {options.count(given)} columns are called {given!r}")
            if given in options:
                return options.index(given)
    heading = next((row for row in rows if len(row) > 1), [])
    raise InputError(
        f"{name}: no column is called {given!r}{nearest(given, heading)}; there are "
        + ", ".join(map(repr, heading))
    )
