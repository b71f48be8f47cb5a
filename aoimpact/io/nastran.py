"""Nastran's bulk data as a mesh: nodes, elements, and groups by property and by set."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray, IntArray, warn
from ..mesh import reference_element
from .nastrandeck import BulkData, Lines, Table, read_bulk_data, read_sections
from .nastrannames import CONNECTIONS, OTHER_ELEMENTS, SKIPPED
from .raw import UPRIGHT_FIRST, RawBlock, RawMesh, cylindrical, joined, nodes_in, repeats, rows_of

# Kinds of elements of corners, and with midside nodes, by the names of entries.
_ELEMENTS = {
    ("CTETRA",): ("tetra", "tetra10"),
    ("CHEXA",): ("hexahedron", "hexahedron20"),
    ("CPENTA",): ("wedge", "wedge15"),
    ("CPYRAM", "CPYRA"): ("pyramid", "pyramid13"),
    ("CTRIA3", "CTRIAR"): ("triangle",),
    ("CTRIA6",): ("triangle", "triangle6"),
    ("CQUAD4", "CQUADR", "CSHEAR"): ("quad",),
    ("CQUAD8",): ("quad", "quad8"),
    ("CBAR", "CBEAM", "CBEND", "CROD", "CTUBE"): ("line",),
    ("CONROD",): ("line",),
    ("CBEAM3",): ("line", "line3"),
}
_SOLIDS = {"CTETRA", "CHEXA", "CPENTA", "CPYRAM"}
_READ = {name for names in _ELEMENTS for name in names} | {
    *("GRID", "SET", "SET1", "SET3"),
    *(f"CORD{i}{kind}" for i in "12" for kind in "RCS"),
}

# Properties by the dimension of their elements.
PROPERTIES = {
    1: re.compile("P(BAR|BARL|BEAM|BEAML|BEAM3|BCOMP|B[MR]SECT|BEND|ROD|TUBE)"),
    2: re.compile("P(SHELL|COMPG?|SHEAR|L?PLANE|SHLN[12])"),
    3: re.compile("P(SOLID|LSOLID|COMPL?S)"),
}

# Largest difference between axes of displacements and the basic ones.
_TURNED = 1e-9

# Relative distance from a line below which three points define no axes.
_COLLINEAR = 1e-8

# Largest number of coordinate systems that refer to each other, one after the other.
_DEEPEST = 200

_SET = re.compile(r"SET\s+(\d+)\s*=(.*)")

# Members of a set of bulk data by its type; sets of other types are of neither.
_BOTH = ("nodes", "elements")
_MEMBERS = {"GRID": _BOTH[:1], "NODE": _BOTH[:1], "ELEM": _BOTH[1:], "ELEMENT": _BOTH[1:]}


@dataclass(frozen=True, eq=False)
class NastranDeck:
    """Case control and bulk data, nodes, and elements block by block as the mesh has them."""

    control: Lines
    bulk: BulkData
    grids: Grids
    parts: list[Entries]

    elements = ""  # by types of their own: all are in the mesh

    @property
    def sections(self) -> str:
        """Properties of shells and beams, as in "2 PSHELL"."""
        return ", ".join(
            f"{len(lines)} {name}"
            for name, lines in sorted(self.bulk.names.items())
            if any(pattern.fullmatch(name) for pattern in (PROPERTIES[1], PROPERTIES[2]))
        )


def read(file: Path) -> RawMesh:
    """Return the mesh of a Nastran deck.

    Elements with the same property make a group such as "property 3". Where a shell's and a bar's
    property have one number, the bars are "property 3 lines". A set (SET of the case control; SET1,
    SET3, SET of bulk data) becomes "SET 5 nodes" where all its numbers are those of
    nodes and "SET 5 elements" where they are those of elements; often both are possible.

    Raises
    ------
    MeshError
        If a line is not understood: with file and line.
    MemoryLimitError

    Warns
    -----
    AOImpactWarning
        If there are elements or connections that are left out.
    """
    control, lines = read_sections(file)
    deck = read_bulk_data(lines)
    grids = Grids.of(deck)
    nodes = grids.coordinates()
    elements = [part for names in _ELEMENTS for part in _elements(deck, names, grids)]
    for part in elements:
        if part.block.dim == 3:
            _make_right_handed(nodes, part.block)
    raw = RawMesh(nodes, tuple(part.block for part in elements))
    labels = joined([] if raw.cell_labels is None else [raw.cell_labels])
    for number in repeats(labels)[:1].tolist():
        at = int(np.searchsorted(raw.first, number, side="right")) - 1
        why = f"element {labels[number]} is there twice"
        raise elements[at].table.refused(number - raw.first[at], why)
    cell_sets = _by_property(deck, elements)
    node_sets = {}
    for name, one in _sets(control, deck).items():
        if "nodes" in one.kinds:
            node_sets[f"{name} nodes"] = one.among(grids.labels)
        if "elements" in one.kinds:
            cell_sets[f"{name} elements"] = one.among(labels)
    if beside := _beside([part.block for part in elements], set(deck.names), len(nodes)):
        warn(
            f"mesh file {str(file)!r}: {beside} are not part of the body, unless their groups are "
            "named as shells and beams"
        )
    counts = sorted((name, len(first)) for name, first in deck.names.items())
    for pattern, what in (
        (OTHER_ELEMENTS, "elements that are not part of the mesh were left out"),
        (CONNECTIONS, "connections between nodes were left out, the body is computed without them"),
    ):
        if listed := ", ".join(f"{n} {name}" for name, n in counts if pattern.fullmatch(name)):
            warn(f"mesh file {str(file)!r}: {what}: {listed}")
    own = NastranDeck(control, deck, grids, elements)
    return RawMesh(nodes, raw.blocks, node_sets, cell_sets, grids.labels, deck=own)


def nastran_nodes(file: Path) -> tuple[IntArray, FloatArray]:
    """Return labels and basic coordinates of the nodes, whose displacements have basic axes.

    Raises
    ------
    MeshError
        As for `read`, or if a node has displacements in other axes (CD).
    """
    grids = Grids.of(read_bulk_data(read_sections(file)[1]))
    nodes = grids.coordinates()
    for label in np.unique(grids.output_systems[grids.output_systems > 0]).tolist():
        own = np.flatnonzero(grids.output_systems == label)
        directions = grids.axes(label, grids.table, int(own[0])).directions(nodes[own])
        turned = np.abs(directions - np.eye(3)).max(axis=(1, 2)) > _TURNED
        for row in own[turned][:1].tolist():
            raise grids.table.refused(
                row,
                f"node {grids.labels[row]} has displacements in system {label} (CD), so K has its "
                "rows in other axes than x, y and z; write K with CD = 0",
            )
    return grids.labels, nodes


# ----------------------------------------------------------------------------------- elements


class Entries(NamedTuple):
    """Elements of one kind: their entries, nodes with labels, and properties (0: none).

    `layout` is the kind for all of whose nodes the entries have fields, such as "quad8".
    """

    table: Table
    block: RawBlock
    properties: IntArray
    layout: str


def _elements(deck: BulkData, names: tuple[str, ...], grids: Grids) -> Iterator[Entries]:
    """Yield the elements of some entries: those of corners, and those with midside nodes."""
    kinds = _ELEMENTS[names]
    corners, most = nodes_in(kinds[0]), nodes_in(kinds[-1])
    table = deck.table(*names, width=2 + most + 14)
    first = 1 if names == ("CONROD",) else 2  # rods without a property
    if names[0] in _SOLIDS:
        surplus = np.any(~table.blank[:, 2 + most :], axis=1)
        table.refuse_first(surplus, f"it has fields after its {most} nodes")
    quadratic = np.any(~table.blank[:, first + corners : first + most], axis=1)
    for kind, own in zip(kinds, (~quadratic, quadratic), strict=False):
        if not own.any():
            continue
        part = table.select(own)
        labels = part.integers(0, 1)[:, 0]
        part.refuse_first(labels < 1, "an element needs a number greater than 0")
        properties = part.integers(1, 1)[:, 0] * (first > 1)
        properties = np.where(part.blank[:, 1], labels, properties)
        numbers = part.integers(first, nodes_in(kind))
        part.refuse_first((numbers[:, :corners] == 0).any(axis=1), "a corner has no node")
        missing = (numbers == 0).any(axis=1)
        part.refuse_first(missing, "some of its midside nodes are missing; give all or none")
        rows = rows_of(grids.labels, numbers)
        for row, column in np.argwhere(rows < 0)[:1].tolist():
            raise part.refused(row, f"node {numbers[row, column]} is not there")
        cells = rows[:, UPRIGHT_FIRST.get(kind, slice(None))]
        yield Entries(part, RawBlock(kind, cells, labels), properties, kinds[-1])


def _by_property(deck: BulkData, parts: list[Entries]) -> dict[str, IntArray]:
    """Return the groups of elements by property.

    Elements of a lower dimension have a group of their own if the deck has a property of that
    number for them. Without one they are sides and edges to which a mesher gave the number.
    """
    properties = joined(part.properties for part in parts)
    dims = np.repeat([part.block.dim for part in parts], [len(p.properties) for p in parts])
    entries = {
        dim: {
            fields[0]
            for name in filter(PROPERTIES[dim].fullmatch, deck.names)
            for _, fields in deck.long_entries(name)
        }
        for dim in (1, 2)
    }
    found = {}
    for number in np.unique(properties[properties > 0]).tolist():
        own = properties == number
        for dim, what in ((1, "lines"), (2, "surfaces")):
            lower = own & (dims == dim)
            if dim < dims[own].max() and lower.any() and str(number) in entries[dim]:
                found[f"property {number} {what}"] = np.flatnonzero(lower)
                own &= ~lower
        found[f"property {number}"] = np.flatnonzero(own)
    return found


def _beside(blocks: list[RawBlock], names: set[str], n_nodes: int) -> str:
    """Count the shells and beams: those with a section, or that are no side or edge of a solid.

    Meshers write sides and edges as elements without sections.
    """

    def corners(block: RawBlock) -> Any:
        """Return which nodes are corners of which cells, shape (n_cells, n_nodes)."""
        cells = block.cells[:, : nodes_in(block.kind.rstrip("0123456789"))]
        starts = np.arange(0, cells.size + 1, cells.shape[1])
        shape = len(cells), n_nodes
        return sp.csr_array((np.ones(cells.size), cells.ravel(), starts), shape=shape)

    counts = {1: 0, 2: 0}
    solids, others = ([b for b in blocks if (b.dim == 3) is solid] for solid in (True, False))
    if solids and others:
        of_node = sp.vstack([corners(block) for block in solids]).T
        for block in others:
            own = corners(block)
            most = (own @ of_node).max(axis=1).toarray().ravel()
            section = any(map(PROPERTIES[block.dim].fullmatch, names))
            counts[block.dim] += int(np.count_nonzero(section | (most < own.sum(axis=1))))
    said = ((counts[2], "surface elements"), (counts[1], "line elements"))
    return " and ".join(f"{count} {what}" for count, what in said if count)


def _make_right_handed(nodes: FloatArray, block: RawBlock) -> None:
    """Renumber the nodes of left-handed solids, which Nastran accepts as well."""
    element = reference_element(block.kind)
    corners = nodes[block.cells[:, : element.n_corners]]
    n_bottom = 3 if block.kind.startswith(("tetra", "wedge")) else 4
    bottom, top = corners[:, :n_bottom], corners[:, n_bottom:]
    middle = bottom.mean(axis=1)
    around = bottom - middle[:, None]
    normal = np.cross(around, np.roll(around, -1, axis=1)).sum(axis=1)
    left = np.einsum("ij,ij->i", normal, top.mean(axis=1) - middle) < 0.0
    block.cells[left] = block.cells[left][:, element.mirror]


# --------------------------------------------------------------- nodes and coordinate systems


@dataclass(frozen=True, eq=False)
class Axes:
    """A coordinate system in basic coordinates.

    Attributes
    ----------
    kind : str
        "R", "C" or "S": rectangular, cylindrical (r, θ, z) or spherical (r, θ, φ), in degrees.
    origin : ndarray, shape (3,)
    axes : ndarray, shape (3, 3)
        Unit vectors in rows.
    """

    kind: str
    origin: FloatArray
    axes: FloatArray

    def basic(self, x: FloatArray) -> FloatArray:
        """Return basic coordinates of points given in this system, shape (n, 3)."""
        if self.kind == "C":
            x = cylindrical(*x.T)
        elif self.kind == "S":
            r, theta, phi = x.T
            theta = np.radians(theta)
            x = cylindrical(r * np.sin(theta), phi, r * np.cos(theta))
        return self.origin + x @ self.axes

    def directions(self, x: FloatArray) -> FloatArray:
        """Return unit vectors of the coordinates at points given in basic coordinates.

        Returns
        -------
        ndarray, shape (n, 3, 3)
            A unit vector in each row.
        """
        local = (x - self.origin) @ self.axes.T
        along = np.arctan2(local[:, 1], local[:, 0])
        down = np.arctan2(np.hypot(local[:, 0], local[:, 1]), local[:, 2])
        c, s, ct, st = np.cos(along), np.sin(along), np.cos(down), np.sin(down)
        zero, one = np.zeros(len(x)), np.ones(len(x))
        turned = {
            "R": [[one, zero, zero], [zero, one, zero], [zero, zero, one]],
            "C": [[c, s, zero], [-s, c, zero], [zero, zero, one]],
            "S": [[st * c, st * s, ct], [ct * c, ct * s, -st], [-s, c, zero]],
        }
        result: FloatArray = np.moveaxis(np.array(turned[self.kind]), 2, 0) @ self.axes
        return result


class _Definition(NamedTuple):
    """A system as its entry gives it: by labels of nodes, or by points in another system."""

    table: Table
    row: int
    kind: str
    grids: list[int]
    reference: int = 0
    points: list[float] = []  # noqa: RUF012


@dataclass(frozen=True, eq=False)
class Grids:
    """Nodes by ascending labels, and the coordinate systems.

    Systems that refer to others are resolved when they are needed.

    Attributes
    ----------
    table : Table
        Their GRID entries.
    labels : ndarray of int, shape (n,)
    systems, output_systems : ndarray of int, shape (n,)
        Labels of the coordinate systems of coordinates (CP) and displacements (CD).
    x : ndarray, shape (n, 3)
        Coordinates in the nodes' own systems.
    definitions : mapping of int to _Definition
        Coordinate systems by label.
    """

    table: Table
    labels: IntArray
    systems: IntArray
    output_systems: IntArray
    x: FloatArray
    definitions: dict[int, _Definition]
    _known: dict[int, Axes] = field(default_factory=lambda: {0: Axes("R", np.zeros(3), np.eye(3))})
    _open: list[int] = field(default_factory=list)

    @classmethod
    def of(cls, deck: BulkData) -> Grids:
        """Return the nodes of a deck; a node that is repeated as it was counts once."""
        for name, first in deck.names.items():  # unknown entries might belong to the mesh
            known = (CONNECTIONS.fullmatch, OTHER_ELEMENTS.fullmatch, SKIPPED.match)
            if name not in _READ and not any(match(name) for match in known):
                raise deck.lines.refused(int(first[0]), name, "no entry of this name is known")
        table = deck.table("GRID", width=8)
        defaults = deck.table("GRDSET", width=8)
        systems = []
        for column in (1, 5):
            default = int(defaults.integers(column, 1)[:1].sum())
            given = table.integers(column, 1)[:, 0]
            systems.append(np.where(table.blank[:, column], default, given))
        labels, x = table.integers(0, 1)[:, 0], table.reals(2, 3)
        table.refuse_first(labels < 1, "a node needs a number greater than 0")
        order = np.argsort(labels, kind="stable")
        again = np.flatnonzero(np.diff(labels[order]) == 0) + 1
        whole = np.column_stack([x, *systems])
        moved = (whole[order[again]] != whole[order[again - 1]]).any(axis=1)
        for row in order[again[moved]][:1].tolist():
            raise table.refused(row, f"node {labels[row]} is there twice, at different places")
        kept = np.delete(order, again)
        own = (table.select(kept), labels[kept], systems[0][kept], systems[1][kept], x[kept])
        return cls(*own, _definitions(deck))

    def coordinates(self) -> FloatArray:
        """Return basic coordinates of all nodes, shape (n, 3)."""
        x = self.x.copy()
        for label in np.unique(self.systems).tolist():
            own = np.flatnonzero(self.systems == label)
            x[own] = self.axes(label, self.table, int(own[0])).basic(self.x[own])
        return x

    def axes(self, label: int, table: Table, row: int) -> Axes:
        """Return a system.

        Parameters
        ----------
        label : int
        table, row
            Entry that refers to it, for messages.

        Raises
        ------
        MeshError
            If it is not defined, or defined by itself, or by points on one line.
        """
        if label in self._known:
            return self._known[label]
        if label not in self.definitions:
            raise table.refused(row, f"coordinate system {label} is not defined (CORD1x, CORD2x)")
        if label in self._open or len(self._open) > _DEEPEST:
            raise table.refused(row, f"coordinate system {label} is defined by itself")
        one = self.definitions[label]
        self._open.append(label)
        if one.grids:
            rows = rows_of(self.labels, np.array(one.grids)).tolist()
            for node in [node for node, at in zip(one.grids, rows, strict=True) if at < 0][:1]:
                raise one.table.refused(one.row, f"node {node} is not there")
            own = [self.axes(int(self.systems[at]), one.table, one.row) for at in rows]
            points = [of.basic(self.x[at : at + 1])[0] for of, at in zip(own, rows, strict=True)]
        else:
            reference = self.axes(one.reference, one.table, one.row)
            points = list(reference.basic(np.reshape(one.points, (3, 3))))
        self._open.remove(label)
        z, x = points[1] - points[0], points[2] - points[0]
        y = np.cross(z, x)
        if not np.linalg.norm(y) > _COLLINEAR * np.linalg.norm(z) * np.linalg.norm(x):
            why = f"the three points of coordinate system {label} lie on one line"
            raise one.table.refused(one.row, why)
        axes = np.stack([np.cross(y, z), y, z])
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        self._known[label] = Axes(one.kind, points[0], axes)
        return self._known[label]


def _definitions(deck: BulkData) -> dict[int, _Definition]:
    """Return the coordinate systems of a deck: CORD1x by three nodes, CORD2x by three points."""
    given: list[tuple[int, _Definition]] = []
    for kind in "RCS":
        table = deck.table(f"CORD1{kind}", width=8)
        for row, numbers in enumerate(table.integers(0, 8).tolist()):
            given.append((numbers[0], _Definition(table, row, kind, numbers[1:4])))
            if not table.blank[row, 4:].all():  # an entry may define two
                given.append((numbers[4], _Definition(table, row, kind, numbers[5:])))
        table = deck.table(f"CORD2{kind}", width=11)
        places = table.reals(2, 9).tolist()
        for row, (label, reference) in enumerate(table.integers(0, 2).tolist()):
            given.append((label, _Definition(table, row, kind, [], reference, places[row])))
    found: dict[int, _Definition] = {}
    for label, one in given:
        if label < 1 or found.setdefault(label, one)[2:] != one[2:]:
            why = f"coordinate system {label} is there twice, or not > 0"
            raise one.table.refused(one.row, why)
    return found


# ---------------------------------------------------------------------------------------- sets


@dataclass(frozen=True)
class _NumberSet:
    """Numbers of nodes or elements.

    Attributes
    ----------
    kinds : tuple of str
        "nodes" or "elements" or both, as the numbers may be.
    single : list of int
    ranges : list of (range, list of int)
        Ranges, and the numbers in them that are left out.
    """

    kinds: tuple[str, ...]
    single: list[int] = field(default_factory=list)
    ranges: list[tuple[range, list[int]]] = field(default_factory=list)

    def among(self, labels: IntArray) -> IntArray:
        """Return the rows of `labels` in the set; none if a number given by itself is missing."""
        if not np.isin(self.single, labels).all():
            return joined([])
        chosen = np.isin(labels, self.single)
        for of, without in self.ranges:
            within = (
                (labels >= of.start) & (labels < of.stop) & ((labels - of.start) % of.step == 0)
            )
            chosen |= within & ~np.isin(labels, without)
        return np.flatnonzero(chosen)


def _sets(control: Lines, deck: BulkData) -> dict[str, _NumberSet]:
    """Return the sets by name, such as "SET 5" and "SET1 5".

    Raises
    ------
    MeshError
        If a set of bulk data is not understood.

    Warns
    -----
    AOImpactWarning
        If the case control defines a set twice, with other members.
    """
    found: dict[str, _NumberSet] = {}
    twice = set()
    lines = iter(line.decode().strip() for line in control.text)
    for line in lines:
        if line.startswith("OUTPUT("):  # sets of plots follow
            break
        while line.endswith(",") and line.startswith("SET"):
            line += " " + next(lines, "")
        if match := _SET.match(line):
            one = _parsed(re.split(r"[,\s]+", match[2].strip()), _BOTH)
            name = f"SET {int(match[1])}"
            if one is not None and found.setdefault(name, one) != one:
                twice.add(name)
    if twice:
        listed = ", ".join(sorted(twice))
        warn(f"{listed}: the case control defines it twice, with other members; it was left out")
    found = {name: one for name, one in found.items() if name not in twice}
    in_bulk: dict[str, _NumberSet] = {}
    for entry, first in (("SET1", 1), ("SET3", 2), ("SET", 8)):
        for at, fields in deck.long_entries(entry):
            kinds = _BOTH if entry == "SET1" else _MEMBERS.get(fields[1], ())
            name, one = f"{entry} {fields[0]}", _parsed(fields[first:], kinds)
            if kinds and (one is None or not fields[0].isdigit()):
                raise deck.lines.refused(at, name, "it is no list of numbers and THRU")
            if one is not None and kinds and in_bulk.setdefault(name, one) != one:
                raise deck.lines.refused(at, name, "it is defined twice, with other members")
    return found | in_bulk


def _parsed(words: list[str], kinds: tuple[str, ...]) -> _NumberSet | None:
    """Return the set of words such as 1 THRU 20 EXCEPT 7 30; None if they are something else.

    A number after EXCEPT is left out of the range before it, if it lies there; else it is in.
    """
    text = " ".join(word for word in words if word)
    one = _NumberSet(kinds)
    excepted = False
    for match in re.finditer(r"(\d+) THRU (\d+)(?: BY (\d+))?(?= |$)|(\S+)(?: |$)", text):
        first, last, step, word = match.groups()
        if first:
            if step and not int(step):
                return None
            one.ranges.append((range(int(first), int(last) + 1, int(step or 1)), []))
            excepted = False
        elif word == "EXCEPT" and one.ranges:
            excepted = True
        elif not word.isdigit():
            return None
        elif excepted and one.ranges[-1][0].start <= int(word) < one.ranges[-1][0].stop:
            one.ranges[-1][1].append(int(word))
        else:
            one.single.append(int(word))
    return one if text else None
