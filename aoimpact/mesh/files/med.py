"""MED files of Salome and code_aster: one unstructured mesh with its families of groups."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...base import IntArray
from .hdf import opened
from ..mesh import right_handed
from .rawmesh import RawBlock, RawMesh

__all__ = ["read"]

# Kinds of elements by MED's names, and their numbers of nodes.
_KINDS = {
    "PO1": ("vertex", 1),
    "SE2": ("line", 2),
    "SE3": ("line3", 3),
    "TR3": ("triangle", 3),
    "TR6": ("triangle6", 6),
    "TR7": ("triangle7", 7),
    "QU4": ("quad", 4),
    "QU8": ("quad8", 8),
    "QU9": ("quad9", 9),
    "TE4": ("tetra", 4),
    "T10": ("tetra10", 10),
    "PY5": ("pyramid", 5),
    "P13": ("pyramid13", 13),
    "PE6": ("wedge", 6),
    "P15": ("wedge15", 15),
    "P18": ("wedge18", 18),
    "HE8": ("hexahedron", 8),
    "H20": ("hexahedron20", 20),
    "H27": ("hexahedron27", 27),
}

# MED's numbers of the nodes within an element, in VTK's order.
_ORDERS = {"hexahedron27": (*range(20), 24, 22, 21, 23, 20, 25, 26)}


def read(file: Path) -> RawMesh:
    """Return the mesh in a MED file, with its groups of nodes and of elements.

    Raises
    ------
    ValueError
        If the file is damaged, has more than one mesh or time, or a structured one.
    """
    with opened(file) as tree:
        if "ENS_MAA" not in tree:
            raise ValueError("it has no mesh (ENS_MAA)")
        name, mesh = _only(tree["ENS_MAA"], "meshes")
        if mesh.attrs.get("TYP", 0) != 0:
            raise ValueError("its mesh is structured; save it as an unstructured one")
        at = mesh if "NOE" in mesh else _only(mesh, "times")[1]
        places = at["NOE/COO"]
        count = int(places.attrs["NBR"])
        if count < 1 or places.size != 3 * count:
            raise ValueError(f"{places.size} coordinates are there for {count} nodes in x, y and z")
        nodes = np.asarray(places[()], np.float64).reshape(3, count).T
        node_groups, cell_groups = (
            _groups(tree.get(f"FAS/{name}/{of}", {})) for of in ("NOEUD", "ELEME")
        )
        node_sets: dict[str, list[IntArray]] = {}
        cell_sets: dict[str, list[IntArray]] = {}
        _add(node_sets, node_groups, _numbers(at["NOE"], "FAM", count), 0)
        blocks, first = [], 0
        for type_, group in at["MAI"].items():
            blocks.append(_block(type_, group, nodes))
            n_cells = len(blocks[-1].cells)
            _add(cell_sets, cell_groups, _numbers(group, "FAM", n_cells), first)
            first += n_cells
        return RawMesh(
            nodes,
            tuple(blocks),
            {name: np.concatenate(parts) for name, parts in node_sets.items()},
            {name: np.concatenate(parts) for name, parts in cell_sets.items()},
            _numbers(at["NOE"], "NUM", count),
        )


def _only(group: Any, what: str) -> tuple[str, Any]:
    if len(group) != 1:
        raise ValueError(f"it has {len(group)} {what}; save one alone")
    return next(iter(group.items()))  # type: ignore[no-any-return]


def _block(type_: str, group: Any, nodes: Any) -> RawBlock:
    if type_ not in _KINDS:
        raise ValueError(f"elements of type {type_} are not read")
    kind, width = _KINDS[type_]
    table = group["NOD"]
    count = int(table.attrs["NBR"])
    if table.size != width * count:
        raise ValueError(f"{table.size} numbers of nodes are there for {count} {type_}")
    cells = np.asarray(table[()], np.int64).reshape(width, count).T - 1
    if count and not 0 <= cells.min() <= cells.max() < len(nodes):
        raise ValueError(f"elements {type_} have nodes that are not there")
    cells = right_handed(kind, nodes, cells[:, _ORDERS.get(kind, slice(None))])
    return RawBlock(kind, cells, _numbers(group, "NUM", count))


def _numbers(group: Any, name: str, count: int) -> IntArray | None:
    if name not in group:
        return None
    found: IntArray = np.asarray(group[name][()], np.int64).reshape(-1)
    if len(found) != count:
        raise ValueError(f"{len(found)} numbers {name} are there for {count}")
    return found


def _groups(families: Any) -> dict[int, list[str]]:
    """Return the names of the groups that each family is in."""
    found = {}
    for family in families.values():
        if "GRO" in family:
            rows = np.asarray(family["GRO/NOM"][()])
            names = [bytes(row.astype(np.uint8)).decode("utf-8", "replace") for row in rows]
            found[int(family.attrs["NUM"])] = [name.partition("\0")[0].strip() for name in names]
    return found


def _add(
    sets: dict[str, list[IntArray]],
    groups: dict[int, list[str]],
    families: IntArray | None,
    first: int,
) -> None:
    if families is not None:
        for number in np.unique(families):
            for name in groups.get(int(number), ()):
                sets.setdefault(name, []).append(first + np.flatnonzero(families == number))
