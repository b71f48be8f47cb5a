"""Nastran's bulk data as a mesh: nodes, elements, and groups by property and by set."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...base import FloatArray, IntArray, warn
from .bulkdata import BulkData, Table, read_bulk_data
from .bulknames import CONNECTIONS, OTHER_ELEMENTS, is_skipped
from .coordsystems import Grids, read_systems
from ..elements import reference_element
from .nastransets import read_sets
from .nastrantext import read_sections
from .rawmesh import UPRIGHT_FIRST, RawBlock, RawMesh

__all__ = ["nastran_nodes", "read"]

# By the names of entries: corners and meshio's kind, then all nodes and kind with midside nodes.
_ELEMENTS: dict[tuple[str, ...], tuple[tuple[int, str], ...]] = {
    ("CTETRA",): ((4, "tetra"), (10, "tetra10")),
    ("CHEXA",): ((8, "hexahedron"), (20, "hexahedron20")),
    ("CPENTA",): ((6, "wedge"), (15, "wedge15")),
    ("CPYRAM", "CPYRA"): ((5, "pyramid"), (13, "pyramid13")),
    ("CTRIA3", "CTRIAR"): ((3, "triangle"),),
    ("CTRIA6",): ((3, "triangle"), (6, "triangle6")),
    ("CQUAD4", "CQUADR", "CSHEAR"): ((4, "quad"),),
    ("CQUAD8",): ((4, "quad"), (8, "quad8")),
    ("CBAR", "CBEAM", "CBEND", "CROD", "CTUBE"): ((2, "line"),),
    ("CONROD",): ((2, "line"),),
    ("CBEAM3",): ((2, "line"), (3, "line3")),
}

_SOLIDS = {"CTETRA", "CHEXA", "CPENTA", "CPYRAM"}

# Axes of displacements that differ less than this from the basic ones are these.
_TURNED = 1e-9

_READ = {name for names in _ELEMENTS for name in names} | {
    *("GRID", "SET", "SET1", "SET3"),
    *(f"CORD{i}{kind}" for i in "12" for kind in "RCS"),
}


@dataclass(frozen=True, eq=False)
class _Elements:
    """Elements of one kind: their entries, corners and numbers of properties (0: none)."""

    table: Table
    block: RawBlock
    labels: IntArray
    properties: IntArray


def read(file: Path) -> RawMesh:
    """Return the mesh of a Nastran deck.

    Elements with the same property make a group such as "property 3". A set (SET of the case
    control; SET1, SET3, SET of bulk data) becomes "SET 5 nodes" where all its numbers are those of
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
    _check_names(deck)
    grids = _grids(deck)
    nodes = read_systems(deck, grids).coordinates()
    elements = [part for names in _ELEMENTS for part in _elements(deck, names, grids)]
    for part in elements:
        if part.block.dim == 3:
            _make_right_handed(nodes, part.block)
    labels = _joined([part.labels for part in elements])
    _check_unique(elements, labels)
    properties = _joined([part.properties for part in elements])
    cell_sets = {
        f"property {number}": np.flatnonzero(properties == number)
        for number in np.unique(properties[properties > 0])
    }
    node_sets = {}
    for name, one in read_sets(control, deck).items():
        if "nodes" in one.kinds:
            node_sets[f"{name} nodes"] = one.among(grids.labels)
        if "elements" in one.kinds:
            cell_sets[f"{name} elements"] = one.among(labels)
    _warn_of_rest(deck, file)
    return RawMesh(
        nodes,
        tuple(part.block for part in elements),
        {name: rows for name, rows in node_sets.items() if len(rows)},
        {name: cells for name, cells in cell_sets.items() if len(cells)},
        grids.labels,
    )


def nastran_nodes(file: Path) -> tuple[IntArray, FloatArray]:
    """Return labels and basic coordinates of the nodes, whose displacements have basic axes.

    Raises
    ------
    MeshError
        As for `read`, or if a node has displacements in other axes (CD).
    """
    deck = read_bulk_data(read_sections(file)[1])
    _check_names(deck)
    grids = _grids(deck)
    systems = read_systems(deck, grids)
    nodes = systems.coordinates()
    for label in np.unique(grids.output_systems[grids.output_systems > 0]):
        own = np.flatnonzero(grids.output_systems == label)
        axes = systems.axes(int(label), grids.table, int(own[0]))
        turned = np.abs(axes.directions(nodes[own]) - np.eye(3)).max(axis=(1, 2)) > _TURNED
        if turned.any():
            row = int(own[turned][0])
            raise grids.table.refused(
                row,
                f"node {grids.labels[row]} has displacements in system {label} (CD), so K has its "
                "rows in other axes than x, y and z; write K with CD = 0",
            )
    return grids.labels, nodes


