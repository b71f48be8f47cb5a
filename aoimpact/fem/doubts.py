"""Warnings about bodies that can be computed but are probably not what the user intends."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import FloatArray, InputError, plain, sp, warn
from ..mesh import Mesh, unit
from .beams import Beam
from .composition import AnyMaterial, pieces
from .laminate import Layers
from .material import Material

# ν above which first-order elements show volumetric locking. The first bending frequency of a bar
# of 16 × 2 × 2 hexahedra is 10 % too high at ν = 0.3, 19 % at 0.45, 35 % at 0.49, 195 % at 0.4999;
# with quadratic elements 4 %.
_NEARLY_INCOMPRESSIBLE = 0.45

# Largest accepted relative difference between the masses of a shell that follow from the area at
# the nodes and from the area of the middle surface.
_CURVED = 0.01


def warn_of_locking(mesh: Mesh, material: AnyMaterial) -> None:
    """Warn of first-order elements of nearly incompressible material."""
    locking = [
        piece
        for piece in pieces(mesh, material, Material)
        if piece.of.nu > _NEARLY_INCOMPRESSIBLE and piece.element.linear is piece.element
    ]
    if locking:
        nu = max(piece.of.nu for piece in locking)
        count = sum(len(piece.rows) for piece in locking)
        warn(f"{count} elements of first order with nu={nu:g} bend far too little: take order=2")


def check_joints(mesh: Mesh, material: AnyMaterial) -> None:
    """Refuse shells and beams that share only an edge or end with solids, which forms a hinge.

    Raises
    ------
    InputError
    """
    solids = np.zeros(mesh.n_nodes, dtype=bool)
    for piece in pieces(mesh, material):
        solids[piece.cells] = True
    shared, held = np.zeros((2, mesh.n_nodes), dtype=bool)
    for part in pieces(mesh, material, (Layers, Beam)):
        on = solids[part.cells]
        shared[part.cells[on]] = True
        held[part.cells[on.all(axis=1)]] = True
    hinged = np.flatnonzero(shared & ~held)
    if len(hinged):
        place = plain(mesh.nodes[hinged[0]])
        raise InputError(
            f"mesh: {len(hinged)} nodes where shells or beams meet solids are hinges, the first is "
            f"near {place} m; continue the shell by a row of elements on the solid's face, or the "
            "beam by an element into the solid"
        )


def warn_of_curved_offsets(mesh: Mesh, material: AnyMaterial) -> None:
    """Warn if an offset makes the middle surface's area differ from the area at the nodes.

    The middle surface is found by moving each node along the mean normal of its elements.
    """
    shells = pieces(mesh, material, Layers)
    if not any(part.of.offset for part in shells):
        return
    normals = np.zeros_like(mesh.nodes)
    for part in shells:
        np.add.at(normals, part.cells, _areas(mesh.nodes[part.cells])[:, None])
    normals = unit(normals)
    mass, true = 0.0, 0.0
    for part in shells:
        moved = mesh.nodes + part.of.offset * normals
        own, middle = (np.linalg.norm(_areas(x[part.cells]), axis=1) for x in (mesh.nodes, moved))
        mass += float(part.of.inertia[0] * own.sum())
        true += float(part.of.inertia[0] * middle.sum())
    if abs(true - mass) > _CURVED * mass:
        warn(
            f"the shells' offset is on a curved or folded surface: by the area at the nodes, which "
            f"is used, their mass is {mass:.4g} kg, by the area of the middle surface {true:.4g} "
            "kg; their stiffness errs likewise; put the nodes on the middle surface"
        )


def _areas(corners: FloatArray) -> FloatArray:
    """Return the area vectors, m², of triangles or quadrilaterals with corners (n, 3 or 4, 3)."""
    return 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])


def warn_of_separate_parts(mesh: Mesh, masses: Any) -> None:
    """Warn of a mesh whose parts share no node and are not joined by `masses`, (dofs, dofs)."""
    row, column = np.repeat(mesh.cells[:, 0], mesh.cells.shape[1]), mesh.cells.ravel()
    if masses is not None:
        joined = masses.tocoo()
        row, column = np.append(row, joined.row // 3), np.append(column, joined.col // 3)
    graph = sp.coo_array((np.ones(len(row)), (row, column)), shape=(mesh.n_nodes, mesh.n_nodes))
    count, part = sp.csgraph.connected_components(graph, directed=False)
    if count == 1:
        return
    of_cell = part[mesh.cells[:, 0]]
    sizes = np.bincount(of_cell, minlength=count)
    place = plain(mesh.nodes[mesh.cells[(of_cell != sizes.argmax()).argmax()]].mean(axis=0))
    which = f"{sizes.max()} of {mesh.n_cells} elements, and others such as near {place} m"
    cure = "merge nodes that lie at the same place, or make a body of each, by part="
    warn(f"the mesh has {count} parts that share no nodes: {which}. All are one body here: {cure}")
