"""Meshes of solid elements: from any file that meshio reads, put in order and checked."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy
import scipy.sparse as sp

from ..base import (
    FloatArray,
    Frozen,
    InputError,
    InputTypeError,
    IntArray,
    MeshError,
    choice,
    finite_array,
    node_ids,
    positive,
    warn,
)
from .elements import KINDS, ReferenceElement, cofactors, jacobians, reference_element
from .files import load, named_nodes

__all__ = ["Mesh", "read_mesh"]


# det J below this fraction of the cube of the element's size: no volume to speak of.
_FLAT = 1e-12

# Coordinates and sizes, m, whose cubes and fourth powers stay far from what doubles can hold.
_LARGEST, _SMALLEST = 1e50, 1e-50

# Nodes closer than this fraction of the mesh's size are at the same place.
_COINCIDENT = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(Frozen):
    """A mesh of solid elements of one kind.

    Parameters
    ----------
    nodes : array_like, shape (n_nodes, 3)
        Coordinates, m.
    cells : array_like of int, shape (n_cells, nodes per cell)
        Node numbers in meshio's (VTK's) order.
    kind : str
        meshio's name of the element, such as "tetra10" or "hexahedron20".
    node_sets : mapping of str to array of int, optional
        Named sets of nodes, e.g. for supports.

    Raises
    ------
    MeshError
        If elements are inverted, flat or there twice, or nodes belong to no element: these are
        counted, and the first one is named.
    InputError, InputTypeError
        If the arrays have the wrong shape or type, or node numbers are out of range.

    Examples
    --------
    >>> mesh = ao.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]], "tetra")
    >>> mesh.n_nodes, mesh.kind
    (4, 'tetra')
    """

    nodes: FloatArray
    cells: IntArray
    kind: str
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        element = reference_element(choice("kind", self.kind, KINDS))
        nodes = np.array(finite_array("nodes", self.nodes, shape=(None, 3), unit="m"))
        cells = _checked_cells(self.cells, element, len(nodes))
        used = np.zeros(len(nodes), dtype=bool)
        used[cells] = True
        unused = np.flatnonzero(~used)
        if len(unused):
            raise MeshError(
                f"nodes: {len(unused)} of {len(nodes)} belong to no element, the first is "
                f"{unused[0]}; leave them out, or let read_mesh do so"
            )
        _check_reach(nodes)
        _check_duplicates(cells, element)
        _check_elements(nodes, cells, element)
        if not isinstance(self.node_sets, Mapping):
            raise InputTypeError(
                f"node_sets must be a dict of names and node numbers, got {self.node_sets!r}"
            )
        sets = {
            str(name): node_ids(f"node_sets[{name!r}]", members, len(nodes))
            for name, members in self.node_sets.items()
        }
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "cells", cells)
        object.__setattr__(self, "node_sets", sets)
        super().__post_init__()

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.nodes)

    @property
    def n_cells(self) -> int:
        """Number of elements."""
        return len(self.cells)

    @cached_property
    def size(self) -> float:
        """The longest side of the box that holds the mesh, m."""
        return float(np.ptp(self.nodes, axis=0).max())

    def __repr__(self) -> str:
        sets = f", sets: {', '.join(self.node_sets)}" if self.node_sets else ""
        return f"Mesh({self.n_nodes} nodes, {self.n_cells} {self.kind}{sets})"


def read_mesh(source: str | os.PathLike[str] | Any, *, scale: float = 1.0) -> Mesh:
    """Return a mesh of solid elements from any file that meshio reads.

    Cells of lower dimension are not part of the body; their groups become named node sets. What
    meshio readers leave in disorder is put right: midside nodes that come in another order than
    meshio's own, elements numbered left-handed throughout, and nodes of no element.

    Parameters
    ----------
    source : path, meshio.Mesh or Mesh
    scale : float, optional
        Factor on the coordinates, to metres: 1e-3 for a file in millimetres.

    Raises
    ------
    MeshError
        If the file cannot be read (`MissingFileError` if it is not there), has no volume cells or
        several kinds of them, or elements that are inverted or flat.

    Warns
    -----
    AOImpactWarning
        If nodes were dropped or elements renumbered, or if the mesh falls into pieces.

    Examples
    --------
    >>> import tempfile
    >>> import meshio
    >>> with tempfile.NamedTemporaryFile(suffix=".vtk") as file:
    ...     box = ao.box_mesh((20, 10, 10), (2, 1, 1))  # mm
    ...     meshio.Mesh(box.nodes, [("hexahedron", box.cells)]).write(file.name, file_format="vtk")
    ...     mesh = ao.read_mesh(file.name, scale=1e-3)
    >>> mesh.nodes.max(axis=0)  # m
    array([0.02, 0.01, 0.01])
    """
    factor = positive("scale", scale)
    if isinstance(source, Mesh):
        if factor == 1.0:
            return source
        return Mesh(_scaled(source.nodes, factor), source.cells, source.kind, source.node_sets)
    if isinstance(source, (str, os.PathLike)):
        raw = load(source)
        try:
            return _ordered(raw, factor)
        except (MeshError, InputError, InputTypeError) as error:
            raise MeshError(f"mesh file {os.fspath(source)!r}: {error}") from None
    if not all(hasattr(source, name) for name in ("points", "cells", "point_sets", "cell_sets")):
        raise InputTypeError(
            f"mesh must be a path, a meshio.Mesh or a Mesh, got {type(source).__name__}"
        )
    return _ordered(source, factor)


def _ordered(raw: Any, factor: float) -> Mesh:
    """Return a `meshio.Mesh` put in order and checked."""
    if np.ndim(raw.points) != 2:
        raise MeshError(
            f"coordinates of the mesh must have shape (any, 3), got {np.shape(raw.points)}"
        )
    kind, cells = _volume_cells(raw)
    element = reference_element(kind)
    cells = _checked_cells(cells, element, len(raw.points))
    nodes = _scaled(_coordinates(raw.points, cells), factor)
    nodes, cells, sets = _drop_unused(nodes, cells, named_nodes(raw))
    cells = _order_midside_nodes(nodes, cells, element)
    cells = _make_right_handed(nodes, cells, element)
    mesh = Mesh(nodes, cells, kind, sets)
    _warn_of_pieces(mesh)
    return mesh


def _scaled(nodes: FloatArray, factor: float) -> FloatArray:
    with np.errstate(over="ignore", under="ignore"):  # what overflows is out of reach
        scaled = nodes * factor
    _check_reach(scaled)
    return scaled


def _check_reach(nodes: FloatArray) -> None:
    """Refuse sizes that no body has: volumes would overflow, or vanish."""
    farthest = float(np.abs(nodes).max())
    if farthest > _LARGEST:
        raise MeshError(
            f"coordinates reach {farthest:.3g} m, and volumes of that size cannot be computed; "
            "give coordinates in metres (is scale right?)"
        )
    size = float(np.ptp(nodes, axis=0).max())
    if 0.0 < size < _SMALLEST or farthest == 0.0:
        raise MeshError(
            f"the mesh is {size:.3g} m long, and volumes of that size cannot be computed; "
            "give coordinates in metres (is scale right?)"
        )


def _coordinates(points: Any, cells: IntArray) -> FloatArray:
    """Return checked coordinates; those of nodes that no cell uses may be anything."""
    array = np.asarray(points)
    if array.ndim == 2 and array.shape[1] == 2:
        raise MeshError("the mesh is two-dimensional (x, y); a solid needs x, y and z")
    unused = np.ones(len(array), dtype=bool)
    unused[cells] = False
    if unused.any() and array.dtype.kind == "f":
        points = np.array(points, subok=True)  # a masked array stays one, and is refused
        points[unused] = 0.0
    return finite_array("coordinates of the mesh", points, shape=(None, 3), unit="m")


def _volume_cells(raw: Any) -> tuple[str, IntArray]:
    """Return the one kind of volume cell and its cells, in the order of the file."""
    counts: Counter[str] = Counter()
    for block in raw.cells:
        counts[block.type] += len(block.data)
    counts = +counts
    supported = f"supported are {', '.join(KINDS)}"
    listed = ", ".join(f"{count} {kind}" for kind, count in counts.items()) or "no cells at all"
    # A block of unknown dimension is of a kind that is not supported either.
    volume = {
        block.type for block in raw.cells if len(block.data) and getattr(block, "dim", 3) == 3
    }
    if not volume:
        raise MeshError(f"the mesh has no volume cells: it has {listed}; {supported}")
    unknown = sorted(volume.difference(KINDS))
    if unknown:
        what = ", ".join(f"{counts[kind]} {kind}" for kind in unknown)
        raise MeshError(f"the mesh has volume cells of an unsupported kind: {what}; {supported}")
    if len(volume) > 1:
        raise MeshError(
            f"the mesh mixes kinds of volume cells: {listed}; mesh the body with one kind"
        )
    (kind,) = volume
    # Empty blocks, as of a header without elements, may have any shape.
    blocks = [block.data for block in raw.cells if block.type == kind and len(block.data)]
    try:
        return kind, np.concatenate(blocks)
    except ValueError:
        shapes = ", ".join(sorted({str(np.shape(block)) for block in blocks}))
        raise MeshError(f"blocks of cells of kind {kind} have different shapes: {shapes}") from None


def _checked_cells(cells: Any, element: ReferenceElement, n_nodes: int) -> IntArray:
    try:
        array = np.array(cells)
    except ValueError as error:
        raise InputTypeError(f"cells must be integer node numbers: {error}") from None
    if array.dtype.kind not in "iu":
        raise InputTypeError(f"cells must be integer node numbers, got dtype {array.dtype}")
    if array.ndim != 2 or array.shape[1] != element.n_nodes or not len(array):
        raise MeshError(
            f"cells of kind {element.kind} must have shape (any, {element.n_nodes}), "
            f"got {array.shape}"
        )
    outside = (array < 0) | (array >= n_nodes)
    if outside.any():
        first = int(np.flatnonzero(outside.any(axis=1))[0])
        raise MeshError(
            f"{int(outside.any(axis=1).sum())} elements refer to nodes that are not there, the "
            f"first is element {first}: {array[first].tolist()}; nodes run from 0 to {n_nodes - 1}"
        )
    return np.ascontiguousarray(array, dtype=np.int64)


def _drop_unused(
    nodes: FloatArray, cells: IntArray, sets: dict[str, IntArray]
) -> tuple[FloatArray, IntArray, dict[str, IntArray]]:
    used = np.zeros(len(nodes), dtype=bool)
    used[cells] = True
    if used.all():
        return nodes, cells, sets
    first = int(np.flatnonzero(~used)[0])
    warn(
        f"{int((~used).sum())} of {len(nodes)} nodes belong to no volume element and were dropped; "
        f"nodes after {first} have new numbers (named sets keep their members)",
    )
    number = np.cumsum(used) - 1
    kept = {name: number[members[used[members]]] for name, members in sets.items()}
    return nodes[used], number[cells], {name: ids for name, ids in kept.items() if len(ids)}


def _order_midside_nodes(nodes: FloatArray, cells: IntArray, element: ReferenceElement) -> IntArray:
    """Put midside nodes in meshio's order by where they lie, if they are in another throughout."""
    n = element.n_corners
    if element.n_nodes == n:
        return cells
    sample = cells[np.linspace(0, len(cells) - 1, min(len(cells), 2000)).astype(int)]
    between = element.linear.shape(element.nodes[n:])
    corners = nodes[sample[:, :n]]
    expected = between @ corners
    size = np.ptp(corners, axis=1).max(axis=1)
    gaps = expected[:, :, None, :] - nodes[sample[:, n:]][:, None, :, :]
    size = np.where(size > _SMALLEST, size, 1.0)
    misfit = np.einsum("eabi,e->ab", gaps**2, size**-2.0)
    _, order = scipy.optimize.linear_sum_assignment(misfit)
    if np.array_equal(order, np.arange(len(order))):
        return cells
    warn(
        f"the midside nodes of the {len(cells)} {element.kind} elements come in another order than "
        f"meshio's; they were put in order by their places ({(order + n).tolist()})",
    )
    return np.ascontiguousarray(np.concatenate([cells[:, :n], cells[:, n:][:, order]], axis=1))


