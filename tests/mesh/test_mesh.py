"""Meshes from files and by hand: errors are counted, and the first is named."""

from __future__ import annotations

import pickle
import warnings
from typing import Any

import meshio
import numpy as np
import numpy.typing as npt
import pytest
from bodies import distorted_box
from rows import each

import aoimpact as ao
from aoimpact.base import (
    AOImpactWarning,
    InputError,
    MeshError,
)
from aoimpact.io import read_mesh
from aoimpact.mesh import KINDS, Mesh, box_mesh, meshio_of_all_kinds, reference_element

# Two unit cubes side by side, by hand.
CUBE = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
ALONG = np.array([1.0, 0.0, 0.0])
TWO = np.vstack([CUBE, CUBE[[1, 2, 5, 6]] + ALONG])
TWO_CELLS = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [1, 8, 9, 2, 5, 10, 11, 6]])


def solid(points: npt.ArrayLike = TWO, cells: npt.ArrayLike = TWO_CELLS, **more: object) -> object:
    return meshio.Mesh(np.asarray(points), [("hexahedron", np.asarray(cells))], **more)


def raw_mesh(nodes: npt.ArrayLike, kind: str, cells: npt.ArrayLike) -> object:
    return meshio_of_all_kinds().Mesh(np.asarray(nodes), [(kind, np.asarray(cells))])


def test_sets_of_meshio_by_mask_by_number_and_of_faces() -> None:
    raw = meshio.Mesh(
        TWO,
        [("hexahedron", TWO_CELLS), ("quad", np.array([[0, 3, 7, 4], [8, 9, 11, 10]]))],
        point_sets={"mask": TWO[:, 2] == 1.0, "numbers": [7, 3], "empty": []},
        cell_sets={"ends": [None, np.array([0, 1])], "first": [np.array([0]), np.array([], int)]},
    )
    sets = read_mesh(raw).node_sets
    assert sets["mask"].tolist() == [4, 5, 6, 7, 10, 11]
    assert sets["numbers"].tolist() == [3, 7]
    assert sets["ends"].tolist() == [0, 3, 4, 7, 8, 9, 10, 11]
    assert sets["first"].tolist() == list(range(8))
    assert "empty" not in sets


def test_blocks_of_one_kind_are_joined() -> None:
    raw = meshio.Mesh(TWO, [("hexahedron", TWO_CELLS[:1]), ("hexahedron", TWO_CELLS[1:])])
    assert np.array_equal(read_mesh(raw).cells, TWO_CELLS)


def test_nodes_of_no_volume_element_are_dropped_with_a_count() -> None:
    stray = np.insert(TWO, [2, 12], [[9.0, 9.0, 9.0], [8.0, 8.0, 8.0]], axis=0)
    cells = TWO_CELLS + (TWO_CELLS >= 2)
    raw = solid(stray, cells, point_sets={"some": [2, 3], "none": [13]})
    with pytest.warns(AOImpactWarning, match="nodes"):
        mesh = read_mesh(raw)
    assert np.array_equal(mesh.nodes, TWO)
    assert np.array_equal(mesh.cells, TWO_CELLS)
    assert {name: ids.tolist() for name, ids in mesh.node_sets.items()} == {"some": [2]}


@each("kind", [kind for kind in KINDS if reference_element(kind).quadratic])
def test_midside_nodes_in_another_order_are_put_right(kind: str) -> None:
    mesh = distorted_box(kind)
    n = reference_element(kind).n_corners
    shuffled = mesh.cells.copy()
    shuffled[:, n:] = np.random.default_rng(3).permutation(mesh.cells[:, n:], axis=1)
    with pytest.warns(AOImpactWarning, match="nodes"):
        repaired = read_mesh(raw_mesh(mesh.nodes, kind, shuffled))
    assert np.array_equal(repaired.cells, mesh.cells)


@each("kind", KINDS)
def test_left_handed_numbering_throughout_is_put_right(kind: str) -> None:
    mesh = distorted_box(kind)
    mirrored = mesh.cells[:, reference_element(kind).mirror]
    assert np.array_equal(read_mesh(raw_mesh(mesh.nodes, kind, mirrored)).cells, mesh.cells)


def test_a_warning_points_at_the_line_that_led_to_it() -> None:
    with pytest.warns(AOImpactWarning) as record:
        read_mesh(solid(np.vstack([TWO, [[5.0, 5.0, 5.0]]])))
    assert record[0].filename == __file__


@each("factor", [1e-9, 1e-3, 1e6])
def test_shape_of_elements_is_judged_at_any_scale(factor: float) -> None:
    thin = TWO * [1.0, 1.0, 1e-3] * factor  # thin, but not flat
    assert read_mesh(solid(thin)).size == pytest.approx(2.0 * factor)


@each("factor", [1e308, 1e200, 1e-120, 1e-320])
def test_bodies_whose_volumes_cannot_be_computed(factor: float) -> None:
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    with pytest.raises(InputError, match="E="):
        ao.FEModel.from_mesh(solid(TWO * min(factor, 8e307)), steel)
    for mesh in (solid(), Mesh(TWO, TWO_CELLS, "hexahedron")):
        with pytest.raises(InputError):
            ao.FEModel.from_mesh(read_mesh(mesh, scale=factor), steel)


