"""Text of one entry a line, row, column and value: Matrix Market, CalculiX, Abaqus COORDINATE."""

from __future__ import annotations

import re
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..base import FloatArray, IntArray
from .found import Found, entry_line, spoilt
from .table import NUMBER, columns, shown

_TRIPLE = re.compile(rb"\s*-?\d+\s+-?\d+\s+" + NUMBER + rb"\s*$")

_ENTRY = "row, column and value"

# Two digits, their spaces and the end of the line: no entry takes less. Of a dense matrix: a number
# and a space.
_LEAST_BYTES, _LEAST_DENSE = 6, 2


def is_market(head: bytes) -> bool:
    """True if a file begins as Matrix Market's do."""
    return head[:14].lower() == b"%%matrixmarket"


def is_triples(head: bytes) -> bool:
    """True if a file begins with lines of row, column and value."""
    return _TRIPLE.match(head.split(b"\n", 1)[0]) is not None


def read_triples(file: Path, size: int) -> list[Found]:
    """Read lines of row, column and value, rows and columns from 1."""
    with file.open("rb") as stream:
        rows, cols, values = _entries(file, stream, 0)
    largest = int(max(rows.max(), cols.max())) + 1
    return [Found(file, "", largest, rows, cols, values, before=0)]


def read_market(file: Path, size: int) -> list[Found]:
    """Read a file of Matrix Market, of coordinates or dense."""
    with file.open("rb") as stream:
        words = stream.readline(1024).decode("latin-1").lower().split()
        kind, triangle = _header(file, words)
        n, entries, number = _counts(file, stream, kind, triangle, size)
        if kind == "array":
            rows, cols, values = _dense(file, stream, n, triangle, number)
        else:
            rows, cols, values = _entries(file, stream, number, n)
    if len(values) != entries:
        raise spoilt(
            file,
            f"it announces {entries} entries, but has {len(values)}: it is cut short",
            entry_line(file, number, max(1, len(values))),
        )
    if kind == "coordinate":
        return [Found(file, "", n, rows, cols, values, triangle=triangle, before=number)]
    keep = values != 0.0
    return [Found(file, "", n, rows[keep], cols[keep], values[keep], triangle=triangle)]


def _header(file: Path, words: list[str]) -> tuple[str, bool]:
    """The format of a file whose first line has these words, and whether it has a triangle only."""
    known = (("matrix",), ("coordinate", "array"), ("real", "integer"), ("general", "symmetric"))
    given = (words[1:] + 4 * [""])[:4]
    for word, wanted in zip(given, known, strict=True):
        if word not in wanted:
            raise spoilt(
                file, f"the header says {word!r}, but {' or '.join(wanted)} can be read", 1
            )
    return given[1], given[3] == "symmetric"


def _counts(
    file: Path, stream: BinaryIO, kind: str, triangle: bool, size: int
) -> tuple[int, int, int]:
    """The numbers of rows and of entries that a file announces, and the line that does."""
    number, line = 2, stream.readline(2**16)
    while line.startswith(b"%") or (line and not line.strip()):
        number, line = number + 1, stream.readline(2**16)
    wanted = 3 if kind == "coordinate" else 2
    counts = line.split()
    if len(counts) != wanted or not all(one.isdigit() and len(one) < 19 for one in counts):
        raise spoilt(file, f"{wanted} counts should stand here, got {shown(line)}", number)
    n, n_cols = int(counts[0]), int(counts[1])
    if n != n_cols:
        raise spoilt(file, f"the matrix is {n} by {n_cols}, not square", number)
    if kind == "array":
        entries = n * (n + 1) // 2 if triangle else n * n
        least = _LEAST_DENSE * entries
    else:
        entries = int(counts[2])
        least = max(_LEAST_BYTES * entries, n)
    if least > size:
        raise spoilt(
            file,
            f"it announces {n} rows and {entries} entries in {size} bytes: it is cut short",
            number,
        )
    return n, entries, number


def _entries(
    file: Path, stream: BinaryIO, before: int, most: int | None = None
) -> tuple[IntArray, IntArray, FloatArray]:
    """Rows and columns from 0, and values, of lines that have them from 1."""
    rows, cols, values = columns(file, stream, 2, _ENTRY, before=before)
    if not len(values):
        raise spoilt(file, "it has no entries: it is cut short")
    limit = most or 2**31
    wrong = np.flatnonzero((rows < 1) | (rows > limit) | (cols < 1) | (cols > limit))
    if len(wrong):
        first = int(wrong[0])
        cure = "" if most else "; internal dofs of Abaqus need FORMAT=MATRIX INPUT"
        raise spoilt(
            file,
            f"row {rows[first]}, column {cols[first]} should be from 1 to "
            f"{most or 'the number of dofs'}{cure}",
            entry_line(file, before, first + 1),
        )
    return rows - 1, cols - 1, values


def _dense(
    file: Path, stream: BinaryIO, n: int, triangle: bool, before: int
) -> tuple[IntArray, IntArray, FloatArray]:
    """All numbers of a matrix, column by column, of a triangle from the diagonal down."""
    (values,) = columns(file, stream, 0, "a number", before=before)
    cols, rows = np.triu_indices(n) if triangle else np.divmod(np.arange(n * n), n)
    if len(values) != len(rows):  # refused by the caller
        rows = cols = np.zeros(len(values), dtype=np.int64)
    return rows, cols, values
