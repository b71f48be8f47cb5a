"""Meshes and matrices as files hold them, and the parts that several readers share."""

from __future__ import annotations

import contextlib
import math
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import field
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..base import PRINTED, FloatArray, InputError, IntArray, MeshError, decoded, record, sp
from ..mesh import twins

# Kinds of cells by their numbers of nodes.
LINES = {2: "line", 3: "line3"}
POINTS = {1: "vertex"}
DIMENSIONS = ("point", "line", "surface", "volume")

# VTK's order of nodes from orders that number the midside nodes of upright edges before the top's.
UPRIGHT_FIRST = {
    "hexahedron20": (*range(12), *range(16, 20), *range(12, 16)),
    "wedge15": (*range(9), *range(12, 15), *range(9, 12)),
}

# Dimension and number of corners of each shape of cells.
_SHAPES = {
    **{"other": (0, 0), "vertex": (0, 1), "line": (1, 2)},
    **{"triangle": (2, 3), "quad": (2, 4), "polygon": (2, 0)},
    **{"tetra": (3, 4), "pyramid": (3, 5), "wedge": (3, 6), "hexahedron": (3, 8)},
}

# Numbers as Fortran writes them: 1, -1.5, .5E3, 1.D0, and 1.0+3 for 1.0E+3.
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[EDed]([+-]?\d+)|([+-]\d+))?")

_SHORT = re.compile(rb"(?<=[\d.])(?=[-+]\d)")  # before the exponent of 1.0+3

# A row's node and component as one number: components are below 64, nodes below 2**40.
_COMPONENTS, _LARGEST_NODE = 64, 2**40

# Largest ratio of data to the size of an HDF5 file: the compression that zlib reaches.
_COMPRESSION = 1100


@record
class RawBlock:
    """Cells of one kind, of any dimension, in the order of the file.

    Attributes
    ----------
    kind : str
        meshio's name, such as "tetra10", "quad8" or "line"; node order is meshio's (VTK's). "other"
        for elements without volume whose nodes are not read.
    cells : ndarray of int, shape (n, nodes per cell)
        Row numbers of `RawMesh.nodes`.
    labels : ndarray of int, shape (n,), or None
        Numbers that the file gives to the elements; None for formats without numbers.
    name : str
        The deck's name of the elements, such as "CPS4"; "" for that of their kind.
    """

    kind: str
    cells: IntArray
    labels: IntArray | None = None
    name: str = ""

    @property
    def dim(self) -> int:
        """Dimension of the cells: 0 for points to 3 for solids."""
        return _SHAPES.get(self.kind.rstrip("0123456789"), (3, 0))[0]


@record
class RawMesh:
    """Nodes, cells and named groups of a file.

    Attributes
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates in the file's unit of length and in global axes.
    blocks : tuple of RawBlock
    node_sets : mapping of str to ndarray of int
        Row numbers of `nodes`.
    cell_sets : mapping of str to ndarray of int
        Cell numbers, counted through all blocks from 0, of any dimension.
    node_labels : ndarray of int, shape (n_nodes,), or None
        Numbers that the file gives to the nodes; None for formats without numbers. A number may
        occur twice, as in two instances of an Abaqus part.
    left_out : mapping of str to str
        Groups that hold more than solids, and the rest of their contents, as in "3 MASS, 20 S4R".
    deck : AbaqusDeck, NastranDeck or None
        Cards of a deck beyond its mesh; None for formats whose cells may be no more than sides and
        edges. Its `sections` count the cards on shells and beams, as in "2 PSHELL"; its `read`
        returns the sections in SI by group, from a `sections.Source`.
    """

    nodes: FloatArray
    blocks: tuple[RawBlock, ...]
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    cell_sets: Mapping[str, IntArray] = field(default_factory=dict)
    node_labels: IntArray | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)
    deck: Any = None

    @property
    def first(self) -> IntArray:
        """Number of the first cell of each block, shape (n_blocks + 1,); the last is the count."""
        return firsts(block.cells for block in self.blocks)

    @property
    def dims(self) -> IntArray:
        """Dimension of each cell, through all blocks."""
        return np.repeat([block.dim for block in self.blocks], np.diff(self.first))

    @property
    def contents(self) -> str:
        """The elements by their names, as in "100 CPS4"."""
        return listed((of.name or of.kind, len(of.cells)) for of in self.blocks)

    @property
    def numbers(self) -> list[IntArray]:
        """Numbers of the cells of each block."""
        return [np.arange(start, stop) for start, stop in pairwise(self.first.tolist())]

    def block_of(self, members: IntArray | int) -> IntArray:
        """Return the numbers of the blocks that cells are in."""
        return np.searchsorted(self.first, members, side="right") - 1

    def rows(self, members: IntArray) -> Iterator[tuple[RawBlock, IntArray]]:
        """Yield each block, and the rows in it of those members, numbers of cells, that it has."""
        for block, (start, stop) in zip(self.blocks, pairwise(self.first.tolist()), strict=True):
            yield block, members[(members >= start) & (members < stop)] - start

    @property
    def cell_labels(self) -> IntArray | None:
        """Numbers that the file gives to the cells, through all blocks; None if one has none."""
        labels = [block.labels for block in self.blocks if block.labels is not None]
        return np.concatenate(labels) if 0 < len(labels) == len(self.blocks) else None


