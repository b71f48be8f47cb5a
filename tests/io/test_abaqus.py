"""Decks of Abaqus and CalculiX are read as these programs read them, or refused by line."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from rows import each

import aoimpact as ao
from aoimpact import AOImpactWarning, InputError, MeshError
from aoimpact.base import MissingFileError

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800.0)

# Four unit cubes in a row along x: elements 1 to 4, nodes 1 to 5 and so on in each edge.
ROW_NODES = [(1 + i + 5 * j + 10 * k, i, j, k) for k in (0, 1) for j in (0, 1) for i in range(5)]
ROW = "*NODE\n" + "".join(f"{n},{x},{y},{z}\n" for n, x, y, z in ROW_NODES)
C3D8 = "*ELEMENT,TYPE=C3D8"

# One brick of 10 mm.
PLACES = [(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
LINES = [f"{1 + n},{i * 0.01},{j * 0.01},{k * 0.01}\n" for n, (i, j, k) in enumerate(PLACES)]
NODES = "*NODE\n" + "".join(LINES)
BRICK = "*ELEMENT,TYPE=C3D8,ELSET=BAR\n1,1,2,4,3,5,6,8,7\n"


def cube(e: int) -> str:
    """The line of element e of the row."""
    corners = (e, e + 1, e + 6, e + 5, e + 10, e + 11, e + 16, e + 15)
    return f"{e},{','.join(map(str, corners))}\n"


def cubes(*numbers: int) -> str:
    return "".join(map(cube, numbers))


def read(folder: Path, deck: str | bytes, **options: object) -> ao.Mesh:
    file = folder / "a.inp"
    file.write_bytes(deck if isinstance(deck, bytes) else deck.encode("latin-1"))
    return ao.read_mesh(file, **options)  # type: ignore[arg-type]


def groups(mesh: ao.Mesh) -> dict[str, list[int]]:
    """Labels of the elements of each group."""
    assert mesh.cell_labels is not None
    return {name: mesh.cell_labels[of].tolist() for name, of in mesh.cell_sets.items()}


def sets(mesh: ao.Mesh) -> dict[str, list[int]]:
    """Labels of the nodes of each set."""
    assert mesh.node_labels is not None
    return {name: mesh.node_labels[of].tolist() for name, of in mesh.node_sets.items()}


@each("deck, name, members", [
        (f"{C3D8},ELSET=P\n{cubes(1, 2, 3)}{C3D8},ELSET=P\n{cube(4)}", "P", [1, 2, 3, 4]),
        (f"{C3D8}\n{cubes(1, 2, 3)}{C3D8},ELSET=TIP\n{cube(4)}", "TIP", [4]),
        (f"{C3D8},ELSET=A\n{cubes(1, 2)}{C3D8},ELSET=B\n{cubes(3, 4)}*ELSET,ELSET=C\nB\n",
         "C", [3, 4]),
        (
            f"{C3D8},ELSET=A\n{cubes(1, 2)}{C3D8},ELSET=B\n{cube(3)}{C3D8},ELSET=D\n{cube(4)}"
            "*ELSET,ELSET=AD\nA, D\n",
            "AD",
            [1, 2, 4],
        ),
        (f"{C3D8}\n{cubes(1, 2, 3, 4)}*ELSET,ELSET=T\n1\n*ELSET,ELSET=T\n2\n", "T", [1, 2]),
        (f"{C3D8}\n{cubes(1, 2)}*ELSET,ELSET=G\n1,4\n{C3D8}\n{cubes(3, 4)}", "G", [1, 4]),
        (f"{C3D8},ELSET=Bar\n{cubes(1, 2)}{C3D8},ELSET=BAR\n{cubes(3, 4)}", "Bar", [1, 2, 3, 4]),
        (f"{C3D8}\n{cubes(1, 2, 3, 4)}*ELSET,ELSET=G,GENERATE\n1,3,2\n4,4\n", "G", [1, 3, 4]),
        (f"{C3D8}\n{cubes(1, 2, 3, 4)}*Elset, elset = g , Generate\n 1 , 4 , 2 ,\n", "g", [1, 3]),
        (f"{C3D8}\n{cubes(1, 2, 3, 4)}*ELSET,ELSET=U,UNSORTED,INTERNAL\n4,1\n", "U", [1, 4]),
        (f'{C3D8}\n{cubes(1, 2)}*ELSET,ELSET="a, b"\n2\n*ELSET,ELSET=Q\n"a, b"\n', "Q", [2]),
    ])  # fmt: skip
def test_groups_have_the_elements_that_abaqus_puts_into_them(
    tmp_path: Path, deck: str, name: str, members: list[int]
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of nodes that no cube uses
        mesh = read(tmp_path, ROW + deck)
        part = read(tmp_path, ROW + deck, part=name.swapcase())
    assert groups(mesh)[name] == members
    assert part.cell_labels is not None
    assert part.cell_labels.tolist() == members


@each(
    "deck, members",
    [
        ("*NSET,NSET=S\n1 , 2 , 3\n4, 5\n", [1, 2, 3, 4, 5]),
        ("*NSET,NSET=S\n1,2,\n** upper edge\n\n 13,14\n", [1, 2, 13, 14]),
        ("*NSET,NSET=s\n1,2\n*NSET,NSET=S\n3\n", [1, 2, 3]),
        ("*NSET,NSET=B\n1,2\n*NSET,NSET=S\nB, 7\n", [1, 2, 7]),
        ("*NSET,NSET=S,GENERATE\n1,5\n11,15,2\n", [1, 2, 3, 4, 5, 11, 13, 15]),
        ("*ELSET,ELSET=LAST\n4\n*NSET,NSET=S,ELSET=LAST\n", [4, 5, 9, 10, 14, 15, 19, 20]),
        ("*NSET,NSET=S,\nUNSORTED\n5,1\n", [1, 5]),
    ],
)
def test_sets_of_nodes(tmp_path: Path, deck: str, members: list[int]) -> None:
    found = sets(read(tmp_path, f"{ROW}{C3D8}\n{cubes(1, 2, 3, 4)}{deck}"))
    assert {name.upper(): of for name, of in found.items()}["S"] == members


def test_a_set_of_nodes_is_not_mixed_with_a_group_of_elements_of_its_name(tmp_path: Path) -> None:
    deck = f"{ROW}{C3D8},ELSET=FIX\n{cubes(1, 2, 3, 4)}*NSET,NSET=FIX\n1,6\n"
    mesh = read(tmp_path, deck)
    assert sets(mesh)["FIX"] == [1, 6]
    assert groups(mesh)["FIX"] == [1, 2, 3, 4]


@each(
    "deck",
    [
        "*NODE\n" + "".join(LINES[:4]) + "*NODE\n" + "".join(LINES[4:]) + BRICK,
        "*NODE\n" + "".join(LINES[:4]) + "** top\n" + "".join(LINES[4:]) + BRICK,
        (NODES + BRICK).lower(),
        NODES + BRICK.replace("C3D8,", "C3D8,\n"),
        NODES + BRICK.replace("C3D8,", "C3D8 ,\n** a comment\n"),
        NODES + BRICK.replace("C3D8", "C3D8T"),
        "*HEADING\nPr\xfcfk\xf6rper\n" + NODES + BRICK,
        "\xef\xbb\xbf" + NODES + BRICK,
        (NODES + BRICK).encode("utf-16"),
        (NODES + BRICK).replace("\n", "\r\n"),
        NODES.replace("\n", ",\n").replace("*NODE,", "*NODE") + BRICK,
        NODES.replace(",0.0\n", "\n") + BRICK,
        NODES.replace("\n1,0.0,0.0,0.0\n", "\n1\n").replace("2,0.01,0.0,0.0", "2,0.01") + BRICK,
        NODES.replace("0.01", "1.D-2") + BRICK,
        NODES.replace("0.01", "1.0-2") + BRICK,
        re.sub(r",0\.0(?=[,\n])", ",", NODES) + BRICK,
        NODES + BRICK.replace("4,3,5", "4,3,\n** more\n\n5"),
        "* Node, NSET = all\n" + NODES[6:].replace(",", " , ") + " " + BRICK,
        BRICK + NODES,
        NODES + BRICK + "*SOLID SECTION, ELSET=BAR, MATERIAL=S\n*MATERIAL, NAME=S\n*ELASTIC\n1,2\n",
        NODES + BRICK + "*STEP\n*STATIC\n*BOUNDARY,\n1,1,1,\n*NODE PRINT\nU\n*END STEP\n",
        NODES + LINES[0] + BRICK,  # the same node again
        "*\n" + NODES + BRICK + "*NSET,NSET=S,FREQUENCY=9\n1,2\n",  # which CalculiX takes, too
        NODES + BRICK + "*END ASSEMBLY\n*END\n",
    ],
)
def test_a_brick_is_read_however_it_is_written(tmp_path: Path, deck: str | bytes) -> None:
    mesh = read(tmp_path, deck)
    assert mesh.kind == "hexahedron"
    assert {name.upper() for name in mesh.cell_sets} == {"BAR"}
    assert np.allclose(mesh.nodes, np.array(PLACES) * 0.01, rtol=1e-15)
    assert ao.FEModel.from_mesh(mesh, STEEL).mass == pytest.approx(1e-6 * 7800.0)


@each("main, others", [
        ("*INCLUDE,FILE=mesh.inc\n*NSET,NSET=FIX\n1,3\n", {"mesh.inc": NODES + BRICK}),
        (NODES + BRICK + "*INCLUDE,INPUT=fix.nam\n", {"fix.nam": "*NSET,NSET=FIX\n1,3\n"}),
        (
            '*include, input=sub/n.inc\n*INCLUDE,INPUT="e.inc"\n*NSET,NSET=FIX\n1,3\n',
            {"sub/n.inc": "*INCLUDE,INPUT=first.inc\n" + "".join(LINES[4:]),
             "sub/first.inc": "*NODE\n" + "".join(LINES[:4]), "e.inc": BRICK},
        ),
        (
            "*NODE\n*INCLUDE,INPUT=n.txt\n" + BRICK + "*NSET,NSET=FIX\n1,\n*INCLUDE,INPUT=s.txt\n",
            {"n.txt": "".join(LINES), "s.txt": "3\n"},
        ),
        (
            "*NODE,INPUT=n.txt\n*ELEMENT,TYPE=C3D8,ELSET=BAR,INPUT=e.txt\n*NSET,NSET=FIX\n1,3\n",
            {"n.txt": "".join(LINES), "e.txt": BRICK.partition("\n")[2]},
        ),
    ])  # fmt: skip
def test_included_files_stand_in_their_places(
    tmp_path: Path, main: str, others: dict[str, str]
) -> None:
    for name, text in others.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    mesh = read(tmp_path, main)
    assert groups(mesh) == {"BAR": [1]}
    assert sets(mesh)["FIX"] == [1, 3]


def wedge_nodes(system: str) -> str:
    """A sixth of a ring of radii 1 and 2, height 1, in some coordinates."""
    lines = []
    for n, (r, turn, z) in enumerate(
        (r, turn, z) for z in (0.0, 1.0) for turn in (0.0, 60.0) for r in (1.0, 2.0)
    ):
        theta = np.radians(turn)
        x, y = r * np.cos(theta), r * np.sin(theta)
        rise = np.degrees(np.arctan2(z, r))
        given = {"R": (x, y, z), "C": (r, turn, z), "S": (np.hypot(r, z), turn, rise)}[system[0]]
        lines.append(f"{n + 1}, " + ", ".join(repr(float(value)) for value in given))
    return f"*NODE, SYSTEM={system}\n" + "\n".join(lines) + "\n"


@each("system", ["R", "C", "S", "CYLINDRICAL"])
def test_nodes_in_cylindrical_and_spherical_coordinates(tmp_path: Path, system: str) -> None:
    mesh = read(tmp_path, wedge_nodes(system) + BRICK)
    expected = read(tmp_path, wedge_nodes("R") + BRICK)
    assert np.allclose(mesh.nodes, expected.nodes, atol=1e-15)


@each(
    "system, axes",
    [
        ("1,2,3\n", np.eye(3)),
        ("1,2,3, 1,5,3\n", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        ("1,2,3, 1,5,9\n", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),  # x is projected
        ("1,2,3, 1,2,7\n5,2,8\n", [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    ],
)
def test_nodes_in_a_system_of_their_own(tmp_path: Path, system: str, axes: object) -> None:
    """The rows of `axes` are the local directions."""
    mesh = read(tmp_path, f"*SYSTEM\n{system}{NODES}{BRICK}")
    local = np.array(PLACES) * 0.01
    assert np.allclose(mesh.nodes, [1, 2, 3] + local @ np.array(axes), atol=1e-15)


def test_a_system_holds_until_the_next_one(tmp_path: Path) -> None:
    low, high = "".join(LINES[:4]), "".join(LINES[4:])
    mesh = read(tmp_path, f"*SYSTEM\n0,0,-5\n*NODE\n{low}*SYSTEM\n*NODE\n{high}{BRICK}")
    assert np.unique(mesh.nodes[:, 2]).tolist() == [-5.0, 0.01]


PART = f"*Part, name=Bar\n{NODES}{BRICK}*Nset, nset=Left\n1,3,5,7\n*Elset,elset=Bar\n1\n*End Part\n"


def assembly(*instances: str, more: str = "") -> str:
    return PART + "*Assembly, name=A\n" + "".join(instances) + more + "*End Assembly\n"


def test_two_instances_are_two_bodies(tmp_path: Path) -> None:
    deck = assembly(
        "*Instance, name=Bar-1, part=Bar\n*End Instance\n",
        "*Instance, name=Bar-2, part=BAR\n1., 0., 0.\n*End Instance\n",
        more="*Nset, nset=Ends\nBar-1.1, Bar-2.8, Bar-2.Left\n"
        "*Nset, nset=One, instance=Bar-2\nLEFT, 2\n*Elset, elset=Both\nBar-1.Bar, Bar-2.BAR\n",
    )
    mesh = read(tmp_path, deck)
    assert (mesh.n_nodes, mesh.n_cells) == (16, 2)
    assert np.allclose(mesh.nodes[8:], mesh.nodes[:8] + np.array([1, 0, 0]))
    assert mesh.node_sets["Ends"].tolist() == [0, 8, 10, 12, 14, 15]
    assert mesh.node_sets["One"].tolist() == [8, 9, 10, 12, 14]
    assert mesh.node_sets["Bar-1.Left"].tolist() == [0, 2, 4, 6]
    assert "Left" not in mesh.node_sets  # of which instance?
    assert mesh.cell_sets["Both"].tolist() == [0, 1]
    assert mesh.cell_sets["Bar-2"].tolist() == mesh.cell_sets["Bar-2.BAR"].tolist() == [1]
    second = read(tmp_path, deck, part="Bar-2")
    assert second.nodes[:, 0].min() == 1.0
    assert sets(second)["One"] == [1, 2, 3, 5, 7]


def test_an_instance_is_moved_and_then_turned(tmp_path: Path) -> None:
    """By 90 degrees about a line along z through (1, 1)."""
    deck = assembly(
        "*Instance, name=B, part=Bar\n1.,2.,3.\n1.,1.,0., 1.,1.,5., 90.\n*End Instance\n"
    )
    mesh = read(tmp_path, deck)
    x, y, z = (np.array(PLACES) * 0.01 + [1, 2, 3]).T
    assert np.allclose(mesh.nodes, np.column_stack([2.0 - y, x, z]))
    assert sets(mesh)["Left"] == sets(mesh)["B.Left"] == [1, 3, 5, 7]


def test_an_instance_may_have_the_mesh_itself_and_the_assembly_reference_points(
    tmp_path: Path,
) -> None:
    deck = (
        "*Part, name=P\n*End Part\n*Assembly, name=A\n*Instance, name=P-1, part=P\n"
        f"{NODES}{BRICK}*End Instance\n*Node\n1, 5., 5., 5.\n*Nset, nset=RP\n1\n"
        "*Nset, nset=Low, instance=P-1, generate\n1, 4\n*Element, type=MASS, elset=M\n1, 1\n"
        "*Element, type=CONN3D2\n2, P-1.1, 1\n*End Assembly\n"
    )
    with pytest.warns(AOImpactWarning, match=r"^elements.*: 1 CONN3D2, 1 MASS$"):
        mesh = read(tmp_path, deck)
    assert mesh.n_nodes == 8
    assert sets(mesh)["Low"] == [1, 2, 3, 4]
    assert "RP" not in mesh.node_sets


def test_parts_without_an_assembly_stand_for_themselves(tmp_path: Path) -> None:
    mesh = read(tmp_path, PART)
    assert groups(mesh) == {"BAR": [1], "Bar.BAR": [1]}
    assert mesh.part("Bar").n_cells == 1


def test_a_part_without_an_instance_is_left_out(tmp_path: Path) -> None:
    other = PART.replace("name=Bar", "name=Other")
    with pytest.warns(AOImpactWarning, match=r"^mesh"):
        mesh = read(tmp_path, other + assembly("*Instance, name=I, part=Bar\n*End Instance\n"))
    assert mesh.n_cells == 1


@each("kind", ["tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27",
                                  "wedge", "wedge15", "pyramid", "pyramid13"])  # fmt: skip
def test_solids_of_every_kind(tmp_path: Path, kind: str) -> None:
    """Nodes in the order of Abaqus' figures: edges of a face, of the other one, then between."""
    box = ao.box_mesh((1.0, 1.0, 1.0), (1, 1, 1), kind=kind)
    cells = box.cells
    if kind == "hexahedron27":  # the middle, then the faces 1-2-3-4, 5-8-7-6, 1-5-6-2 and so on
        cells = cells[:, [*range(20), 26, 24, 25, 22, 21, 23, 20]]
    nodes = "".join(f"{n},{x!r},{y!r},{z!r}\n" for n, (x, y, z) in enumerate(box.nodes.tolist(), 1))
    rows = []
    for e, cell in enumerate(cells.tolist(), 1):
        numbers = [e, *(n + 1 for n in cell)]
        lines = [numbers[i : i + 16] for i in (0, 16) if numbers[i:]]
        comma = "" if e % 2 else ","
        rows.append(f"{comma}\n".join(",".join(map(str, line)) for line in lines))
    deck = f"*NODE\n{nodes}*ELEMENT,TYPE=C3D{cells.shape[1]}\n" + "\n".join(rows) + "\n"
    mesh = read(tmp_path, deck)
    assert mesh.kind == kind
    assert np.array_equal(mesh.cells, box.cells)


