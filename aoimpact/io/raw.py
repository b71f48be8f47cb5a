"""Meshes and matrices as they are in files, and functions that several readers share."""

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

# `LINES`, `POINTS`: meshio's kinds by number of nodes. `DIMENSIONS`: words for cells by dimension.
LINES = {2: "line", 3: "line3"}
POINTS = {1: "vertex"}
DIMENSIONS = ("point", "line", "surface", "volume")

# For each node in VTK's order, its number in the order of Exodus and Nastran, where midside nodes
# of the upright edges precede the midside nodes of the top edges.
UPRIGHT_FIRST = {
    "hexahedron20": (*range(12), *range(16, 20), *range(12, 16)),
    "wedge15": (*range(9), *range(12, 15), *range(9, 12)),
}

# Dimension and number of corners of a cell, by its shape: the name of its kind without digits.
_SHAPES = {
    **{"other": (0, 0), "vertex": (0, 1), "line": (1, 2)},
    **{"triangle": (2, 3), "quad": (2, 4), "polygon": (2, 0)},
    **{"tetra": (3, 4), "pyramid": (3, 5), "wedge": (3, 6), "hexahedron": (3, 8)},
}

# Pattern of numbers as Fortran writes them: 1, -1.5, .5E3, 1.D0, and 1.0+3 for 1.0E+3.
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[EDed]([+-]?\d+)|([+-]\d+))?")

_SHORT = re.compile(rb"(?<=[\d.])(?=[-+]\d)")  # the place in 1.0+3 where E is missing

# Exclusive upper bounds of component and node number of a matrix row: `codes` packs both into one
# integer.
_COMPONENTS, _LARGEST_NODE = 64, 2**40

# Largest ratio of the size of data to the size of their HDF5 file: zlib's strongest compression.
_COMPRESSION = 1100


@record
class RawBlock:
    """Cells of one kind, of any dimension, in the order of the file.

    Attributes
    ----------
    kind : str
        meshio's name, such as "tetra10", "quad8" or "line", with nodes in meshio's (VTK's) order;
        "other" for elements without volume whose nodes are not read.
    cells : ndarray of int, shape (n, nodes per cell)
        Nodes of each cell, as row numbers of `RawMesh.nodes`.
    labels : ndarray of int, shape (n,), or None
        Numbers of the elements in the file; None for formats without numbers.
    name : str
        Name of the element type in the deck, such as "CPS4"; "" for formats without such names.
    """

    kind: str
    cells: IntArray
    labels: IntArray | None = None
    name: str = ""

    @property
    def dim(self) -> int:
        """Dimension of the cells, from 0 for points to 3 for solids."""
        return _SHAPES.get(self.kind.rstrip("0123456789"), (3, 0))[0]


@record
class RawMesh:
    """Nodes, cells and named groups as read from a file.

    Attributes
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates in the file's unit of length and in global axes.
    blocks : tuple of RawBlock
    node_sets : mapping of str to ndarray of int
        Named sets of nodes, as row numbers of `nodes`.
    cell_sets : mapping of str to ndarray of int
        Named groups of cells of any dimension, numbered from 0 through all blocks.
    node_labels : ndarray of int, shape (n_nodes,), or None
        Numbers of the nodes in the file; None for formats without numbers. A number may occur
        twice, as in two instances of an Abaqus part.
    left_out : mapping of str to str
        By group, counts of its elements that cannot make up a body together with its other
        elements, as in "3 MASS, 20 S4R".
    deck : AbaqusDeck, NastranDeck or None
        Contents of the deck beyond its mesh; None for other formats, where cells of lower dimension
        may just be sides and edges. `deck.sections` counts the entries of shell and beam sections,
        as in "2 PSHELL"; `deck.read` takes a `sections.Source` and returns the sections, in SI
        units, by group.
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
        """Number of each block's first cell, then the count of cells, shape (n_blocks + 1,)."""
        return firsts(block.cells for block in self.blocks)

    @property
    def dims(self) -> IntArray:
        """Dimension of each cell, in the order of the blocks."""
        return np.repeat([block.dim for block in self.blocks], np.diff(self.first))

    @property
    def contents(self) -> str:
        """Counts of cells by name of their type, as in "100 CPS4"."""
        return listed((of.name or of.kind, len(of.cells)) for of in self.blocks)

    @property
    def numbers(self) -> list[IntArray]:
        """For each block, the numbers of its cells, counted from 0 through all blocks."""
        return [np.arange(start, stop) for start, stop in pairwise(self.first.tolist())]

    def block_of(self, members: IntArray | int) -> IntArray:
        """Return, for each cell number, the number of the block that contains it."""
        return np.searchsorted(self.first, members, side="right") - 1

    def rows(self, members: IntArray) -> Iterator[tuple[RawBlock, IntArray]]:
        """Yield each block, and the rows within it of the cells numbered `members`."""
        for block, (start, stop) in zip(self.blocks, pairwise(self.first.tolist()), strict=True):
            yield block, members[(members >= start) & (members < stop)] - start

    @property
    def cell_labels(self) -> IntArray | None:
        """Numbers that the file gives to all cells; None if a block has no numbers."""
        labels = [block.labels for block in self.blocks if block.labels is not None]
        return np.concatenate(labels) if 0 < len(labels) == len(self.blocks) else None


