"""Signals from the text files of data loggers."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..base import FloatArray, InputError, InputTypeError, choice, file_path, nearest, text
from .signal import Signal

__all__ = ["STANDARD_GRAVITY", "read_signal"]

STANDARD_GRAVITY = 9.80665  # m/s², ISO 80000-3

# SI units of signals, with how else they are written; and what has no prefix.
_BASES = {"N": "N", "s": "s", "m/s²": "m/s²", "m/s2": "m/s²", "m/s^2": "m/s²", "m": "m", "V": "V"}
_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6}
_OTHERS = {"g": (STANDARD_GRAVITY, "m/s²"), "lbf": (4.4482216152605, "N")}

_SEPARATORS = (";", "\t", ",")


def read_signal(
    path: str | os.PathLike[str],
    *,
    time: int | str = 0,
    values: int | str = 1,
    time_unit: str = "s",
    unit: str = "N",
    name: str = "force",
) -> Signal:
    """Read a signal from a text file of columns, as data loggers write it.

    Columns are separated by semicolons, tabs, commas or spaces; lines before the first one of
    numbers are headings. With semicolons or tabs a comma may be the decimal point.

    Parameters
    ----------
    path : path
    time, values : int or str, optional
        Columns, by number from 0 or by what stands over them (without the unit will do).
    time_unit : str, optional
        Of the times in the file: "s", "ms", "µs" (or "us").
    unit : str, optional
        Of the values in the file: "N", "kN", "lbf", "m/s²", "g", "mm", ….
    name : str, optional
        What axes and messages call it.

    Returns
    -------
    Signal
        In SI units.

    Raises
    ------
    InputError
        If the file cannot be read, a line has too few columns or no numbers, or times do not rise;
        the message has the line.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> text = "time [ms];force [kN]\\n0,0;0,0\\n0,1;1,5\\n0,2;0,3\\n"
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "drop.csv"
    ...     _ = file.write_text(text)
    ...     signal = read_signal(file, time_unit="ms", unit="kN")
    >>> signal
    Signal(force, 3 samples at 10 kHz, largest 1500 N)
    """
    of_time, seconds = _unit("time_unit", time_unit)
    if seconds != "s":
        raise InputError(f"time_unit must be a unit of time such as 'ms', got {time_unit!r}")
    factor, base = _unit("unit", unit)
    file = file_path("path", path)
    table, headings, first = _table(file)
    i, j = _column("time", time, headings, table), _column("values", values, headings, table)
    times = of_time * table[:, i]
    still = np.flatnonzero(np.diff(times) <= 0.0)
    if len(still):
        line = first + int(still[0]) + 1
        raise InputError(
            f"{file}, line {line}: the time does not rise from the line before; is column {i} the "
            "time, and is it written with digits enough?"
        )
    return Signal(times, factor * table[:, j], unit=base, name=text("name", name))


def _unit(name: str, unit: str) -> tuple[float, str]:
    """Factor to SI, and the SI unit."""
    given = text(name, unit)
    if given in _OTHERS:
        return _OTHERS[given]
    for written, base in _BASES.items():
        prefix = given.removesuffix(written)
        if given.endswith(written) and prefix in _PREFIXES:
            return _PREFIXES[prefix], base
    known = ["s", "ms", "µs", "N", "kN", "lbf", "m/s²", "g", "mm", "V"]
    choice(name, given, known)
    raise AssertionError


def _table(file: Path) -> tuple[FloatArray, list[str], int]:
    """Numbers by row and column, what stands over them, and the line of the first row."""
    try:
        lines = file.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise InputError(f"cannot read {str(file)!r}: {error.strerror or error}") from None
    separator = next((s for s in _SEPARATORS if any(s in line for line in lines)), None)
    if separator == "," and not any(_numbers(line, ",") for line in lines):
        separator = None
    rows: list[list[float]] = []
    headings: list[str] = []
    first = 0
    for number, line in enumerate(lines, 1):
        found = _numbers(line, separator)
        if not rows and (found is None or len(found) < 2):
            headings = [cell.strip().strip('"') for cell in line.split(separator)]
            continue
        if not line.strip():
            continue
        if found is None or len(found) != len(rows[0] if rows else found):
            raise InputError(
                f"{file}, line {number}: {line.strip()[:60]!r} is no row of {len(rows[0])} numbers"
            )
        first = first or number
        rows.append(found)
    if len(rows) < 2:
        raise InputError(f"{file}: there are no two lines of two numbers or more in it")
    return np.array(rows), headings, first


def _numbers(line: str, separator: str | None) -> list[float] | None:
    cells = [cell.strip().strip('"') for cell in line.split(separator)]
    while cells and not cells[-1]:  # a separator at the end of the line
        cells.pop()
    if separator != ",":
        cells = [cell.replace(",", ".") for cell in cells]
    try:
        return [float(cell) for cell in cells] or None
    except ValueError:
        return None


def _column(name: str, given: int | str, headings: Sequence[str], table: FloatArray) -> int:
    """The number of a column."""
    count = table.shape[1]
    if isinstance(given, str):
        plain = [re.sub(r"\s*[\[(].*$", "", heading) for heading in headings]
        for options in (headings, plain):
            if given in options:
                return list(options).index(given)
        listed = ", ".join(repr(heading) for heading in headings)
        raise InputError(
            f"{name}: no column is called {given!r}{nearest(given, headings)}; there are {listed}"
        )
    if isinstance(given, bool) or not isinstance(given, (int, np.integer)):
        raise InputTypeError(f"{name} must be a column's number or heading, got {given!r}")
    if not 0 <= given < count:
        raise InputError(f"{name} must be a column from 0 to {count - 1}, got {given}")
    return int(given)
