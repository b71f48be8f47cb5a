"""Kratos Multiphysics' model parts (.mdpa): elements, conditions and sub-model parts."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ...base import IntArray
from .rawmesh import LINES, SOLIDS, SURFACES, UPRIGHT_FIRST, RawBlock, RawMesh, rows_of
from .textfile import integers

__all__ = ["read"]

_POINT = {1: "vertex"}

# Elements in space that are no solids, by a part of their names.
_SURFACE_NAMES = re.compile("shell|membrane|surface|plate|triangle|quadrilateral|2d", re.IGNORECASE)
_LINE_NAMES = re.compile(
    "beam|truss|cable|line(?!ar)|spring|damper|nodal|point|mass|rotation", re.IGNORECASE
)

# Kratos' numbers of the nodes within an element, in VTK's order: those of GiD.
_ORDERS = UPRIGHT_FIRST | {
    "hexahedron27": (*UPRIGHT_FIRST["hexahedron20"], 24, 22, 21, 23, 20, 25, 26),
}

# What the parts of a sub-model part name, and blocks without influence on mesh and groups.
_MEMBERS = {
    f"SubModelPart{what}": what for what in ("Nodes", "Elements", "Conditions", "Geometries")
}
_IGNORED = re.compile(r"SubModelPart(Tables|Properties)?|Mesh\w*|Properties|Table|\w+Data")

# Rows of numbers by what they are: nodes, elements, …, and the numbers before the nodes.
_HEAD = {"Elements": 2, "Conditions": 2, "Geometries": 1}


def read(file: Path) -> RawMesh:
    """Return the mesh in a model part, with the sub-model parts as groups.

    Raises
    ------
    ValueError
        If the file is damaged or has a block that is not known; the line is named.
    """
    nodes: list[list[str]] = []
    tables: list[tuple[str, str, list[list[str]]]] = []  # what, the name of the element, its rows
    members: dict[str, list[tuple[str, list[list[str]]]]] = {}
    stack: list[tuple[str, str]] = []
    rows: list[list[str]] | None = None
    for number, line in enumerate(file.read_bytes().decode("utf-8", "replace").splitlines(), 1):
        words = line.partition("//")[0].split()
        if not words:
            continue
        if words[0] == "Begin" and len(words) > 1:
            what, name = words[1], " ".join(words[2:])
            stack.append((what, name))
            path = [part for kind, part in stack if kind == "SubModelPart"]
            rows = []
            if what == "Nodes":
                nodes = rows
            elif what in _HEAD:
                tables.append((what, name, rows))
            elif what in _MEMBERS and path:  # members of a part are those of all parts around it
                for depth in range(1, 1 + len(path)):
                    around = members.setdefault(".".join(path[:depth]), [])
                    around.append((_MEMBERS[what], rows))
            elif not _IGNORED.fullmatch(what):
                raise ValueError(f"line {number}: the block {what!r} is not known")
        elif words[0] == "End":
            if not stack or words[1:2] != [stack[-1][0]]:
                raise ValueError(f"line {number}: {line.strip()!r} ends no block that is open")
            stack.pop()
            rows = None
        elif not stack:
            raise ValueError(f"line {number}: {line.strip()[:40]!r} is outside of any block")
        elif rows is not None:
            rows.append(words)
    if stack:
        raise ValueError(f"the block {stack[-1][0]!r} has no end")
    return _mesh(nodes, tables, members)


def _table(what: str, rows: list[list[str]], dtype: type) -> list[tuple[float, ...]]:
    try:
        return [tuple(dtype(word) for word in row) for row in rows]
    except ValueError as error:
        raise ValueError(f"{what}: {error}") from None


def _mesh(
    nodes: list[list[str]],
    tables: list[tuple[str, str, list[list[str]]]],
    members: dict[str, list[tuple[str, list[list[str]]]]],
) -> RawMesh:
    places = _table("Nodes", nodes, float)
    if any(len(row) != 4 for row in places):
        raise ValueError("Nodes: a row is not a number and x, y, z")
    table = np.array(places, dtype=np.float64).reshape(-1, 4)
    labels = integers(table[:, 0])
    _check_once("Nodes", labels)
    blocks: list[RawBlock] = []
    none = np.zeros(0, dtype=np.int64)
    known = {"Elements": none, "Conditions": none}  # their labels, and
    numbers = dict(known)  # their numbers among all cells
    for what, name, rows in tables:
        for width in sorted({len(row) for row in rows}):
            own = np.array(
                _table(what, [row for row in rows if len(row) == width], int), dtype=np.int64
            )
            kind = _kind(what, name, width - _HEAD[what])
            cells = _looked_up(labels, own[:, _HEAD[what] :], f"{what} {name}")
            if kind in _ORDERS:
                cells = cells[:, _ORDERS[kind]]
            if what == "Geometries":  # shapes that elements may be made of, but no elements
                continue
            first = sum(len(block.cells) for block in blocks)
            blocks.append(RawBlock(kind, cells, own[:, 0]))
            known[what] = np.concatenate([known[what], own[:, 0]])
            numbers[what] = np.concatenate([numbers[what], first + np.arange(len(own))])
    for what in known:
        _check_once(what, known[what])
    node_sets: dict[str, IntArray] = {}
    cell_sets: dict[str, IntArray] = {}
    for path, parts in members.items():
        for what, rows in parts:
            ids = np.array([int(word) for row in rows for word in row], dtype=np.int64)
            if what == "Geometries" or not len(ids):
                continue
            sets = node_sets if what == "Nodes" else cell_sets
            found = _looked_up(known.get(what, labels), ids, f"sub-model part {path!r}")
            found = found if what == "Nodes" else numbers[what][found]
            sets[path] = np.union1d(sets.get(path, none), found)
    return RawMesh(table[:, 1:], tuple(blocks), node_sets, cell_sets, labels)


def _kind(what: str, name: str, width: int) -> str:
    if _LINE_NAMES.search(name):
        kinds = _POINT | LINES
    elif what == "Conditions" or _SURFACE_NAMES.search(name):
        kinds = _POINT | LINES | SURFACES
    else:
        kinds = SOLIDS
    return kinds.get(width, f"{name} of {width} nodes")


def _looked_up(known: IntArray, labels: IntArray, what: str) -> IntArray:
    found = rows_of(known, labels)
    if (found < 0).any():
        raise ValueError(f"{what} names number {labels[found < 0][0]}, which is not there")
    return found


def _check_once(what: str, labels: IntArray) -> None:
    unique, counts = np.unique(labels, return_counts=True)
    if (counts > 1).any():
        raise ValueError(f"{what}: number {unique[counts > 1][0]} is there twice")
