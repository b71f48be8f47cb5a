"""Kratos Multiphysics' model parts (.mdpa): elements, conditions and sub-model parts."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ...base import IntArray
from . import raw
from .raw import RawBlock, RawMesh

# Elements in space that are no solids, by a part of their names.
_SURFACE_NAMES = re.compile("shell|membrane|surface|plate|triangle|quadrilateral|2d", re.IGNORECASE)
_LINE_NAMES = re.compile(
    "beam|truss|cable|line(?!ar)|spring|damper|nodal|point|mass|rotation", re.IGNORECASE
)

# Kratos' numbers of the nodes within an element, in VTK's order: those of GiD.
_ORDERS = raw.UPRIGHT_FIRST | {
    "hexahedron27": (*raw.UPRIGHT_FIRST["hexahedron20"], 24, 22, 21, 23, 20, 25, 26),
}

# Blocks of members of a sub-model part, and blocks without influence on mesh and groups.
_MEMBERS = {
    f"SubModelPart{what}": what for what in ("Nodes", "Elements", "Conditions", "Geometries")
}
_IGNORED = re.compile(r"SubModelPart(Tables|Properties)?|Mesh\w*|Properties|Table|\w+Data")

# Numbers before the nodes in a row.
_HEAD = {"Elements": 2, "Conditions": 2, "Geometries": 1}

_Rows = list[list[str]]


def read(file: Path) -> RawMesh:
    """Return the mesh in a model part, with the sub-model parts as groups.

    Raises
    ------
    ValueError
        If the file is damaged or has a block that is not known; the line is named.
    """
    nodes: _Rows = []
    tables: list[tuple[str, str, _Rows]] = []  # block, name of the element, rows
    members: list[tuple[str, str, _Rows]] = []  # sub-model part, what its members are, rows
    stack: list[tuple[str, str]] = []
    rows: _Rows | None = None
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
                around = (".".join(path[: depth + 1]) for depth in range(len(path)))
                members += [(part, _MEMBERS[what], rows) for part in around]
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


def _mesh(
    nodes: _Rows, tables: list[tuple[str, str, _Rows]], members: list[tuple[str, str, _Rows]]
) -> RawMesh:
    if any(len(row) != 4 for row in nodes):
        raise ValueError("Nodes: a row is not a number and x, y, z")
    table = _numbers("Nodes", nodes, float).reshape(-1, 4)
    labels, none = raw.integers(table[:, 0]), np.zeros(0, dtype=np.int64)
    # Labels, and numbers among all nodes or all cells.
    known = {"Nodes": labels, "Elements": none, "Conditions": none}
    numbers = {"Nodes": np.arange(len(table)), "Elements": none, "Conditions": none}
    _check_once("Nodes", labels)
    blocks: list[RawBlock] = []
    n_cells = 0
    for what, name, rows in tables:
        head = _HEAD[what]
        for width in sorted({len(row) for row in rows}):
            own = _numbers(what, [row for row in rows if len(row) == width], int)
            kind = _kind(what, name, width - head)
            cells = _looked_up(known["Nodes"], own[:, head:], f"{what} {name}")
            if what == "Geometries":  # shapes that elements may be made of, but no elements
                continue
            blocks.append(RawBlock(kind, cells[:, _ORDERS.get(kind, slice(None))], own[:, 0]))
            known[what] = raw.joined([known[what], own[:, 0]])
            numbers[what] = raw.joined([numbers[what], n_cells + np.arange(len(own))])
            n_cells += len(own)
    for what in known:
        _check_once(what, known[what])
    sets: dict[bool, list[tuple[str, IntArray]]] = {True: [], False: []}
    for part, what, rows in members:
        ids = _numbers(what, [[word for row in rows for word in row]], int)[0]
        if what != "Geometries" and len(ids):
            found = _looked_up(known[what], ids, f"sub-model part {part!r}")
            sets[what == "Nodes"].append((part, numbers[what][found]))
    node_sets, cell_sets = raw.grouped(sets[True]), raw.grouped(sets[False])
    return RawMesh(table[:, 1:], tuple(blocks), node_sets, cell_sets, known["Nodes"])


def _numbers(what: str, rows: _Rows, kind: type) -> Any:
    try:
        return np.array([[kind(word) for word in row] for row in rows], dtype=kind)
    except (ValueError, OverflowError) as error:
        raise ValueError(f"{what}: {error}") from None


def _kind(what: str, name: str, width: int) -> str:
    if _LINE_NAMES.search(name):
        kinds = raw.POINTS | raw.LINES
    elif what == "Conditions" or _SURFACE_NAMES.search(name):
        kinds = raw.POINTS | raw.LINES | raw.SURFACES
    else:
        kinds = raw.SOLIDS
    return kinds.get(width, f"{name} of {width} nodes")


def _check_once(what: str, labels: IntArray) -> None:
    if len(again := raw.repeats(labels)):
        raise ValueError(f"{what}: number {labels[again[0]]} is there twice")


def _looked_up(known: IntArray, labels: IntArray, what: str) -> IntArray:
    found = raw.rows_of(known, labels)
    if (found < 0).any():
        raise ValueError(f"{what} names number {labels[found < 0][0]}, which is not there")
    return found
