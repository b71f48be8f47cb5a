"""Readers of matrices in text files with one entry per line.

The formats are Matrix Market; lines of row, column and value (CalculiX' ``.sti`` and ``.mas``,
Abaqus' COORDINATE); and lines of node, component, node, component and value (Abaqus' MATRIX INPUT,
where internal nodes have negative numbers).
"""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path

import numpy as np

from ..base import FloatArray, IntArray, sp, warn
from .raw import RawMatrix, columns, entry_line, labelled, number, spoilt

_INTEGER = re.compile(rb"\s*[-+]?\d{1,15}\s*")

_MARKET = re.compile("matrix (coordinate|array) (real|integer) (general|symmetric)")

# Smallest number of bytes per matrix entry in a file. `_LEAST_BYTES`: row, column and value of one
# digit each, with separators. `_LEAST_DENSE`: one digit and a separator, for a dense matrix.
_LEAST_BYTES, _LEAST_DENSE = 6, 2


def _is_entry(line: bytes, integers: int, between: bytes | None = None) -> bool:
    """Return whether a line holds the given count of integers, followed by a real number.

    The numbers are separated by `between`, or by blanks if `between` is None.
    """
    *labels, value = line.strip().removesuffix(b",").split(between) or [b""]
    with contextlib.suppress(ValueError):
        number(value.decode("ascii", "replace"))
        return len(labels) == integers and all(map(_INTEGER.fullmatch, labels))
    return False


def is_triples(head: bytes) -> bool:
    """Return whether the first line of a file consists of row, column and value."""
    return _is_entry(head.split(b"\n", 1)[0], 2)


def is_nodal(head: bytes) -> bool:
    """Return whether the first data line is node, component, node, component and value."""
    lines = (line for line in head.split(b"\n") if line.strip() and not line.startswith(b"*"))
    return _is_entry(next(lines, b"").replace(b",", b" "), 4)


def read_triples(file: Path) -> list[RawMatrix]:
    """Return the matrix in a file of lines of row, column (both from 1) and value."""
    rows, cols, values = _coordinates(file, 0)
    largest = int(max(rows.max(), cols.max())) + 1
    matrix = sp.coo_array((values, (rows, cols)), shape=(largest, largest))
    return [RawMatrix(file, "", matrix, before=0)]


def read_nodal(file: Path) -> list[RawMatrix]:
    """Return the matrix in a file of lines of node, component, node, component and value."""
    with file.open("rb") as stream:
        first = next(line for line in stream if line.strip() and not line.startswith(b"*"))
    *labels, values = _columns(file, 4, comma=b"," in first, comments="*")
    return [labelled(file, "", labels[:2], labels[2:], values)]


def read_market(file: Path) -> list[RawMatrix]:
    """Return the matrix in a Matrix Market file, sparse (coordinate) or dense (array)."""
    with file.open("rb") as stream:
        header = stream.readline(1024).decode("utf-8-sig", "replace").lower().split()[1:5]
        size, before, line = os.fstat(stream.fileno()).st_size, 2, stream.readline(2**16)
        while line.startswith(b"%") or (line and not line.strip()):
            before, line = before + 1, stream.readline(2**16)
    if not _MARKET.fullmatch(" ".join(header)):
        why = "the header should be matrix, coordinate or array, real or integer, general or "
        raise spoilt(file, f"{why}symmetric, got {' '.join(header)!r}", 1)
    dense, triangle = header[1] == "array", header[3] == "symmetric"
    counts = line.split()
    n_counts = 2 if dense else 3
    if len(counts) != n_counts or not all(one.isdigit() and len(one) < 19 for one in counts):
        raise spoilt(file, f"{n_counts} counts should stand here, got {_shown(line)}", before)
    n, n_cols, *entries = map(int, counts)
    if n != n_cols:
        raise spoilt(file, f"the matrix is {n} by {n_cols}, not square", before)
    announced = entries[0] if entries else n * (n + 1) // 2 if triangle else n * n
    if (_LEAST_DENSE * announced if dense else max(_LEAST_BYTES * announced, n)) > size:
        raise spoilt(file, f"{size} bytes do not hold {announced} entries: cut short?", before)
    if dense:  # stored by columns; a triangle's columns begin at the diagonal
        (values,) = _columns(file, 0, before=before)
    else:
        rows, cols, values = _coordinates(file, before, n)
    if len(values) != announced:
        place = entry_line(file, before, max(1, len(values)))
        raise spoilt(file, f"{announced} entries are announced, {len(values)} are there", place)
    if not dense:
        matrix = sp.coo_array((values, (rows, cols)), shape=(n, n))
        return [RawMatrix(file, "", matrix, triangle=triangle, before=before)]
    full = np.zeros((n, n))
    full.T[np.triu_indices(n, 0 if triangle else -n)] = values
    return [RawMatrix(file, "", sp.coo_array(full), triangle=triangle)]


def _coordinates(
    file: Path, before: int, most: int | None = None
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return row, column and value of each entry; rows count from 0 here, from 1 in the file."""
    rows, cols, values = _columns(file, 2, before=before)
    if not len(values):
        raise spoilt(file, "it has no entries: it is cut short")
    wrong = (np.minimum(rows, cols) < 1) | (np.maximum(rows, cols) > (most or 2**31))
    for first in np.flatnonzero(wrong)[:1].tolist():
        cure = most or "the number of dofs; internal dofs of Abaqus need FORMAT=MATRIX INPUT"
        why = f"row {rows[first]}, column {cols[first]} should be from 1 to {cure}"
        raise spoilt(file, why, entry_line(file, before, first + 1))
    return rows - 1, cols - 1, values


def _columns(
    file: Path, integers: int, *, before: int = 0, comma: bool = False, comments: str | None = None
) -> list[np.ndarray]:
    """Return the columns of a table: `integers` columns of integers, then the values.

    The first `before` lines of the file are skipped.

    Raises
    ------
    InputError
        If a line has other contents; the message names the first wrong line.
    """
    what = f"{integers} integers, of row and column, and a number"
    how = {"skiprows": before, "comments": comments}
    table = columns(file, integers + 1, "," if comma else None, **how)
    labels = np.zeros((0, 0)) if table is None else table[:, :-1]
    if table is not None and (labels == np.rint(labels.clip(-(2.0**53), 2.0**53))).all():
        with file.open("rb") as stream:
            stream.seek(-1, os.SEEK_END)
            if stream.read(1) not in b"\n\r":
                warn(f"matrix file {str(file)!r} ends within a line: is its last number whole?")
        return [*labels.T.astype(np.int64), np.ascontiguousarray(table[:, -1])]
    # Find the wrong line for the message. This is slow, but happens only for refused files.
    with file.open("rb") as stream:
        for place, line in enumerate(stream, 1):
            comment = comments and line.lstrip().startswith(comments.encode())
            if place <= before or not line.strip() or comment:
                continue
            if not _is_entry(line, integers, b"," if comma else None):
                found = f"{what} should stand here, got {_shown(line)}"
                raise spoilt(file, f"{found}: is it cut short, or of another format?", place)
    raise spoilt(file, f"{what} should stand on each line, and be finite")


def _shown(line: bytes) -> str:
    """Return a line as quoted in messages, shortened to 60 characters."""
    text = line.decode("latin-1").strip()
    return repr(text if len(text) < 60 else text[:57] + "...") if text else "an empty line"
