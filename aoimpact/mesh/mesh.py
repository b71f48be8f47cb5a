"""Meshes of solid, surface and line elements, and their validation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..base import (
    ROUNDING,
    ArrayPair,
    BoolArray,
    FloatArray,
    Frozen,
    InputError,
    InputTypeError,
    IntArray,
    MeshError,
    called,
    choice,
    finite_array,
    instance,
    integers,
    nearest,
    node_ids,
    record,
    sequence,
    text,
)
from .elements import KINDS, THIN, ReferenceElement, cofactors, jacobians, reference_element

# Elements of one kind: the kind, node numbers of each element, and its number among all cells of
# the file.
Solids = tuple[str, IntArray, IntArray]

# Largest distance, relative to the size of the body or element, between places that count as the
# same, and largest sine of the angle between directions that do: coordinates in mesh files have few
# digits.
AT_NODE = 1e-6

# Cosine of 45°. An edge is sharp if the normals of its faces differ by more; on round bodies of few
# linear elements they differ by up to 40°. A quadrilateral is folded, not just warped, if the
# normal at a corner differs from the mean normal by more. A force acts along a beam if its angle
# with the axis is smaller.
SHARP = np.sqrt(0.5)


@record
class Block(Frozen):
    """The elements of one kind in a mesh.

    Attributes
    ----------
    kind : str
        One of `KINDS` or `THIN`, with "+" if enriched.
    cells : ndarray of int, shape (n, nodes per cell)
        Node numbers of each element.
    first : int
        Number of the block's first element among all elements of the mesh.
    signs : ndarray, shape (n, nodes per cell), or None
        Factors (1, -1 or 0) on the shape functions of each element; None: all are 1.
    """

    kind: str
    cells: IntArray
    first: int
    signs: FloatArray | None = None

    @property
    def element(self) -> ReferenceElement:
        """The reference element: shape functions and quadrature of the block's kind."""
        return reference_element(self.kind)

    @property
    def numbers(self) -> slice:
        """Numbers of the block's elements among all elements of the mesh."""
        return slice(self.first, self.first + len(self.cells))


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(Frozen):
    """A mesh of solid elements, or of surface and line elements for shells and beams.

    Parameters
    ----------
    nodes : array_like, shape (n_nodes, 3)
        Coordinates, m.
    cells : array_like of int, shape (n_cells, nodes per cell)
        Node numbers of each element in meshio's (VTK's) order; for several kinds of elements, a
        list of pairs (kind, cells). The attribute `cells` of such a mesh is an array as wide as the
        largest element, in which shorter rows repeat their first node; see `blocks`.
    kind : str, optional
        meshio's name of the kind of element, such as "tetra10", "hexahedron20", "quad" or "line";
        "mixed" for several kinds.
    node_sets : mapping of str to array of int, optional
        Named sets of nodes, e.g. for supports.
    cell_sets : mapping of str to array of int, optional
        Named groups of element numbers, e.g. for materials. Elements are numbered from 0 through
        all kinds, one kind after the other.
    node_labels : array_like of int, shape (n_nodes,), optional
        Numbers of the nodes in the file, by which supports, masses, springs, contacts and probes
        refer to nodes. A number that occurs twice, as in two instances of an Abaqus part, cannot be
        used to refer to a node.
    cell_labels : array_like of int, shape (n_cells,), optional
        Numbers of the elements in the file.
    left_out : mapping of str to str, optional
        Groups of a file that also contain other items than solids, and these items, as in
        "3 MASS". Such groups are refused as groups of elements.

    Attributes
    ----------
    blocks : tuple of Block
        The elements, kind by kind.

    Raises
    ------
    MeshError
        If elements are inverted, flat or duplicate, or nodes belong to no element; the message says
        how many, and which is the first.
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
    node_labels: IntArray | None = None
    cell_labels: IntArray | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)
    blocks: tuple[Block, ...] = field(init=False)

    def __post_init__(self) -> None:
        given = _given_blocks(self.cells, self.kind)
        nodes = np.array(finite_array("nodes", self.nodes, shape=(None, 3), unit="m"))
        blocks, first = [], 0
        for kind, cells in given:
            own = checked_cells(cells, reference_element(kind), len(nodes))
            blocks.append(Block(kind, own, first))
            first += len(own)
        table = _table(blocks)
        unused = np.flatnonzero(np.bincount(table.ravel(), minlength=len(nodes)) == 0)
        if len(unused):
            which = f"{len(unused)} of {len(nodes)}, the first {unused[0]}, belong to no element"
            raise MeshError(f"nodes: {which}. Leave them out, or let read_mesh do so")
        labels = [
            None if own is None else integers(name, own, "integers", shape=(count,))
            for name, own, count in (
                ("node_labels", self.node_labels, len(nodes)),
                ("cell_labels", self.cell_labels, first),
            )
        ]
        for block in blocks:
            _check_elements(nodes, block, *labels)
        vars(self).update(
            nodes=nodes,
            cells=table,
            kind=blocks[0].kind if len(blocks) == 1 else "mixed",
            node_sets=_sets("node_sets", self.node_sets, len(nodes), "node"),
            cell_sets=_sets("cell_sets", self.cell_sets, first, "element"),
            node_labels=labels[0],
            cell_labels=labels[1],
            left_out=dict(instance("left_out", self.left_out, Mapping)),
            blocks=tuple(blocks),
        )
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
        """Length of the longest side of the bounding box of the mesh, m."""
        return float(np.ptp(self.nodes, axis=0).max())

    @property
    def thin(self) -> bool:
        """True if the mesh has surface or line elements, for shells and beams."""
        return any(block.element.thin for block in self.blocks)

    def of_elements(self, *, thin: bool) -> Mesh:
        """Return a mesh of the shells and beams, or of the solids, with all nodes of this mesh.

        :meta private:
        """
        made = copy(self)
        vars(made)["blocks"] = tuple(of for of in self.blocks if of.element.thin == thin)
        return made

    @property
    def thin_nodes(self) -> IntArray:
        """Nodes of surface and line elements, which have rotational dofs, ascending."""
        cells = [block.cells.ravel() for block in self.blocks if block.element.thin]
        return np.unique(np.concatenate([np.zeros(0, np.int64), *cells]))

    @property
    def quadratic(self) -> bool:
        """True if some elements have nodes between their corners."""
        return any(block.element.quadratic for block in self.blocks)

    @property
    def contents(self) -> str:
        """Number of elements of each kind, as in "10 hexahedron, 4 wedge"."""
        return ", ".join(f"{len(block.cells)} {block.kind}" for block in self.blocks)

    def __repr__(self) -> str:
        sets = f", sets: {', '.join(self.node_sets)}" if self.node_sets else ""
        groups = f", groups: {', '.join(self.cell_sets)}" if self.cell_sets else ""
        return f"Mesh({self.n_nodes} nodes, {self.contents}{sets}{groups})"

    def part(self, names: str | Sequence[str]) -> Mesh:
        """Return the mesh of the named groups of elements, e.g. of one of several bodies in a file.

        Nodes and elements are renumbered. Sets and groups keep the members that are in the part.

        Parameters
        ----------
        names : str or sequence of str
            Names in `cell_sets`.

        Raises
        ------
        InputError, InputTypeError
            If the mesh has no group of that name.

        Examples
        --------
        >>> box = ao.box_mesh((0.2, 0.1, 0.1), (2, 1, 1))
        >>> two = Mesh(box.nodes, box.cells, box.kind, box.node_sets, {"tup": [0], "plate": [1]})
        >>> two.part("tup")
        Mesh(8 nodes, 1 hexahedron, sets: xmin, ymin, ymax, zmin, zmax, groups: tup)
        """
        return select(self, "names", names)


def select(mesh: Mesh, name: str, given: Any) -> Mesh:
    """Return `mesh.part(given)`; `name` is the name of the argument, for messages."""
    wanted = [given] if isinstance(given, str) else sequence(name, given)
    if not wanted:
        raise InputError(f"{name}: give the name of a group of elements")
    return taken(mesh, np.unique(np.concatenate([group(mesh, name, each) for each in wanted])))


def group(mesh: Mesh, name: str, wanted: Any) -> IntArray:
    """Return the element numbers of a group; `name` is the argument's name, for messages."""
    text(name, wanted)
    if other := called(wanted, mesh.left_out):
        why = f"{name}: the group {wanted!r} also holds {mesh.left_out[other]}"
        raise InputError(f"{why}. Name groups of solids alone")
    found = called(wanted, mesh.cell_sets)
    if found is None:
        known = ", ".join(map(repr, mesh.cell_sets)) or "none"
        if called(wanted, mesh.node_sets):
            why = f"{name}: {wanted!r} is a set of nodes of this mesh"
            raise InputError(f"{why}. Name groups of shells and beams in read_mesh(path, part=)")
        why = f"{name}: the mesh has no group of elements {wanted!r}"
        raise InputError(f"{why}{nearest(wanted, mesh.cell_sets)}. It has {known}")
    return mesh.cell_sets[found]


