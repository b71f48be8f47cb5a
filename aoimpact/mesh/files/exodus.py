"""Exodus II files, of netCDF 3 and 4: blocks, sets of nodes and sets of sides by their names.

The format is that of "Exodus: A Finite Element Data Model" (Sandia National Laboratories).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from ...base import IntArray
from ..elements import KINDS
from ..faces import reference_faces
from .hdf import opened
from .rawmesh import LINES, SOLIDS, SURFACES, UPRIGHT_FIRST, RawBlock, RawMesh

__all__ = ["read"]

# Variables that say what the mesh is; the others are results.
_OF_THE_MESH = re.compile(
    r"coord[xyz]?|connect\d+|(eb|ns|ss)_(names|prop1)|(node_n|elem_s|side_s)s\d+|(node|elem)_num_map"
)

# Kinds of cells by the first letters of the elements' names, and the shapes of solids among them.
_SHAPES = {"HEX": "hexahedron", "TET": "tetra", "WED": "wedge", "PYR": "pyramid"}
_KINDS = {
    **{
        name: {n: kind for n, kind in SOLIDS.items() if kind.startswith(shape)}
        for name, shape in _SHAPES.items()
    },
    **dict.fromkeys(("QUA", "SHE", "TRI"), SURFACES),
    **dict.fromkeys(("TRU", "BEA", "BAR", "EDG"), LINES),
    **{name: {1: "vertex"} for name in ("SPH", "CIR")},
}

# Exodus' numbers of the nodes within an element, in VTK's order.
_ORDERS = UPRIGHT_FIRST | {
    "hexahedron27": (*UPRIGHT_FIRST["hexahedron20"], 23, 24, 25, 26, 21, 22, 20),
}

# The corners of each side, in the order of Exodus' numbers.
_SIDES = {
    "hexahedron": (
        *((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3)),
        *((0, 3, 2, 1), (4, 5, 6, 7)),
    ),
    "tetra": ((0, 1, 3), (1, 2, 3), (0, 3, 2), (0, 2, 1)),
    "wedge": ((0, 1, 4, 3), (1, 2, 5, 4), (0, 3, 5, 2), (0, 2, 1), (3, 4, 5)),
    "pyramid": ((0, 1, 4), (1, 2, 4), (2, 3, 4), (0, 4, 3), (0, 3, 2, 1)),
}


def read(file: Path) -> RawMesh:
    """Return the mesh in an Exodus file.

    Element blocks are groups of elements. Sets of sides are the sets of the nodes on them. What has
    no name is called after its number, as in "block 1", "nodeset 2" and "sideset 3".

    Raises
    ------
    ValueError
        If the file is damaged, or has sides of elements that are no solids in a set of sides.
    """
    with file.open("rb") as stream:
        head = stream.read(4)
    if head == b"CDF\5":
        raise ValueError("netCDF 3 with 64-bit data (CDF-5) is not read; write netCDF 4")
    if head[:3] != b"CDF":
        with opened(file) as tree:
            return _mesh(
                {
                    name: _Variable(item[()], item.attrs)
                    for name, item in tree.items()
                    if _OF_THE_MESH.fullmatch(name)
                }
            )
    try:
        with scipy.io.netcdf_file(file, "r", mmap=False) as tree:
            variables = {
                name: _Variable(np.array(item.data), vars(item).get("_attributes", {}))
                for name, item in tree.variables.items()
                if _OF_THE_MESH.fullmatch(name)
            }
    except (OSError, TypeError, KeyError, IndexError, AssertionError) as error:
        raise ValueError(f"netCDF: {error!r}") from None
    return _mesh(variables)


class _Variable:
    """An array of the file, and the type of the elements in it."""

    def __init__(self, values: Any, attributes: Mapping[str, Any]) -> None:
        self.values = np.asarray(values)
        self.type = _text(attributes.get("elem_type", b""))


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.astype("S").tobytes()
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return text.partition("\0")[0].strip()


def _mesh(variables: dict[str, _Variable]) -> RawMesh:
    if "coord" in variables:
        nodes = variables["coord"].values.astype(np.float64).T
    else:
        axes = [variables[f"coord{x}"].values for x in "xyz" if f"coord{x}" in variables]
        nodes = np.array(axes, dtype=np.float64).T
    if nodes.ndim != 2 or nodes.shape[1] != 3:
        raise ValueError(f"nodes have {nodes.shape[-1]} coordinates; a solid needs x, y and z")
    names, count = _named(variables, "eb", "block")
    kinds, cells = [], []
    for i in range(1, count + 1):
        block = variables.get(f"connect{i}")
        table = np.zeros((0, 1)) if block is None else block.values
        if table.ndim != 2:
            raise ValueError(f"the nodes of {names[i - 1]!r} are no table")
        type_ = "" if block is None else block.type.upper()
        kind = _KINDS.get(type_[:3], {}).get(table.shape[1], f"{type_} of {table.shape[1]} nodes")
        rows = table.astype(np.int64) - 1
        kinds.append(kind if len(rows) else "vertex")
        cells.append(rows[:, _ORDERS[kind]] if kind in _ORDERS else rows)
    first = np.cumsum([0, *map(len, cells)])
    labels = _labels(variables, "elem_num_map", first[-1])
    blocks = tuple(
        RawBlock(kind, rows, None if labels is None else labels[start : start + len(rows)])
        for kind, rows, start in zip(kinds, cells, first[:-1], strict=True)
    )
    groups: dict[str, IntArray] = {}
    for name, start, rows in zip(names, first[:-1], cells, strict=True):
        groups[name] = np.r_[groups.get(name, np.zeros(0, np.int64)), start : start + len(rows)]
    node_sets = _node_sets(variables) | _side_sets(variables, blocks, first)
    return RawMesh(nodes, blocks, node_sets, groups, _labels(variables, "node_num_map", len(nodes)))


def _labels(variables: dict[str, _Variable], name: str, count: int) -> IntArray | None:
    if name not in variables:
        return None
    labels: IntArray = variables[name].values.astype(np.int64)
    if labels.shape != (count,):
        raise ValueError(f"{name} has {labels.size} numbers for {count}")
    return labels


def _named(variables: dict[str, _Variable], prefix: str, what: str) -> tuple[list[str], int]:
    """Return the names of blocks or sets, and how many there are."""
    if f"{prefix}_prop1" in variables:
        ids = variables[f"{prefix}_prop1"].values.reshape(-1).tolist()
    else:  # as in files of old, for which they are numbered through
        members = {"eb": "connect", "ns": "node_ns", "ss": "elem_ss"}[prefix]
        ids = list(range(1, 1 + sum(name.startswith(members) for name in variables)))
    given = variables.get(f"{prefix}_names")
    rows = [""] * len(ids) if given is None else [_text(row) for row in given.values]
    if len(rows) != len(ids):
        raise ValueError(f"there are {len(rows)} names for {len(ids)} of {what}")
    return [row or f"{what} {id_}" for row, id_ in zip(rows, ids, strict=True)], len(ids)


def _node_sets(variables: dict[str, _Variable]) -> dict[str, IntArray]:
    names, _ = _named(variables, "ns", "nodeset")
    return {
        name: variables[f"node_ns{i}"].values.astype(np.int64).reshape(-1) - 1
        for i, name in enumerate(names, 1)
        if f"node_ns{i}" in variables
    }


def _side_sets(
    variables: dict[str, _Variable], blocks: tuple[RawBlock, ...], first: IntArray
) -> dict[str, IntArray]:
    names, _ = _named(variables, "ss", "sideset")
    found = {}
    for i, name in enumerate(names, 1):
        if f"elem_ss{i}" not in variables or f"side_ss{i}" not in variables:
            continue
        elements, sides = (variables[f"{of}_ss{i}"].values for of in ("elem", "side"))
        if elements.shape != sides.shape or ((elements < 1) | (elements > first[-1])).any():
            raise ValueError(f"the set of sides {name!r} names elements that are not there")
        members = [np.zeros(0, np.int64)]
        for block, start in zip(blocks, first[:-1], strict=True):
            own = (elements > start) & (elements <= start + len(block.cells))
            if own.any():
                members += _on_sides(name, block, elements[own] - 1 - start, sides[own])
        found[name] = np.unique(np.concatenate(members))
    return found


def _on_sides(name: str, block: RawBlock, rows: IntArray, sides: IntArray) -> list[IntArray]:
    """Return the nodes on sides of the elements in some rows of a block."""
    if block.kind not in KINDS:
        raise ValueError(f"the set of sides {name!r} has sides of {block.kind} elements")
    corners = _SIDES[block.kind.rstrip("0123456789")]
    faces = {
        frozenset(f.nodes[: f.n_corners].tolist()): f.nodes for f in reference_faces(block.kind)
    }
    if ((sides < 1) | (sides > len(corners))).any():
        raise ValueError(f"the set of sides {name!r} has a side that {block.kind} has not")
    return [
        block.cells[rows[sides == number]][:, faces[frozenset(corners[number - 1])]].reshape(-1)
        for number in np.unique(sides)
    ]