def test_an_element_without_a_mass_is_refused() -> None:
    corner = np.vstack([np.zeros(3), np.eye(3)])
    small = np.vstack([corner, 1e-120 * corner])
    mesh = Mesh(small, [[0, 1, 2, 3], [4, 5, 6, 7]], "tetra")
    with pytest.raises(InputError, match="vanishes"):
        ao.FEModel.from_mesh(mesh, ao.Material(E=210e9, nu=0.3, rho=7800))


def test_scale_turns_millimetres_into_metres() -> None:
    mesh = read_mesh(solid(1000.0 * TWO), scale=1e-3)
    assert mesh.nodes == pytest.approx(TWO, rel=1e-15)
    assert read_mesh(mesh, scale=2.0).nodes == pytest.approx(2.0 * TWO, rel=1e-15)
    assert read_mesh(mesh) is mesh


TURNED = TWO_CELLS[0, [1, 2, 3, 0, 5, 6, 7, 4]]  # the same cube, begun at another corner
UPSIDE_DOWN = TWO_CELLS[0, [4, 5, 6, 7, 0, 1, 2, 3]]


@each(
    "points, cells, words",
    [
        (TWO, [], "elements"),
        (TWO, [("triangle10", np.arange(10)[None])], "order"),
        (TWO, [("hexahedron", np.zeros((0, 8), int))], "elements"),
        (TWO, [("wedge18", np.arange(18).reshape(1, 18) % 12)], "unsupported"),
        (TWO, [("tetra20", np.arange(20).reshape(1, 20) % 12)], "unsupported"),
        (TWO, [("hexahedron", TWO_CELLS + 1)], "elements"),
        (TWO, [("hexahedron", np.array([UPSIDE_DOWN, TWO_CELLS[1]]))], "1 of 2 elements"),
        (TWO, [("hexahedron", np.array([*TWO_CELLS, TURNED]))], "1 of 3 elements"),
        (TWO * [1.0, 1.0, 0.0], [("hexahedron", TWO_CELLS)], "2 of 2 elements"),
        (TWO * [np.nan, 1.0, 1.0], [("hexahedron", TWO_CELLS)], "^coordinates"),
        (TWO + np.inf, [("hexahedron", TWO_CELLS)], "^coordinates"),
        (TWO[:, :2], [("hexahedron", TWO_CELLS)], "x, y and z"),
        (np.float64(1.0), [("hexahedron", TWO_CELLS)], "^coordinates"),
    ],
)
def test_what_is_no_body_is_refused(
    points: npt.ArrayLike, cells: list[tuple[str, npt.NDArray[Any]]], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        read_mesh(meshio.Mesh(points, cells))


@each("bad", [np.nan, np.inf, 1e200])
def test_nodes_of_no_element_may_have_any_coordinates(bad: float) -> None:
    points = np.vstack([[[bad, 0.0, bad]], TWO])
    with pytest.warns(AOImpactWarning, match="nodes"):
        mesh = read_mesh(solid(points, TWO_CELLS + 1))
    assert np.array_equal(mesh.nodes, TWO)
    assert np.array_equal(points[0], [bad, 0.0, bad], equal_nan=True)


def test_mesh_is_a_value_of_its_own() -> None:
    nodes = TWO.copy()
    mesh = Mesh(nodes, TWO_CELLS, "hexahedron", {"end": [9, 8]})
    nodes[:] = 0.0
    assert np.array_equal(mesh.nodes, TWO)
    with pytest.raises(ValueError, match="read-only"):
        mesh.nodes[0, 0] = 1.0
    again = pickle.loads(pickle.dumps(mesh))
    assert np.array_equal(again.cells, mesh.cells)
    assert again.node_sets["end"].tolist() == [8, 9]
    assert repr(mesh) == "Mesh(12 nodes, 2 hexahedron, sets: end)"


def test_good_meshes_raise_no_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for kind in KINDS:
            read_mesh(box_mesh((1, 1, 1), (2, 2, 2), kind=kind))
            mesh = distorted_box(kind)
            read_mesh(raw_mesh(mesh.nodes, kind, mesh.cells))


def test_groups_of_what_is_not_there_are_refused() -> None:
    with pytest.raises(MeshError, match="groups"):
        read_mesh(solid(cell_sets={"a": [np.array([5])]}))


# ------------------------------------------------------------------------------- numbers of files


def labelled() -> Mesh:
    return Mesh(
        TWO,
        TWO_CELLS,
        "hexahedron",
        cell_sets={"far": [1]},
        node_labels=10 * np.arange(1, 13),
        cell_labels=[7, 5],
    )


def test_numbers_of_a_file_stay_with_their_nodes_and_elements() -> None:
    far = labelled().part("far")
    assert far.cell_labels is not None
    assert far.cell_labels.tolist() == [5]
    assert far.node_labels is not None
    assert far.node_labels.tolist() == (10 * np.unique(TWO_CELLS[1]) + 10).tolist()
    scaled = read_mesh(labelled(), scale=1e-3)
    assert np.array_equal(scaled.node_labels, labelled().node_labels)
    assert np.array_equal(scaled.cell_labels, labelled().cell_labels)