def nodes_in(kind: str) -> int:
    """Return the number of nodes in a cell of one of meshio's kinds, such as 10 for "tetra10"."""
    shape = kind.rstrip("0123456789")
    return int(kind[len(shape) :] or _SHAPES[shape][1])


def firsts(parts: Iterable[Any]) -> IntArray:
    """Return the index of each part's first item in the joined parts, then the total count."""
    return np.cumsum([0, *map(len, parts)], dtype=np.int64)


def joined(parts: Iterable[IntArray]) -> IntArray:
    """Return the concatenation of integer arrays, which is empty if there are no arrays."""
    return np.concatenate([np.zeros(0, np.int64), *parts])


def grouped(members: Iterable[tuple[str, IntArray]]) -> dict[str, IntArray]:
    """Return the sorted members of each group that is not empty, from pairs of name and members."""
    found: dict[str, list[IntArray]] = {}
    for name, some in members:
        if len(some):
            found.setdefault(name, []).append(some)
    return {name: np.unique(joined(parts)) for name, parts in found.items()}


def rows_of(known: IntArray, wanted: IntArray) -> IntArray:
    """Return the row in `known` of each label, in the shape of `wanted`; -1 if absent."""
    if not len(known):
        return np.full(wanted.shape, -1)
    order = None if (known[1:] >= known[:-1]).all() else np.argsort(known, kind="stable")
    rows = np.searchsorted(known, wanted, sorter=order).clip(max=len(known) - 1)
    rows = rows if order is None else order[rows]
    return np.where(known[rows] == wanted, rows, -1)


def cells_of(known: IntArray, labels: IntArray, nodes: IntArray, refuse: Any) -> IntArray:
    """Return the rows of the elements' nodes in `known`; refuse elements with unknown nodes.

    Parameters
    ----------
    known : ndarray of int
        Labels of all nodes.
    labels : ndarray of int, shape (n,)
        Labels of the elements, for messages.
    nodes : ndarray of int, shape (n, nodes per element)
        Labels of the elements' nodes.
    refuse : callable
        Function that makes the error from the row of the element and the reason.
    """
    rows = rows_of(known, nodes)
    for row, column in np.argwhere(rows < 0)[:1].tolist():
        why = f"element {labels[row]} has node {nodes[row, column]}, which is not there"
        raise refuse(row, why)
    return rows


def repeats(labels: IntArray) -> IntArray:
    """Return the rows whose label occurs in an earlier row, sorted by label."""
    order = np.argsort(labels, kind="stable")
    return np.asarray(order[1:][np.diff(labels[order]) == 0])


def labels_of(arrays: Any, name: str, count: int) -> IntArray | None:
    """Return `arrays[name]`, the file's numbers of its `count` nodes or cells; None if absent.

    Raises
    ------
    ValueError
        If the array's length is not `count`.
    """
    if name not in arrays:
        return None
    found: IntArray = np.asarray(arrays[name][()], np.int64).reshape(-1)
    check_count(f"numbers {name}", count, len(found))
    return found