def _joined(parts: list[IntArray]) -> IntArray:
    return np.concatenate([np.zeros(0, np.int64), *parts])


def _check_names(deck: BulkData) -> None:
    """Refuse entries of unknown names: these might have to do with the mesh."""
    for name, first in deck.names.items():
        known = name in _READ or CONNECTIONS.fullmatch(name) or OTHER_ELEMENTS.fullmatch(name)
        if not known and not is_skipped(name):
            raise deck.lines.refused(int(first[0]), name, "no entry of this name is known")


def _grids(deck: BulkData) -> Grids:
    """Return the nodes by label; a node that is repeated as it was counts once."""
    table = deck.table("GRID", width=8)
    defaults = deck.table("GRDSET", width=8)
    systems = []
    for column in (1, 5):
        given = table.integers(column, 1)[:, 0]
        default = int(defaults.integers(column, 1)[:1].sum())
        systems.append(np.where(table.blank[:, column], default, given))
    labels, x = table.integers(0, 1)[:, 0], table.reals(2, 3)
    table.refuse_first(labels < 1, "a node needs a number greater than 0")
    order = np.argsort(labels, kind="stable")
    again = np.flatnonzero(np.diff(labels[order]) == 0) + 1
    earlier, later = order[again - 1], order[again]
    moved = (x[later] != x[earlier]).any(axis=1)
    for values in systems:
        moved |= values[later] != values[earlier]
    if moved.any():
        row = int(later[moved][0])
        raise table.refused(row, f"node {labels[row]} is there twice, at different places")
    kept = np.delete(order, again)
    return Grids(table.select(kept), labels[kept], systems[0][kept], systems[1][kept], x[kept])


def _elements(deck: BulkData, names: tuple[str, ...], grids: Grids) -> Iterator[_Elements]:
    """Yield the elements of some entries: those of corners, and those with midside nodes."""
    kinds = _ELEMENTS[names]
    corners, most = kinds[0][0], kinds[-1][0]
    table = deck.table(*names, width=2 + most + 8)
    first = 1 if names == ("CONROD",) else 2  # rods without a property
    if names[0] in _SOLIDS:
        surplus = np.any(~table.blank[:, 2 + most :], axis=1)
        table.refuse_first(surplus, f"it has fields after its {most} nodes")
    quadratic = np.any(~table.blank[:, first + corners : first + most], axis=1)
    for (count, kind), own in zip(kinds, (~quadratic, quadratic), strict=False):
        if own.any():
            part = table.select(own)
            labels = part.integers(0, 1)[:, 0]
            part.refuse_first(labels < 1, "an element needs a number greater than 0")
            properties = part.integers(1, 1)[:, 0] * (first > 1)
            properties = np.where(part.blank[:, 1], labels, properties)
            numbers = part.integers(first, count)
            part.refuse_first((numbers[:, :corners] == 0).any(axis=1), "a corner has no node")
            missing = (numbers == 0).any(axis=1)
            part.refuse_first(missing, "some of its midside nodes are missing; give all or none")
            rows = grids.rows(numbers)
            if (rows < 0).any():
                row, column = np.argwhere(rows < 0)[0]
                raise part.refused(row, f"node {numbers[row, column]} is not there")
            cells = rows[:, UPRIGHT_FIRST.get(kind, slice(None))]
            yield _Elements(part, RawBlock(kind, cells, labels), labels, properties)


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


def _check_unique(elements: list[_Elements], labels: IntArray) -> None:
    order = np.argsort(labels, kind="stable")
    again = order[1:][np.diff(labels[order]) == 0]
    if not len(again):
        return
    number, first = int(again[0]), 0
    for part in elements:
        if number < first + len(part.labels):
            label = labels[number]
            raise part.table.refused(number - first, f"element {label} is there twice")
        first += len(part.labels)


def _warn_of_rest(deck: BulkData, file: Path) -> None:
    """Say which elements and connections the mesh does not have."""
    counts = sorted((name, len(first)) for name, first in deck.names.items())
    others = [f"{n} {name}" for name, n in counts if OTHER_ELEMENTS.fullmatch(name)]
    links = [f"{n} {name}" for name, n in counts if CONNECTIONS.fullmatch(name)]
    for listed, what in (
        (others, "elements that are not part of the mesh were left out"),
        (links, "connections between nodes were left out, and the body is computed without them"),
    ):
        if listed:
            warn(f"mesh file {str(file)!r}: {what}: {', '.join(listed)}")
