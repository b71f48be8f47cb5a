"""Meshes of solid elements: from any file that meshio reads, put in order and checked."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping, Sequence
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
    nearest,
    node_ids,
    positive,
    sequence,
    text,
    warn,
)
from .elements import KINDS, ReferenceElement, cofactors, jacobians, reference_element
from .files import load, named_cells, named_nodes

__all__ = ["Block", "Mesh", "group", "read_mesh", "taken"]


# det J below this fraction of the cube of the element's size: no volume to speak of.
_FLAT = 1e-12

# Coordinates and sizes, m, whose cubes and fourth powers stay far from what doubles can hold.
_LARGEST, _SMALLEST = 1e50, 1e-50

# Nodes closer than this fraction of the mesh's size are at the same place.
_COINCIDENT = 1e-9


# Kinds of elements and their cells.
_Blocks = list[tuple[str, IntArray]]


@dataclass(frozen=True, eq=False)
class Block(Frozen):
    """The elements of one kind in a mesh.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    cells : ndarray of int, shape (n, nodes per cell)
    first : int
        Number of the first among all elements of the mesh.
    """

    kind: str
    cells: IntArray
    first: int

    @property
    def element(self) -> ReferenceElement:
        """Its shape functions and quadrature."""
        return reference_element(self.kind)

    @property
    def numbers(self) -> slice:
        """Of its elements among all of the mesh."""
        return slice(self.first, self.first + len(self.cells))


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(Frozen):
    """A mesh of solid elements.

    Parameters
    ----------
    nodes : array_like, shape (n_nodes, 3)
        Coordinates, m.
    cells : array_like of int, shape (n_cells, nodes per cell)
        Node numbers in meshio's (VTK's) order. Of several kinds of elements: a list of pairs of a
        kind and its cells. As an attribute of such a mesh: an array as wide as the largest element,
        in which short rows repeat their first node; see `blocks`.
    kind : str, optional
        meshio's name of the element, such as "tetra10" or "hexahedron20"; "mixed" for several
        kinds.
    node_sets : mapping of str to array of int, optional
        Named sets of nodes, e.g. for supports.
    cell_sets : mapping of str to array of int, optional
        Named groups of elements by their numbers, e.g. for materials. Kinds are numbered through,
        one after the other.

    Attributes
    ----------
    blocks : tuple of Block
        The elements, kind by kind.

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
    kind: str = "mixed"
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    cell_sets: Mapping[str, IntArray] = field(default_factory=dict)
    blocks: tuple[Block, ...] = field(init=False)

    def __post_init__(self) -> None:
        given = _given_blocks(self.cells, self.kind)
        nodes = np.array(finite_array("nodes", self.nodes, shape=(None, 3), unit="m"))
        blocks, first = [], 0
        for kind, cells in given:
            checked_cells = _checked_cells(cells, reference_element(kind), len(nodes))
            blocks.append(Block(kind, checked_cells, first))
            first += len(checked_cells)
        used = np.zeros(len(nodes), dtype=bool)
        for block in blocks:
            used[block.cells] = True
        unused = np.flatnonzero(~used)
        if len(unused):
            raise MeshError(
                f"nodes: {len(unused)} of {len(nodes)} belong to no element, the first is "
                f"{unused[0]}; leave them out, or let read_mesh do so"
            )
        _check_reach(nodes)
        for block in blocks:
            _check_duplicates(block)
            _check_elements(nodes, block)
        object.__setattr__(self, "node_sets", _sets("node_sets", self.node_sets, len(nodes)))
        object.__setattr__(self, "cell_sets", _sets("cell_sets", self.cell_sets, first))
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "blocks", tuple(blocks))
        object.__setattr__(self, "cells", _table(blocks))
        object.__setattr__(self, "kind", blocks[0].kind if len(blocks) == 1 else "mixed")
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

    @property
    def quadratic(self) -> bool:
        """Whether elements have nodes between their corners."""
        return any(block.element.quadratic for block in self.blocks)

    @property
    def contents(self) -> str:
        """The elements in words, as in "10 hexahedron, 4 wedge"."""
        return ", ".join(f"{len(block.cells)} {block.kind}" for block in self.blocks)

    def __repr__(self) -> str:
        sets = f", sets: {', '.join(self.node_sets)}" if self.node_sets else ""
        groups = f", groups: {', '.join(self.cell_sets)}" if self.cell_sets else ""
        return f"Mesh({self.n_nodes} nodes, {self.contents}{sets}{groups})"

    def part(self, names: str | Sequence[str]) -> Mesh:
        """Return the mesh of some named groups of elements: one of several bodies in a file.

        Sets and groups keep what of them belongs to it; nodes and elements are numbered anew.

        Parameters
        ----------
        names : str or sequence of str
            Of `cell_sets`.

        Raises
        ------
        InputError, InputTypeError
            If there is no group of that name.

        Examples
        --------
        >>> box = ao.box_mesh((0.2, 0.1, 0.1), (2, 1, 1))
        >>> two = Mesh(box.nodes, box.cells, box.kind, box.node_sets, {"tup": [0], "plate": [1]})
        >>> two.part("tup")
        Mesh(8 nodes, 1 hexahedron, sets: xmin, ymin, ymax, zmin, zmax, groups: tup)
        """
        return _part(self, "names", names)