def nodes_in(kind: str) -> int:
    """Return the number of nodes in a cell of one of meshio's kinds, such as 10 for "tetra10"."""
    shape = kind.rstrip("0123456789")
    return int(kind[len(shape) :] or _SHAPES[shape][1])


def firsts(parts: Iterable[Any]) -> IntArray:
    """Return the number at which each part begins if all are counted through, and the total."""
    return np.cumsum([0, *map(len, parts)], dtype=np.int64)


def joined(parts: Iterable[IntArray]) -> IntArray:
    """Return arrays of integers as one, also if there are none."""
    return np.concatenate([np.zeros(0, np.int64), *parts])


def grouped(members: Iterable[tuple[str, IntArray]]) -> dict[str, IntArray]:
    """Return groups of sorted numbers from pairs of a name and some members; no empty ones."""
    found: dict[str, list[IntArray]] = {}
    for name, some in members:
        if len(some):
            found.setdefault(name, []).append(some)
    return {name: np.unique(joined(parts)) for name, parts in found.items()}


def rows_of(known: IntArray, wanted: IntArray) -> IntArray:
    """Return the rows of labels among those that are known, of the same shape; -1 for others."""
    if not len(known):
        return np.full(wanted.shape, -1)
    order = None if (known[1:] >= known[:-1]).all() else np.argsort(known, kind="stable")
    rows = np.searchsorted(known, wanted, sorter=order).clip(max=len(known) - 1)
    rows = rows if order is None else order[rows]
    return np.where(known[rows] == wanted, rows, -1)


def cells_of(known: IntArray, labels: IntArray, nodes: IntArray, refuse: Any) -> IntArray:
    """Return elements by the rows of their nodes' labels; refuse one of which a node is missing."""
    rows = rows_of(known, nodes)
    for row, column in np.argwhere(rows < 0)[:1].tolist():
        why = f"element {labels[row]} has node {nodes[row, column]}, which is not there"
        raise refuse(row, why)
    return rows


def repeats(labels: IntArray) -> IntArray:
    """Return the rows whose label another row before them has, in the order of the labels."""
    order = np.argsort(labels, kind="stable")
    return np.asarray(order[1:][np.diff(labels[order]) == 0])


def labels_of(arrays: Any, name: str, count: int) -> IntArray | None:
    """Return the numbers of so many nodes or cells in arrays, or datasets, by name; None if none.

    Raises
    ------
    ValueError
        If there are more or fewer.
    """
    if name not in arrays:
        return None
    found: IntArray = np.asarray(arrays[name][()], np.int64).reshape(-1)
    check_count(f"numbers {name}", count, len(found))
    return found


def listed(counts: Iterable[tuple[str, int]]) -> str:
    """Return names and how often each is there in all, as in "100 CPS4, 2 S4R"."""
    found = Counter[str]()
    for name, count in counts:
        found[name] += count
    return ", ".join(f"{count} {name}" for name, count in sorted((+found).items()))


