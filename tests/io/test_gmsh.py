"""Gmsh's files: every group whole, against what Gmsh itself says of the mesh that it wrote."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact import AOImpactWarning, MeshError

# Two bricks in a row, volumes 1 and 2, with the end faces 1 and 2, some of them in reverse.
TWO = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
2 10 "fix"
3 20 "body"
$EndPhysicalNames
$Entities
0 0 2 2
1 0 0 0 0 1 1 2 10 11 0
2 2 0 0 2 1 1 2 -10 11 0
1 0 0 0 1 1 1 1 20 0
2 1 0 0 2 1 1 1 -20 0
$EndEntities
$Nodes
1 12 1 12
3 1 0 12
{labels}
{places}
$EndNodes
$Elements
4 4 1 4
2 1 3 1
1 1 2 4 3
2 2 3 1
2 9 10 12 11
3 1 5 1
3 1 5 6 2 3 7 8 4
3 2 5 1
4 5 9 10 6 7 11 12 8
$EndElements
""".format(
    labels="\n".join(map(str, range(1, 13))),
    places="\n".join(f"{i} {j} {k}" for i in range(3) for k in (0, 1) for j in (0, 1)),
)


def written(folder: Path, text: str) -> Path:
    file = folder / "a.msh"
    file.write_text(text)
    return file


def test_groups_of_entities_in_reverse_and_overlapping_groups(tmp_path: Path) -> None:
    mesh = ao.read_mesh(written(tmp_path, TWO))
    ends = np.flatnonzero(mesh.nodes[:, 0] != 1.0)
    assert {name: ids.tolist() for name, ids in mesh.node_sets.items()} == {
        "fix": ends.tolist(),
        "surface 11": ends.tolist(),
        "body": list(range(12)),
    }
    assert mesh.cell_sets["body"].tolist() == [0, 1]
    assert np.array_equal(mesh.node_labels, np.arange(1, 13))
    assert np.array_equal(mesh.cell_labels, [3, 4])


def test_one_name_for_groups_of_two_dimensions_is_said(tmp_path: Path) -> None:
    with pytest.warns(AOImpactWarning, match="groups"):
        mesh = ao.read_mesh(written(tmp_path, TWO.replace('"fix"', '"body"')))
    assert len(mesh.node_sets["body"]) == mesh.n_nodes


def test_names_in_latin_1(tmp_path: Path) -> None:
    file = tmp_path / "latin.msh"
    file.write_bytes(TWO.replace('"fix"', '"flèche"').encode("latin-1"))
    assert "flèche" in ao.read_mesh(file).node_sets


def test_names_without_dimensions(tmp_path: Path) -> None:
    """Version 2.0 of the format gives the number of a group and its name alone."""
    text = TWO.replace('2 10 "', '10 "').replace('3 20 "', '20"')
    assert set(ao.read_mesh(written(tmp_path, text)).node_sets) == {"fix", "surface 11", "body"}


def test_a_group_without_elements_is_said(tmp_path: Path) -> None:
    with pytest.warns(AOImpactWarning, match=r"^groups"):
        ao.read_mesh(
            written(tmp_path, TWO.replace(" 2 10 11 0", " 0 0").replace("-10 11", "11 12"))
        )


DAMAGED = [
    ("4.1 0 8", "4 0 8"),
    ("4.1 0 8", "4.1 1 8"),
    ("4.1 0 8", "4.1 0"),
    ("$EndNodes", ""),
    ("$EndNodes", "$EndNodes\nrubbish"),
    ("$Nodes", "$NOD"),
    ("1 12 1 12", "1 13 1 12"),
    ("3 1 0 12", "3 1 0 99999999999"),
    ("3 1 0 12", "3 1 0 -1"),
    ("2 1 1\n", "2 1 x\n"),
    ("\n12\n", "\n11\n"),
    ("4 4 1 4", "4 5 1 4"),
    ("4 4 1 4", "9999999999999 4 1 4"),
    ("3 2 5 1", "3 2 5 0"),
    ("3 2 5 1", "3 2 29 1"),
    ("4 5 9 10 6", "4 5 9 10 60"),
    ("2 10 ", "ten "),
    ("2\n2 10", "3\n2 10"),
    ("$Elements", "$Others"),
]


@pytest.fixture(scope="module")
def gmsh(gmsh: Any) -> Any:
    """Two cubes with physical groups that overlap, partly in reverse."""
    gmsh.model.addPhysicalGroup(3, [1, -2], 20, "body")
    gmsh.model.addPhysicalGroup(3, [2], 21, "two")
    gmsh.model.addPhysicalGroup(2, [1, -7], 10, "fix")
    gmsh.model.addPhysicalGroup(2, [1], 11)
    gmsh.model.addPhysicalGroup(0, [1], 5, "a point")
    return gmsh