def taken(mesh: Mesh, cells: IntArray) -> Mesh:
    """Return the mesh of the elements numbered `cells`, ascending, with only their nodes."""
    parts = np.split(cells, np.searchsorted(cells, [block.first for block in mesh.blocks[1:]]))
    own = [
        (block.kind, block.cells[numbers - block.first], numbers)
        for block, numbers in zip(mesh.blocks, parts, strict=True)
        if len(numbers)
    ]
    return gathered(mesh, own, mesh.n_cells)


def gathered(of: Any, parts: Sequence[Solids], n_cells: int) -> Mesh:
    """Return the mesh of some elements of a `Mesh` or `RawMesh`, with only their nodes.

    Sets and groups keep the members that are in the new mesh.
    """
    members = np.concatenate([cells.ravel() for _, cells, _ in parts])
    used = np.bincount(members, minlength=len(of.nodes)) > 0
    number = np.where(used, np.cumsum(used) - 1, -1)
    order = np.concatenate([numbers for *_, numbers in parts])
    place = np.full(n_cells, -1)
    place[order] = np.arange(len(order))
    return Mesh(
        of.nodes[used],
        [(kind, number[cells]) for kind, cells, _ in parts],  # type: ignore[arg-type]
        "mixed",
        _renumbered(of.node_sets, number),
        _renumbered(of.cell_sets, place),
        None if of.node_labels is None else of.node_labels[used],
        None if of.cell_labels is None else of.cell_labels[order],
        of.left_out,
    )


