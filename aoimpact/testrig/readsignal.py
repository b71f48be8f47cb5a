"""Signals from the text files of data loggers."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base import (
    FloatArray,
    InputError,
    InputTypeError,
    choice,
    decoded,
    file_path,
    nearest,
    text,
)
from .signal import Signal

STANDARD_GRAVITY = 9.80665  # m/s², ISO 80000-3

# SI units of signals, with how else they are written; and what has no prefix.
_BASES = {"N": "N", "s": "s", "m/s²": "m/s²", "m/s2": "m/s²", "m/s^2": "m/s²", "m": "m", "V": "V"}
_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6}
_OTHERS = {"g": (STANDARD_GRAVITY, "m/s²"), "lbf": (4.4482216152605, "N")}

# Separators of columns; None stands for spaces. No number has one of the first two in it.
_SEPARATORS = (";", "\t", None, ",")

# A number by its decimal mark: digits, also in groups of three between which stand the other mark,
# apostrophes or spaces, then decimals and an exponent.
_NUMBERS = {
    mark: re.compile(
        rf"[+-]?(?:(?:\d+|[1-9]\d{{0,2}}(?P<group>[{other}'’ \u00a0\u202f])\d{{3}}"
        rf"(?:(?P=group)\d{{3}})*)(?:[{mark}]\d*)?|[{mark}]\d+)(?:[eE][+-]?\d+)?",
        re.ASCII,
    )
    for mark, other in ((".", ","), (",", "."))
}


@dataclass(frozen=True, eq=False)
class _Reading:
    """A file under one separator and decimal mark.

    Attributes
    ----------
    lines : list of int
        The line of each row, counted from 1.
    numbers : ndarray, shape (rows, 2)
        Times and values.
    rows : list of list of str
        All cells of each row.
    """

    lines: list[int]
    numbers: FloatArray
    rows: list[list[str]]


class _UnreadError(InputError):
    """A file makes no sense under a separator and decimal mark.

    `near` is how far it did: rows, then cells of a row.
    """

    def __init__(self, message: str, *near: int) -> None:
        super().__init__(message)
        self.near = near


def read_signal(
    path: str | os.PathLike[str],
    *,
    time: int | str = 0,
    values: int | str = 1,
    time_unit: str = "s",
    unit: str = "N",
    decimal: str | None = None,
    name: str = "force",
) -> Signal:
    """Read a signal from a text file of columns, as data loggers write it.

    Columns are separated by semicolons, tabs, spaces or commas, and cells may be quoted. Lines
    before the first one with numbers in both columns are headings; other columns may hold anything.
    Thousands may be separated by commas (by points, beside decimal commas), spaces or apostrophes.

    Parameters
    ----------
    path : path
    time, values : int or str, optional
        Columns, by number from 0 or by what stands over them (without the unit will do).
    time_unit : str, optional
        Unit of the times in the file: "s", "ms", "µs" (or "us").
    unit : str, optional
        Unit of the values in the file: "N", "kN", "lbf", "m/s²", "g", "mm", ….
    decimal : {".", ","}, optional
        Decimal mark of the numbers. Found from the file if not given; a file that can be read in
        both ways, as one in which all numbers are like 1,500, is refused.
    name : str, optional
        Name on axes and in messages.

    Returns
    -------
    Signal
        In SI units.

    Raises
    ------
    InputError
        If the file cannot be read, or can be read in two ways; if a line after the first row has no
        number in one of the columns, or more or fewer cells than that row; or if times do not rise.
        The message has the line.

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
    marks = list(_NUMBERS) if decimal is None else [choice("decimal", decimal, list(_NUMBERS))]
    for which, given in (("time", time), ("values", values)):
        if isinstance(given, bool) or not isinstance(given, (int, np.integer, str)):
            raise InputTypeError(f"{which} must be a column's number or heading, got {given!r}")
    file = file_path("path", path)
    try:
        content = decoded(file.read_bytes())
    except OSError as error:
        raise InputError(f"cannot read {str(file)!r}: {error.strerror or error}") from None
    if content is None:
        raise InputError(f"{file} is binary; export it as text")
    try:
        found = _only_reading(content.split("\n"), marks, time=time, values=values)
    except InputError as error:
        raise InputError(f"{file}, {error}") from None
    times = of_time * found.numbers[:, 0]
    still = np.flatnonzero(np.diff(times) <= 0.0)
    if len(still):
        raise InputError(
            f"{file}, line {found.lines[still[0] + 1]}: the time does not rise; is it the right "
            "column, with digits enough?"
        )
    return Signal(times, factor * found.numbers[:, 1], unit=base, name=text("name", name))


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