def _make_right_handed(nodes: FloatArray, cells: IntArray, element: ReferenceElement) -> IntArray:
    """Renumber the elements if every one of them is the mirror image of a good one."""
    _, highest = _jacobian_range(nodes, cells, element)
    if (highest >= 0.0).any():
        return cells
    warn(
        f"all {len(cells)} elements are numbered left-handed; they were renumbered",
    )
    return np.ascontiguousarray(cells[:, element.mirror])


def _check_duplicates(cells: IntArray, element: ReferenceElement) -> None:
    """Refuse elements on the same corners: their stiffness and mass would count twice."""
    corners = np.sort(cells[:, : element.n_corners], axis=1)
    order = np.lexsort(corners.T)  # stable: of equal elements the first comes first
    same = (corners[order[1:]] == corners[order[:-1]]).all(axis=1)
    if same.any():
        first = int(np.flatnonzero(same)[0])
        earlier, later = int(order[first]), int(order[first + 1])
        raise MeshError(
            f"{int(same.sum())} of {len(cells)} elements are there twice, on the same corners in "
            f"whatever order: element {later} repeats element {earlier}, with nodes "
            f"{cells[earlier].tolist()}; remove duplicate elements in the mesher (a volume in two "
            "groups, or copied)"
        )


def _check_elements(nodes: FloatArray, cells: IntArray, element: ReferenceElement) -> None:
    lowest, highest = _jacobian_range(nodes, cells, element)
    flat = np.maximum(np.abs(lowest), np.abs(highest)) <= _FLAT
    inverted = (lowest <= _FLAT) & ~flat
    for bad, what in ((flat, "flat (no volume)"), (inverted, "inverted (Jacobian not positive)")):
        if bad.any():
            first = int(np.flatnonzero(bad)[0])
            centre = ", ".join(f"{x:.4g}" for x in nodes[cells[first]].mean(axis=0))
            raise MeshError(
                f"{int(bad.sum())} of {len(cells)} elements are {what}; the first is element "
                f"{first} near ({centre}) m with nodes {cells[first].tolist()}; "
                "repair or improve the mesh there"
            )