@each("more, said", [
        ("*ELEMENT,TYPE=R3D4,ELSET=G\n9,1,2,4,3\n", "1 R3D4"),
        ("*ELEMENT,TYPE=S4R,ELSET=G\n9,1,2,4,3\n*ELEMENT,TYPE=MASS,ELSET=G\n10,1\n",
         "1 MASS, 1 S4R"),
        ("*ELEMENT,TYPE=SPRINGA,ELSET=G\n9,1,2\n10,3,4\n", "2 SPRINGA"),
        ("*ELEMENT,TYPE=GAPUNI,ELSET=G\n9,1,2\n", "1 GAPUNI"),
        ("*ELEMENT,TYPE=SC8R,ELSET=G\n9,1,2,4,3,5,6,8,7\n", "1 SC8R"),
        ("*ELEMENT,TYPE=B31,ELSET=G\n9,1,2\n", "1 B31"),
    ])  # fmt: skip
def test_other_elements_are_listed_and_ignored_unless_a_group_needs_them(
    tmp_path: Path, more: str, said: str
) -> None:
    section = "*SHELL SECTION,ELSET=G,MATERIAL=M\n.1\n"  # without one, sides may be a mesher's
    deck = NODES + BRICK + more + section + "*ELSET,ELSET=MIXED\n1,9\n"
    with pytest.warns(AOImpactWarning, match=f": {said}$"):
        mesh = read(tmp_path, deck)
    assert mesh.n_cells == 1
    assert mesh.part("BAR").n_cells == 1
    for name in ("G", "MIXED"):
        with pytest.raises(InputError, match=name):
            mesh.part(name)