def once(labels: IntArray, places: Any, refuse: Callable[[int], MeshError]) -> IntArray:
    """Return rows by ascending labels, one for each; refuse a row that repeats one elsewhere."""
    _, first, own = np.unique(labels, return_index=True, return_inverse=True)
    for row in np.flatnonzero((places != places[first[own]]).any(axis=1))[:1].tolist():
        raise refuse(row)
    return first


@contextmanager
def naming(what: str) -> Iterator[None]:
    """Begin errors with the argument that a file was given for, or with a part of the file."""
    try:
        yield
    except (ValueError, OverflowError) as error:
        if str(error).startswith(what):
            raise
        raise type(error)(f"{what}: {error}") from error


def check_count(what: str, announced: int, there: int) -> None:
    """Refuse a file that holds more or less than it announces."""
    if there != announced:
        raise ValueError(f"{announced} {what} are announced, but {there} are there")


def read_text(file: Path) -> str:
    """Return a text file with "\\n" for each end of a line.

    The encoding is that of the byte order mark; else UTF-8, or Latin-1 if the file is not UTF-8.

    Raises
    ------
    MeshError
        If it is binary.
    """
    text = decoded(file.read_bytes())
    if text is None:
        raise MeshError(f"mesh file {str(file)!r} is binary; a text file is needed")
    return text


class Line(NamedTuple):
    """A line of a deck: its text, str or bytes, its number in the file from 1, and an order."""

    text: Any
    file: Path
    number: int
    order: int

    def refused(self, what: str, why: str) -> MeshError:
        """Return the error for a keyword or entry in it, such as "*NODE"."""
        return MeshError(f"mesh file {str(self.file)!r}, line {self.number}, {what}: {why}")


def number(text: str) -> float:
    """Return a number as Fortran programs write it, such as 1.5, 1.D0 or 1.0+3.

    Raises
    ------
    ValueError
        If it is none, or too large for a double.
    """
    found = _NUMBER.fullmatch(text.strip())
    if found is None:
        raise ValueError(f"{text.strip()!r} is no number")
    value = float(f"{found[1]}e{found[2] or found[3] or 0}")
    if not math.isfinite(value):
        raise ValueError(f"{text.strip()!r} is too large")
    return value


def numbers(texts: npt.NDArray[np.bytes_]) -> FloatArray:
    """Return texts as numbers, read as `number` reads them; NaN where one is none."""
    whole = texts.tobytes()
    if not any(mark in whole for mark in (b"_", b"n", b"N")):  # Python's 1_0, nan and inf
        spelled = np.frombuffer(whole.replace(b"D", b"E"), texts.dtype)
        for short in (False, True):
            if short:
                spelled = np.array(_SHORT.sub(b"E", b"\n".join(spelled.tolist())).split(b"\n"))
            with contextlib.suppress(ValueError):
                found: FloatArray = spelled.astype(float).reshape(texts.shape)
                if np.isfinite(found).all():
                    return found
    found = np.full(texts.shape, np.nan)
    for i, text in enumerate(texts.tolist()):
        with contextlib.suppress(ValueError):
            found[i] = number(text.decode("latin-1"))
    return found