def listed(counts: Iterable[tuple[str, int]]) -> str:
    """Return the total count of each name as text, as in "100 CPS4, 2 S4R"."""
    found = Counter[str]()
    for name, count in counts:
        found[name] += count
    return ", ".join(f"{count} {name}" for name, count in sorted((+found).items()))


def once(labels: IntArray, places: Any, refuse: Callable[[int], MeshError]) -> IntArray:
    """Return the first row of each label, by ascending label; refuse a label with two places."""
    _, first, own = np.unique(labels, return_index=True, return_inverse=True)
    for row in np.flatnonzero((places != places[first[own]]).any(axis=1))[:1].tolist():
        raise refuse(row)
    return first


@contextmanager
def naming(what: str) -> Iterator[None]:
    """Prefix messages of errors with `what`: the name of an argument, or of a part of the file."""
    try:
        yield
    except (ValueError, OverflowError) as error:
        if str(error).startswith(what):
            raise
        raise type(error)(f"{what}: {error}") from error


def check_count(what: str, announced: int, there: int) -> None:
    """Refuse a file that announces another count of `what` than it has."""
    if there != announced:
        raise ValueError(f"{announced} {what} are announced, but {there} are there")


def read_text(file: Path) -> str:
    """Return the content of a text file, with "\\n" for each end of a line.

    The byte order mark tells the encoding; without it, the file is read as UTF-8 or else Latin-1.

    Raises
    ------
    MeshError
        If the file is binary.
    """
    text = decoded(file.read_bytes())
    if text is None:
        raise MeshError(f"mesh file {str(file)!r} is binary; a text file is needed")
    return text


class Line(NamedTuple):
    """A line of a deck: text (str or bytes), file, line number from 1, and order in the deck."""

    text: Any
    file: Path
    number: int
    order: int

    def refused(self, what: str, why: str) -> MeshError:
        """Return the error for the keyword or entry `what`, such as "*NODE", in this line."""
        return MeshError(f"mesh file {str(self.file)!r}, line {self.number}, {what}: {why}")


def number(text: str) -> float:
    """Return the number that a text gives in Fortran's or C's form: 1.5, 1.D0 or 1.0+3.

    Raises
    ------
    ValueError
        If the text is no number, or the number is too large for a double.
    """
    found = _NUMBER.fullmatch(text.strip())
    if found is None:
        raise ValueError(f"{text.strip()!r} is no number")
    value = float(f"{found[1]}e{found[2] or found[3] or 0}")
    if not math.isfinite(value):
        raise ValueError(f"{text.strip()!r} is too large")
    return value


