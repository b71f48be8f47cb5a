"""Shells and beams in files: which cells are the body, and by which names."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from decks import strip

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
SHEET = ao.Shell(1e-3, STEEL)
RIB = ao.Beam(ao.CircularSection(0.01), STEEL)

# The decks below have cards of sections, which are named in a warning.
NOT_READ = pytest.mark.filterwarnings("ignore:(sections|elements) of the deck")

PLACES = [(0, 0), (0.1, 0), (0.2, 0), (0, 0.1), (0.1, 0.1), (0.2, 0.1)]

ABAQUS = """*NODE
{nodes}
*ELEMENT, TYPE=S4R, ELSET=SKIN
1, 1, 2, 5, 4
*ELEMENT, TYPE=S3, ELSET=SKIN
2, 2, 3, 6
3, 2, 6, 5
*ELEMENT, TYPE=B31, ELSET=RIB
4, 1, 2
5, 2, 3{towards}
*SHELL SECTION, ELSET=SKIN, MATERIAL=STEEL
0.001
*BEAM SECTION, ELSET=RIB, SECTION=RECT, MATERIAL=STEEL
.01, .02
0, 0, 1
*NSET, NSET=ROOT
1, 4
"""

NASTRAN = """BEGIN BULK
{nodes}
CQUAD4,1,7,1,2,5,4
CTRIA3,2,7,2,3,6
CTRIA3,3,7,2,6,5
CBAR,4,8,1,2,0.,0.,1.
CBAR,5,8,2,3,0.,0.,1.
PSHELL,7,1,.001,1
PBARL,8,1,,ROD
,.01
MAT1,1,2.1E11,,.3,7800.
ENDDATA
"""


def written(tmp_path: Path, name: str) -> tuple[Path, str, str]:
    """A panel of a quadrilateral, two triangles and two bars; names of its two groups."""
    path = tmp_path / f"panel.{name}"
    if name == "inp":
        nodes = "\n".join(f"{i}, {x}, {y}, 0" for i, (x, y) in enumerate(PLACES, 1))
        path.write_text(ABAQUS.format(nodes=nodes, towards=""))
        return path, "SKIN", "RIB"
    if name == "bdf":
        nodes = "\n".join(f"GRID,{i},,{x:.1f},{y:.1f},0." for i, (x, y) in enumerate(PLACES, 1))
        path.write_text(NASTRAN.format(nodes=nodes))
        return path, "property 7", "property 8"
    cells = [
        ("quad", [[0, 1, 4, 3]]),
        ("triangle", [[1, 2, 5], [1, 5, 4]]),
        ("line", [[0, 1], [1, 2]]),
    ]
    tags = [np.full(len(of), 2 if kind == "line" else 1) for kind, of in cells]
    mesh = meshio.Mesh(
        np.array([(*place, 0) for place in PLACES], dtype=float),
        [(kind, np.array(of)) for kind, of in cells],
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={"skin": np.array([1, 2]), "rib": np.array([2, 1])},
    )
    mesh.write(path, file_format="gmsh22", binary=False)
    return path, "skin", "rib"


@NOT_READ
@pytest.mark.parametrize("name", ["inp", "bdf", "msh"])
def test_the_body_is_of_surfaces_and_of_the_lines_that_are_named(tmp_path: Path, name: str) -> None:
    path, skin, rib = written(tmp_path, name)
    mesh = ao.read_mesh(path)
    assert mesh.contents == "1 quad, 2 triangle"
    assert len(mesh.node_sets[rib]) == 3
    assert ao.FEModel.from_mesh(path, SHEET).mass == pytest.approx(0.02 * 1e-3 * 7800)
    body = ao.FEModel.from_mesh(path, {skin: SHEET, rib: RIB})
    assert body.mesh.contents == "1 quad, 2 triangle, 2 line"
    bars = np.pi * 0.01**2 * 0.2 * 7800
    assert body.mass == pytest.approx(0.02 * 1e-3 * 7800 + bars)
    assert ao.read_mesh(path, part=[skin, rib]).contents == body.mesh.contents
    frame = ao.FEModel.from_mesh(path, RIB, part=rib)
    assert frame.mesh.contents == "2 line"
    with pytest.raises(ao.InputError, match=f"{rib!r}.* read_mesh.*part="):
        ao.FEModel.from_mesh(mesh, {skin: SHEET, rib: RIB})


@NOT_READ
def test_a_beam_may_name_a_third_node_for_its_section(tmp_path: Path) -> None:
    nodes = "\n".join(f"{i}, {x}, {y}, 0" for i, (x, y) in enumerate(PLACES, 1))
    deck = ABAQUS.replace("4, 1, 2\n", "4, 1, 2, 6\n").format(nodes=nodes, towards=", 6")
    (tmp_path / "a.inp").write_text(deck)
    mesh = ao.read_mesh(tmp_path / "a.inp", part="RIB")
    assert mesh.contents == "2 line"


ROOM = {  # nodes of one element of each kind, and the elements of first order that it becomes
    "S8R": ([(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)], "4 quad"),
    "S9R5": (
        [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)],
        "4 quad",
    ),
    "STRI65": ([(0, 0), (2, 0), (0, 2), (1, 0), (1, 1), (0, 1)], "4 triangle"),
    "B32": ([(0, 0), (1, 0), (2, 0)], "2 line"),
}


@pytest.mark.parametrize("kind", list(ROOM))
def test_shells_and_beams_of_second_order_are_split_at_their_nodes(
    tmp_path: Path, kind: str
) -> None:
    """All of them, with normals on one side, and the area of the whole."""
    places, contents = ROOM[kind]
    nodes = "\n".join(f"{i}, {x}, {y}, 0" for i, (x, y) in enumerate(places, 1))
    numbers = ", ".join(str(i) for i in range(1, len(places) + 1))
    text = f"*NODE\n{nodes}\n*ELEMENT, TYPE={kind}, ELSET=A\n7, {numbers}\n"
    (tmp_path / "a.inp").write_text(text)
    mesh = ao.read_mesh(tmp_path / "a.inp")
    assert ", ".join(sorted(mesh.contents.split(", "), key=lambda of: of[2:])) == contents
    assert len(mesh.cell_sets["A"]) == mesh.n_cells
    assert set(mesh.cell_labels) == {7}
    made_of = RIB if kind == "B32" else SHEET
    across = np.pi * 0.01**2 * 2 if kind == "B32" else 1e-3 * (2 if "TRI" in kind else 4)
    assert ao.FEModel.from_mesh(mesh, made_of).mass == pytest.approx(7800 * across)


def of_eight_nodes(n: int, place: Any) -> meshio.Mesh:
    """n x n elements of eight nodes on the unit square, put into space."""
    nodes, cells = strip(n, n, place)
    return meshio.Mesh(nodes, [("quad8", cells)], point_sets={"all": np.arange(len(nodes))})


def test_elements_of_eight_nodes_converge_as_quadrilaterals() -> None:
    """Frequency of a thin simply supported square, π √(D/m) = 2π f, to second order."""
    t = 1e-3
    D = 210e9 * t**3 / 12 / (1 - 0.3**2)
    exact = np.pi * np.sqrt(D / (7800 * t))
    errors = []
    for n in (4, 8):
        mesh = ao.read_mesh(of_eight_nodes(n, lambda x, y: (x, y, 0 * x)))
        assert mesh.contents == f"{4 * n * n} quad"
        assert len(mesh.node_sets["all"]) == mesh.n_nodes
        x, y, _ = mesh.nodes.T
        rim = np.flatnonzero((x == 0) | (x == 1) | (y == 0) | (y == 1))
        shell = ao.Shell(t, ao.Material(210e9, 0.3, 7800))
        body = ao.FEModel.from_mesh(mesh, shell, fixed=[(rim, "xyz")])
        errors.append(body.frequencies(1)[0] / exact - 1)
    assert errors[1] < 0.006
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


def test_the_middle_of_a_curved_element_lies_on_its_surface() -> None:
    """A part of a sphere: the serendipity function leaves terms of the fourth order alone."""
    off = []
    for n in (4, 8):
        curved = of_eight_nodes(n, lambda x, y: (x, y, np.sqrt(4 - x**2 - y**2)))
        off.append(np.abs(np.linalg.norm(ao.read_mesh(curved).nodes, axis=1) - 2).max())
    assert off[0] < 1e-4
    assert off[0] / off[1] > 8  # third order at least


@NOT_READ
def test_rigid_elements_and_membranes_are_no_part_of_a_shell(tmp_path: Path) -> None:
    nodes = "\n".join(f"{i}, {x}, {y}, 0" for i, (x, y) in enumerate(PLACES, 1))
    deck = ABAQUS.format(nodes=nodes, towards="") + "*ELEMENT, TYPE=R3D3, ELSET=TOOL\n9, 1, 2, 5\n"
    (tmp_path / "a.inp").write_text(deck)
    with pytest.warns(ao.AOImpactWarning, match=r"^elements.* 1 R3D3"):
        mesh = ao.read_mesh(tmp_path / "a.inp")
    assert mesh.contents == "1 quad, 2 triangle"


def test_shells_beside_solids_are_the_body_if_they_are_named(tmp_path: Path) -> None:
    box = ao.box_mesh((0.2, 0.1, 0.1), (2, 1, 1))
    top = np.flatnonzero(box.nodes[:, 2] > 0.05)
    cells = [[top[0], top[2], top[3], top[1]], [top[2], top[4], top[5], top[3]]]
    tags = [np.full(2, 1), np.full(2, 2)]
    mesh: Any = meshio.Mesh(
        box.nodes,
        [("hexahedron", box.cells), ("quad", np.array(cells))],
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={"block": np.array([1, 3]), "skin": np.array([2, 2])},
    )
    mesh.write(tmp_path / "a.msh", file_format="gmsh22", binary=False)
    solid = ao.FEModel.from_mesh(tmp_path / "a.msh", STEEL)
    assert solid.mesh.contents == "2 hexahedron"
    coated = ao.FEModel.from_mesh(tmp_path / "a.msh", {"block": STEEL, "skin": SHEET})
    assert coated.mass - solid.mass == pytest.approx(0.02 * 1e-3 * 7800)


def test_a_vtu_of_a_shell_is_read_back(tmp_path: Path) -> None:
    sheet = ao.sheet_mesh((0.2, 0.1), (4, 2), kind="triangle")
    meshio.Mesh(sheet.nodes, [("triangle", sheet.cells)]).write(tmp_path / "a.vtu")
    again = ao.read_mesh(tmp_path / "a.vtu")
    assert np.array_equal(again.cells, sheet.cells)


def test_a_quadrilateral_without_one_edge_is_a_triangle() -> None:
    nodes = np.array([(*place, 0) for place in PLACES], dtype=float)
    cells = np.array([[0, 1, 4, 3], [1, 2, 5, 5], [1, 5, 4, 4]])
    mesh = ao.read_mesh(meshio.Mesh(nodes, [("quad", cells)]))
    assert mesh.contents == "1 quad, 2 triangle"


@pytest.mark.parametrize(
    ("name", "said"),
    [("inp", r"1 \*BEAMSECTION, 1 \*SHELLSECTION\)"), ("bdf", r"1 PBARL, 1 PSHELL\)")],
)
def test_sections_of_decks_are_named_unless_the_groups_are(
    tmp_path: Path, name: str, said: str
) -> None:
    path, skin, rib = written(tmp_path, name)
    with pytest.warns(ao.AOImpactWarning) as caught:
        ao.FEModel.from_mesh(path, SHEET)
    first, second = (str(each.message) for each in caught)
    assert re.search(said, first)
    assert "read_sections(path)" in first
    assert re.search("^elements of the deck .*: 2 (B31|line)$", second)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ao.FEModel.from_mesh(path, {skin: SHEET, rib: RIB})


@pytest.mark.parametrize("kind", ["CPS4", "CPE4R", "M3D4"])
def test_planar_elements_and_membranes_are_named_and_are_no_shells(
    tmp_path: Path, kind: str
) -> None:
    nodes = "\n".join(f"{i}, {x}, {y}, 0" for i, (x, y) in enumerate(PLACES, 1))
    (tmp_path / "a.inp").write_text(f"*NODE\n{nodes}\n*ELEMENT, TYPE={kind}\n1, 1, 2, 5, 4\n")
    with pytest.raises(ao.MeshError, match=f"no elements: it has 1 {kind};.* write S4 or S3"):
        ao.read_mesh(tmp_path / "a.inp")