def columns(lines: Any, width: int, delimiter: str | None = None, **how: Any) -> FloatArray | None:
    """Return the numbers of lines of so many each, shape (n, width); None if some are not so.

    Parameters
    ----------
    lines : sequence of str, or file
    **how
        Further keywords of `numpy.loadtxt`.
    """
    for converters in (None, number):  # NumPy reads no 1.D0 and 1.0+3
        with (
            contextlib.suppress(ValueError, OverflowError, RuntimeError),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")  # of no data
            how = {"comments": None, "ndmin": 2, "encoding": "latin-1"} | how
            found = np.loadtxt(lines, delimiter=delimiter, converters=converters, **how)
            table: FloatArray = found.reshape(len(found), -1 if len(found) else width)
            return table if table.shape[1] == width and np.isfinite(table).all() else None
    return None


def numbers_of(text: bytes) -> FloatArray:
    """Return the numbers of a text that holds nothing but numbers and blanks.

    Raises
    ------
    ValueError
        If there is anything else.
    """
    found = numbers(np.array(text.split(), "S"))
    if np.isnan(found).any():
        raise ValueError("there is text among the numbers")
    return found


def integers(values: npt.NDArray[Any]) -> IntArray:
    """Return numbers as integers.

    Raises
    ------
    ValueError
        If one is not.
    """
    if values.dtype.kind == "f":
        whole = (np.abs(values) < 2.0**53) & (values == np.trunc(values))
        if not whole.all():
            raise ValueError(f"{values[~whole][0]} is no whole number")
    return values.astype(np.int64)


@contextmanager
def opened_hdf5(file: Path) -> Iterator[Any]:
    """Open an HDF5 file, and turn h5py's errors about damaged files into a `ValueError`.

    Arrays that are larger than the file can hold are refused before they are read.
    """
    try:
        import h5py
    except ModuleNotFoundError:
        raise MeshError(f"mesh file {str(file)!r} needs h5py: pip install h5py") from None
    most = 4096 + _COMPRESSION * file.stat().st_size

    def check(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.nbytes > most:
            raise ValueError(f"{name} announces {item.nbytes} bytes, more than the file can hold")

    try:
        with h5py.File(file, "r") as tree:
            tree.visititems(check)
            yield tree
    except (OSError, RuntimeError, LookupError, TypeError, AttributeError) as error:
        raise ValueError(f"HDF5: {error}") from None


# ------------------------------------------------------------------------------- matrices


@record
class RawMatrix:
    """A matrix as its file has it.

    Attributes
    ----------
    file : Path
    name : str
        Name of the matrix, in capitals; empty if the file gives none.
    matrix : scipy.sparse.coo_array
        Its entries in the order of the file.
    labels : ndarray of int, shape (n, 2), or None
        Node and component of each row.
    triangle : bool
        True if the file says that it holds one triangle only.
    unfit : str
        Why it is neither stiffness nor mass: complex, not square, empty.
    before : int or None
        Lines before the entries, of a file of one entry a line.
    """

    file: Path
    name: str
    matrix: Any
    labels: IntArray | None = None
    triangle: bool = False
    unfit: str = ""
    before: int | None = None

    @property
    def called(self) -> str:
        """The file and, where it has names, the matrix in it."""
        return f"{self.file.name}: {self.name}" if self.name else self.file.name

    def symmetric(self) -> Any:
        """Return both triangles as a CSR array.

        Raises
        ------
        InputError
            If an entry occurs twice, or only some entries have a transposed one.
        """
        matrix, places = self.matrix.tocsr(), self.matrix.coords
        if matrix.nnz < self.matrix.nnz:
            again = int(twins(np.stack(places, axis=1))[1][0])
            row, column = (at(self.labels, int(of[again])) for of in places)
            line = None if self.before is None else entry_line(self.file, self.before, again + 1)
            why = f"the entry of {row} and {column} is there twice: are two files joined in it?"
            raise spoilt(self.file, why, line)
        there = matrix.astype(bool)
        there.data[:] = True  # entries that are 0 are there as well
        paired = there.multiply(there.T).nnz - int(there.diagonal().sum())
        off = matrix.nnz - int(there.diagonal().sum())
        if paired == 0 and off:
            return sp.csr_array(matrix + matrix.T - sp.diags_array(matrix.diagonal()))
        if self.triangle and paired:
            raise spoilt(self.file, "it says symmetric, but has both triangles; say general")
        limit = PRINTED * float(np.abs(matrix.data).max(initial=0.0))
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
    small = (np.abs(nodes) < _LARGEST_NODE) & (components >= 0) & (components < _COMPONENTS)
    if not small.all():
        raise spoilt(file, "a node or component is too large: are columns mixed up?")
    known, places = np.unique(codes(np.stack([nodes, components], axis=1)), return_inverse=True)
    labels = np.stack(np.divmod(known, _COMPONENTS), axis=1)
    entries = values, (places[: len(values)], places[len(values) :])
    matrix = sp.coo_array(entries, shape=(len(known), len(known)))
    return RawMatrix(file, name, matrix, labels, **more)


def passed_over(file: Path, name: str, why: str) -> RawMatrix:
    """Return a matrix without entries: its file may have others."""
    return RawMatrix(file, name, sp.coo_array((0, 0)), unfit=why)


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