def numbers(texts: npt.NDArray[np.bytes_]) -> FloatArray:
    """Return the number in each text, as read by `number`; NaN if a text is no number."""
    whole = texts.tobytes()
    if not any(mark in whole for mark in (b"_", b"n", b"N")):  # Python alone accepts 1_0, nan, inf
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
    """Return a table of `width` numbers per line, shape (n, width); None for any other content.

    Parameters
    ----------
    lines : sequence of str, or file
    width : int
    delimiter : str, optional
        Separator of the numbers; blanks by default.
    **how
        Other keywords of `numpy.loadtxt`.
    """
    for converters in (None, number):  # NumPy reads no 1.D0 and 1.0+3
        with (
            contextlib.suppress(ValueError, OverflowError, RuntimeError),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")  # NumPy's warning of missing data
            how = {"comments": None, "ndmin": 2, "encoding": "latin-1"} | how
            found = np.loadtxt(lines, delimiter=delimiter, converters=converters, **how)
            table: FloatArray = found.reshape(len(found), -1 if len(found) else width)
            return table if table.shape[1] == width and np.isfinite(table).all() else None
    return None


def numbers_of(text: bytes) -> FloatArray:
    """Return the numbers in a text that consists of numbers and blanks only.

    Raises
    ------
    ValueError
        If the text has other contents.
    """
    found = numbers(np.array(text.split(), "S"))
    if np.isnan(found).any():
        raise ValueError("there is text among the numbers")
    return found


def integers(values: npt.NDArray[Any]) -> IntArray:
    """Return an array of whole numbers converted to integers.

    Raises
    ------
    ValueError
        If a value is no whole number.
    """
    if values.dtype.kind == "f":
        whole = (np.abs(values) < 2.0**53) & (values == np.trunc(values))
        if not whole.all():
            raise ValueError(f"{values[~whole][0]} is no whole number")
    return values.astype(np.int64)


@contextmanager
def opened_hdf5(file: Path) -> Iterator[Any]:
    """Open an HDF5 file; h5py's errors about damaged files become `ValueError`.

    Arrays that announce more data than the file can hold are refused before they are read.
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
    """A matrix as read from a file.

    Attributes
    ----------
    file : Path
    name : str
        Name of the matrix, in capitals; empty if the file gives none.
    matrix : scipy.sparse.coo_array
        Entries in the order of the file.
    labels : ndarray of int, shape (n, 2), or None
        Node and component of each row.
    triangle : bool
        True if the file declares that it holds one triangle only.
    unfit : str
        Reason why the matrix is neither stiffness nor mass (complex, not square, empty); else "".
    before : int or None
        Number of lines before the first entry, in files with one entry per line; else None.
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
        """Name for messages: the file's name, and the matrix's name if it has one."""
        return f"{self.file.name}: {self.name}" if self.name else self.file.name

    def symmetric(self) -> Any:
        """Return the full symmetric matrix as a CSR array.

        Raises
        ------
        InputError
            If an entry occurs twice, or if only some entries (i, j) have an entry (j, i).
        """
        matrix, places = self.matrix.tocsr(), self.matrix.coords
        if matrix.nnz < self.matrix.nnz:
            again = int(twins(np.stack(places, axis=1))[1][0])
            row, column = (at(self.labels, int(of[again])) for of in places)
            line = None if self.before is None else entry_line(self.file, self.before, again + 1)
            why = f"the entry of {row} and {column} is there twice: are two files joined in it?"
            raise spoilt(self.file, why, line)
        there = matrix.astype(bool)
        there.data[:] = True  # explicit zeros count as entries
        paired = there.multiply(there.T).nnz - int(there.diagonal().sum())
        off = matrix.nnz - int(there.diagonal().sum())
        if paired == 0 and off:
            return sp.csr_array(matrix + matrix.T - sp.diags_array(matrix.diagonal()))
        if self.triangle and paired:
            raise spoilt(self.file, "declared symmetric, but has both triangles; say general")
        limit = PRINTED * float(np.abs(matrix.data).max(initial=0.0))
        if paired < off and float(abs(matrix - matrix.T).max()) > limit:
            lack = f"{off - paired} of {off} entries lack the transposed one"
            raise spoilt(self.file, f"{lack}: is the file cut short?")
        return matrix


def at(labels: IntArray | None, row: int) -> str:
    """Return the name of a row or column for messages: its dof or, if unknown, its number."""
    return f"row {row + 1}" if labels is None else "dof {}.{}".format(*labels[row])


def codes(labels: IntArray) -> IntArray:
    """Return node and component, shape (n, 2), as one integer for each row, shape (n,)."""
    return labels[:, 0] * _COMPONENTS + labels[:, 1]


def labelled(file: Path, name: str, rows: Any, cols: Any, values: Any, **more: Any) -> RawMatrix:
    """Return the matrix of entries whose rows and columns are given by node and component.

    Parameters
    ----------
    rows, cols : sequence of two ndarrays of int
        Node and component of the row, or column, of each entry.
    values : ndarray
        Values of the entries.
    **more
        Further attributes of `RawMatrix`.

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
    """Return an empty matrix that stands for an unfit one: others in the file remain usable."""
    return RawMatrix(file, name, sp.coo_array((0, 0)), unfit=why)


def entry_line(file: Path, before: int, entry: int) -> int:
    """Return the number of the line that holds an entry, in a file with one entry per line.

    Lines and entries are counted from 1; `before` lines precede the entries.
    """
    with file.open("rb") as stream:
        for number, line in enumerate(stream, 1):
            entry -= number > before and bool(line.strip())
            if not entry:
                return number
    return number


def spoilt(file: Path, why: str, line: int | None = None) -> InputError:
    """Return the error that says why a matrix file, or a line of it, is refused."""
    place = "" if line is None else f", line {line}"
    return InputError(f"matrix file {str(file)!r}{place}: {why}")