def _part(mesh: Mesh, name: str, given: Any) -> Mesh:
    wanted = [given] if isinstance(given, str) else sequence(name, given)
    if not wanted:
        raise InputError(f"{name}: give the name of a group of elements")
    return taken(mesh, np.unique(np.concatenate([group(mesh, name, each) for each in wanted])))


def group(mesh: Mesh, name: str, wanted: Any) -> IntArray:
    """Return the numbers of the elements of a named group; `name` is the argument's."""
    text(name, wanted)
    if wanted not in mesh.cell_sets:
        known = ", ".join(map(repr, mesh.cell_sets)) or "none"
        raise InputError(
            f"{name}: the mesh has no group of elements {wanted!r}"
            f"{nearest(wanted, mesh.cell_sets)}; it has {known}"
        )
    return mesh.cell_sets[wanted]


def taken(mesh: Mesh, cells: IntArray) -> Mesh:
    """Return the mesh of some elements, shape (n,), ascending, with their nodes alone."""
    chosen = np.zeros(mesh.n_cells, dtype=bool)
    chosen[cells] = True
    used = np.zeros(mesh.n_nodes, dtype=bool)
    used[mesh.cells[chosen]] = True
    number, place = np.cumsum(used) - 1, np.cumsum(chosen) - 1
    blocks: Any = [
        (block.kind, number[block.cells[chosen[block.numbers]]])
        for block in mesh.blocks
        if chosen[block.numbers].any()
    ]
    nodes = {name: number[ids[used[ids]]] for name, ids in mesh.node_sets.items()}
    groups = {name: place[ids[chosen[ids]]] for name, ids in mesh.cell_sets.items()}
    kept = [{name: ids for name, ids in of.items() if len(ids)} for of in (nodes, groups)]
    return Mesh(mesh.nodes[used], blocks, "mixed", *kept)


