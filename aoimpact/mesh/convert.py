"""Conversion of elements: to second order, and of bricks with repeated nodes to other solids."""

from __future__ import annotations

from functools import cache
from itertools import permutations
from typing import Any

import numpy as np

from ..base import IntArray, MeshError
from .elements import RAISED, SOLIDS, reference_element, reference_faces
from .mesh import Mesh, Solids
from .surface import boundary
from .vectors import parted

# ------------------------------------------------------------------------------- second order


def of_second_order(mesh: Mesh) -> Mesh:
    """Return the mesh with a node in the middle of each edge; second-order meshes as they are.

    Edges stay straight. The new nodes come after the others; their `node_labels`, if any, follow
    the largest label. A new node joins a set of nodes if both ends of its edge are in the set; if
    all of the set is on the surface, the edge must be on the surface, too. A node set with the name
    and the nodes of a group of elements gets all new nodes of the group.

    Raises
    ------
    MeshError
        If the mesh has elements of both orders, shells or beams.
    """
    if any(block.element.thin for block in mesh.blocks):
        raise MeshError(f"order=2 is for solids, not shells and beams, got {mesh.contents}")
    linear = [not block.element.quadratic for block in mesh.blocks]
    if not any(linear):
        return mesh
    if not all(linear):
        raise MeshError(f"order: give a mesh of first order throughout, got {mesh.contents}")
    raised = [reference_element(RAISED[block.kind]) for block in mesh.blocks]
    ends = [
        np.sort(block.cells[:, element.edges], axis=2)
        for block, element in zip(mesh.blocks, raised, strict=True)
    ]
    n = mesh.n_nodes
    keys, number = np.unique(
        np.concatenate([part.reshape(-1, 2) @ [n, 1] for part in ends]), return_inverse=True
    )
    edges = np.stack([keys // n, keys % n], axis=1)
    middles = parted(n + number, [part[..., 0] for part in ends])
    blocks: Any = [
        (element.kind, np.hstack([block.cells, own]))
        for block, element, own in zip(mesh.blocks, raised, middles, strict=True)
    ]
    labels = mesh.node_labels
    if labels is not None:
        labels = np.concatenate([labels, labels.max() + 1 + np.arange(len(edges))])
    surface = boundary(mesh)
    skin = surface.ends(np.arange(len(surface.cell)))
    on_surface = np.isin(keys, (skin @ [n, 1]).reshape(-1))
    node_sets = {}
    for name, ids in mesh.node_sets.items():
        inside = not np.isin(ids, surface.nodes).all()
        between = np.isin(edges, ids).all(axis=1) & (on_surface | inside)
        node_sets[name] = np.concatenate([ids, n + np.flatnonzero(between)])
    for name, members in mesh.cell_sets.items():
        own = [
            cells[np.isin(np.r_[block.numbers], members)].ravel()
            for block, (_, cells) in zip(mesh.blocks, blocks, strict=True)
        ]
        nodes = np.unique(np.concatenate(own))
        if np.array_equal(nodes[nodes < n], mesh.node_sets.get(name, [])):
            node_sets[name] = nodes
    places = np.concatenate([mesh.nodes, mesh.nodes[edges].mean(axis=1)])
    return Mesh(places, blocks, "mixed", node_sets, mesh.cell_sets, labels, mesh.cell_labels)


def open_edges(mesh: Mesh, ids: IntArray) -> int:
    """Return the number of edges on the surface whose ends, but not middle nodes, are in a set.

    Parameters
    ----------
    mesh : Mesh
    ids : ndarray of int
        Nodes of the set. The result is 0 if any of them is a midside node.
    """
    middles = []
    for block in mesh.blocks:
        ends = block.element.edges
        middle = block.cells[:, block.element.n_corners :][:, : len(ends)]
        if np.isin(middle, ids).any():
            return 0
        middles.append(middle[np.isin(block.cells[:, ends], ids).all(axis=2)])
    found = np.unique(np.concatenate(middles))
    return int(np.isin(found, boundary(mesh).nodes).sum()) if len(found) else 0


# ----------------------------------------------------------------------------- repeated nodes


def collapse(kind: str, cells: IntArray, numbers: IntArray) -> tuple[list[Solids], IntArray]:
    """Convert elements with repeated corners to the wedges, pyramids or tetrahedra they represent.

    Programs without elements of these shapes write them as bricks with edges of zero length.
    Integrals over such a brick are right, but its sides are not those of the body.

    Parameters
    ----------
    kind : str
        Kind of the given elements.
    cells : ndarray of int, shape (n, nodes per cell)
        Nodes of each element, of which some may repeat others.
    numbers : ndarray of int, shape (n,)
        Numbers of the elements among the cells of the file.

    Returns
    -------
    list of Solids
        Elements without repeated nodes, then the converted ones, by kind and pattern.
    ndarray of int
        Rows of elements with repeated nodes that are no valid solid.
    """
    element = reference_element(kind)
    corners = cells[:, : element.n_corners]
    first = (corners[:, :, None] == corners[:, None, :]).argmax(axis=2)
    repeats = (first != np.arange(element.n_corners)).any(axis=1)
    found: list[Solids] = []
    if not repeats.all():
        found.append((kind, cells[~repeats], numbers[~repeats]))
    wrong = [np.zeros(0, np.int64)]
    for pattern in np.unique(first[repeats], axis=0):
        rows = np.flatnonzero((first == pattern).all(axis=1))
        plan = _plan(kind, tuple(pattern.tolist()))
        if plan is None:
            wrong.append(rows)
            continue
        target, order, same = plan
        alike = (cells[rows][:, same[:, 0]] == cells[rows][:, same[:, 1]]).all(axis=1)
        wrong.append(rows[~alike])
        found.append((target, cells[rows[alike]][:, order], numbers[rows[alike]]))
    return found, np.sort(np.concatenate(wrong))


@cache
def _plan(kind: str, pattern: tuple[int, ...]) -> tuple[str, list[int], IntArray] | None:
    """Return how to convert an element with repeated corners, or None if it is no valid solid.

    Parameters
    ----------
    kind : str
        Kind of the given element.
    pattern : tuple of int
        For each corner of the element, the first corner with the same node.

    Returns
    -------
    kind : str
        Kind of the converted element.
    order : list of int
        Nodes of the converted element, by their numbers within the given element.
    same : ndarray of int, shape (any, 2)
        Pairs of nodes of the given element that must coincide.
    """
    element = reference_element(kind)
    distinct = sorted(set(pattern))
    if element.thin:  # a quadrilateral with an edge of zero length
        beside = len(distinct) == 3 and pattern not in ((0, 1, 0, 3), (0, 1, 2, 1))
        return ("triangle", distinct, np.zeros((0, 2), np.int64)) if beside else None
    target = SOLIDS.get(len(distinct))
    # A hexahedron of 27 nodes cannot be converted: other solids have no nodes within sides.
    if len(element.nodes) == 27 or target is None:
        return None
    # Sides that still have an area. A folded side matches no side of any solid below.
    around = [[pattern[n] for n in face.nodes] for face in reference_faces(element.cell.linear)]
    left = ([n for n, last in zip(of, [of[-1], *of], strict=False) if n != last] for of in around)
    sides = sorted(sorted(of) for of in left if len(of) > 2)
    # Find the order of the corners that gives a right-handed element with these sides.
    places = np.stack(
        [element.cell.corners[np.array(pattern) == corner].mean(axis=0) for corner in distinct]
    )
    linear = reference_element(target)
    middle = linear.gradient(linear.cell.corners.mean(axis=0, keepdims=True))[0]
    faces = [face.nodes for face in reference_faces(target)]
    for order in map(list, permutations(distinct)):
        turned = places[[distinct.index(corner) for corner in order]]
        fits = sorted(sorted(order[n] for n in face) for face in faces) == sides
        if fits and np.linalg.det(turned.T @ middle) > 0.0:
            break
    else:
        return None
    same: list[tuple[int, int]] = []
    if element.quadratic:
        middles: dict[frozenset[int], list[int]] = {}
        for i, ends in enumerate(element.edges.tolist(), element.n_corners):
            middles.setdefault(frozenset(pattern[end] for end in ends), []).append(i)
        for ends, nodes in middles.items():  # edges that coincide or have no length
            same += [(nodes[0], other) for other in (*nodes[1:], *(ends if len(ends) == 1 else ()))]
        target = RAISED[target]
        edges = reference_element(target).edges.tolist()
        order += [middles[frozenset(order[end] for end in ends)][0] for ends in edges]
    return target, order, np.array(same, dtype=np.int64).reshape(-1, 2)
