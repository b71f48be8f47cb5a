"""Reader of MED files of Salome and code_aster: one unstructured mesh and its groups."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..base import IntArray
from .raw import RawBlock, RawMesh, check_count, grouped, labels_of, nodes_in, opened_hdf5

# MED's and meshio's names of the kinds of elements.
_NAMES = "PO1 SE2 SE3 TR3 TR6 TR7 QU4 QU8 QU9 TE4 T10 PY5 P13 PE6 P15 P18 HE8 H20 H27"
_OURS = (
    "vertex line line3 triangle triangle6 triangle7 quad quad8 quad9 tetra tetra10 pyramid "
    "pyramid13 wedge wedge15 wedge18 hexahedron hexahedron20 hexahedron27"
)
_KINDS = dict(zip(_NAMES.split(), _OURS.split(), strict=True))

# For each node in VTK's order, its number in MED's order.
_ORDERS = {"hexahedron27": (*range(20), 24, 22, 21, 23, 20, 25, 26)}


def read(file: Path) -> RawMesh:
    """Return the mesh in a MED file, with its groups of nodes and of elements.

    Raises
    ------
    ValueError
        If the file is damaged, has several meshes or times, or a structured mesh.
    """
    with opened_hdf5(file) as tree:
        if "ENS_MAA" not in tree:
            raise ValueError("it has no mesh (ENS_MAA)")
        name, mesh = _only(tree["ENS_MAA"], "meshes")
        if mesh.attrs.get("TYP", 0) != 0:
            raise ValueError("its mesh is structured; save it as an unstructured one")
        at = mesh if "NOE" in mesh else _only(mesh, "times")[1]
        places = at["NOE/COO"]
        count = int(places.attrs["NBR"])
        if count < 1 or places.size != 3 * count:
            raise ValueError(f"{count} nodes need x, y and z, got {places.size} coordinates")
        nodes = np.asarray(places[()], np.float64).reshape(3, count).T
        node_families, cell_families = (
            _families(tree.get(f"FAS/{name}/{of}", {})) for of in ("NOEUD", "ELEME")
        )
        node_sets = _groups(node_families, labels_of(at["NOE"], "FAM", count), 0)
        cell_sets: list[tuple[str, IntArray]] = []
        blocks, first = [], 0
        for type_, group in at["MAI"].items():
            if type_ not in _KINDS:
                raise ValueError(f"elements of type {type_} are not read")
            kind, width = _KINDS[type_], nodes_in(_KINDS[type_])
            n_cells = int(group["NOD"].attrs["NBR"])
            check_count(f"numbers of nodes of {type_}", width * n_cells, group["NOD"].size)
            cells = np.asarray(group["NOD"][()], np.int64).reshape(width, n_cells).T - 1
            if n_cells and not 0 <= cells.min() <= cells.max() < len(nodes):
                raise ValueError(f"elements {type_} have nodes that are not there")
            cells = cells[:, _ORDERS.get(kind, slice(None))]
            blocks.append(RawBlock(kind, cells, labels_of(group, "NUM", n_cells)))
            cell_sets += _groups(cell_families, labels_of(group, "FAM", n_cells), first)
            first += n_cells
        labels = labels_of(at["NOE"], "NUM", count)
        return RawMesh(nodes, tuple(blocks), grouped(node_sets), grouped(cell_sets), labels)


def _only(group: Any, what: str) -> tuple[str, Any]:
    if len(group) != 1:
        raise ValueError(f"it has {len(group)} {what}; save one alone")
    return next(iter(group.items()))  # type: ignore[no-any-return]


def _families(families: Any) -> dict[int, list[str]]:
    """Return, by family number, the names of the groups that contain the family."""
    found = {}
    for family in families.values():
        if "GRO" in family:
            rows = np.asarray(family["GRO/NOM"][()])
            names = [bytes(row.astype(np.uint8)).decode("utf-8", "replace") for row in rows]
            found[int(family.attrs["NUM"])] = [name.partition("\0")[0].strip() for name in names]
    return found


def _groups(
    families: dict[int, list[str]], numbers: IntArray | None, first: int
) -> list[tuple[str, IntArray]]:
    """Return pairs of a group's name and its members: nodes, or cells numbered from `first`.

    `numbers`: family number of each node or cell. A group occurs once for each of its families.
    """
    of = np.zeros(0, np.int64) if numbers is None else numbers
    return [
        (name, first + np.flatnonzero(of == number))
        for number in np.unique(of).tolist()
        for name in families.get(number, ())
    ]