def _renumbered(sets: Mapping[str, IntArray], number: IntArray) -> dict[str, IntArray]:
    """Return sets with the members' new numbers; members of number -1, empty sets are left out."""
    new = {name: number[ids] for name, ids in sets.items()}
    return {name: ids[ids >= 0] for name, ids in new.items() if (ids >= 0).any()}


def _given_blocks(cells: Any, kind: Any) -> list[tuple[str, Any]]:
    """Return pairs (kind, cells), from an array and its kind or from a list of pairs."""
    if not (isinstance(kind, str) and kind == "mixed"):
        return [(choice("kind", kind, KINDS + THIN), cells)]
    how = 'cells of a mixed mesh must be a list of pairs such as [("tetra", array), …]'
    try:
        pairs = [(name, part) for name, part in cells]
    except (TypeError, ValueError):
        raise InputTypeError(f"{how}; with an array give its kind") from None
    if not pairs:
        raise InputError(f"{how}, got none")
    kinds = [choice(f"cells[{i}][0]", name, KINDS + THIN) for i, (name, _) in enumerate(pairs)]
    if len(set(kinds)) < len(kinds):
        raise InputError(f"cells: join the cells of one kind, got {', '.join(kinds)}")
    return list(zip(kinds, (part for _, part in pairs), strict=True))


def _table(blocks: Sequence[Block]) -> IntArray:
    """Return the cells of all blocks in one array; shorter rows repeat their first node."""
    if len(blocks) == 1:
        return blocks[0].cells
    width = max(block.cells.shape[1] for block in blocks)
    fill = [np.repeat(of.cells[:, :1], width - of.cells.shape[1], axis=1) for of in blocks]
    return np.vstack([np.hstack([of.cells, more]) for of, more in zip(blocks, fill, strict=True)])


def _sets(name: str, given: Any, count: int, what: str) -> dict[str, IntArray]:
    return {
        str(key): node_ids(f"{name}[{key!r}]", members, count, what)
        for key, members in instance(name, given, Mapping).items()
    }


def twins(table: IntArray) -> tuple[IntArray, IntArray]:
    """Return the indices of the first and of the second row of each pair of equal rows."""
    order = np.lexsort(table.T)
    same = (table[order[1:]] == table[order[:-1]]).all(axis=1)
    return order[:-1][same], order[1:][same]


def checked_cells(cells: Any, element: ReferenceElement, n_nodes: int) -> IntArray:
    """Return `cells` as an array, shape (n, nodes per element), of node numbers in range."""
    array = integers("cells", cells, "integer node numbers")
    if array.ndim != 2 or array.shape[1] != element.n_nodes or not len(array):
        shape = f"(any, {element.n_nodes})"
        raise MeshError(f"cells of {element.kind} must have shape {shape}, got {array.shape}")
    outside = np.flatnonzero(((array < 0) | (array >= n_nodes)).any(axis=1))
    if len(outside):
        nodes = array[outside[0]].tolist()
        which = f"{len(outside)} elements, the first {outside[0]}: {nodes}"
        raise MeshError(f"cells: nodes must be from 0 to {n_nodes - 1}, unlike in {which}")
    return np.ascontiguousarray(array)


