"""Reader of Exodus II files (netCDF 3 and 4), with named blocks, node sets and side sets.

The format is that of "Exodus: A Finite Element Data Model" (Sandia National Laboratories).
"""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from ..base import IntArray
from ..mesh import KINDS, SOLIDS, SURFACES, reference_faces
from . import raw
from .raw import RawBlock, RawMesh

# Names of the netCDF variables that define the mesh; all other variables are results.
_OF_THE_MESH = re.compile(
    r"coord[xyz]?|connect\d+|(eb|ns|ss)_(names|prop1)|(node_n|elem_s|side_s)s\d+|(node|elem)_num_map"
)

# meshio's kind of cell, by the first three letters of Exodus' element name and the number of nodes.
_KINDS = {
    **{
        name: {n: kind for n, kind in SOLIDS.items() if kind[:3].upper() == name}
        for name in ("HEX", "TET", "WED", "PYR")
    },
    **dict.fromkeys(("QUA", "SHE", "TRI"), SURFACES),
    **dict.fromkeys(("TRU", "BEA", "BAR", "EDG"), raw.LINES),
    **dict.fromkeys(("SPH", "CIR"), raw.POINTS),
}

# For each node in VTK's order, its number in Exodus' order.
_ORDERS = raw.UPRIGHT_FIRST | {
    "hexahedron27": (*raw.UPRIGHT_FIRST["hexahedron20"], 23, 24, 25, 26, 21, 22, 20),
}

# Corners of each side of an element, in the order of Exodus' side numbers.
_SIDES = {
    "hexahedron": ("0154", "1265", "2376", "0473", "0321", "4567"),
    "tetra": ("013", "123", "032", "021"),
    "wedge": ("0143", "1254", "0352", "021", "345"),
    "pyramid": ("014", "124", "234", "043", "0321"),
}


def read(file: Path) -> RawMesh:
    """Return the mesh in an Exodus file.

    Element blocks become groups of elements. A side set becomes the set of the nodes on its sides.
    Blocks and sets without a name are called after their numbers, as in "block 1", "nodeset 2" and
    "sideset 3".

    Raises
    ------
    ValueError
        If the file is damaged, or a side set has sides of elements other than solids.
    """
    with file.open("rb") as stream:
        head = stream.read(4)
    if head == b"CDF\5":
        raise ValueError("netCDF 3 with 64-bit data (CDF-5) is not read; write netCDF 4")
    if head[:3] == b"CDF":
        try:
            with scipy.io.netcdf_file(file, "r", mmap=False) as tree:
                found = {
                    name: (np.array(item.data), vars(item).get("_attributes", {}))
                    for name, item in tree.variables.items()
                    if _OF_THE_MESH.fullmatch(name)
                }
        except (OSError, TypeError, KeyError, IndexError, AssertionError) as error:
            raise ValueError(f"netCDF: {error!r}") from None
    else:
        with raw.opened_hdf5(file) as tree:
            found = {
                name: (np.asarray(item[()]), dict(item.attrs))
                for name, item in tree.items()
                if _OF_THE_MESH.fullmatch(name)
            }
    arrays = {name: values for name, (values, _) in found.items()}
    axes = [arrays[f"coord{x}"] for x in "xyz" if f"coord{x}" in arrays]
    nodes = np.array(arrays.get("coord", axes), dtype=np.float64).T
    if nodes.ndim != 2 or nodes.shape[1] != 3:
        raise ValueError(f"nodes have {nodes.shape[-1]} coordinates; a solid needs x, y and z")
    names = _names(arrays, "eb", "block", "connect")
    kinds, cells = [], []
    for i, name in enumerate(names, 1):
        table, attributes = found.get(f"connect{i}", (np.zeros((0, 1)), {}))
        if table.ndim != 2:
            raise ValueError(f"the connectivity of {name!r} must be a table")
        type_, width = _text(attributes.get("elem_type", b"")).upper(), table.shape[1]
        kind = _KINDS.get(type_[:3], {}).get(width, f"{type_} of {width} nodes")
        kinds.append(kind if len(table) else "vertex")
        cells.append((table.astype(np.int64) - 1)[:, _ORDERS.get(kind, slice(None))])
    first = raw.firsts(cells)
    labels = raw.labels_of(arrays, "elem_num_map", first[-1])
    own: Any = [None] * len(cells) if labels is None else np.split(labels, first[1:-1])
    blocks = tuple(map(RawBlock, kinds, cells, own))
    node_sets = {}
    for i, name in enumerate(_names(arrays, "ns", "nodeset", "node_ns"), 1):
        if f"node_ns{i}" in arrays:
            node_sets[name] = arrays[f"node_ns{i}"].astype(np.int64).reshape(-1) - 1
    for i, name in enumerate(_names(arrays, "ss", "sideset", "elem_ss"), 1):
        if f"elem_ss{i}" in arrays and f"side_ss{i}" in arrays:
            elements, sides = arrays[f"elem_ss{i}"], arrays[f"side_ss{i}"]
            node_sets[name] = _on_sides(name, blocks, first, elements, sides)
    spans = zip(names, pairwise(first), strict=True)
    cell_sets = raw.grouped((name, np.arange(*span)) for name, span in spans)
    return RawMesh(
        nodes, blocks, node_sets, cell_sets, raw.labels_of(arrays, "node_num_map", len(nodes))
    )


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.astype("S").tobytes()
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return text.partition("\0")[0].strip()


def _names(arrays: dict[str, Any], prefix: str, what: str, members: str) -> list[str]:
    """Return the names of all blocks or sets; the unnamed get names such as "block 1"."""
    if f"{prefix}_prop1" in arrays:
        ids = arrays[f"{prefix}_prop1"].reshape(-1).tolist()
    else:  # old files number blocks and sets 1, 2, …
        ids = list(range(1, 1 + sum(name.startswith(members) for name in arrays)))
    rows = [_text(row) for row in arrays.get(f"{prefix}_names", np.full(len(ids), b""))]
    raw.check_count(f"names of a {what}", len(ids), len(rows))
    return [row or f"{what} {id_}" for row, id_ in zip(rows, ids, strict=True)]


def _on_sides(
    name: str, blocks: tuple[RawBlock, ...], first: IntArray, elements: IntArray, sides: IntArray
) -> IntArray:
    """Return the nodes on sides of elements; `elements` and `sides` are numbered from 1."""
    if elements.shape != sides.shape or ((elements < 1) | (elements > first[-1])).any():
        raise ValueError(f"the set of sides {name!r} names elements that are not there")
    members = [np.zeros(0, np.int64)]
    for block, start in zip(blocks, first[:-1], strict=True):
        own = (elements > start) & (elements <= start + len(block.cells))
        if not own.any():
            continue
        if block.kind not in KINDS:
            raise ValueError(f"sides in the set {name!r} must be of solids, got {block.kind}")
        corners = _SIDES[block.kind.rstrip("0123456789")]
        faces = {frozenset(f.nodes[: f.n_corners]): f.nodes for f in reference_faces(block.kind)}
        for number in np.unique(sides[own]).tolist():
            if not 1 <= number <= len(corners):
                raise ValueError(f"the set of sides {name!r}: {block.kind} has no side {number}")
            on = faces[frozenset(map(int, corners[number - 1]))]
            rows = elements[own & (sides == number)] - 1 - start
            members.append(block.cells[rows][:, on].reshape(-1))
    return np.unique(np.concatenate(members))
