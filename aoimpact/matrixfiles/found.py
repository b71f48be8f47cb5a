"""Contents of a matrix file, as its reader returns them, and errors of every reader."""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray, InputError, IntArray, MissingFileError, require

# Bytes of memory that a byte of a file becomes at most: of text, entries of three numbers each, of
# which both triangles and their sum are held at once.
_PER_BYTE = 12

# Entries of one triangle only that were left out of the other as rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Found:
    """A matrix as its file has it.

    Attributes
    ----------
    file : Path
    name : str
        Name of the matrix, in capitals; empty if the file gives none.
    size : int or None
        Number of rows; None where the file does not state it.
    rows, cols : ndarray of int
        From 0.
    values : ndarray
    labels : ndarray of int, shape (size, 2), or None
        Node and component of each row.
    unique : bool
        True if an entry given twice is an error; else the two add up.
    triangle : bool
        True if the file says that it holds one triangle only.
    unfit : str
        Why it is neither stiffness nor mass: complex, not square, empty.
    before : int or None
        Lines before the entries, of a file of one entry a line.
    """

    file: Path
    name: str
    size: int | None
    rows: IntArray
    cols: IntArray
    values: FloatArray
    labels: IntArray | None = None
    unique: bool = True
    triangle: bool = False
    unfit: str = ""
    before: int | None = None

    @property
    def called(self) -> str:
        """The file and, where it has names, the matrix in it."""
        return f"{self.file.name}: {self.name}" if self.name else self.file.name


def unfit(file: Path, name: str, why: str) -> Found:
    """A matrix that is passed over: its file may have others."""
    none = np.zeros(0, dtype=np.int64)
    return Found(file, name, None, none, none, np.zeros(0), unfit=why)


def entry_line(file: Path, before: int, entry: int) -> int:
    """The line of an entry, counted from 1, of a file of one a line after some lines."""
    with file.open("rb") as stream:
        for number, line in enumerate(stream, 1):
            entry -= number > before and bool(line.strip())
            if not entry:
                return number
    return number


def spoilt(file: Path, why: str, line: int | None = None) -> InputError:
    """The error for a file that is not what it should be."""
    place = "" if line is None else f", line {line}"
    return InputError(f"matrix file {str(file)!r}{place}: {why}")


def existing(file: Path) -> int:
    """Return the size of a file that is to be read, bytes.

    Raises
    ------
    MissingFileError, InputError, MemoryLimitError
    """
    try:
        state = file.stat()
    except FileNotFoundError:
        raise MissingFileError(
            f"matrix file {str(file)!r} does not exist (in {os.getcwd()})"
        ) from None
    except OSError as error:
        raise spoilt(file, f"it cannot be opened: {error}") from None
    if not stat.S_ISREG(state.st_mode):
        raise spoilt(file, "it is no regular file")
    if state.st_size == 0:
        raise spoilt(file, "it is empty")
    require(
        _PER_BYTE * state.st_size,
        f"matrix file {str(file)!r} of {state.st_size} bytes",
        "take a coarser mesh, or a reduced model of the other program",
    )
    return state.st_size


def symmetric(found: Found, size: int) -> sp.csr_array:
    """Return the matrix with both of its triangles.

    Raises
    ------
    InputError
        If an entry is there twice, or of some entries the transposed one is there and of others
        not.
    """
    shape = (size, size)
    matrix = sp.csr_array(sp.coo_array((found.values, (found.rows, found.cols)), shape=shape))
    if found.unique and matrix.nnz < len(found.values):
        raise _there_twice(found)
    both = _pattern(matrix)
    off = both.nnz - int((both.diagonal() != 0).sum())
    paired = int((both * both.T.tocsr()).nnz) - (both.nnz - off)
    if paired == 0 and off:
        return sp.csr_array(matrix + matrix.T - sp.diags_array(matrix.diagonal()))
    if found.triangle and paired:
        raise spoilt(
            found.file,
            "it says symmetric, but has entries of both triangles; say general",
        )
    largest = float(np.abs(found.values).max(initial=0.0))
    if (
        paired < off
        and float(np.abs((matrix - matrix.T).data).max(initial=0.0)) > _ROUNDING * largest
    ):
        raise spoilt(
            found.file,
            f"{off - paired} of {off} entries lack the transposed one: is the file cut short?",
        )
    return matrix


def _pattern(matrix: sp.csr_array) -> sp.csr_array:
    ones = np.ones(matrix.nnz, dtype=np.int8)
    return sp.csr_array((ones, matrix.indices, matrix.indptr), shape=matrix.shape)


def _there_twice(found: Found) -> InputError:
    order = np.lexsort((found.cols, found.rows))
    rows, cols = found.rows[order], found.cols[order]
    first = int(np.flatnonzero((np.diff(rows) == 0) & (np.diff(cols) == 0))[0])
    again = None
    if found.before is not None:
        again = entry_line(found.file, found.before, int(order[first + 1]) + 1)
    row, col = int(rows[first]), int(cols[first])
    where = f"row {row + 1}, column {col + 1}"
    if found.labels is not None:
        (a, i), (b, j) = found.labels[row].tolist(), found.labels[col].tolist()
        where = f"dofs {a}.{i} and {b}.{j}"
    return spoilt(
        found.file,
        f"the entry of {where} is there twice: are two files or two steps joined in it?",
        again,
    )