def _check_elements(
    nodes: FloatArray, block: Block, node_labels: IntArray | None, cell_labels: IntArray | None
) -> None:
    """Refuse elements that are duplicate, flat or inverted, or that repeat a corner."""
    cells, number = block.cells, np.r_[block.numbers]
    elements = number if cell_labels is None else cell_labels[number]  # numbers that the user knows
    names = np.arange(len(nodes)) if node_labels is None else node_labels
    corners = np.sort(cells[:, : block.element.n_corners], axis=1)
    both = np.stack(twins(corners), axis=1)
    for earlier, later in both[:1]:  # their stiffness and mass would count twice
        of = names[cells[earlier]].tolist()
        two = f"element {elements[later]} repeats {elements[earlier]}, nodes {of}"
        raise MeshError(f"{len(both)} of {len(cells)} elements are there twice: {two}. Remove them")
    repeats = (corners[:, 1:] == corners[:, :-1]).any(axis=1)
    if block.element.thin:
        flat, inverted = _misshapen(nodes[cells])
        flat &= ~repeats
        size, turned = "area or length", "are folded, or have an angle of 180° or more"
    else:
        lowest, highest = jacobian_range(nodes, cells, block.element)
        flat = np.maximum(np.abs(lowest), np.abs(highest)) <= ROUNDING
        inverted = (lowest <= ROUNDING) & ~flat
        size, turned = "volume", "are inverted (Jacobian not positive)"
    cure = "Repair or improve the mesh there"
    for bad, what, how in (
        (flat, f"are flat (no {size})", cure),
        (inverted, turned, cure),
        (repeats, "repeat a node", "Read the mesh by read_mesh, which makes them other solids"),
    ):
        for row in np.flatnonzero(bad)[:1].tolist():
            centre = ", ".join(f"{x:.4g}" for x in nodes[cells[row]].mean(axis=0))
            of = names[cells[row]].tolist()
            first = f"the first is element {elements[row]} near ({centre}) m, nodes {of}"
            raise MeshError(f"{int(bad.sum())} of {len(cells)} elements {what}; {first}. {how}")


def _misshapen(corners: FloatArray) -> tuple[BoolArray, BoolArray]:
    """Return masks of surface or line elements of no area or length, and of folded elements."""
    ahead = np.roll(corners, -1, axis=1) - corners
    size = np.abs(ahead).max(axis=(1, 2))
    if corners.shape[1] == 2:
        return size == 0.0, np.zeros(len(corners), dtype=bool)
    ahead /= np.where(size > 0.0, size, 1.0)[:, None, None]
    at_corners = np.cross(np.roll(ahead, 1, axis=1), ahead)
    mean = at_corners.sum(axis=1)
    size = np.linalg.norm(mean, axis=1)
    flat = size <= AT_NODE * (ahead**2).sum(axis=2).max(axis=1)
    along = np.einsum("nci,ni->nc", at_corners, mean / np.where(flat, 1.0, size)[:, None])
    folded = (along <= SHARP * np.linalg.norm(at_corners, axis=2)).any(axis=1)
    return flat, folded & ~flat


def jacobian_range(nodes: FloatArray, cells: IntArray, element: ReferenceElement) -> ArrayPair:
    """Return the smallest and largest det J/size³ of each element over its Gauss points."""
    gradient = element.gradient(element.stiffness_rule.points)
    found = []
    for part in np.array_split(cells, len(cells) // 4096 + 1):
        corners = nodes[part]
        size = np.ptp(corners, axis=1).max(axis=1)
        corners = corners / np.where(size > 0.0, size, 1.0)[:, None, None]
        det, _ = cofactors(jacobians(corners, gradient))
        found.append(np.stack([det.min(axis=1), det.max(axis=1)]))
    lowest, highest = np.hstack(found)
    return lowest, highest


def right_handed(kind: str, nodes: FloatArray, cells: IntArray) -> IntArray:
    """Return cells with nodes reordered if all elements are left-handed, else as they are."""
    if kind not in KINDS or not len(cells):
        return cells
    element = reference_element(kind)
    for part in (cells[:1], cells):  # the first element alone, then all
        _, highest = jacobian_range(nodes, part, element)
        if not (highest < 0.0).all():  # true also if det J is NaN
            return cells
    return np.ascontiguousarray(cells[:, element.mirror])