def test_sides_and_edges_of_solids_need_no_warning_and_name_nodes(tmp_path: Path) -> None:
    side = "*ELEMENT,TYPE=CPS4,ELSET=BASE\n9,1,2,4,3\n"
    edge = "*ELEMENT,TYPE=T3D2,ELSET=EDGE\n10,1,2\n"
    mesh = read(tmp_path, NODES + BRICK + side + edge)
    assert sets(mesh)["BASE"] == [1, 2, 3, 4]
    assert sets(mesh)["EDGE"] == [1, 2]


def test_connections_between_nodes_are_named(tmp_path: Path) -> None:
    more = "*TIE, NAME=T\nA, B\n*Rigid Body, REF NODE=1, ELSET=E\n*TIE, NAME=U\nC, D\n"
    with pytest.warns(AOImpactWarning, match=r"^mesh"):
        assert read(tmp_path, NODES + BRICK + more).n_cells == 1


def test_members_that_are_not_there_are_named(tmp_path: Path) -> None:
    with pytest.warns(AOImpactWarning, match=r"^mesh"):
        mesh = read(tmp_path, NODES + BRICK + "*NSET,NSET=S\n1,99\n*NSET,NSET=T,GENERATE\n1,100\n")
    assert sets(mesh)["S"] == [1]
    assert sets(mesh)["T"] == list(range(1, 9))