def _only_reading(lines: list[str], marks: Sequence[str], **wanted: int | str) -> _Reading:
    """Return the one way to read the wanted columns, or refuse them."""
    found: list[_Reading] = []
    unread: list[_UnreadError] = []
    for separator in _SEPARATORS:
        table = [(at, _cells(line, separator)) for at, line in enumerate(lines, 1) if line.strip()]
        for mark in marks:
            doubtful = separator == "," and len(marks) > 1
            try:
                found.append(_reading(table, mark, wanted, doubtful))
            except _UnreadError as error:
                unread.append(error)
        if found and separator in _SEPARATORS[:2]:
            break
    if not found:
        raise max(unread, key=lambda error: error.near)
    # A later first row takes rows before it for headings. Else the decimal point comes first.
    start = min(one.lines[0] for one in found)
    first, *others = [one for one in found if one.lines[0] == start]
    if others and not any(re.search(",[0-9]", cell) for row in first.rows for cell in row):
        return first
    for other in others:
        apart = (first.numbers != other.numbers).any(axis=1)
        if apart.any():
            row = int(apart.argmax())
            one, two = (" and ".join(f"{x:g}" for x in r.numbers[row]) for r in (first, other))
            raise InputError(
                f"line {first.lines[row]}: time and value may be {one}, or {two}; give "
                "decimal='.' or decimal=','"
            )
    return first


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.replace('"', " ").split()
    split = next(csv.reader([line], delimiter=separator)) if '"' in line else line.split(separator)
    return [cell.strip() for cell in split]


def _reading(
    table: Sequence[tuple[int, list[str]]], mark: str, wanted: dict[str, int | str], doubtful: bool
) -> _Reading:
    """Read the wanted columns of lines that are split into cells.

    Parameters
    ----------
    table : sequence of (int, list of str)
        Lines' numbers and cells.
    mark : str
        The decimal mark.
    wanted : dict of str to int or str
        The columns by argument.
    doubtful : bool
        True if decimal commas may have split cells in two.

    Raises
    ------
    _UnreadError
    """
    is_number = _NUMBERS[mark].fullmatch
    columns = tuple(_column(*one, [row for _, row in table]) for one in wanted.items())
    lines: list[int] = []
    numbers: list[list[float]] = []
    first: list[str] = []
    heading: list[str] = []
    rows: list[list[str]] = []
    for at, row in table:
        cells = [row[column] if column < len(row) else "" for column in columns]
        if not all(map(is_number, cells)):
            if not lines:
                heading = row
                continue
            bad = next(cell for cell in cells if not is_number(cell))
            raise _UnreadError(f"line {at}: {bad!r} is no number", len(lines), len(first))
        first = first or row
        if len(row) != len(first) and _filled(row) != _filled(first):
            raise _UnreadError(
                f"line {at} has {len(row)} cells, line {lines[0]} has {len(first)}",
                len(lines),
                len(first),
            )
        lines.append(at)
        numbers.append([_value(cell, mark) for cell in cells])
        rows.append(row)
    width = max((len(row) for _, row in table), default=0)
    if len(lines) < 2:
        for name, column in zip(wanted, columns, strict=True):
            if 0 < width <= column:
                raise _UnreadError(
                    f"{name} must be a column from 0 to {width - 1}, got {column}", 0, width
                )
        raise _UnreadError(
            f"columns {columns[0]} and {columns[1]}: there are no two lines with numbers in both",
            len(lines),
            width,
        )
    if doubtful and 1 < _filled(heading) < _filled(first) <= 2 * _filled(heading):
        raise _UnreadError(
            f"line {lines[0]}: {_filled(first)} cells are under {_filled(heading)} headings; give "
            "decimal='.', or quote numbers with commas",
            len(lines),
            width,
        )
    return _Reading(lines, np.array(numbers), rows)


def _filled(row: list[str]) -> int:
    """Number of cells up to the last one that is not empty."""
    return max((i for i, cell in enumerate(row, 1) if cell), default=0)


def _value(cell: str, mark: str) -> float:
    """Return a number that matches `_NUMBERS`."""
    if mark == "," or "," in cell or not cell.isascii() or "'" in cell or " " in cell:
        cell = re.sub(rf"[^0-9eE+{mark}-]", "", cell).replace(",", ".")
    return float(cell)


def _column(name: str, given: int | str, rows: Sequence[list[str]]) -> int:
    """Return the number of a column."""
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
    over: list[str] = []
    for row in rows:
        if sum(bool(_NUMBERS["."].fullmatch(cell)) for cell in row) > 1:
            break
        over = row
    listed = ", ".join(repr(heading) for heading in over)
    raise _UnreadError(
        f"{name}: no column is called {given!r}{nearest(given, over)}; there are {listed}",
        0,
        len(over),
    )