def mesh_of(gmsh: Any, order: int, *, bricks: bool) -> None:
    gmsh.model.mesh.clear()
    for _, curve in gmsh.model.getEntities(1):
        if bricks:
            gmsh.model.mesh.setTransfiniteCurve(curve, 3)
    for dim, tag in [*gmsh.model.getEntities(2), *gmsh.model.getEntities(3)]:
        if bricks and dim == 2:
            gmsh.model.mesh.setTransfiniteSurface(tag)
            gmsh.model.mesh.setRecombine(2, tag)
        elif bricks:
            gmsh.model.mesh.setTransfiniteVolume(tag)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)


def nodes_of(gmsh: Any, dim: int, entities: list[int]) -> set[int]:
    tags = [gmsh.model.mesh.getNodes(dim, tag, includeBoundary=True)[0] for tag in entities]
    return {int(tag) for part in tags for tag in part}


@pytest.mark.parametrize(
    ("version", "binary", "order", "bricks"),
    [(2.2, 1, 2, False), (4.1, 1, 1, False), (2.2, 0, 1, True), (4.1, 0, 2, True)],
)
def test_groups_are_those_that_gmsh_wrote(
    gmsh: Any, tmp_path: Path, version: float, binary: int, order: int, bricks: bool
) -> None:
    mesh_of(gmsh, order, bricks=bricks)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.option.setNumber("Mesh.SaveAll", 0)
    gmsh.write(str(tmp_path / "a.msh"))
    mesh = ao.read_mesh(tmp_path / "a.msh")
    kinds = {(1, False): "tetra", (2, False): "tetra10", (1, True): "hexahedron"}
    assert mesh.kind == kinds.get((order, bricks), "hexahedron20")
    assert mesh.node_labels is not None
    expected = {
        "body": (3, [1, 2]),
        "two": (3, [2]),
        "fix": (2, [1, 7]),
        "surface 11": (2, [1]),
        "a point": (0, [1]),
    }
    assert set(mesh.node_sets) == set(expected)
    for name, (dim, entities) in expected.items():
        found = mesh.node_labels[mesh.node_sets[name]]
        assert set(found.tolist()) == nodes_of(gmsh, dim, entities)
    for i, label in enumerate(mesh.node_labels):
        assert mesh.nodes[i] == pytest.approx(gmsh.model.mesh.getNode(label)[0], abs=1e-15)
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    assert ao.FEModel.from_mesh(mesh.part("two"), steel).mass == pytest.approx(7800.0)
    assert ao.FEModel.from_mesh(mesh, steel).mass == pytest.approx(2 * 7800.0)


def test_save_all_keeps_groups_in_version_4_and_their_loss_in_2_is_said(
    gmsh: Any, tmp_path: Path
) -> None:
    mesh_of(gmsh, 1, bricks=False)
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.write(str(tmp_path / "new.msh"))
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    gmsh.write(str(tmp_path / "old.msh"))
    mesh = ao.read_mesh(tmp_path / "new.msh")
    assert set(mesh.node_sets) == {"body", "two", "fix", "surface 11", "a point"}
    assert len(mesh.cell_sets["body"]) == mesh.n_cells
    with pytest.warns(AOImpactWarning, match=r"^groups"):
        ao.read_mesh(tmp_path / "old.msh")


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_a_partitioned_mesh_is_read_whole_or_not_at_all(
    gmsh: Any, tmp_path: Path, version: float
) -> None:
    mesh_of(gmsh, 1, bricks=False)
    gmsh.option.setNumber("Mesh.SaveAll", 0)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.write(str(tmp_path / "whole.msh"))
    whole = ao.read_mesh(tmp_path / "whole.msh")
    gmsh.model.mesh.partition(3)
    try:
        for split in (0, 1):
            gmsh.option.setNumber("Mesh.PartitionSplitMeshFiles", split)
            gmsh.write(str(tmp_path / "parts.msh"))
    finally:
        gmsh.option.setNumber("Mesh.PartitionSplitMeshFiles", 0)
        gmsh.model.mesh.unpartition()
    joined = ao.read_mesh(tmp_path / "parts.msh")
    assert {name: len(ids) for name, ids in joined.node_sets.items()} == {
        name: len(ids) for name, ids in whole.node_sets.items()
    }
    with pytest.raises(MeshError, match=r"^mesh"):
        ao.read_mesh(tmp_path / "parts_1.msh")


def test_a_partitioned_mesh_of_surfaces_is_read_whole(gmsh: Any, tmp_path: Path) -> None:
    mesh_of(gmsh, 1, bricks=False)
    gmsh.model.mesh.clear(gmsh.model.getEntities(3))
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    triangles = len(gmsh.model.mesh.getElements(2)[1][0])
    gmsh.model.mesh.partition(3)
    try:
        gmsh.write(str(tmp_path / "skin.msh"))
    finally:
        gmsh.model.mesh.unpartition()
    with pytest.warns(AOImpactWarning, match=r"^groups"):  # those of volumes
        skin = ao.read_mesh(tmp_path / "skin.msh")
    assert (skin.thin, skin.n_cells) == (True, triangles)