def read_mesh(
    source: str | os.PathLike[str] | Any,
    *,
    scale: float = 1.0,
    part: str | Sequence[str] | None = None,
) -> Mesh:
    """Return a mesh of solid elements from any file that meshio reads.

    Cells of lower dimension are not part of the body; their groups become named node sets. Groups
    of volume cells become both sets of nodes and groups of elements. What meshio readers leave in
    disorder is put right: midside nodes that come in another order than meshio's own, elements
    numbered left-handed throughout, and nodes of no element.

    Parameters
    ----------
    source : path, meshio.Mesh or Mesh
    scale : float, optional
        Factor on the coordinates, to metres: 1e-3 for a file in millimetres.
    part : str or sequence of str, optional
        Groups of elements that make up the body; all elements if left out. See `Mesh.part`.

    Raises
    ------
    MeshError
        If the file cannot be read (`MissingFileError` if it is not there), has no volume cells or
        some of an unsupported kind, or elements that are inverted or flat.
    InputError
        If there is no group of the name given as `part`.

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
        mesh = source if factor == 1.0 else replace_nodes(source, _scaled(source.nodes, factor))
        return mesh if part is None else _part(mesh, "part", part)
    if isinstance(source, (str, os.PathLike)):
        raw = load(source)
        try:
            mesh = _ordered(raw, factor)
        except (MeshError, InputError, InputTypeError) as error:
            raise MeshError(f"mesh file {os.fspath(source)!r}: {error}") from None
    elif all(hasattr(source, name) for name in ("points", "cells", "point_sets", "cell_sets")):
        mesh = _ordered(source, factor)
    else:
        raise InputTypeError(
            f"mesh must be a path, a meshio.Mesh or a Mesh, got {type(source).__name__}"
        )
    mesh = mesh if part is None else _part(mesh, "part", part)
    _warn_of_pieces(mesh)
    return mesh


def replace_nodes(mesh: Mesh, nodes: FloatArray) -> Mesh:
    """Return the same mesh with its nodes elsewhere."""
    blocks: Any = [(block.kind, block.cells) for block in mesh.blocks]
    return Mesh(nodes, blocks, "mixed", mesh.node_sets, mesh.cell_sets)


def _given_blocks(cells: Any, kind: Any) -> list[tuple[str, Any]]:
    """The kinds of elements and their cells, of either form of the arguments."""
    if not (isinstance(kind, str) and kind == "mixed"):
        return [(choice("kind", kind, KINDS), cells)]
    how = 'cells of a mixed mesh must be a list of pairs such as [("tetra", array), …]'
    try:
        pairs = [(name, part) for name, part in cells]
    except (TypeError, ValueError):
        raise InputTypeError(f"{how}; with an array give its kind") from None
    if not pairs:
        raise InputError(f"{how}, got none")
    kinds = [choice(f"cells[{i}][0]", name, KINDS) for i, (name, _) in enumerate(pairs)]
    if len(set(kinds)) < len(kinds):
        raise InputError(f"cells: join the cells of one kind, got {', '.join(kinds)}")
    return list(zip(kinds, (part for _, part in pairs), strict=True))


def _table(blocks: Sequence[Block]) -> IntArray:
    """The cells of all blocks in one array; short rows repeat their first node."""
    if len(blocks) == 1:
        return blocks[0].cells
    width = max(block.cells.shape[1] for block in blocks)
    return np.concatenate(
        [
            np.hstack([block.cells, np.repeat(block.cells[:, :1], width - block.cells.shape[1], 1)])
            for block in blocks
        ]
    )


def _sets(name: str, sets: Any, count: int) -> dict[str, IntArray]:
    what = "node" if name == "node_sets" else "element"
    if not isinstance(sets, Mapping):
        raise InputTypeError(f"{name} must be a dict of names and {what} numbers, got {sets!r}")
    return {
        str(key): node_ids(f"{name}[{key!r}]", members, count, what)
        for key, members in sets.items()
    }


def _ordered(raw: Any, factor: float) -> Mesh:
    """Return a `meshio.Mesh` put in order and checked."""
    if np.ndim(raw.points) != 2:
        raise MeshError(
            f"coordinates of the mesh must have shape (any, 3), got {np.shape(raw.points)}"
        )
    blocks, first = _volume_cells(raw)
    blocks = [
        (kind, _checked_cells(cells, reference_element(kind), len(raw.points)))
        for kind, cells in blocks
    ]
    nodes = _scaled(_coordinates(raw.points, blocks), factor)
    nodes, blocks, sets = _drop_unused(nodes, blocks, named_nodes(raw))
    blocks = [(kind, _order_midside_nodes(nodes, cells, kind)) for kind, cells in blocks]
    blocks = [(kind, _make_right_handed(nodes, cells, kind)) for kind, cells in blocks]
    return Mesh(nodes, blocks, "mixed", sets, named_cells(raw, first))  # type: ignore[arg-type]


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


def _coordinates(points: Any, blocks: _Blocks) -> FloatArray:
    """Return checked coordinates; those of nodes that no cell uses may be anything."""
    array = np.asarray(points)
    if array.ndim == 2 and array.shape[1] == 2:
        raise MeshError("the mesh is two-dimensional (x, y); a solid needs x, y and z")
    unused = np.ones(len(array), dtype=bool)
    for _, cells in blocks:
        unused[cells] = False
    if unused.any() and array.dtype.kind == "f":
        points = np.array(points, subok=True)  # a masked array stays one, and is refused
        points[unused] = 0.0
    return finite_array("coordinates of the mesh", points, shape=(None, 3), unit="m")


def _volume_cells(raw: Any) -> tuple[list[tuple[str, Any]], dict[int, int]]:
    """Return the volume cells by kind, in the order of the file, and each block's first number."""
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
    found: list[tuple[str, Any]] = []
    first: dict[int, int] = {}
    count = 0
    for kind in (kind for kind in KINDS if kind in volume):
        # Empty blocks, as of a header without elements, may have any shape.
        parts = [(i, of.data) for i, of in enumerate(raw.cells) if of.type == kind and len(of.data)]
        for i, cells in parts:
            first[i] = count
            count += len(cells)
        try:
            found.append((kind, np.concatenate([cells for _, cells in parts])))
        except ValueError:
            shapes = ", ".join(sorted({str(np.shape(cells)) for _, cells in parts}))
            raise MeshError(
                f"blocks of cells of kind {kind} have different shapes: {shapes}"
            ) from None
    return found, first


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
    nodes: FloatArray, blocks: _Blocks, sets: dict[str, IntArray]
) -> tuple[FloatArray, _Blocks, dict[str, IntArray]]:
    used = np.zeros(len(nodes), dtype=bool)
    for _, cells in blocks:
        used[cells] = True
    if used.all():
        return nodes, blocks, sets
    first = int(np.flatnonzero(~used)[0])
    warn(
        f"{int((~used).sum())} of {len(nodes)} nodes belong to no volume element and were dropped; "
        f"nodes after {first} have new numbers (named sets keep their members)",
    )
    number = np.cumsum(used) - 1
    kept = {name: number[members[used[members]]] for name, members in sets.items()}
    moved = [(kind, number[cells]) for kind, cells in blocks]
    return nodes[used], moved, {name: ids for name, ids in kept.items() if len(ids)}