@each("deck, words", [
        ("1,0,0,0\n" + NODES, r"line 1\b"),
        ("*NOED\n1,0,0,0\n" + NODES + BRICK, r"line 1\b"),
        (NODES + "*NCOPY,CHANGE NUMBER=9\n", r"line 10\b"),
        (NODES + "*NFILL\n", r"line 10\b"),
        (NODES + "*ELEMENT,TYPE=C3D8Q2\n1,1,2,4,3,5,6,8,7\n", r"line 10\b"),
        (NODES + "*ELEMENT,TYPE=C3D15V\n1,1\n", r"line 10\b"),
        (NODES + BRICK.replace("ELSET", "OFFSET"), r"line 10\b"),
        (NODES + BRICK.replace(",7", ""), r"line 11\b"),
        (NODES + BRICK.replace("4,3,", "4,3\n"), r"line 11\b"),
        (NODES + BRICK.replace(",7", ",99"), r"line 10\b"),
        (NODES + BRICK.replace(",7", ",x"), r"line 11\b"),
        (NODES + BRICK.replace(",7", ",-7"), r"line 11\b"),
        (NODES + BRICK.replace(",7", ",7.5"), r"line 11\b"),
        (NODES + BRICK + BRICK, r"line 12\b"),
        (NODES + "1,5,5,5\n" + BRICK, r"line 1\b"),
        (NODES.replace("0.01", "1,2,3,4,5,6,7,8", 1) + BRICK, r"line 3\b"),
        (NODES.replace("0.01", "0x1", 1) + BRICK, r"line 3\b"),
        (NODES.replace("0.01", "inf", 1) + BRICK, r"line 3\b"),
        (NODES.replace("0.01", "1e999", 1) + BRICK, r"line 3\b"),
        (NODES.replace("\n2,", "\n2.5,") + BRICK, r"line 3\b"),
        (NODES.replace("\n2,", "\n99999999999999999999,") + BRICK, r"line 3\b"),
        ("*NODE,SYSTEM=Q\n" + BRICK, r"line 1\b"),
        ("*SYSTEM\n0,0,0,1,0,0\n2,0,0\n" + NODES, r"line 1\b"),
        (NODES + BRICK + "*NSET,NSET=S\nNONE\n", r"line 12\b"),
        (NODES + BRICK + "*NSET,NSET=S\nP-1.5\n", r"line 12\b"),
        (NODES + BRICK + "*NSET,NSET=A\nB\n*NSET,NSET=B\nA\n", r"line 12\b"),
        (NODES + BRICK + "*NSET,NSET=A\n1\n*NSET,NSET=B\nA\n*NSET,NSET=A\n2\n", r"line 14\b"),
        (NODES + BRICK + "*NSET,NSET=S,GENERATE\n1,4,0\n", r"line 13\b"),
        (NODES + BRICK + "*NSET,NSET=S,GENERATE\n4,1\n", r"line 13\b"),
        (NODES + BRICK + "*NSET,NSET=S,GENERATE\n4,1,-1\n", r"line 13\b"),
        (NODES + BRICK + "*NSET\n1\n", r"line 12\b"),
        (NODES + BRICK + "*NSET,NSET=S,INSTANCE=I\n1\n", r"line 12\b"),
        (NODES + BRICK + "*NSET,NSET=S,NSET=T\n1\n", r"line 12\b"),
        (NODES + BRICK + "*ELGEN\n7,2\n", r"line 12\b"),
        ("*INCLUDE,INPUT=a.inp\n", r"line 1\b"),
        ("*INCLUDE\n", r"line 1\b"),
        ("*PART,NAME=P\n" + NODES + BRICK, r"line 11\b"),
        (PART + NODES, r"line 18\b"),
        (NODES + PART, r"line 1\b"),
        (assembly("*INSTANCE,NAME=I,PART=BAR\n*END INSTANCE\n", more=NODES + BRICK), r"line 30\b"),
        (NODES + BRICK + "*ELEMENT,TYPE=SPRINGA,ELSET=S\n9,1,2\n*NSET,NSET=R,ELSET=S\n",
         r"line 14\b"),
        (NODES + BRICK + "*NSET,NSET=S0\n1\n" + "".join(
            f"*NSET,NSET=S{i}\nS{i + 1}\n" for i in range(1, 2000)) + "*NSET,NSET=S2000\nS0\n",
         "mesh"),
        (PART + PART, r"line 18\b"),
        (assembly("*INSTANCE,NAME=I,PART=Q\n*END INSTANCE\n"), r"line 19\b"),
        (assembly("*INSTANCE,NAME=I,PART=BAR,LIBRARY=x\n"), r"line 19\b"),
        (assembly("*INSTANCE,NAME=I,PART=BAR\n0,0,0\n1,1,1,1,1,1,90\n*END INSTANCE\n"), "axis"),
        (NODES + BRICK + "*END PART\n", r"line 12\b"),
        (NODES + BRICK + "*\n9,1,0,0\n", r"line 12\b"),
        (NODES + BRICK + "*NSET,NSET=S,\n1,2\n", r"line 12\b"),
        (NODES + "*ELEMENT,TYPE=B32\n1,1,2\n", r"line 11\b"),
        (PART.replace("*End Part\n", "*INSTANCE,NAME=I,PART=BAR\n*END INSTANCE\n*End Part\n"),
         r"line 17\b"),
    ])  # fmt: skip
def test_what_is_not_understood_is_refused_by_line_and_keyword(
    tmp_path: Path, deck: str, words: str
) -> None:
    with pytest.raises(MeshError, match=words):
        read(tmp_path, deck)


def test_a_file_to_include_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"line 2\b"):
        read(tmp_path, "*HEADING\n*INCLUDE, INPUT=b.inp\n")


def test_decks_are_known_by_their_content(tmp_path: Path) -> None:
    (tmp_path / "all.msh").write_text(NODES + BRICK)  # as CalculiX GraphiX calls them
    assert ao.read_mesh(tmp_path / "all.msh").n_cells == 1
