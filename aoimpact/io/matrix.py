"""The matrix as a file holds it, and the errors of its readers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import PRINTED, FloatArray, InputError, IntArray

# A row's node and component as one number: components are below 64, nodes below 2**40.
_COMPONENTS, _LARGEST_NODE = 64, 2**40


@dataclass(frozen=True, eq=False)
class RawMatrix:
    """A matrix as its file has it.

    Attributes
    ----------
    file : Path
    name : str
        Name of the matrix, in capitals; empty if the file gives none.
    size : int
        Number of rows.
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
    size: int
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

    def line(self, entry: int) -> int | None:
        """Return the line of an entry; None if entries have no lines of their own."""
        return None if self.before is None else entry_line(self.file, self.before, entry + 1)

    def symmetric(self) -> Any:
        """Return both triangles as a CSR array, shape (size, size).

        Raises
        ------
        InputError
            If an entry occurs twice, or only some entries have a transposed one.
        """
        shape = (self.size, self.size)
        matrix = sp.csr_array(sp.coo_array((self.values, (self.rows, self.cols)), shape=shape))
        if self.unique and matrix.nnz < len(self.values):
            order = np.lexsort((self.cols, self.rows))
            rows, cols = self.rows[order], self.cols[order]
            first = int(np.flatnonzero((np.diff(rows) == 0) & (np.diff(cols) == 0))[0])
            row, column = (at(self.labels, int(of[first])) for of in (rows, cols))
            why = f"the entry of {row} and {column} is there twice: are two files joined in it?"
            raise spoilt(self.file, why, self.line(int(order[first + 1])))
        there = matrix.astype(bool)
        there.data[:] = True  # entries that are 0 are there as well
        paired = there.multiply(there.T).nnz - int(there.diagonal().sum())
        off = matrix.nnz - int(there.diagonal().sum())
        if paired == 0 and off:
            return sp.csr_array(matrix + matrix.T - sp.diags_array(matrix.diagonal()))
        if self.triangle and paired:
            raise spoilt(self.file, "it says symmetric, but has both triangles; say general")
        limit = PRINTED * float(np.abs(self.values).max(initial=0.0))
        if paired < off and float(abs(matrix - matrix.T).max()) > limit:
            lack = f"{off - paired} of {off} entries lack the transposed one"
            raise spoilt(self.file, f"{lack}: is the file cut short?")
        return matrix


def at(labels: IntArray | None, row: int) -> str:
    """Return a row, or column, as its program calls it."""
    return f"row {row + 1}" if labels is None else "dof {}.{}".format(*labels[row])


def codes(labels: IntArray) -> IntArray:
    """Return nodes and components, shape (n, 2), as single numbers, in the same order."""
    return labels[:, 0] * _COMPONENTS + labels[:, 1]


def labelled(file: Path, name: str, rows: Any, cols: Any, values: Any, **more: Any) -> RawMatrix:
    """Return the matrix of entries whose rows and columns are pairs of node and component.

    Parameters
    ----------
    rows, cols : sequence of two ndarrays of int
        Nodes and components of the entries.

    Raises
    ------
    InputError
        If a component or a node is out of range.
    """
    nodes, components = (np.concatenate(pair) for pair in zip(rows, cols, strict=True))
    if len(nodes) and (
        components.min() < 0
        or components.max() >= _COMPONENTS
        or max(-nodes.min(), nodes.max()) >= _LARGEST_NODE
    ):
        raise spoilt(file, "a node or component is too large: are columns mixed up?")
    known, places = np.unique(codes(np.stack([nodes, components], axis=1)), return_inverse=True)
    labels = np.stack(np.divmod(known, _COMPONENTS), axis=1)
    first, second = places[: len(values)], places[len(values) :]
    return RawMatrix(file, name, len(known), first, second, values, labels, **more)


def passed_over(file: Path, name: str, why: str) -> RawMatrix:
    """Return a matrix without entries: its file may have others."""
    none = np.zeros(0, dtype=np.int64)
    return RawMatrix(file, name, 0, none, none, np.zeros(0), unfit=why)


def entry_line(file: Path, before: int, entry: int) -> int:
    """Return the line of an entry, both counted from 1, of one entry a line after some lines."""
    with file.open("rb") as stream:
        for number, line in enumerate(stream, 1):
            entry -= number > before and bool(line.strip())
            if not entry:
                return number
    return number


def spoilt(file: Path, why: str, line: int | None = None) -> InputError:
    """Return the error for a file that is not what it should be."""
    place = "" if line is None else f", line {line}"
    return InputError(f"matrix file {str(file)!r}{place}: {why}")
