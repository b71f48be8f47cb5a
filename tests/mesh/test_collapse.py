"""Bricks with repeated nodes, as Ansys writes SOLID185 and SOLID186, become other solids."""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from bodies import mixed_box, no_solid

import aoimpact as ao
from aoimpact import MeshError
from aoimpact.fem import stiffness_mass
from aoimpact.mesh import meshio_of_all_kinds, reference_element

# The nodes of a shape at each node of a brick: corners from I to P, then Q to X, Y to B.
PRISM = (0, 1, 2, 2, 3, 4, 5, 5)
PYRAMID = (0, 1, 2, 3, 4, 4, 4, 4)
TETRAHEDRON = (0, 1, 2, 2, 3, 3, 3, 3)
BRICKS = {
    "wedge": PRISM,
    "pyramid": PYRAMID,
    "tetra": TETRAHEDRON,
    "wedge15": (*PRISM, 6, 7, 2, 8, 9, 10, 5, 11, 12, 13, 14, 14),
    "pyramid13": (*PYRAMID, 5, 6, 7, 8, 4, 4, 4, 4, 9, 10, 11, 12),
    "tetra10": (*TETRAHEDRON, 4, 5, 2, 6, 3, 3, 3, 3, 7, 8, 9, 9),
}


def bricks(mesh: ao.Mesh) -> meshio.Mesh:
    """The same elements, each written as a brick."""
    rows = [block.cells[:, BRICKS.get(block.kind, slice(None))] for block in mesh.blocks]
    kind = "hexahedron20" if mesh.quadratic else "hexahedron"
    return meshio_of_all_kinds().Mesh(np.array(mesh.nodes), [(kind, np.concatenate(rows))])


@pytest.mark.parametrize("kind", BRICKS)
def test_shapes_written_as_bricks_have_their_matrices(kind: str) -> None:
    mesh = ao.box_mesh((2.0, 1.5, 1.0), (2, 2, 2), kind=kind)
    read = ao.read_mesh(bricks(mesh))
    assert read.kind == kind
    for found, wanted in zip(
        stiffness_mass(read, no_solid()), stiffness_mass(mesh, no_solid()), strict=True
    ):
        assert abs(found - wanted).max() < 1e-12 * abs(wanted).max()


@pytest.mark.parametrize("order", [1, 2])
def test_a_mesh_of_all_shapes_written_as_bricks_is_itself_again(order: int) -> None:
    mesh = mixed_box((2.0, 1.5, 1.0), (2, 2, 3), order=order)
    raw = bricks(mesh)
    raw.cell_sets = {"last": [np.array([mesh.n_cells - 1])]}
    read = ao.read_mesh(raw)
    kinds = {block.kind: len(block.cells) for block in mesh.blocks}
    assert {block.kind: len(block.cells) for block in read.blocks} == kinds
    assert np.array_equal(np.sort(read.node_sets["last"]), np.unique(mesh.blocks[-1].cells[-1]))


@pytest.mark.parametrize(
    ("kind", "row", "target"),
    [
        ("wedge", (0, 1, 2, 3, 3, 3), "tetra"),
        ("wedge", (0, 1, 2, 0, 3, 4), "pyramid"),
        ("pyramid", (0, 1, 2, 2, 3), "tetra"),
        ("hexahedron", (0, 0, 1, 2, 3, 3, 4, 5), "wedge"),
        ("hexahedron", (2, 1, 0, 0, 3, 3, 3, 3), "tetra"),
    ],
)
def test_a_shape_within_another(kind: str, row: tuple[int, ...], target: str) -> None:
    """Its corners lie where the merged corners of the other did, in their middle."""
    corners = reference_element(kind).cell.corners
    places = np.stack([corners[np.array(row) == n].mean(axis=0) for n in range(max(row) + 1)])
    mesh = ao.read_mesh(meshio.Mesh(places, [(kind, np.array([row]))]))
    assert mesh.kind == target


@pytest.mark.filterwarnings("ignore:.*belong to no element")
@pytest.mark.parametrize(
    ("kind", "changed"),
    [
        ("hexahedron", {1: 0}),  # seven corners
        ("hexahedron", {2: 0, 6: 4}),  # folded along a diagonal
        ("hexahedron", {1: 0, 6: 7}),  # two edges that are not opposite sides of one face
        ("wedge", {4: 3}),
        ("hexahedron27", {3: 2, 7: 6}),
        ("hexahedron20", {3: 2, 7: 6}),  # the midside nodes of merged edges differ
    ],
)
def test_other_repetitions_are_refused_by_the_number_of_the_element(
    kind: str, changed: dict[int, int]
) -> None:
    cells = ao.box_mesh((1, 1, 2), (1, 1, 2), kind=kind)
    rows = np.array(cells.cells)
    for one, other in changed.items():
        rows[-1, one] = rows[-1, other]
    words = f"1 {kind} elements repeat nodes, .* is element {len(rows) - 1}"
    with pytest.raises(MeshError, match=words):
        ao.read_mesh(meshio.Mesh(np.array(cells.nodes), [(kind, rows)]))


def test_a_mesh_by_hand_must_not_repeat_corners() -> None:
    corners = reference_element("wedge").cell.corners
    with pytest.raises(MeshError, match="elements"):
        ao.Mesh(corners, [[0, 1, 2, 2, 3, 4, 5, 5]], "hexahedron")
