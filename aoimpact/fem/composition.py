"""Materials of the elements of a mesh: one, or several by named groups of elements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import Frozen, InputError, InputTypeError, IntArray
from ..mesh import Block, Mesh, ReferenceElement, group
from .material import Material
from .orthotropic import Orthotropic

__all__ = [
    "AnyMaterial",
    "Layout",
    "Materials",
    "OneMaterial",
    "Piece",
    "each_of",
    "layout",
    "materials_of",
    "pieces",
]

OneMaterial = Material | Orthotropic


@dataclass(frozen=True, eq=False)
class Materials(Frozen):
    """The materials of a body that has several.

    Attributes
    ----------
    groups : mapping of str to Material or Orthotropic
        By the named groups of elements, as given.
    materials : tuple of Material or Orthotropic
        Each once.
    index : ndarray of int, shape (n_cells,)
        Which of them each element is made of.
    """

    groups: Mapping[str, OneMaterial]
    materials: tuple[OneMaterial, ...]
    index: IntArray

    def of(self, cell: int) -> OneMaterial:
        """Return the material of an element."""
        number = int(self.index[cell])
        return self.materials[number]

    def taken(self, cells: IntArray) -> Materials:
        """Return those of some of the elements, shape (n,)."""
        return Materials(self.groups, self.materials, self.index[cells])


AnyMaterial = Material | Orthotropic | Materials


def materials_of(mesh: Mesh, given: Any) -> AnyMaterial:
    """Return what a mesh is made of: the argument `material` of `FEModel.from_mesh`, checked.

    Raises
    ------
    InputError, InputTypeError
        If it is no material, a group is unknown, or an element has none or two of them.
    """
    if isinstance(given, Materials) and len(given.index) != mesh.n_cells:
        raise InputError(
            f"material: these materials belong to a mesh of {len(given.index)} elements, not to "
            f"one of {mesh.n_cells}"
        )
    if isinstance(given, AnyMaterial):
        return given
    if not isinstance(given, Mapping):
        raise InputTypeError(
            "material must be a Material, an Orthotropic or a dict of groups of elements and "
            f"materials, got {type(given).__name__}"
        )
    if not given:
        raise InputError("material names no groups of elements; give a material for each group")
    owner = np.full(mesh.n_cells, -1)
    for number, (name, material) in enumerate(given.items()):
        if not isinstance(material, OneMaterial):
            raise InputTypeError(
                f"material[{name!r}] must be a Material or an Orthotropic, "
                f"got {type(material).__name__}"
            )
        cells = group(mesh, "material", name)
        if (owner[cells] >= 0).any():
            twice = cells[owner[cells] >= 0]
            other = list(given)[int(owner[twice[0]])]
            raise InputError(
                f"material: {len(twice)} elements are in both groups {other!r} and {name!r}, the "
                f"first is element {_called(mesh, twice[0])}; each needs exactly one material"
            )
        owner[cells] = number
    if (owner < 0).any():
        raise InputError(_left_over(mesh, owner, given))
    distinct: dict[OneMaterial, int] = {}
    number_of = [distinct.setdefault(material, len(distinct)) for material in given.values()]
    if len(distinct) == 1:
        return next(iter(distinct))
    return Materials(dict(given), tuple(distinct), np.array(number_of)[owner])


def _called(mesh: Mesh, cell: int) -> int:
    """The number by which a user knows an element."""
    return int(cell if mesh.cell_labels is None else mesh.cell_labels[cell])


def _left_over(mesh: Mesh, owner: IntArray, given: Mapping[str, Any]) -> str:
    bare = np.flatnonzero(owner < 0)
    counts = {
        name: int((owner[cells] < 0).sum())
        for name, cells in mesh.cell_sets.items()
        if name not in given
    }
    where = ", ".join(f"{count} of them in {name!r}" for name, count in counts.items() if count)
    place = ", ".join(f"{x:.4g}" for x in mesh.nodes[mesh.cells[bare[0]]].mean(axis=0))
    return (
        f"material: {len(bare)} of {mesh.n_cells} elements have none, the first is element "
        f"{_called(mesh, bare[0])} near ({place}) m: give the material of their groups "
        f"({where or 'no group has any of them; name them in the mesher'})"
    )


def each_of(material: AnyMaterial) -> tuple[OneMaterial, ...]:
    """Return the materials, each once; of one material itself."""
    return material.materials if isinstance(material, Materials) else (material,)


@dataclass(frozen=True, eq=False)
class Piece:
    """Elements of one kind and one material.

    Attributes
    ----------
    block : Block
    material : Material or Orthotropic
    which : int
        Number of the material.
    rows : ndarray of int, shape (n,)
        The elements' numbers in their block.
    """

    block: Block
    material: OneMaterial
    which: int
    rows: IntArray

    @property
    def element(self) -> ReferenceElement:
        return self.block.element

    def batches(self, step: int) -> Iterator[Piece]:
        """Yield pieces of at most so many elements."""
        for start in range(0, len(self.rows), step):
            yield self.taken(slice(start, start + step))

    def taken(self, some: IntArray | slice) -> Piece:
        """Return some of the elements."""
        return Piece(self.block, self.material, self.which, self.rows[some])

    @property
    def cells(self) -> IntArray:
        """The elements' nodes, shape (n, nodes per element)."""
        return self.block.cells[self.rows]

    @property
    def numbers(self) -> IntArray:
        """The elements' numbers among all of the mesh."""
        return self.block.first + self.rows


def pieces(mesh: Mesh, material: AnyMaterial) -> list[Piece]:
    """Return the elements of a mesh by kind and material."""
    if not isinstance(material, Materials):
        return [Piece(block, material, 0, np.arange(len(block.cells))) for block in mesh.blocks]
    found = []
    for block in mesh.blocks:
        index = material.index[block.numbers]
        for which in np.unique(index):
            rows = np.flatnonzero(index == which)
            found.append(Piece(block, material.materials[which], int(which), rows))
    return found


@dataclass(frozen=True, eq=False)
class Layout:
    """The nodes of a mesh, one for each material that meets there: stress jumps between them.

    Attributes
    ----------
    key : ndarray of int, shape (n,)
        Of each place: material · n_nodes + node, ascending.
    cells : ndarray of int, shape (n_cells, width)
        `Mesh.cells` by places.
    n_nodes : int
    """

    key: IntArray
    cells: IntArray
    n_nodes: int

    @property
    def node(self) -> IntArray:
        """The node at each place, shape (n,)."""
        found: IntArray = self.key % self.n_nodes
        return found

    @property
    def which(self) -> IntArray:
        """The number of the material at each place, shape (n,)."""
        found: IntArray = self.key // self.n_nodes
        return found

    def of(self, piece: Piece) -> IntArray:
        """Return a piece's `cells` by places."""
        found: IntArray = self.cells[piece.numbers, : piece.element.n_nodes]
        return found


def layout(mesh: Mesh, material: AnyMaterial) -> Layout:
    """Return the places of a mesh at which stress has one value."""
    if not isinstance(material, Materials):
        return Layout(np.arange(mesh.n_nodes), mesh.cells, mesh.n_nodes)
    keys = material.index[:, None] * mesh.n_nodes + mesh.cells
    key, cells = np.unique(keys, return_inverse=True)
    return Layout(key, cells.reshape(keys.shape), mesh.n_nodes)
