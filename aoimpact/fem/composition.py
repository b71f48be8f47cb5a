"""Assignment of materials to elements: one for the whole mesh, or one per group of elements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..base import (
    FloatArray,
    Frozen,
    InputError,
    InputTypeError,
    IntArray,
    in_batches,
    plain,
    record,
    with_unit,
)
from ..mesh import Block, Mesh, ReferenceElement, group
from .beams import Beam
from .labels import label_of
from .laminate import Layers
from .material import Solid

OneMaterial = Solid | Layers | Beam

# Materials, in words and as types, allowed for thin elements of each kind. Other kinds are solids.
_FITTING: dict[str, tuple[str, Any]] = {
    "quad": ("ao.Shell(thickness, material) or an ao.Laminate", Layers),
    "triangle": ("ao.Shell(thickness, material) or an ao.Laminate", Layers),
    "line": ("ao.Beam(section, material, orientation)", Beam),
}
_ANY = "a Material, Orthotropic, Shell, Laminate or Beam"
_SOLID: tuple[str, Any] = ("a Material or an Orthotropic", Solid)


@record
class Materials(Frozen):
    """The materials of a body that has several materials.

    Attributes
    ----------
    groups : mapping of str to Material, Orthotropic, Shell, Laminate or Beam
        Material of each named group of elements, as the user gave it.
    materials : tuple of Material, Orthotropic, Shell, Laminate or Beam
        Distinct materials.
    index : ndarray of int, shape (n_cells,)
        Index into `materials` for each element.
    """

    groups: Mapping[str, OneMaterial]
    materials: tuple[OneMaterial, ...]
    index: IntArray


AnyMaterial = OneMaterial | Materials


def materials_of(mesh: Mesh, given: Any) -> AnyMaterial:
    """Return the checked argument `material` of `FEModel.from_mesh`.

    Raises
    ------
    InputError, InputTypeError
        If `given` is not a material, a group is unknown, or an element has no material, several,
        or one that does not suit its kind.
    """
    found = _of_elements(mesh, given)
    for piece in pieces(mesh, found, OneMaterial):
        wanted, fitting = _FITTING.get(piece.block.kind, _SOLID)
        kind, thick = type(piece.of).__name__, getattr(piece.of, "narrowest", 0.0)
        if not isinstance(piece.of, fitting):
            got = f"{len(piece.rows)} elements of kind {piece.block.kind} got {kind}"
            raise InputError(f"material: {got}; give {wanted}")
        if thick > mesh.size:
            long = f"on a body {with_unit(mesh.size, 'm', 3)} long; give both in metres"
            raise InputError(f"material: a {kind} {with_unit(thick, 'm')} thick is {long}")
    return found


def _of_elements(mesh: Mesh, given: Any) -> AnyMaterial:
    if isinstance(given, Materials) and len(given.index) != mesh.n_cells:
        raise InputError(f"material must be of {mesh.n_cells} elements, got {len(given.index)}")
    if isinstance(given, AnyMaterial):
        return given
    if not isinstance(given, Mapping):
        raise InputTypeError(f"material must be {_ANY} or a dict, got {type(given).__name__}")
    if not given:
        raise InputError("material names no groups of elements; give a material for each group")
    owner = np.full(mesh.n_cells, -1)
    for number, (name, material) in enumerate(given.items()):
        if not isinstance(material, OneMaterial):
            raise InputTypeError(f"material[{name!r}] must be {_ANY}, no {type(material).__name__}")
        cells = group(mesh, "material", name)
        if (owner[cells] >= 0).any():
            twice = cells[owner[cells] >= 0]
            other = list(given)[int(owner[twice[0]])]
            first = label_of(int(twice[0]), mesh.cell_labels)
            both = f"{len(twice)} elements are in both {other!r} and {name!r}"
            raise InputError(f"material: {both}, the first is element {first}; take one material")
        owner[cells] = number
    if len(bare := np.flatnonzero(owner < 0)):
        counts = {name: int((owner[cells] < 0).sum()) for name, cells in mesh.cell_sets.items()}
        where = ", ".join(f"{count} of them in {name!r}" for name, count in counts.items() if count)
        first = label_of(int(bare[0]), mesh.cell_labels)
        near = f"{first} near {plain(mesh.nodes[mesh.cells[bare[0]]].mean(axis=0))} m"
        why = f"{len(bare)} of {mesh.n_cells} elements have none, the first is element {near}"
        cure = f"({where or 'no group has any of them; name them in the mesher'})"
        raise InputError(f"material: {why}: give the material of their groups {cure}")
    distinct: dict[OneMaterial, int] = {}
    number_of = [distinct.setdefault(material, len(distinct)) for material in given.values()]
    if len(distinct) == 1:
        return next(iter(distinct))
    return Materials(dict(given), tuple(distinct), np.array(number_of)[owner])


def thin_groups(given: Any) -> tuple[str, ...]:
    """Return the names of the groups whose given material is a shell or beam."""
    if not isinstance(given, Mapping):
        return ()
    return tuple(name for name, of in given.items() if isinstance(of, (Layers, Beam)))


def each_of(material: AnyMaterial) -> tuple[OneMaterial, ...]:
    """Return the distinct materials of a body."""
    return material.materials if isinstance(material, Materials) else (material,)


def material_of(material: AnyMaterial, cell: int) -> OneMaterial:
    """Return the material of the element with the index `cell`."""
    return each_of(material)[material.index[cell] if isinstance(material, Materials) else 0]


def taken_material(material: AnyMaterial, cells: IntArray) -> AnyMaterial:
    """Return the material of a mesh that consists of the elements `cells`, shape (n,)."""
    if not isinstance(material, Materials):
        return material
    used, index = np.unique(material.index[cells], return_inverse=True)
    return Materials(material.groups, tuple(material.materials[i] for i in used), index)


@record
class Piece:
    """Elements of one kind and one material.

    Attributes
    ----------
    block : Block
        The mesh's elements of this kind.
    of : Material, Orthotropic, Shell, Laminate or Beam
        The elements' material.
    which : int
        Index of the material in `each_of`.
    rows : ndarray of int, shape (n,)
        Indices of the elements in `block`.
    """

    block: Block
    of: Any
    which: int
    rows: IntArray

    @property
    def element(self) -> ReferenceElement:
        return self.block.element

    def batches(self, each: float) -> Iterator[Piece]:
        """Yield pieces of few elements, each with temporary arrays of `each` bytes."""
        return map(self.taken, in_batches(len(self.rows), each))

    def taken(self, some: Any) -> Piece:
        """Return the piece with the elements that an index, mask or slice selects."""
        return Piece(self.block, self.of, self.which, self.rows[some])

    @property
    def cells(self) -> IntArray:
        """The elements' nodes, shape (n, nodes per element)."""
        return self.block.cells[self.rows]

    def signed(self, values: FloatArray) -> FloatArray:
        """Return values per shape function, (n, nodes per element, ...), times signs 1, -1 or 0."""
        if self.block.signs is None:
            return values
        signs = self.block.signs[self.rows]
        return values * signs.reshape(*signs.shape, *(1,) * (values.ndim - 2))

    @property
    def numbers(self) -> IntArray:
        """Indices of the elements in the mesh."""
        return self.block.first + self.rows


