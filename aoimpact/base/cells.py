"""Rows of cells as a table: aligned for a terminal, CSV in a file."""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterable, Sequence
from typing import Any

from .checks import written_file


def aligned(rows: Iterable[Sequence[str]], *, left: Collection[int] = ()) -> list[str]:
    """Return a line per row with columns aligned right, or left if their number is in `left`."""
    columns = []
    for number, cells in enumerate(zip(*rows, strict=True)):
        width = max(map(len, cells))
        columns.append(
            [cell.ljust(width) if number in left else cell.rjust(width) for cell in cells]
        )
    return ["  ".join(line).rstrip() for line in zip(*columns, strict=True)]


def write_csv(path: Any, heading: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    """Write a heading and rows to a file; reading the file gives the same numbers bit for bit.

    Raises
    ------
    InputTypeError, InputError
        If `path` cannot be written to; see `written_file`.
    """
    with (
        written_file(path) as given,
        open(given, "w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heading)
        writer.writerows(rows)