def _jacobian_range(
    nodes: FloatArray, cells: IntArray, element: ReferenceElement
) -> tuple[FloatArray, FloatArray]:
    """Smallest and largest det J of each element at its points of quadrature, over its size³."""
    gradient = element.gradient(element.stiffness_rule.points)
    lowest, highest = np.empty(len(cells)), np.empty(len(cells))
    for start in range(0, len(cells), 4096):
        part = slice(start, start + 4096)
        corners = nodes[cells[part]]
        det, _ = cofactors(jacobians(corners, gradient))
        size = np.ptp(corners, axis=1).max(axis=1)
        det /= np.where(size > _SMALLEST, size, 1.0)[:, None] ** 3
        lowest[part], highest[part] = det.min(axis=1), det.max(axis=1)
    return lowest, highest


def _warn_of_pieces(mesh: Mesh) -> None:
    n_local = mesh.cells.shape[1]
    first = np.repeat(mesh.cells[:, 0], n_local - 1)
    others = mesh.cells[:, 1:].reshape(-1)
    links = sp.coo_array((np.ones(len(first), bool), (first, others)), shape=(mesh.n_nodes,) * 2)
    n_pieces, _ = sp.csgraph.connected_components(links, directed=False)
    if n_pieces == 1:
        return
    pairs = scipy.spatial.KDTree(mesh.nodes).query_pairs(
        _COINCIDENT * mesh.size, output_type="ndarray"
    )
    hint = (
        f"{len(pairs)} pairs of nodes lie at the same place: merge coincident nodes in the mesher"
        if len(pairs)
        else "no nodes lie at the same place: check that this is one body"
    )
    warn(
        f"the mesh falls into {n_pieces} pieces that share no nodes; {hint}",
    )