def pieces(mesh: Mesh, material: AnyMaterial, kind: Any = Solid) -> list[Piece]:
    """Return the elements of a mesh grouped by kind and material.

    Parameters
    ----------
    mesh, material
    kind : type or union of types, optional
        Class of the materials to include; by default solids.
    """
    found, each = [], each_of(material)
    for block in mesh.blocks:
        index = np.zeros(len(block.cells), dtype=np.int64)
        if isinstance(material, Materials):
            index = material.index[block.numbers]
        for which in np.unique(index).tolist():
            if isinstance(each[which], kind):
                rows = np.flatnonzero(index == which)
                found.append(Piece(block, each[which], which, rows))
    return found


def thickness_of_cells(mesh: Mesh, material: AnyMaterial) -> FloatArray:
    """Return the thickness of each element, m, shape (n_cells,): 0 unless it is a shell."""
    found = np.zeros(mesh.n_cells)
    for part in pieces(mesh, material, Layers):
        found[part.numbers] = part.of.total_thickness
    return found


@record
class Layout:
    """Pairs of a node and a material at it; stress has one value per pair.

    Attributes
    ----------
    node, which : ndarray of int, shape (n,)
        Node and material index of each pair, ordered by material, then by node.
    cells : ndarray of int, shape (n_cells, width)
        `Mesh.cells` with the indices of pairs in place of nodes.
    """

    node: IntArray
    which: IntArray
    cells: IntArray

    def of(self, piece: Piece) -> IntArray:
        """Return indices of the pairs at a piece's nodes; added shape functions have no pairs."""
        return self.cells[piece.numbers, : piece.element.own.n_nodes]


def layout(mesh: Mesh, material: AnyMaterial) -> Layout:
    """Return the pairs of node and material of a mesh; stress has one value for each pair."""
    index = material.index[:, None] if isinstance(material, Materials) else 0
    keys = index * mesh.n_nodes + mesh.cells
    key, cells = np.unique(keys, return_inverse=True)
    return Layout(key % mesh.n_nodes, key // mesh.n_nodes, cells.reshape(keys.shape))