def _order_midside_nodes(nodes: FloatArray, cells: IntArray, kind: str) -> IntArray:
    """Put midside nodes in meshio's order by where they lie, if they are in another throughout."""
    element = reference_element(kind)
    n = element.n_corners
    if not element.quadratic:
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
        f"the midside nodes of the {len(cells)} {kind} elements come in another order than "
        f"meshio's; they were put in order by their places ({(order + n).tolist()})",
    )
    return np.ascontiguousarray(np.concatenate([cells[:, :n], cells[:, n:][:, order]], axis=1))


def _make_right_handed(nodes: FloatArray, cells: IntArray, kind: str) -> IntArray:
    """Renumber the elements if every one of them is the mirror image of a good one."""
    element = reference_element(kind)
    _, highest = _jacobian_range(nodes, cells, element)
    if (highest >= 0.0).any():
        return cells
    warn(f"all {len(cells)} {kind} elements are numbered left-handed; they were renumbered")
    return np.ascontiguousarray(cells[:, element.mirror])


def _check_duplicates(block: Block) -> None:
    """Refuse elements on the same corners: their stiffness and mass would count twice."""
    cells = block.cells
    corners = np.sort(cells[:, : block.element.n_corners], axis=1)
    order = np.lexsort(corners.T)  # stable: of equal elements the first comes first
    same = (corners[order[1:]] == corners[order[:-1]]).all(axis=1)
    if same.any():
        first = int(np.flatnonzero(same)[0])
        earlier, later = int(order[first]), int(order[first + 1])
        raise MeshError(
            f"{int(same.sum())} of {len(cells)} elements are there twice, on the same corners in "
            f"whatever order: element {block.first + later} repeats element "
            f"{block.first + earlier}, with nodes {cells[earlier].tolist()}; remove duplicate "
            "elements in the mesher (a volume in two groups, or copied)"
        )


def _check_elements(nodes: FloatArray, block: Block) -> None:
    cells = block.cells
    lowest, highest = _jacobian_range(nodes, cells, block.element)
    flat = np.maximum(np.abs(lowest), np.abs(highest)) <= _FLAT
    inverted = (lowest <= _FLAT) & ~flat
    for bad, what in ((flat, "flat (no volume)"), (inverted, "inverted (Jacobian not positive)")):
        if bad.any():
            first = int(np.flatnonzero(bad)[0])
            centre = ", ".join(f"{x:.4g}" for x in nodes[cells[first]].mean(axis=0))
            raise MeshError(
                f"{int(bad.sum())} of {len(cells)} elements are {what}; the first is element "
                f"{block.first + first} near ({centre}) m with nodes {cells[first].tolist()}; "
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
