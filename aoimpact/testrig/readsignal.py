"""Signals from the text files of data loggers."""

from __future__ import annotations

import csv
import os
import re

import numpy as np

from ..base import InputError, choice, decoded, file_path, integer, nearest, text
from .signal import STANDARD_GRAVITY, Signal

# Units that have prefixes, in SI, also as else they are written; and factors to SI of all.
_BASES = {of: of for of in ("N", "s", "m", "V", "m/s", "m/s²")} | {"m/s2": "m/s²", "m/s^2": "m/s²"}
_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6}
_UNITS = {
    prefix + written: (factor, base)
    for written, base in _BASES.items()
    for prefix, factor in _PREFIXES.items()
} | {"g": (STANDARD_GRAVITY, "m/s²"), "lbf": (4.4482216152605, "N")}

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
    of_time, _ = _UNITS[choice("time_unit", time_unit, [f"{of}s" for of in _PREFIXES])]
    if text("unit", unit) not in _UNITS:
        choice("unit", unit, ["N", "kN", "lbf", "m/s", "m/s²", "g", "mm", "V"])
    factor, base = _UNITS[unit]
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
    split = csv.reader(lines, delimiter=next(present, " "), skipinitialspace=True)
    try:
        table = [(split.line_num, [cell.strip() for cell in row]) for row in split if any(row)]
    except csv.Error as error:
        raise InputError(f"{file}, line {split.line_num}: {error}") from None
    columns = [_column("time", time, table), _column("values", values, table)]

    found: list[tuple[float, float]] = []
    point = str.maketrans({mark: ".", ".": mark})
    heading = width = 0
    for at, cells in table:
        wanted = [cells[i].translate(point) if i < len(cells) else "" for i in columns]
        bad = [cell for cell in wanted if not _NUMBER.fullmatch(cell)]
        if bad and not found:
            heading = len(cells)
            continue
        width, told = width or len(cells), ""
        if bad:
            told = f"{bad[0]!r} is no number"
        elif len(cells) != width:
            told = f"{len(cells)} cells, not {width}"
        elif not found and 1 < heading < sum(map(bool, cells)):
            told = f"{width} cells under {heading} headings"
        elif found and float(wanted[0]) <= found[-1][0]:
            told = "the time does not rise"
        if told:
            raise InputError(f"{file}, line {at}: {told}; are columns and decimal={mark!r} right?")
        found.append((float(wanted[0]), float(wanted[1])))
    if len(found) < 2:
        raise InputError(
            f"{file}: no two lines have numbers in time={time!r} and values={values!r}; are these "
            f"columns, and is decimal={mark!r} right?"
        )
    times, numbers = np.array(found).T
    return Signal(of_time * times, factor * numbers, unit=base, name=text("name", name))


def _column(name: str, given: int | str, table: list[tuple[int, list[str]]]) -> int:
    """Return the number of a column."""
    if not isinstance(given, str):
        return integer(name, given, low=0)
    for _, row in table:
        for options in (row, [re.sub(r"\s*[\[(].*$", "", cell) for cell in row]):
            if options.count(given) > 1:
                raise InputError(f"{name}: {options.count(given)} columns are called {given!r}")
            if given in options:
                return options.index(given)
    heading = next((row for _, row in table if len(row) > 1), [])
    raise InputError(
        f"{name}: no column is called {given!r}{nearest(given, heading)}; there are "
        + ", ".join(map(repr, heading))
    )
