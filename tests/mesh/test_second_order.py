"""Elements of second order made from those of first order."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import mixed_box, no_solid

import aoimpact as ao
from aoimpact import MeshError
from aoimpact.fem import stiffness_mass
from aoimpact.mesh import boundary

LENGTHS = (2.0, 1.5, 1.0)
RAISED = {
    "tetra": "tetra10",
    "hexahedron": "hexahedron20",
    "wedge": "wedge15",
    "pyramid": "pyramid13",
}


def by_place(mesh: ao.Mesh) -> np.ndarray:
    """The order of the nodes along x, then y, then z."""
    return np.lexsort(mesh.nodes.round(9).T[::-1])


@pytest.mark.parametrize("kind", RAISED)
def test_it_is_the_mesh_that_the_generator_makes_of_second_order(kind: str) -> None:
    raised = ao.read_mesh(ao.box_mesh(LENGTHS, (2, 2, 2), kind=kind), order=2)
    wanted = ao.box_mesh(LENGTHS, (2, 2, 2), kind=RAISED[kind])
    assert raised.kind == RAISED[kind]
    here, there = by_place(raised), by_place(wanted)
    assert raised.nodes[here] == pytest.approx(wanted.nodes[there], abs=1e-15)
    for one, other in zip(
        stiffness_mass(raised, no_solid()), stiffness_mass(wanted, no_solid()), strict=True
    ):
        rows, columns = ((3 * order[:, None] + np.arange(3)).reshape(-1) for order in (here, there))
        assert abs(one[rows][:, rows] - other[columns][:, columns]).max() < 1e-9 * abs(other).max()
    for name, ids in wanted.node_sets.items():
        places = raised.nodes[raised.node_sets[name]]
        assert sorted(map(tuple, places.round(9))) == sorted(map(tuple, wanted.nodes[ids].round(9)))


def test_kinds_fit_each_other_and_groups_stay() -> None:
    mesh = mixed_box(LENGTHS, (2, 2, 3))
    raised = ao.read_mesh(mesh, order=2)
    assert {block.kind for block in raised.blocks} == set(RAISED.values())
    boundary(raised)  # checks that sides have the same nodes from both of their elements
    for name in mesh.cell_sets:
        assert np.array_equal(raised.cell_sets[name], mesh.cell_sets[name])
        masses = [stiffness_mass(of.part(name), no_solid())[1].sum() for of in (mesh, raised)]
        assert masses[0] == pytest.approx(masses[1], rel=1e-12)


def test_nodes_keep_their_numbers_and_new_ones_come_after_the_largest() -> None:
    box = ao.box_mesh((1, 1, 1), (1, 1, 1))
    mesh = ao.Mesh(
        box.nodes, box.cells, box.kind, node_labels=10 * np.arange(1, 9), cell_labels=[7]
    )
    raised = ao.read_mesh(mesh, order=2)
    assert np.array_equal(raised.node_labels, [*range(10, 90, 10), *range(81, 93)])
    assert np.array_equal(raised.cell_labels, [7])


def test_a_set_on_both_faces_of_a_sheet_does_not_reach_through_it() -> None:
    box = ao.box_mesh((4, 4, 1), (4, 4, 1))
    inner = (np.abs(box.nodes[:, :2] - 2.0) < 1.5).all(axis=1)
    mesh = ao.Mesh(box.nodes, box.cells, box.kind, {"faces": np.flatnonzero(inner)})
    raised = ao.read_mesh(mesh, order=2)
    heights = raised.nodes[raised.node_sets["faces"]][:, 2]
    assert set(heights.tolist()) == {0.0, 1.0}
    assert len(heights) == 2 * (9 + 12)


def test_the_set_of_a_group_of_elements_is_that_of_their_nodes() -> None:
    box = ao.box_mesh((3, 1, 1), (3, 1, 1))
    ends = {name: np.unique(box.cells[row]) for name, row in (("left", 0), ("right", 2))}
    both = {"ends": np.unique(box.cells[[0, 2]])}
    mesh = ao.Mesh(box.nodes, box.cells, box.kind, ends | both, {"left": [0], "ends": [0, 2]})
    raised = ao.read_mesh(mesh, order=2)
    assert np.array_equal(raised.node_sets["left"], np.unique(raised.cells[0]))
    assert np.array_equal(raised.node_sets["ends"], np.unique(raised.cells[[0, 2]]))


@pytest.mark.parametrize("kind", ["hexahedron", "tetra", "wedge"])
def test_corners_by_number_that_leave_out_the_nodes_between_them_warn(kind: str) -> None:
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    bar = ao.box_mesh((0.04, 0.01, 0.01), (4, 1, 1), kind=kind)
    corners = bar.node_sets["xmin"]
    ao.FEModel.from_mesh(bar, steel, fixed=[(corners, "xyz")])
    with pytest.warns(ao.AOImpactWarning, match=r"^fixed"):
        loose = ao.FEModel.from_mesh(bar, steel, fixed=[(corners, "xyz")], order=2)
    raised = ao.read_mesh(bar, order=2)
    for nodes in ("xmin", raised.node_sets["xmin"], lambda x: x[:, 0] == 0.0):
        clamped = ao.FEModel.from_mesh(bar, steel, fixed=[(nodes, "xyz")], order=2)
        assert clamped.frequencies(1)[0] > 1.1 * loose.frequencies(1)[0]
    ao.FEModel.from_mesh(raised, steel, fixed=[(corners[[0]], "xyz"), ("xmax", "x")])


def test_a_mesh_of_second_order_stays_and_one_of_both_is_refused() -> None:
    box = ao.box_mesh((1, 1, 1), (1, 1, 1), kind="tetra10")
    assert ao.read_mesh(box, order=2) is box
    aside = np.vstack([box.nodes, [[3, 0, 0], [4, 0, 0], [3, 1, 0], [3, 0, 1]]])
    four = len(box.nodes) + np.arange(4)
    both = ao.Mesh(aside, [("tetra10", box.cells), ("tetra", four[None])])
    with pytest.raises(MeshError, match=r"^order"):
        ao.read_mesh(both, order=2)
