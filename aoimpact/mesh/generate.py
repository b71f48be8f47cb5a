"""Mesh generators for simple bodies: balls, boxes and sheets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations, product
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import (
    PRINTED,
    FloatArray,
    InputError,
    IntArray,
    choice,
    finite_array,
    integer,
    positive,
    sequence,
)
from .convert import of_second_order
from .elements import KINDS, reference_element
from .mesh import Mesh

GOLDEN = 0.5 * (1.0 + 5.0**0.5)  # golden ratio

# `_ICOSAHEDRON_ANGLE`: angle between neighbouring vertices, seen from the centre, rad. `_STRETCH`:
# upper bound of the longest element edge on a unit sphere, relative to this angle divided by n;
# measured: 1.161 for n = 4, 1.176 for n = 16.
_ICOSAHEDRON_ANGLE = float(np.arctan(2.0))
_STRETCH = 1.18

# Largest number of nodes. Matrices of 1e7 nodes need 40 GB; a larger number is probably due to
# lengths in mm instead of m.
_MOST_NODES = 1e7


def sphere_mesh(radius: float, size: float) -> Mesh:
    """Return a ball of tetra10 elements about the origin.

    The ball is cut into the 20 cones of an icosahedron and each cone into n³ tetrahedra, in n
    similar layers, n even. All nodes of the surface, midside ones too, lie on the sphere. There is
    a corner node at the centre and at each of (±R, 0, 0), (0, ±R, 0), (0, 0, ±R).

    Parameters
    ----------
    radius : float
        Radius R of the ball, m.
    size : float
        Length of the longest element edge on the surface, m; some edges inside are 1.5 times as
        long. n is the smallest even number ≥ 1.31 R/size.

    Returns
    -------
    Mesh
        The mesh, with the node set "surface".

    Raises
    ------
    InputError
        If `radius` or `size` is not positive, `size` exceeds the diameter, or is so small that
        the mesh would exceed the memory.

    Examples
    --------
    >>> mesh = ao.sphere_mesh(radius=0.01, size=0.006)
    >>> mesh.kind, float(abs(mesh.nodes).max().round(9))
    ('tetra10', 0.01)
    """
    R = positive("radius", radius, unit="m")
    h = positive("size", size, unit="m")
    if h > 2.0 * R:
        raise InputError(f"size must be at most 2 radius = {2.0 * R:g} m, got {h:g} m")
    n_exact = _STRETCH * _ICOSAHEDRON_ANGLE * (R / h)
    _refuse_monster(80.0 / 3.0 * n_exact * n_exact * n_exact, "size", f"{h:g}, of radius={R:g} m,")
    n = 2 * max(1, int(np.ceil(n_exact / 2.0 - PRINTED)))
    directions, cones = _icosahedron()
    # Kuhn's subdivision of the tetrahedron of one cone into n³ tetrahedra.
    grid = np.array(np.meshgrid(*[np.arange(n)] * 3, indexing="ij")).reshape(3, -1).T
    every = grid[:, None, None] + reference_element("tetra").cell.of_brick.astype(np.int64)
    x, y, z = np.moveaxis(every, 3, 0)
    x, y, z = np.moveaxis(every[((x >= y) & (y >= z)).all(axis=2)], 2, 0)
    weights = np.stack([n - x, x - y, y - z, z], axis=-1).reshape(-1, 4)
    barycentric, tets = np.unique(weights, axis=0, return_inverse=True)
    # The first barycentric coordinate belongs to the centre; the sum of the others is the layer.
    # Sines of their shares in this sum give the direction, and nearly even spacing on the sphere.
    share = barycentric[:, 1:]
    layer = share.sum(axis=1)
    angle = share / np.maximum(layer, 1)[:, None] * _ICOSAHEDRON_ANGLE
    places = np.einsum("pk,fkc->fpc", np.sin(angle), directions[cones])
    norm = np.linalg.norm(places, axis=2, keepdims=True)
    places *= (layer / n)[:, None] / np.where(norm > 0.0, norm, 1.0)
    # Points of two cones are the same if they have equal shares of the same vertices. Each vertex
    # and its share make one number, and the sorted numbers of a point its key.
    label = np.where(share[None] > 0, cones[:, None, :] * (n + 1) + share[None] + 1, 0)
    label.sort(axis=2)
    keys = label @ np.array([(12 * (n + 1) + 1) ** 2, 12 * (n + 1) + 1, 1])
    _, first, number = np.unique(keys.reshape(-1), return_index=True, return_inverse=True)
    corners = places.reshape(-1, 3)[first]
    cells = number.reshape(len(cones), -1)[:, tets.ravel()].reshape(-1, 4)
    volume = np.linalg.det(corners[cells[:, 1:]] - corners[cells[:, :1]])
    cells = np.where(volume[:, None] < 0.0, cells[:, [0, 2, 1, 3]], cells)
    outside = np.flatnonzero(np.abs(np.linalg.norm(corners, axis=1) - 1.0) < PRINTED)
    straight = of_second_order(Mesh(corners, cells, "tetra", {"surface": outside}))
    surface, nodes = straight.node_sets["surface"], straight.nodes.copy()
    nodes[surface] /= np.linalg.norm(nodes[surface], axis=1)[:, None]
    return Mesh(R * nodes, straight.cells, "tetra10", {"surface": surface})


def _icosahedron() -> tuple[FloatArray, IntArray]:
    """Return unit vectors to the 12 vertices, and the vertices of the 20 faces.

    Each coordinate axis passes through the middles of two opposite edges.
    """
    signs = [(a, b) for a in (1.0, -1.0) for b in (GOLDEN, -GOLDEN)]
    vertices = [np.roll([0.0, a, b], shift) for shift in range(3) for a, b in signs]
    directions = np.array(vertices) / np.hypot(1.0, GOLDEN)
    near = directions @ directions.T > 0.4
    faces = [
        corners
        for corners in combinations(range(12), 3)
        if all(near[i, j] for i, j in combinations(corners, 2))
    ]
    return directions, np.array(faces)


def box_mesh(lengths: npt.ArrayLike, divisions: Sequence[int], *, kind: str = "hexahedron") -> Mesh:
    """Return the box from the origin to `lengths`, cut into equal bricks.

    Parameters
    ----------
    lengths : array_like, shape (3,)
        Lengths of the box along x, y and z, m.
    divisions : sequence of 3 int
        Numbers of bricks along x, y and z.
    kind : str, optional
        Kind of element, any of solids. Each brick is one hexahedron, two wedges, six tetrahedra or
        six pyramids.

    Returns
    -------
    Mesh
        The mesh, with node sets "xmin", "xmax", "ymin", "ymax", "zmin", "zmax" of the six faces.

    Raises
    ------
    InputError
        If a length is not positive, a division is less than one, `kind` is unknown, or the mesh is
        so fine that it would exceed the memory.

    Examples
    --------
    The paper's beam (Table 4 and section 4), 459 nodes and 200 elements:

    >>> box_mesh((1.0, 0.02, 0.02), (50, 2, 2))
    Mesh(459 nodes, 200 hexahedron, sets: xmin, xmax, ymin, ymax, zmin, zmax)
    """
    return _lattice(lengths, divisions, kind, KINDS, 3)


def sheet_mesh(lengths: npt.ArrayLike, divisions: Sequence[int], *, kind: str = "quad") -> Mesh:
    """Return a flat rectangle for shells, from the origin to `lengths` in the plane z = 0.

    Parameters
    ----------
    lengths : array_like, shape (2,)
        Lengths of the sheet along x and y, m.
    divisions : sequence of 2 int
        Numbers of rectangles along x and y; even numbers put a node in the middle.
    kind : str, optional
        Kind of element: "quad", or "triangle" with two elements per rectangle.

    Returns
    -------
    Mesh
        The mesh, with node sets "xmin", "xmax", "ymin", "ymax" of the edges and "rim" of all four.
        Normals point to +z.

    Raises
    ------
    InputError
        If a length is not positive, a division is less than one, `kind` is unknown, or the mesh is
        so fine that it would exceed the memory.

    Examples
    --------
    >>> ao.sheet_mesh((0.3, 0.2), (6, 4))
    Mesh(35 nodes, 24 quad, sets: xmin, xmax, ymin, ymax, rim)
    """
    sheet = _lattice(lengths, divisions, kind, ("quad", "triangle"), 2)
    rim = np.unique(np.concatenate(list(sheet.node_sets.values())))
    return Mesh(sheet.nodes, sheet.cells, kind, {**sheet.node_sets, "rim": rim})


def _lattice(lengths: Any, divisions: Any, kind: str, kinds: Sequence[str], axes: int) -> Mesh:
    """Return the mesh of a box or rectangle: equal bricks, each cut into elements of one kind."""
    sides = finite_array("lengths", lengths, shape=(axes,), unit="m")
    for i, side in enumerate(sides):
        positive(f"lengths[{i}]", float(side), unit="m")
    given = sequence("divisions", divisions)
    if len(given) != axes:
        raise InputError(f"divisions must be {axes} integers, got {given!r}")
    counts = [integer(f"divisions[{i}]", value, low=1) for i, value in enumerate(given)]
    element = reference_element(choice("kind", kind, kinds))
    most = 8 * math.prod(counts) if axes == 3 else math.prod(count + 1 for count in counts)
    _refuse_monster(float(min(most, 10**30)), "divisions", counts)
    # Integer coordinates of all elements' nodes in quarters of a brick, (n_cells, n_nodes, axes).
    local = 4.0 * (element.linear.shape(element.nodes) @ element.cell.of_brick)[..., :axes]
    bricks = 4 * np.array(list(product(*(range(count) for count in counts))))
    lattice = bricks[:, None, None, :] + np.rint(local).astype(np.int64)[None]
    lattice = lattice.reshape(-1, element.n_nodes, axes)
    places = 4 * np.array(counts) + 1
    keys = np.ravel_multi_index(tuple(np.moveaxis(lattice, 2, 0)), tuple(places))
    used, cells = np.unique(keys, return_inverse=True)
    grid = np.stack(np.unravel_index(used, tuple(places)), axis=1)
    sets = {}
    for axis, name in enumerate("xyz"[:axes]):
        sets[f"{name}min"] = np.flatnonzero(grid[:, axis] == 0)
        sets[f"{name}max"] = np.flatnonzero(grid[:, axis] == places[axis] - 1)
    nodes = np.zeros((len(grid), 3))
    nodes[:, :axes] = grid * (sides / (places - 1))
    return Mesh(nodes, cells.reshape(keys.shape), kind, sets)


def _refuse_monster(n_nodes: float, name: str, value: object) -> None:
    if n_nodes > _MOST_NODES:
        raise InputError(f"{name}={value} makes over {_MOST_NODES:g} nodes; is it in metres?")
